//! Opens what `--device` asks for.
//!
//! In: a choice, a scene. Out: a raster, and where the CPU twin stands in for a missing device, the reason; or what
//! resamples plates.

use super::cpu::CpuRaster;
use super::vulkan::{DeviceInfo, DeviceKind, VulkanRaster, VulkanRemap, devices};
use super::{DeviceChoice, Raster, RasterError};
use crate::plate::Resampler;
use crate::scene::Scene;

/// A raster for a scene; with [`DeviceChoice::Auto`] also why the CPU twin draws, where no device could be opened.
///
/// ```
/// use pinwarp::{raster::{self, DeviceChoice, Raster as _}, scene::Scene};
/// let (raster, reason) = raster::open(&DeviceChoice::Cpu, &Scene::default())?;
/// assert!(raster.name().starts_with("CPU") && reason.is_none());
/// # Ok::<(), pinwarp::raster::RasterError>(())
/// ```
///
/// # Errors
/// [`RasterError`] where a device was named and cannot be opened; `Auto` and `Cpu` always open.
pub fn open(choice: &DeviceChoice, scene: &Scene) -> Result<(Box<dyn Raster + Send>, Option<String>), RasterError> {
    match choice {
        DeviceChoice::Cpu => Ok((Box::new(CpuRaster::new(scene)), None)),
        DeviceChoice::Named(_) => Ok((Box::new(VulkanRaster::open(choice, scene)?), None)),
        DeviceChoice::Auto => Ok(match VulkanRaster::open(choice, scene) {
            Ok(raster) => (Box::new(raster), None),
            Err(error) => (Box::new(CpuRaster::new(scene)), Some(error.to_string())),
        }),
    }
}

/// What resamples plates; `None`: the CPU. [`DeviceChoice::Auto`] takes a graphics card where there is one, never a
/// software driver, which is slower than the kernels of [`plate`](crate::plate).
///
/// # Errors
/// [`RasterError`] where a device was named and cannot be opened.
pub fn resampler(choice: &DeviceChoice) -> Result<Option<Box<dyn Resampler>>, RasterError> {
    let open = || VulkanRemap::open(choice);
    let boxed = |device| -> Box<dyn Resampler> { Box::new(device) };
    match choice {
        DeviceChoice::Cpu => Ok(None),
        DeviceChoice::Named(_) => open().map(boxed).map(Some),
        DeviceChoice::Auto => Ok(if has_card() { open().ok().map(boxed) } else { None }),
    }
}

/// Whether the best device that serves is no software.
fn has_card() -> bool {
    let usable = |device: &DeviceInfo| device.unusable.is_none();
    devices().is_ok_and(|all| all.iter().any(|device| usable(device) && device.kind < DeviceKind::Software))
}
