//! Turns a problem file into a scene and a shot, so that its pins can be dragged and keyed.
//!
//! In: the mesh, lattice and poses of a problem file. Out: the bytes of a .glb file, and the text of a shot. In 2D a frame height
//! is seen by a parallel camera, and the lattice lies on the screen; in 3D it lies in the scene. Poses become keys.

use crate::export::gltf::packed_glb;
use crate::files::GENERATOR;
use crate::lattice::Grid;
use crate::pipeline::PipelineError;
use crate::scene::Packed;
use crate::solve::problem_file::{Figure, FigurePart, FigurePose, Figures, read_figure};
use crate::solve::{EdgeWeights, Lambdas, PointPin, Scaling, Settings, Shape, nearest_barycentric};
use crate::spelling::escaped;
use serde_json::{Value, json};
use std::fmt::Write;
use std::ops::Range;
use std::path::Path;

/// Width of the frame divided by its height.
const ASPECT: f64 = 16.0 / 9.0;

/// Height of the frame, relative to what it has to show.
const MARGIN: f64 = 1.2;

/// Frames between two poses.
const BETWEEN: usize = 12;

/// Distance in depth of two parts of a flat figure, relative to its height.
const APART: f64 = 1e-4;

/// The colour of figures without parts.
const GREY: [u8; 3] = [190, 178, 160];

/// A problem as a scene and a shot.
#[derive(Clone, Debug)]
pub(crate) struct ProblemShot {
    /// The scene, a .glb file.
    pub glb: Vec<u8>,
    /// The text of the shot, which names the scene as it was asked for.
    pub text: String,
}

/// Reads a problem file; `scene` is the path by which the shot names the scene.
///
/// # Errors
/// [`PipelineError::Unusable`] if it is no problem file, or not a mesh of triangles.
pub(crate) fn problem_shot(path: &Path, scene: &str) -> Result<ProblemShot, PipelineError> {
    let unusable = |what: String, hint: &str| PipelineError::Unusable { what, hint: hint.to_owned() };
    let hint = "open a problem file as `pinwarp solve` reads it, or a shot, scene or picture";
    let figures = read_figure(path).map_err(|error| unusable(error.to_string(), hint))?;
    let is_empty = match &figures {
        Figures::Plane(figure) => figure.shape.triangles.is_empty(),
        Figures::Space(figure) => figure.shape.triangles.is_empty(),
    };
    if is_empty {
        let what = format!("{}: its shape has no triangles that could be drawn and pinned", path.display());
        return Err(unusable(what, "give it `triangles`"));
    }
    let (packed, text) = match &figures {
        Figures::Plane(figure) => (packed(figure), plane_text(figure, scene)),
        Figures::Space(figure) => (packed(figure), space_text(figure, scene)),
    };
    let glb = packed_glb(packed).map_err(|error| unusable(error.to_string(), hint))?;
    Ok(ProblemShot { glb, text })
}

/// Returns the parts with their triangles.
fn parts<const D: usize>(figure: &Figure<D>) -> Vec<(FigurePart, Range<usize>)> {
    let count = figure.shape.triangles.len();
    if figure.parts.is_empty() {
        return vec![(FigurePart { name: "shape".into(), color: GREY, triangles: count }, 0..count)];
    }
    let mut first = 0;
    let part = |part: &FigurePart| {
        first += part.triangles;
        (part.clone(), first - part.triangles..first)
    };
    figure.parts.iter().map(part).collect()
}

/// Returns the mesh as a glTF file: one primitive per part.
fn packed<const D: usize>(figure: &Figure<D>) -> Packed {
    let apart = if D == 2 { APART * extent(figure)[1] } else { 0.0 };
    let mut packed =
        Packed { json: json!({ "asset": { "version": "2.0", "generator": GENERATOR } }), binary: Vec::new() };
    let (mut primitives, mut materials, mut views, mut accessors) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (number, (part, range)) in parts(figure).into_iter().enumerate() {
        let triangles = &figure.shape.triangles[range];
        let mut vertices: Vec<u32> = triangles.iter().flatten().copied().collect();
        vertices.sort_unstable();
        vertices.dedup();
        let place = |&vertex: &u32| {
            let point = figure.shape.points[vertex as usize];
            let z = point.get(2).copied().unwrap_or(number as f64 * apart);
            [point[0] as f32, point[1] as f32, z as f32]
        };
        let points: Vec<[f32; 3]> = vertices.iter().map(place).collect();
        let bound = |pick: fn(f32, f32) -> f32| {
            points.iter().copied().reduce(|a, b| std::array::from_fn(|axis| pick(a[axis], b[axis])))
        };
        let index = |corner: &u32| vertices.partition_point(|vertex| vertex < corner) as u32;
        let corners: Vec<u32> = triangles.iter().flatten().map(index).collect();
        let mut view = |bytes: &[u8]| {
            views.push(json!({ "buffer": 0, "byteOffset": packed.binary.len(), "byteLength": bytes.len() }));
            packed.binary.extend_from_slice(bytes);
            views.len() - 1
        };
        let (at, of) = (view(bytemuck::cast_slice(&points)), view(bytemuck::cast_slice(&corners)));
        accessors.push(json!({ "bufferView": at, "componentType": 5126, "type": "VEC3", "count": points.len(),
            "min": bound(f32::min), "max": bound(f32::max) }));
        accessors.push(json!({ "bufferView": of, "componentType": 5125, "type": "SCALAR", "count": corners.len() }));
        materials.push(material(&part));
        primitives
            .push(json!({ "attributes": { "POSITION": 2 * number }, "indices": 2 * number + 1, "material": number }));
    }
    let root = &mut packed.json;
    root["extensionsUsed"] = json!(["KHR_materials_unlit"]);
    root["scene"] = json!(0);
    root["scenes"] = json!([{ "nodes": [0] }]);
    root["nodes"] = json!([{ "name": name_of(figure), "mesh": 0 }]);
    root["meshes"] = json!([{ "name": name_of(figure), "primitives": primitives }]);
    (root["materials"], root["bufferViews"], root["accessors"]) = (json!(materials), json!(views), json!(accessors));
    packed
}

fn material(part: &FigurePart) -> Value {
    let linear = part.color.map(|code| {
        let code = f64::from(code) / 255.0;
        if code <= 0.04045 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
    });
    let [red, green, blue] = linear;
    json!({ "name": part.name, "doubleSided": true, "extensions": { "KHR_materials_unlit": {} },
        "pbrMetallicRoughness": { "baseColorFactor": [red, green, blue, 1.0], "metallicFactor": 0.0 } })
}

/// Returns the name of the figure's node.
fn name_of<const D: usize>(figure: &Figure<D>) -> String {
    let name = escaped(&figure.name).replace(['*', '?', '!', '"', '\\'], "_");
    if name.trim().is_empty() { "Shape".to_owned() } else { name }
}

/// Returns width and height of all that a pose may show.
fn extent<const D: usize>(figure: &Figure<D>) -> [f64; 2] {
    let [low, high] = bounds(figure);
    [0, 1].map(|axis| (high[axis] - low[axis]).max(1e-6))
}

/// Returns the lowest and highest corner of the shape and of all targets.
fn bounds<const D: usize>(figure: &Figure<D>) -> [[f64; D]; 2] {
    let targets = figure.poses.iter().flat_map(|pose| &pose.pins).map(|pin| pin.target);
    let points = figure.shape.points.iter().copied().chain(targets).map(|point| [point; 2]);
    let join = |[a, b]: [[f64; D]; 2], [c, d]: [[f64; D]; 2]| {
        [std::array::from_fn(|axis| a[axis].min(c[axis])), std::array::from_fn(|axis| b[axis].max(d[axis]))]
    };
    points.reduce(join).unwrap_or([[0.0; D], [1.0; D]])
}

fn plane_text(figure: &Figure<2>, scene: &str) -> String {
    let [width, height] = extent(figure);
    let height = MARGIN * height.max(width / ASPECT);
    let [low, high] = bounds(figure);
    let center = [0, 1].map(|axis| 0.5 * (low[axis] + high[axis]));
    let seen =
        |point: [f64; 2]| [(point[0] - center[0]) / height + 0.5 * ASPECT, (point[1] - center[1]) / height + 0.5];
    let ([left, bottom], [right, top]) = (seen(figure.grid.lo), seen(figure.grid.hi));
    let camera = format!("{{ position = [{:?}, {:?}, {:?}], ortho = {height:?} }}", center[0], center[1], 4.0 * height);
    let bounds = format!("[{left:?}, {bottom:?}, {right:?}, {top:?}]");
    let mut text =
        head(figure, (scene, &camera), &format!("dims = {:?}, box = {{ fixed = {bounds} }}", figure.grid.dims));
    pins(&mut text, figure, |by| by.iter().map(|x| x / height).collect());
    text
}

fn space_text(figure: &Figure<3>, scene: &str) -> String {
    let Grid { dims, lo, hi, .. } = &figure.grid;
    let bounds = [lo, hi].map(|corner| corner.map(|x| format!("{x:?}")).join(", ")).join(", ");
    let lattice = format!("space = \"world\", dims = {dims:?}, box = {{ fixed = [{bounds}] }}");
    let mut text = head(figure, (scene, "\"three-quarter\""), &lattice);
    pins(&mut text, figure, |by| by.to_vec());
    text
}

/// Returns the shot up to its pins.
fn head<const D: usize>(figure: &Figure<D>, (scene, camera): (&str, &str), lattice: &str) -> String {
    let last = 1 + BETWEEN * figure.poses.len().saturating_sub(1).max(1);
    let settings = &figure.settings;
    // Not all energies have edge weights.
    let has_weights = settings.weights != EdgeWeights::Uniform;
    let weights = if has_weights { format!(", weights = {}", json!(settings.weights)) } else { String::new() };
    let weights = weights + &terms(settings);
    format!(
        "# A problem file as a shot.\n\
         version = 1\nscene   = {scene:?}\ncamera  = {camera}\nframes  = {{ first = 1, last = {last}, rate = 24 }}\n\
         size    = [1920, 1080]\n\n[[layer]]\nname    = {:?}\n\
         lattice = {{ {lattice}, basis = {}, topology = \"plain\" }}\n\
         solve   = {{ energy = {}, regularizer = {}{weights}, temporal = 0 }}\n{}",
        name_of(figure),
        json!(figure.grid.basis),
        json!(settings.energy),
        json!(settings.regularizer),
        moved_handles(figure)
    )
}

/// Returns the weights of the terms and the number of iterations, as far as the problem has its own.
fn terms(settings: &Settings) -> String {
    let mut text = String::new();
    if settings.scaling == Scaling::Plain {
        let Lambdas { shape, pins, handles, regularizer } = settings.lambdas;
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            ",\n            lambdas = {{ ml = {shape:?}, mp = {pins:?}, gp = {handles:?}, gr = {regularizer:?} }}"
        );
    }
    if settings.acceleration == 0 {
        let _ = write!(text, ", iterations = {}", settings.iteration_limit);
    }
    text
}

/// Returns the handles that the problem moves.
fn moved_handles<const D: usize>(figure: &Figure<D>) -> String {
    let grid = &figure.grid;
    let mut text = String::new();
    for handle in &figure.handles {
        let rest = grid.rest_handle(handle.index);
        let by: Vec<f64> = (0..D).map(|axis| (handle.target[axis] - rest[axis]) / grid.size(axis)).collect();
        let index = grid.handle_coords(handle.index);
        // Writing to a string cannot fail.
        let _ =
            write!(text, "\n  [[layer.handle]]\n  index = {index:?}\n  keys  = [{{ frame = 1, offset = {by:?} }}]\n");
    }
    text
}

/// Appends the pins: those of all poses at one point are one pin, with a key for each pose.
fn pins<const D: usize>(text: &mut String, figure: &Figure<D>, offset: impl Fn([f64; D]) -> Vec<f64>) {
    let mut points: Vec<[f64; D]> = Vec::new();
    for pin in figure.poses.iter().flat_map(|pose| &pose.pins) {
        if !points.contains(&pin.at) {
            points.push(pin.at);
        }
    }
    let parts = parts(figure);
    for (number, point) in points.iter().enumerate() {
        let Some((triangle, weights)) = nearest(&figure.shape, point) else { continue };
        let primitive = parts.iter().position(|(_, range)| range.contains(&triangle)).unwrap_or(0);
        let own = triangle - parts.get(primitive).map_or(0, |(_, range)| range.start);
        let key = |(pose, own): (usize, &FigurePose<D>)| {
            let pin: &PointPin<D> = own.pins.iter().find(|pin| pin.at == *point)?;
            let by = offset(std::array::from_fn(|axis| pin.target[axis] - pin.at[axis]));
            Some(format!("{{ frame = {}, offset = {by:?}, ease = \"smooth\" }}", 1 + BETWEEN * pose))
        };
        let keys: Vec<String> = figure.poses.iter().enumerate().filter_map(key).collect();
        let _ = write!(
            text,
            "\n  [[layer.pin]]\n  name   = \"pin {}\"\n  anchor = {{ node = {:?}, primitive = {primitive}, triangle = {own}, \
             barycentric = {weights:?} }}\n  keys   = [{}]\n",
            number + 1,
            name_of(figure),
            keys.join(",\n            ")
        );
    }
}

/// Returns the nearest triangle to a point, the last of several, and the barycentric coordinates there.
fn nearest<const D: usize>(shape: &Shape<D>, point: &[f64; D]) -> Option<(usize, [f64; 3])> {
    let mut found: Option<(f64, usize, [f64; 3])> = None;
    for (triangle, corners) in shape.triangles.iter().enumerate() {
        let places = corners.map(|corner| shape.points[corner as usize]);
        let weights = nearest_barycentric(point, &places);
        let at = |axis: usize| (0..3).map(|corner| weights[corner] * places[corner][axis]).sum::<f64>();
        let far = (0..D).map(|axis| (at(axis) - point[axis]).powi(2)).sum::<f64>();
        if found.is_none_or(|(least, ..)| far <= least) {
            found = Some((far, triangle, weights));
        }
    }
    found.map(|(_, triangle, weights)| (triangle, weights))
}
