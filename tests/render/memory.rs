//! What a render holds for every triangle of a scene.

use super::support::Studio;
use crate::internal::skip::skip;
use pinwarp::pipeline::PreparedShot;
use pinwarp::raster::Raster;
use pinwarp::raster::cpu::CpuRaster;
use pinwarp::raster::vulkan::VulkanRaster;
use pinwarp::raster::{DeviceChoice, RasterError};
use pinwarp::shot::Shot;
use std::path::Path;
use std::process::Command;

/// Bytes per triangle that a render of one frame may take in all, with a layer and all channels: the scene, three poses
/// (motion needs the frames beside it), the geometry; on a driver also what is uploaded and what the driver keeps. At half
/// a million triangles the heap still keeps freed blocks: 2,000,000 triangles take 214 bytes each on the CPU.
const LIMIT_ON_CPU: u64 = 300;
const LIMIT_ON_DRIVER: u64 = 500;

/// The same where the layer is solved over time, by threads of their own, whose heaps keep blocks, too.
const LIMIT_OVER_TIME: u64 = 200;

/// A ball of 2·n² triangles as a binary glTF: positions, normals, texture coordinates, indices.
fn write_ball(path: &Path, n: u32) {
    let (mut floats, mut indices) = ([Vec::new(), Vec::new(), Vec::new()], Vec::<u32>::new());
    for (row, column) in (0..=n).flat_map(|row| (0..=n).map(move |column| (row, column))) {
        let (u, v) = (column as f32 / n as f32, row as f32 / n as f32);
        let (around, down) = (u * std::f32::consts::TAU, v * std::f32::consts::PI);
        let normal = [down.sin() * around.sin(), down.cos(), down.sin() * around.cos()];
        floats[0].extend(normal);
        floats[1].extend(normal);
        floats[2].extend([u, v]);
    }
    for (row, column) in (0..n).flat_map(|row| (0..n).map(move |column| (row, column))) {
        let a = row * (n + 1) + column;
        indices.extend([a, a + n + 1, a + n + 2, a, a + n + 2, a + 1]);
    }
    let mut parts: Vec<&[u8]> = floats.iter().map(|floats| bytemuck::cast_slice(floats)).collect();
    parts.push(bytemuck::cast_slice(&indices));
    let mut offset = 0;
    let views: Vec<_> = parts
        .iter()
        .map(|part| {
            offset += part.len();
            serde_json::json!({ "buffer": 0, "byteOffset": offset - part.len(), "byteLength": part.len() })
        })
        .collect();
    let vertices = (n + 1) * (n + 1);
    let accessor = |view, count, kind| {
        let component = if view == 3 { 5125 } else { 5126 };
        serde_json::json!({ "bufferView": view, "componentType": component, "count": count, "type": kind,
            "min": if view == 0 { serde_json::json!([-1, -1, -1]) } else { serde_json::Value::Null },
            "max": if view == 0 { serde_json::json!([1, 1, 1]) } else { serde_json::Value::Null } })
    };
    let mut accessors = vec![
        accessor(0, vertices, "VEC3"),
        accessor(1, vertices, "VEC3"),
        accessor(2, vertices, "VEC2"),
        accessor(3, 6 * n * n, "SCALAR"),
    ];
    for accessor in &mut accessors[1..] {
        let fields = accessor.as_object_mut().expect("an object");
        fields.remove("min");
        fields.remove("max");
    }
    let attributes = serde_json::json!({ "POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2 });
    let scene = serde_json::json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0, "name": "Ball" }],
        "meshes": [{ "primitives": [{ "attributes": attributes, "indices": 3 }] }],
        "buffers": [{ "byteLength": offset }], "bufferViews": views, "accessors": accessors,
    });
    let mut json = scene.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let chunk = |kind: u32, bytes: usize| [(bytes as u32).to_le_bytes(), kind.to_le_bytes()].concat();
    let total = 12 + 8 + json.len() + 8 + offset;
    let mut file = [*b"glTF", 2u32.to_le_bytes(), (total as u32).to_le_bytes()].concat();
    file.extend(chunk(0x4E4F_534A, json.len()));
    file.extend(&json);
    file.extend(chunk(0x004E_4942, offset));
    parts.iter().for_each(|part| file.extend(*part));
    std::fs::write(path, file).expect("the folder can be written to");
}

/// Not a test by itself: renders a frame of a ball in a process of its own and prints the most memory it had, KiB.
#[test]
#[ignore = "run by the tests below"]
fn probe() {
    let wanted = |name| std::env::var(name).ok();
    let side = wanted("PINWARP_SIDE").and_then(|side| side.parse().ok()).unwrap_or(100);
    let folder = tempfile::tempdir().expect("a temporary folder");
    write_ball(&folder.path().join("ball.glb"), side);
    let temporal = wanted("PINWARP_TEMPORAL").unwrap_or_default();
    let text = "version = 1\nscene = \"ball.glb\"\nframes = { first = 1, last = 2, rate = 24 }\nsize = [320, 180]\n\
                samples = 4\n[[layer]]\nname = \"all\"\nlattice = { dims = [6, 6] }\n\
                solve = { temporal = TEMPORAL }\n[[layer.pin]]\nname = \"side\"\n\
                anchor = { screen = [0.9, 0.5], frame = 1 }\nkeys = [{ frame = 1, offset = [0.1, 0.05] }]\n";
    let shot =
        Shot::parse(&text.replace("TEMPORAL", &temporal), &folder.path().join("shot.toml")).expect("a right shot");
    let studio = Studio::of_shot(shot);
    let has_driver = wanted("PINWARP_ON").is_some_and(|on| on == "vulkan");
    let open = |prepared: &PreparedShot| -> Box<dyn Raster> {
        if !has_driver {
            return Box::new(CpuRaster::new(&prepared.scene));
        }
        match VulkanRaster::open(&DeviceChoice::Vulkan, &prepared.scene) {
            Ok(raster) => Box::new(raster),
            Err(RasterError::NoDevice { what }) => {
                println!("PROBE none: {what}");
                std::process::exit(0)
            }
            Err(error) => panic!("{error}"),
        }
    };
    studio.files_by(&[1], |prepared| Boxed(open(prepared)));
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    match status.lines().find_map(|line| line.strip_prefix("VmHWM:")) {
        Some(most) => println!("PROBE {}", most.trim().trim_end_matches("kB").trim()),
        None => println!("PROBE none: the system does not tell"),
    }
}

/// Either raster.
struct Boxed(Box<dyn Raster>);

impl Raster for Boxed {
    fn name(&self) -> String {
        self.0.name()
    }
    fn class(&self) -> pinwarp::raster::DeviceClass {
        self.0.class()
    }
    fn max_side(&self) -> u32 {
        self.0.max_side()
    }
    fn start(&mut self, target: &pinwarp::raster::Target) -> Result<(), RasterError> {
        self.0.start(target)
    }
    fn draw(&mut self, pass: &pinwarp::raster::Pass) -> Result<(), RasterError> {
        self.0.draw(pass)
    }
    fn finish(&mut self) -> Result<pinwarp::image::Frame, RasterError> {
        self.0.finish()
    }
}

/// The most memory that a render of a ball had, KiB; `None`: it cannot be told here, said so.
fn most_kib(on: &str, temporal: &str, side: u32) -> Option<u64> {
    let arguments = ["--exact", "internal::render::memory::probe", "--ignored", "--nocapture"];
    let mut command = Command::new(std::env::current_exe().expect("this program"));
    command.args(arguments).env("PINWARP_SIDE", side.to_string()).env("PINWARP_ON", on);
    command.env("PINWARP_TEMPORAL", temporal);
    let run = command.output().expect("it starts");
    let text = String::from_utf8_lossy(&run.stdout);
    let found = text.lines().find_map(|line| line.split_once("PROBE ").map(|(_, found)| found.to_owned()));
    let found = found.unwrap_or_else(|| panic!("{text}{}", String::from_utf8_lossy(&run.stderr)));
    if let Some(reason) = found.strip_prefix("none: ") {
        skip(reason);
        return None;
    }
    Some(found.parse().expect("a number"))
}

fn assert_lean(on: &str, temporal: &str, limit: u64) {
    // The difference of two renders leaves out what a program, a driver and a frame take.
    let (small, large) = (100, 500);
    let Some((least, most)) = most_kib(on, temporal, small).zip(most_kib(on, temporal, large)) else { return };
    let triangles = 2 * u64::from(large * large - small * small);
    let each = most.saturating_sub(least) * 1024 / triangles;
    eprintln!("{on}, temporal weight {temporal}: {each} bytes a triangle");
    assert!(each <= limit, "{on}, temporal weight {temporal}: {each} bytes a triangle, {least} KiB and {most} KiB");
    assert!(each >= 40, "{on}: {each} bytes are less than a mesh has: the measurement is wrong");
}

#[test]
fn a_triangle_takes_few_bytes_on_the_cpu() {
    assert_lean("cpu", "0", LIMIT_ON_CPU);
    assert_lean("cpu", "0.3", LIMIT_ON_CPU + LIMIT_OVER_TIME);
}

#[test]
fn a_triangle_takes_few_bytes_on_a_device() {
    assert_lean("vulkan", "0", LIMIT_ON_DRIVER);
    assert_lean("vulkan", "0.3", LIMIT_ON_DRIVER + LIMIT_OVER_TIME);
}
