//! Cryptomattes beside what the device draws: coverage sums to the device's own alpha.

use super::stage::{self, everything};
use super::support::{self, draw_passes, samples, target};
use glam::Vec2;
use pinwarp::raster::cpu::CpuRaster;
use pinwarp::raster::{ChannelGroup, Geometry, MATTE_LAYERS, PassRole, Target};

const MATTES: [ChannelGroup; 2] = [ChannelGroup::Beauty, ChannelGroup::Cryptomatte];

/// Sixteen jitters over a pixel.
fn passes(geometry: &Geometry) -> Vec<(&Geometry, Vec2, PassRole)> {
    let jitter = |k: u32| (Vec2::new((k % 4) as f32, (k / 4) as f32) - 1.5) / 4.0;
    let role = |k: u32| if k == 5 { PassRole::BeautyAndData } else { PassRole::Beauty };
    (0..16).map(|k| (geometry, jitter(k), role(k))).collect()
}

#[test]
fn coverage_sums_to_the_alpha_that_the_device_draws() {
    let scene = stage::scene();
    let Some(mut vulkan) = support::open(&scene) else { return };
    let geometry = everything(1.5);
    let target = Target { channels: MATTES.to_vec(), beauty_passes: 16, ..target(240, 160) };
    let ours = draw_passes(&mut *vulkan, &target, &passes(&geometry));
    let twin = draw_passes(&mut CpuRaster::new(&scene), &target, &passes(&geometry));
    let names = |frame: &pinwarp::image::Frame| -> Vec<String> {
        frame.channels.iter().map(|channel| channel.name.clone()).collect()
    };
    assert_eq!(names(&ours), names(&twin));
    assert_eq!(ours.channels[4..], twin.channels[4..], "every device has the same mattes");
    let alpha = samples(&ours, "A");
    for layer in MATTE_LAYERS {
        let coverage: Vec<&[f32]> = ["00.G", "00.A", "01.G", "01.A", "02.G", "02.A"]
            .map(|rank| samples(&ours, &format!("{layer}{rank}")))
            .to_vec();
        let difference = |at: usize| (coverage.iter().map(|plane| plane[at]).sum::<f32>() - alpha[at]).abs();
        let differences: Vec<f32> = (0..alpha.len()).map(difference).collect();
        // A sample on an edge, or at the border of a cut-out, may fall to either side: a sixteenth of a pixel each.
        let far = differences.iter().filter(|difference| **difference > 1.5 / 16.0).count();
        let mean = differences.iter().sum::<f32>() / differences.len() as f32;
        assert!(far * 200 < alpha.len() && mean < 2e-3, "{layer}: {far} pixels far off, mean {mean}");
    }
}

#[test]
fn mattes_alone_are_a_frame_too() {
    let scene = stage::scene();
    let Some(mut vulkan) = support::open(&scene) else { return };
    let geometry = everything(1.5);
    let target = Target { channels: MATTES[1..].to_vec(), beauty_passes: 16, ..target(120, 80) };
    let frame = draw_passes(&mut *vulkan, &target, &passes(&geometry));
    assert_eq!(frame.channels.len(), 36);
    assert!(samples(&frame, "CryptoObject00.G").iter().any(|&share| share > 0.99));
}
