//! Collects messages of the validation layers.
//!
//! In: callbacks of VK_EXT_debug_utils. Out: a list of texts, which tests check.

use super::fault::vulkan_error;
use crate::raster::RasterError;
use ash::ext::debug_utils;
use ash::{Entry, vk};
use std::ffi::{CStr, c_void};
use std::sync::{Arc, Mutex, PoisonError};

/// Messages of the validation layers, shared with a rasteriser opened by
/// [`VulkanRaster::open_validated`](super::VulkanRaster::open_validated); more may be added until that rasteriser is
/// dropped.
#[derive(Clone, Debug, Default)]
pub(crate) struct Messages(Arc<Mutex<Vec<String>>>);

impl Messages {
    /// Removes and returns all messages so far.
    #[cfg(test)]
    #[must_use]
    pub(crate) fn take(&self) -> Vec<String> {
        std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    pub(super) fn push(&self, message: String) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(message);
    }
}

/// Receives warnings and errors of the layers.
pub(super) struct Messenger {
    functions: debug_utils::Instance,
    handle: vk::DebugUtilsMessengerEXT,
}

impl Messenger {
    pub(super) fn new(entry: &Entry, instance: &ash::Instance, messages: &Messages) -> Result<Self, RasterError> {
        let functions = debug_utils::Instance::new(entry, instance);
        let info = messenger_info(messages);
        // SAFETY: `info` is valid (VUID-vkCreateDebugUtilsMessengerEXT-pCreateInfo-parameter); its user data lives in
        // `Instance::messages`, which is dropped after this messenger.
        let made = unsafe { functions.create_debug_utils_messenger(&info, None) };
        let handle = made.map_err(vulkan_error("vkCreateDebugUtilsMessengerEXT"))?;
        Ok(Self { functions, handle })
    }
}

impl Drop for Messenger {
    fn drop(&mut self) {
        // SAFETY: created in `new`, destroyed once, before its instance (`Instance::drop`).
        unsafe { self.functions.destroy_debug_utils_messenger(self.handle, None) };
    }
}

/// Returns the creation info. The user data points into `messages`, which must outlive whatever is created from it.
pub(super) fn messenger_info(messages: &Messages) -> vk::DebugUtilsMessengerCreateInfoEXT<'static> {
    use vk::DebugUtilsMessageSeverityFlagsEXT as Severity;
    use vk::DebugUtilsMessageTypeFlagsEXT as Type;
    vk::DebugUtilsMessengerCreateInfoEXT::default()
        .message_severity(Severity::WARNING | Severity::ERROR)
        .message_type(Type::VALIDATION | Type::PERFORMANCE)
        .pfn_user_callback(Some(collect))
        .user_data(Arc::as_ptr(&messages.0).cast_mut().cast())
}

/// Stores one message. Must not unwind into C: it only allocates and locks, which does not panic.
unsafe extern "system" fn collect(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the user data of `messenger_info`, alive as long as the messenger.
    let list = unsafe { &*user.cast::<Mutex<Vec<String>>>() };
    // SAFETY: the layer passes valid data for the duration of the call.
    let text = unsafe { (*data).p_message };
    if !text.is_null() {
        // SAFETY: p_message is a null-terminated string (VUID-VkDebugUtilsMessengerCallbackDataEXT-pMessage-parameter).
        let text = unsafe { CStr::from_ptr(text) };
        list.lock().unwrap_or_else(PoisonError::into_inner).push(text.to_string_lossy().into_owned());
    }
    vk::FALSE
}
