//! What can go wrong while drawing.

/// A frame that cannot be drawn.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RasterError {
    /// No Vulkan loader, driver or usable device.
    #[error(
        "no usable Vulkan device: {what}; install a driver (Debian: mesa-vulkan-drivers libvulkan1) or use --device cpu"
    )]
    NoDevice {
        /// What was found missing.
        what: String,
    },
    /// `--device` names nothing that is there.
    #[error("no device matches '{wanted}'; there are: cpu, {available}")]
    UnknownDevice {
        /// What was asked for.
        wanted: String,
        /// What there is.
        available: String,
    },
    /// A Vulkan call failed.
    #[error("Vulkan: {call} failed: {source}; try --device cpu")]
    Vulkan {
        /// The call.
        call: &'static str,
        /// Its result.
        source: ash::vk::Result,
    },
    /// The device or the machine has not enough memory.
    #[error("not enough memory for {what}; render at a smaller --scale")]
    OutOfMemory {
        /// For what.
        what: String,
    },
    /// `start`, `draw` and `finish` were called out of order, or the target is larger than the device allows.
    #[error("raster: {0}")]
    Misuse(&'static str),
}
