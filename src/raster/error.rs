//! Errors of rendering.
//!
//! In: failed calls of devices and allocators, invalid use. Out: [`RasterError`], whose message says what to do.

/// A frame that cannot be rendered.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RasterError {
    /// No Vulkan loader, driver or usable device.
    #[error(
        "no usable Vulkan device: {what}; install a driver (Debian: mesa-vulkan-drivers libvulkan1) or use --device cpu"
    )]
    NoDevice {
        /// What is missing.
        what: String,
    },
    /// `--device` matches no device.
    #[error("no device matches '{wanted}'; there are: cpu, {available}")]
    UnknownDevice {
        /// The requested device.
        wanted: String,
        /// The available devices.
        available: String,
    },
    /// A Vulkan call failed.
    #[error("Vulkan: {call} failed: {source}; try --device cpu")]
    Vulkan {
        /// The name of the call.
        call: &'static str,
        /// Its result code.
        source: ash::vk::Result,
    },
    /// Out of device or host memory.
    #[error("not enough memory for {what}; render at a smaller --scale")]
    OutOfMemory {
        /// What the memory was for.
        what: String,
    },
    /// The device was lost: a driver reset, a hang, a card that was removed.
    #[error("the Vulkan device was lost in {call}; render the frame again, or use --device cpu")]
    DeviceLost {
        /// The call that reported it.
        call: &'static str,
    },
    /// The device cannot address that many vertices.
    #[error("the scene has {vertices} vertices on the screen, and the device draws {limit} at most; use --device cpu")]
    TooManyVertices {
        /// Number of vertices.
        vertices: usize,
        /// Maximum number of vertices.
        limit: u64,
    },
    /// `start`, `draw` and `finish` were called out of order, or the target exceeds the device's limits.
    #[error("raster: {0}")]
    Misuse(&'static str),
}
