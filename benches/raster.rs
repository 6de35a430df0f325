//! Time of a frame by stage: a bumpy ball of 100,000 triangles, all channels.
//!
//! Run with `cargo bench --bench raster`. Prints medians in milliseconds.

#[path = "../tests/support/ball.rs"]
mod ball;

use glam::{Vec2, Vec4};
use pinwarp::raster::cpu::{CpuRaster, StageTimes};
use pinwarp::raster::vulkan::VulkanRaster;
use pinwarp::raster::{ChannelGroup, DeviceChoice, Geometry, Pass, PassRole, Raster, Target};
use pinwarp::scene::{Material, Scene};
use pinwarp::space::FrameSize;
use std::time::{Duration, Instant};

/// Frames drawn per case; the median is printed.
const RUNS: usize = 9;

/// Rings and segments of the ball: 100,000 triangles.
const FINENESS: (u32, u32) = (200, 250);

struct Case {
    name: &'static str,
    frame: FrameSize,
    samples: u32,
}

fn main() {
    let cases = [
        Case { name: "1920x1080, 1 sample", frame: FrameSize::new(1920, 1080), samples: 1 },
        Case { name: "3840x2160, 1 sample", frame: FrameSize::new(3840, 2160), samples: 1 },
        Case { name: "1920x1080, 16 samples", frame: FrameSize::new(1920, 1080), samples: 16 },
    ];
    let material =
        Material { base_color: Vec4::new(0.7, 0.5, 0.4, 1.0), metallic: 0.2, roughness: 0.5, ..Material::default() };
    let scene = Scene { materials: vec![material], ..Scene::default() };
    bench_vulkan(&scene, &cases);
    let mut raster = CpuRaster::new(&scene);
    println!("{}, {} triangles, all channels; median of {RUNS}, ms", raster.name(), 2 * FINENESS.0 * FINENESS.1);
    println!("{:<24}{:>9}{:>9}{:>9}{:>9}{:>12}", "", "whole", "bin", "draw", "resolve", "cpu, mean");
    for case in &cases {
        let geometry = ball::ball(case.frame, FINENESS, 0.02);
        let cpu_before = cpu_secs();
        let mut times: Vec<(Duration, StageTimes)> =
            (0..RUNS).map(|_| (draw_frame(&mut raster, &geometry, case), raster.stage_times())).collect();
        let cpu = cpu_before.zip(cpu_secs()).map_or("-".into(), |(a, b)| format!("{:.1}", (b - a) * 1e3 / RUNS as f64));
        times.sort_by_key(|time| time.0);
        let (whole, stages) = times[RUNS / 2];
        let ms = |time: Duration| format!("{:.1}", time.as_secs_f64() * 1e3);
        let [bin, draw, resolve] = [stages.bin, stages.tiles, stages.resolve].map(ms);
        println!("{:<24}{:>9}{bin:>9}{draw:>9}{resolve:>9}{cpu:>12}", case.name, ms(whole));
    }
}

/// The Vulkan raster next to a bare draw and copy of the same mesh with the same shaders and images, alternating. The bare
/// frame is timed until its bytes are in mapped memory (bare) and until they are in the program's own memory (kept). The
/// ratios compare the whole frame with one bare frame per sample, in elapsed time and in processor time.
fn bench_vulkan(scene: &Scene, cases: &[Case]) {
    let mut raster = match VulkanRaster::open(&DeviceChoice::Vulkan, scene) {
        Ok(raster) => raster,
        Err(error) => return println!("SKIPPED: {error}"),
    };
    println!("{}, {} triangles, all channels; median of {RUNS}, ms", raster.name(), 2 * FINENESS.0 * FINENESS.1);
    let heads = ["whole", "upload", "draw", "read", "bare", "kept", "to bare", "to kept", "on cores"];
    println!("{:<24}{}", "", heads.map(|head| format!("{head:>9}")).concat());
    for case in cases {
        let numbers = measure_vulkan(&mut raster, case);
        println!("{:<24}{}", case.name, numbers.map(|number| format!("{number:>9.2}")).concat());
    }
}

/// The numbers of one row.
fn measure_vulkan(raster: &mut VulkanRaster, case: &Case) -> [f64; 9] {
    let geometry = ball::ball(case.frame, FINENESS, 0.02);
    let bare_target = target(case, 1);
    let (mut whole, mut bare, mut kept, mut cores) = (Vec::new(), Vec::new(), Vec::new(), [0.0; 2]);
    for run in 0..=RUNS {
        let start = cpu_secs().unwrap_or(0.0);
        let time = draw_frame(raster, &geometry, case);
        let (stages, middle) = (raster.stage_times(), cpu_secs().unwrap_or(0.0));
        let times = raster.time_bare_frame(&bare_target, &geometry).expect("the window is small");
        // The first frame is not counted, because it creates pipelines and images.
        if run > 0 {
            whole.push((time, stages));
            bare.push(times.device);
            kept.push(times.device + times.host);
            cores[0] += middle - start;
            cores[1] += cpu_secs().unwrap_or(0.0) - middle;
        }
    }
    whole.sort_by_key(|time| time.0);
    bare.sort();
    kept.sort();
    let ms = |time: Duration| time.as_secs_f64() * 1e3;
    let (time, stages) = whole[RUNS / 2];
    let (bare, kept, samples) = (ms(bare[RUNS / 2]), ms(kept[RUNS / 2]), f64::from(case.samples));
    let [upload, draw, read] = [stages.upload, stages.draw, stages.read].map(ms);
    let ratio = |to: f64| ms(time) / (to * samples);
    [ms(time), upload, draw, read, bare, kept, ratio(bare), ratio(kept), cores[0] / (cores[1] * samples)]
}

/// Processor time of all threads of the process, which other processes affect less than elapsed time; Linux only.
fn cpu_secs() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    // The fields after the program's name. User and system time are the 12th and 13th of them, in hundredths of a second.
    let fields: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
    Some((fields.get(11)?.parse::<f64>().ok()? + fields.get(12)?.parse::<f64>().ok()?) / 100.0)
}

fn target(case: &Case, beauty_passes: u32) -> Target {
    let channels =
        vec![ChannelGroup::Beauty, ChannelGroup::Depth, ChannelGroup::Motion, ChannelGroup::Normal, ChannelGroup::Id];
    Target { frame: case.frame, window: case.frame.window(), channels, beauty_passes }
}

fn draw_frame(raster: &mut dyn Raster, geometry: &Geometry, case: &Case) -> Duration {
    let begin = Instant::now();
    raster.start(&target(case, case.samples)).expect("the window is small");
    for sample in 0..case.samples {
        let jitter_px = Vec2::new((sample % 4) as f32, (sample / 4) as f32) / 4.0 - 0.375;
        let role = if sample == 0 { PassRole::BeautyAndData } else { PassRole::Beauty };
        let pass = Pass { geometry, jitter_px, role };
        raster.draw(&pass).expect("a frame was started");
    }
    std::hint::black_box(raster.finish().expect("a frame was started"));
    begin.elapsed()
}
