//! Memory stays flat however many frames are drawn.
//!
//! A driver that compiles shaders anew for every pass, or objects of ours that are made for every pass, would show here.

use super::stage::{self, everything};
use super::support::{draw_passes, target};
use crate::internal::skip::skip;
use glam::Vec2;
use pinwarp::raster::vulkan::VulkanRaster;
use pinwarp::raster::{DeviceChoice, Geometry, PassRole, Raster, RasterError, Target};
use std::process::Command;

/// Passes of a frame.
const PASSES: usize = 4;
/// Frames until all that is kept is there.
const WARM_UP: usize = 40;
/// Growth that is still called flat, KiB: a leak of 4 KiB a pass would be found in the fewest frames drawn here.
const FLAT_KIB: u64 = 4 << 10;

/// Resident memory of this process, KiB; `None` where the system does not tell.
fn resident_kib() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    line.trim().trim_end_matches("kB").trim().parse().ok()
}

fn draw_frames(raster: &mut dyn Raster, geometry: &Geometry, frames: usize) {
    let target = Target { beauty_passes: PASSES as u32, ..target(32, 32) };
    let role = |pass| if pass == 0 { PassRole::BeautyAndData } else { PassRole::Beauty };
    for frame in 0..frames {
        let jitter = |pass: usize| Vec2::splat(((frame + pass) % 7) as f32 / 7.0 - 0.5);
        let passes: Vec<_> = (0..PASSES).map(|pass| (geometry, jitter(pass), role(pass))).collect();
        draw_passes(raster, &target, &passes);
    }
}

/// Not a test by itself: a process of its own, since other tests take memory, too. Without validation layers, which
/// keep what was said about every object.
#[test]
#[ignore = "run by the test below; PINWARP_FRAMES sets how many"]
fn probe() {
    let frames = std::env::var("PINWARP_FRAMES").ok().and_then(|count| count.parse().ok()).unwrap_or(300);
    let (scene, geometry) = (stage::scene(), everything(1.0));
    let mut raster = match VulkanRaster::open(&DeviceChoice::Vulkan, &scene) {
        Ok(raster) => raster,
        Err(RasterError::NoDevice { what }) => return println!("PROBE none: {what}"),
        Err(error) => panic!("{error}"),
    };
    draw_frames(&mut raster, &geometry, WARM_UP);
    let Some(before) = resident_kib() else { return println!("PROBE none: memory is not told") };
    draw_frames(&mut raster, &geometry, frames);
    println!("PROBE {frames} {before} {}", resident_kib().unwrap());
}

#[test]
fn memory_is_flat_over_the_frames() {
    let arguments = ["--exact", "internal::vulkan::memory::probe", "--ignored", "--nocapture"];
    let run = Command::new(std::env::current_exe().unwrap()).args(arguments).output().unwrap();
    let text = String::from_utf8_lossy(&run.stdout);
    let found = text.lines().find_map(|line| line.split_once("PROBE ").map(|(_, found)| found.to_owned()));
    let found = found.unwrap_or_else(|| panic!("{text}"));
    if let Some(reason) = found.strip_prefix("none: ") {
        return skip(reason);
    }
    let numbers: Vec<u64> = found.split(' ').map(|number| number.parse().unwrap()).collect();
    let [frames, before, after] = numbers[..] else { panic!("{found}") };
    let grown = after.saturating_sub(before);
    assert!(frames >= 300 && before > 1 << 10, "{found}");
    assert!(grown < FLAT_KIB, "{frames} frames of {PASSES} passes took {grown} KiB more, from {before} KiB");
}
