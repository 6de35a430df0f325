//! Converts result codes of Vulkan and of the allocator to errors.
//!
//! In: result codes with the name of the call. Out: [`RasterError`]s.

use crate::raster::RasterError;
use ash::vk;
use gpu_allocator::AllocationError;

/// Converts a result of `call`; out-of-memory and device-lost results have variants of their own.
pub(super) fn vulkan_error(call: &'static str) -> impl FnOnce(vk::Result) -> RasterError {
    move |source| match source {
        vk::Result::ERROR_OUT_OF_HOST_MEMORY | vk::Result::ERROR_OUT_OF_DEVICE_MEMORY => {
            RasterError::OutOfMemory { what: call.into() }
        }
        vk::Result::ERROR_DEVICE_LOST => RasterError::DeviceLost { call },
        source => RasterError::Vulkan { call, source },
    }
}

/// Converts an allocation failure of memory for `what`.
pub(super) fn memory_error(what: &str, bytes: u64) -> impl FnOnce(AllocationError) -> RasterError {
    let what = format!("{what} ({} MiB on the device)", bytes.div_ceil(1 << 20));
    move |_| RasterError::OutOfMemory { what }
}

/// Creates an error for a missing device.
pub(super) fn no_device(what: impl Into<String>) -> RasterError {
    RasterError::NoDevice { what: what.into() }
}
