//! Opens what `--device` asks for.
//!
//! In: a choice, a scene. Out: a raster, and where the CPU twin stands in for a missing device, the reason.

use super::cpu::CpuRaster;
use super::vulkan::VulkanRaster;
use super::{DeviceChoice, Raster, RasterError};
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
