//! The Vulkan rasteriser: offscreen float targets through ash; the loader is opened at run time.
//!
//! In: a scene, then the geometry of each pass. Out: the same frames as from the CPU rasteriser. Requires Vulkan 1.3
//! (dynamic rendering, `synchronization2`).

#![expect(unsafe_code, reason = "Vulkan is a C API; safe wrappers around single calls, each with its SAFETY remark")]

mod attachments;
mod choose;
mod commands;
mod descriptors;
mod device;
mod draws;
mod fault;
mod formats;
mod instance;
mod materials;
mod memory;
mod messenger;
mod microbenchmark;
mod owned;
mod pass;
mod pipeline;
mod raster;
mod readback;
mod remap;
mod remap_tiles;
mod rendering;
#[cfg(test)]
mod shim;
#[cfg(test)]
mod tests;
mod textures;
mod upload;

#[cfg(any(test, feature = "cli"))]
pub(crate) use choose::DeviceInfo;
#[cfg(test)]
pub(crate) use choose::DeviceKind;
pub(crate) use choose::devices;
#[cfg(test)]
pub(crate) use messenger::Messages;
pub use microbenchmark::BareTimes;
pub use raster::{StageTimes, VulkanRaster};
pub use remap::VulkanRemap;
