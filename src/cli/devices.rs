//! `pinwarp devices`: lists the rendering devices.

use super::outcome::Outcome;
use crate::raster::vulkan::{self, DeviceInfo};
use crate::spelling::pluralised;
use std::io::{self, Write};

pub(super) fn run() -> anyhow::Result<Outcome> {
    let mut out = io::stdout().lock();
    match vulkan::devices() {
        Ok(devices) => {
            for device in &devices {
                writeln!(out, "{}", line(device))?;
            }
        }
        Err(error) => writeln!(io::stderr(), "note: {error}")?,
    }
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    writeln!(out, "cpu  the built-in CPU rasteriser on {}", pluralised(threads, "thread", "threads"))?;
    Ok(Outcome::Complete)
}

/// Formats number, name, kind, driver, version and memory, and the reason if the device is unusable.
fn line(device: &DeviceInfo) -> String {
    let gib = device.memory_bytes as f64 / f64::from(1 << 30);
    let DeviceInfo { index, name, kind, driver, api_version, .. } = device;
    let fault = device.unusable.as_ref().map_or_else(String::new, |fault| format!("; UNUSABLE: {fault}"));
    format!("{index}    {name} ({kind}, {driver}, Vulkan {api_version}, {gib:.1} GiB){fault}")
}
