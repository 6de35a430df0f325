//! Opens what `--device` asks for.
//!
//! In: a choice, a scene. Out: a raster, and where the CPU draws instead of a card, the reason; or what resamples plates.

use super::cpu::CpuRaster;
use super::vulkan::{VulkanRaster, VulkanRemap, devices};
use super::{DeviceChoice, Raster, RasterError};
use crate::plate::Resampler;
use crate::scene::Scene;

/// A raster for a scene. [`DeviceChoice::Auto`] takes a graphics card where there is one, else the CPU; where a card
/// cannot be opened, the reason comes along.
///
/// ```
/// use pinwarp::{raster::{self, DeviceChoice, Raster as _}, scene::Scene};
/// let (raster, reason) = raster::open(&DeviceChoice::Cpu, &Scene::default())?;
/// assert!(raster.name() == "CPU" && reason.is_none());
/// # Ok::<(), pinwarp::raster::RasterError>(())
/// ```
///
/// # Errors
/// [`RasterError`] where a device was named and cannot be opened; `Auto` and `Cpu` always open.
pub fn open(choice: &DeviceChoice, scene: &Scene) -> Result<(Box<dyn Raster + Send>, Option<String>), RasterError> {
    let on_cpu = || Box::new(CpuRaster::new(scene));
    match choice {
        DeviceChoice::Auto if has_card() => Ok(match VulkanRaster::open(choice, scene) {
            Ok(raster) => (Box::new(raster), None),
            Err(error) => (on_cpu(), Some(error.to_string())),
        }),
        DeviceChoice::Auto | DeviceChoice::Cpu => Ok((on_cpu(), None)),
        DeviceChoice::Vulkan | DeviceChoice::Named(_) => Ok((Box::new(VulkanRaster::open(choice, scene)?), None)),
    }
}

/// What resamples plates; `None`: the CPU. [`DeviceChoice::Auto`] takes a graphics card where there is one.
///
/// # Errors
/// [`RasterError`] where a device was named and cannot be opened.
pub fn resampler(choice: &DeviceChoice) -> Result<Option<Box<dyn Resampler>>, RasterError> {
    let open = || VulkanRemap::open(choice);
    let boxed = |device| -> Box<dyn Resampler> { Box::new(device) };
    match choice {
        DeviceChoice::Auto if has_card() => Ok(open().ok().map(boxed)),
        DeviceChoice::Auto | DeviceChoice::Cpu => Ok(None),
        DeviceChoice::Vulkan | DeviceChoice::Named(_) => open().map(boxed).map(Some),
    }
}

/// Software drivers are slower than the CPU raster and the kernels of plates.
fn has_card() -> bool {
    devices().is_ok_and(|all| all.iter().any(|device| device.unusable.is_none() && device.kind.is_card()))
}
