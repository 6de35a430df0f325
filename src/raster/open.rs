//! Opens the device selected by `--device`.
//!
//! In: a choice, a scene. Out: a rasteriser, with the reason if the CPU replaces a graphics card; or a resampler of
//! plates.

use super::cpu::CpuRaster;
use super::vulkan::{VulkanRaster, VulkanRemap, devices};
use super::{DeviceChoice, Raster, RasterError};
use crate::plate::Resampler;
use crate::scene::Scene;

/// Opens a rasteriser for a scene. [`DeviceChoice::Auto`] uses a graphics card if there is one, else the CPU; if a card
/// cannot be opened, the reason is returned, too.
///
/// ```
/// use pinwarp::{raster::{self, DeviceChoice, Raster as _}, scene::Scene};
/// let (raster, reason) = raster::open(&DeviceChoice::Cpu, &Scene::default())?;
/// assert!(raster.name() == "CPU" && reason.is_none());
/// # Ok::<(), pinwarp::raster::RasterError>(())
/// ```
///
/// # Errors
/// [`RasterError`] if a named device cannot be opened; `Auto` and `Cpu` always succeed.
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

/// Opens a resampler of plates; `None` for the CPU. [`DeviceChoice::Auto`] uses a graphics card if there is one.
///
/// # Errors
/// [`RasterError`] if a named device cannot be opened.
pub(crate) fn resampler(choice: &DeviceChoice) -> Result<Option<Box<dyn Resampler>>, RasterError> {
    let open = || VulkanRemap::open(choice);
    let boxed = |device| -> Box<dyn Resampler> { Box::new(device) };
    match choice {
        DeviceChoice::Auto if has_card() => Ok(open().ok().map(boxed)),
        DeviceChoice::Auto | DeviceChoice::Cpu => Ok(None),
        DeviceChoice::Vulkan | DeviceChoice::Named(_) => open().map(boxed).map(Some),
    }
}

/// Software drivers do not count: they are slower than the CPU rasteriser and resampler.
fn has_card() -> bool {
    devices().is_ok_and(|all| all.iter().any(|device| device.unusable.is_none() && device.kind.is_card()))
}
