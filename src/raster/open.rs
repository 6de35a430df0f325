//! Chooses what draws.

use super::cpu::CpuRaster;
use super::{DeviceChoice, Raster, RasterError};
use crate::scene::Scene;

/// Opens the chosen device for a scene; with it, for [`DeviceChoice::Auto`], why the CPU twin had to be used.
///
/// # Errors
/// [`RasterError`] where a device asked for by name cannot be had.
pub fn open(choice: &DeviceChoice, scene: &Scene) -> Result<(Box<dyn Raster + Send>, Option<String>), RasterError> {
    match choice {
        DeviceChoice::Auto | DeviceChoice::Cpu => Ok((Box::new(CpuRaster::new(scene)), None)),
        DeviceChoice::Named(wanted) => {
            Err(RasterError::UnknownDevice { wanted: wanted.clone(), available: "cpu".into() })
        }
    }
}
