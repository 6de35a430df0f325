//! Several passes: beauty is their mean, data come from one of them; and calls out of order.

use super::limits::assert_alike;
use super::stage::{self, everything};
use super::support::{self, draw_passes, samples, target};
use glam::Vec2;
use pinwarp::image::Frame;
use pinwarp::raster::{Geometry, Pass, PassRole, Raster, RasterError, Target};

const JITTERS: [Vec2; 4] = [Vec2::new(-0.25, -0.4), Vec2::new(0.3, -0.1), Vec2::new(-0.1, 0.35), Vec2::new(0.45, 0.2)];
const BEAUTY: [&str; 4] = ["R", "G", "B", "A"];

fn singles(raster: &mut dyn Raster, target: &Target, geometry: &Geometry) -> Vec<Frame> {
    let single = |jitter: &Vec2| draw_passes(raster, target, &[(geometry, *jitter, PassRole::BeautyAndData)]);
    JITTERS.iter().map(single).collect()
}

#[test]
fn beauty_is_the_mean_and_data_are_of_one_pass() {
    let Some(mut vulkan) = support::open(&stage::scene()) else { return };
    let (target, geometry) = (target(120, 80), everything(1.5));
    let singles = singles(&mut *vulkan, &target, &geometry);
    let several = Target { beauty_passes: 4, ..target };
    for data in 0..4 {
        let role = |at| if at == data { PassRole::BeautyAndData } else { PassRole::Beauty };
        let passes: Vec<_> = (0..4).map(|at| (&geometry, JITTERS[at], role(at))).collect();
        let mean = draw_passes(&mut *vulkan, &several, &passes);
        for name in BEAUTY {
            for (at, sample) in samples(&mean, name).iter().enumerate() {
                let wanted = singles.iter().map(|frame| samples(frame, name)[at]).sum::<f32>() / 4.0;
                assert!((sample - wanted).abs() < 1e-5 * wanted.abs().max(1.0), "{name} {at}: {sample}, not {wanted}");
            }
        }
        for name in ["depth.Z", "N.X", "N.Z", "forward.u", "id.object"] {
            assert_eq!(samples(&mean, name), samples(&singles[data], name), "{name} of pass {data}");
        }
    }
}

#[test]
fn a_second_data_pass_is_refused_on_every_raster() {
    let (scene, geometry) = (stage::scene(), everything(1.5));
    let mut cpu = pinwarp::raster::cpu::CpuRaster::new(&scene);
    let mut vulkan = support::open(&scene);
    let mut rasters: Vec<&mut dyn Raster> = vec![&mut cpu];
    if let Some(raster) = vulkan.as_deref_mut() {
        rasters.push(raster);
    }
    for raster in rasters {
        for (first, second) in [(PassRole::Data, PassRole::Data), (PassRole::BeautyAndData, PassRole::Data)] {
            raster.start(&Target { beauty_passes: 2, ..target(60, 40) }).unwrap();
            raster.draw(&Pass { geometry: &geometry, jitter_px: Vec2::ZERO, role: first }).unwrap();
            let again = raster.draw(&Pass { geometry: &geometry, jitter_px: Vec2::ZERO, role: second });
            assert!(again.unwrap_err().to_string().contains("only one data pass"));
        }
    }
}

#[test]
fn separate_passes_for_beauty_and_data_make_the_same_frame() {
    let Some(mut vulkan) = support::open(&stage::scene()) else { return };
    let (target, geometry) = (target(120, 80), everything(1.5));
    let still = Vec2::ZERO;
    let together = draw_passes(&mut *vulkan, &target, &[(&geometry, still, PassRole::BeautyAndData)]);
    let (beauty, data) = ((&geometry, still, PassRole::Beauty), (&geometry, still, PassRole::Data));
    for order in [[beauty, data], [data, beauty]] {
        assert_alike(&together, &draw_passes(&mut *vulkan, &target, &order), 0.1);
    }
}

#[test]
fn beauty_of_two_times_is_mixed_and_data_is_of_its_own_time() {
    let Some(mut vulkan) = support::open(&stage::scene()) else { return };
    let (target, geometry) = (Target { beauty_passes: 2, ..target(60, 40) }, everything(1.5));
    let nothing = Geometry::default();
    let still = Vec2::ZERO;
    let passes =
        [(&nothing, still, PassRole::Beauty), (&geometry, still, PassRole::Beauty), (&nothing, still, PassRole::Data)];
    let frame = draw_passes(&mut *vulkan, &target, &passes);
    assert!(samples(&frame, "depth.Z").iter().all(|&depth| depth == 1e10));
    let most = samples(&frame, "A").iter().copied().fold(0.0, f32::max);
    assert_eq!(most, 0.5);
}

#[test]
fn calls_out_of_order_are_errors_and_the_raster_goes_on() {
    let Some(mut vulkan) = support::open(&stage::scene()) else { return };
    let geometry = everything(1.5);
    let pass = |geometry| Pass { geometry, jitter_px: Vec2::ZERO, role: PassRole::BeautyAndData };
    let is_misuse = |result: Result<(), RasterError>| matches!(result, Err(RasterError::Misuse(_)));
    assert!(is_misuse(vulkan.draw(&pass(&geometry))), "draw before start");
    assert!(is_misuse(vulkan.finish().map(drop)), "finish before start");
    let mut beyond = geometry.clone();
    beyond.indices[7] = geometry.vertices.len() as u32;
    let mut outside = geometry.clone();
    outside.draws[1].indices.end = geometry.indices.len() as u32 + 3;
    let mut unknown = geometry.clone();
    unknown.draws[2].material = 99;
    for broken in [&beyond, &outside, &unknown] {
        vulkan.start(&target(60, 40)).unwrap();
        assert!(is_misuse(vulkan.draw(&pass(broken))));
        assert!(is_misuse(vulkan.finish().map(drop)), "a frame with a failed pass is gone");
    }
    vulkan.start(&target(60, 40)).unwrap();
    vulkan.draw(&pass(&geometry)).unwrap();
    assert!(is_misuse(vulkan.draw(&pass(&geometry))), "one beauty pass was announced");
    let fresh = draw_passes(&mut *vulkan, &target(60, 40), &[(&geometry, Vec2::ZERO, PassRole::BeautyAndData)]);
    assert!(samples(&fresh, "A").contains(&1.0));
}

#[test]
fn impossible_sizes_are_clear_errors() {
    let Some(mut vulkan) = support::open(&stage::scene()) else { return };
    let side = vulkan.max_side();
    assert!(side >= 4096, "{side}");
    for (width, height) in [(side + 1, 1), (1, side + 1), (100_000, 100_000), (0, 5), (5, 0)] {
        let error = vulkan.start(&target(width, height)).unwrap_err().to_string();
        assert!(error.contains("tiles") || error.contains("no pixels"), "{error}");
    }
    let strip = draw_passes(&mut *vulkan, &target(side, 1), &[]);
    assert_eq!(samples(&strip, "A").len(), side as usize);
}
