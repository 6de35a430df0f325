//! The Vulkan instance: the loader is opened at run time; validation is optional.
//!
//! In: nothing, or the destination of validation messages. Out: an [`Instance`] that owns library, instance and
//! messenger.

use super::fault::{no_device, vulkan_error};
use super::messenger::{Messages, Messenger, messenger_info};
use crate::raster::RasterError;
use ash::{Entry, ext, vk};
use std::ffi::CStr;

/// The validation layer.
const VALIDATION_LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// Minimum Vulkan version: dynamic rendering and `synchronization2` are in its core.
pub(super) const API_VERSION: u32 = vk::API_VERSION_1_3;

/// Owns the instance. Drop order: messenger, instance, messages, library.
pub(super) struct Instance {
    messenger: Option<Messenger>,
    raw: ash::Instance,
    messages: Option<Messages>,
    _library: Entry,
}

impl Instance {
    /// Opens the loader and creates an instance; with `messages`, validation (core and synchronisation) is enabled.
    pub(super) fn new(messages: Option<&Messages>) -> Result<Self, RasterError> {
        // SAFETY: loading libvulkan runs its initialisers; `_library` keeps it loaded as long as its functions are used.
        let entry = unsafe { Entry::load() }
            .map_err(|error| no_device(format!("the Vulkan loader cannot be opened ({error})")))?;
        check_version(&entry)?;
        if messages.is_some() {
            require_layer(&entry)?;
        }
        let raw = create(&entry, messages)?;
        // From here on `Drop` cleans up.
        let mut instance = Self { messenger: None, raw, messages: messages.cloned(), _library: entry };
        if let Some(messages) = &instance.messages {
            instance.messenger = Some(Messenger::new(&instance._library, &instance.raw, messages)?);
        }
        Ok(instance)
    }

    /// Returns the function table of the instance.
    pub(super) fn raw(&self) -> &ash::Instance {
        &self.raw
    }

    /// Returns the destination of validation messages; `None` if validation is disabled.
    pub(super) fn messages(&self) -> Option<&Messages> {
        self.messages.as_ref()
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        // The messenger is a child of the instance.
        self.messenger = None;
        // SAFETY: all children are destroyed (VUID-vkDestroyInstance-instance-00629): `Device` holds an `Arc` of this.
        unsafe { self.raw.destroy_instance(None) };
    }
}

fn check_version(entry: &Entry) -> Result<(), RasterError> {
    // SAFETY: no preconditions.
    let version = unsafe { entry.try_enumerate_instance_version() };
    let version = version.map_err(vulkan_error("vkEnumerateInstanceVersion"))?.unwrap_or(vk::API_VERSION_1_0);
    if version < API_VERSION {
        return Err(no_device(format!(
            "the Vulkan loader knows version {} only, 1.3 is needed",
            version_text(version)
        )));
    }
    Ok(())
}

/// Formats a version such as `1.3.230`.
pub(super) fn version_text(version: u32) -> String {
    let (major, minor) = (vk::api_version_major(version), vk::api_version_minor(version));
    format!("{major}.{minor}.{}", vk::api_version_patch(version))
}

fn require_layer(entry: &Entry) -> Result<(), RasterError> {
    // SAFETY: no preconditions.
    let layers = unsafe { entry.enumerate_instance_layer_properties() };
    let layers = layers.map_err(vulkan_error("vkEnumerateInstanceLayerProperties"))?;
    if layers.iter().any(|layer| layer.layer_name_as_c_str() == Ok(VALIDATION_LAYER)) {
        return Ok(());
    }
    Err(no_device(
        "the validation layer VK_LAYER_KHRONOS_validation is not installed (Debian: vulkan-validationlayers)",
    ))
}

fn create(entry: &Entry, messages: Option<&Messages>) -> Result<ash::Instance, RasterError> {
    let application = vk::ApplicationInfo::default().application_name(c"pinwarp").api_version(API_VERSION);
    let layers = [VALIDATION_LAYER.as_ptr()];
    let extensions = [ext::debug_utils::NAME.as_ptr(), ext::validation_features::NAME.as_ptr()];
    let checks = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
    let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&checks);
    let mut info = vk::InstanceCreateInfo::default().application_info(&application);
    let mut messenger = messages.map(messenger_info);
    if let Some(messenger) = &mut messenger {
        info = info.enabled_layer_names(&layers).enabled_extension_names(&extensions);
        info = info.push_next(&mut features).push_next(messenger);
    }
    // SAFETY: everything that `info` points to lives until the call returns; the layer and its extensions were queried
    // (VUID-vkCreateInstance-ppEnabledExtensionNames-01388).
    let made = unsafe { entry.create_instance(&info, None) };
    made.map_err(|result| match result {
        vk::Result::ERROR_INCOMPATIBLE_DRIVER => no_device("no Vulkan driver is installed"),
        result => vulkan_error("vkCreateInstance")(result),
    })
}
