//! Errors of drawing.
//!
//! In: failed calls of devices and allocators, wrong use. Out: [`RasterError`], which says what to do.

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
    /// The device stopped working: a driver reset, a hang, a card that was removed.
    #[error("the Vulkan device was lost in {call}; render the frame again, or use --device cpu")]
    DeviceLost {
        /// The call that reported it.
        call: &'static str,
    },
    /// The device cannot address that many vertices.
    #[error("the scene has {vertices} vertices on the screen, and the device draws {limit} at most; use --device cpu")]
    TooManyVertices {
        /// How many there are.
        vertices: usize,
        /// How many may be drawn.
        limit: u64,
    },
    /// `start`, `draw` and `finish` were called out of order, or the target is larger than the device allows.
    #[error("raster: {0}")]
    Misuse(&'static str),
}
