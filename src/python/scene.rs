//! Scenes, and the screen positions of their meshes.
//!
//! In: a glTF file, a camera, a frame. Out: names; projected points of every part.

use super::arrays::{from_points, from_triangles};
use super::failure::Failure;
use super::options::Options;
use super::work::away;
use crate::pipeline::PreparedShot;
use crate::scene;
use crate::screen;
use crate::shot::{CameraRule, ClipName, Shot, Source};
use crate::space::FrameSize;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A minimal shot file; scene, frame and other settings are filled in afterwards.
const BARE: &str = "scene = \"scene\"\nframes = { first = 1, last = 1 }\n";

/// A glTF scene (.glb or .gltf), seen by a camera over time.
///
/// camera: name of a camera or of its node, or a view such as "front" or "three-quarter"; default: the scene's first camera, or a view of
///     the whole scene if it has none.
/// size: (width, height) of the frame in pixels.
/// rate: frames per second; the animation starts at frame 1.
/// clip: name of the animation clip; default: the first.
#[pyclass(frozen, module = "pinwarp")]
pub(super) struct Scene {
    pub(super) prepared: Arc<PreparedShot>,
}

#[pymethods]
impl Scene {
    #[new]
    #[pyo3(
        signature = (path, **options),
        text_signature = "(path, *, camera=None, size=(1920, 1080), rate=24.0, clip=None)"
    )]
    fn new(py: Python<'_>, path: PathBuf, options: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let mut options = Options::new(options);
        let [width, height] = options.take::<[u32; 2]>("size")?.unwrap_or([1920, 1080]);
        let mut shot = Shot::parse(BARE, &path).map_err(Failure::from)?;
        shot.camera = options.take("camera")?.map_or(shot.camera, CameraRule::Named);
        shot.clip = options.take("clip")?.map(ClipName::Name);
        shot.frames.rate = options.take("rate")?.unwrap_or(shot.frames.rate);
        options.end()?;
        if width == 0 || height == 0 || width.max(height) > 1 << 16 {
            return Err(Failure::argument(
                "size",
                format!("is ({width}, {height})"),
                "give sides of 1 to 65536 pixels",
            )
            .into());
        }
        if !(0.01..=1000.0).contains(&shot.frames.rate) {
            return Err(
                Failure::argument("rate", format!("is {}", shot.frames.rate), "keep it within 0.01 to 1000").into()
            );
        }
        (shot.size, shot.source) = (FrameSize::new(width, height), Source::Scene(path.clone()));
        let prepared = away(py, None, |_| Ok(PreparedShot::with_scene(shot, scene::load(&path)?)?))?;
        Ok(Self { prepared: Arc::new(prepared) })
    }

    /// Path of the scene file.
    #[getter]
    fn path(&self) -> &Path {
        &self.prepared.scene.path
    }

    /// Names of all nodes.
    #[getter]
    fn nodes(&self) -> Vec<&str> {
        self.prepared.scene.nodes.iter().map(|node| node.name.as_str()).collect()
    }

    /// Names of the nodes with cameras.
    #[getter]
    fn cameras(&self) -> Vec<&str> {
        let nodes = self.prepared.scene.nodes.iter().filter(|node| node.camera.is_some());
        nodes.map(|node| node.name.as_str()).collect()
    }

    /// Animation clips: name and length in seconds.
    #[getter]
    fn clips(&self) -> Vec<(&str, f32)> {
        self.prepared.scene.clips.iter().map(|clip| (clip.name.as_str(), clip.end_secs)).collect()
    }

    /// Notes on what was chosen or ignored when the scene was loaded.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.prepared.notes.clone()
    }

    /// Returns the screen positions of all meshes at a frame, which may lie between frames, before any warp: a list with one dict per
    /// part of a mesh.
    ///
    /// node: name of the node.
    /// points: float64 (V, 2), in frame heights, x right, y up; NaN behind the camera.
    /// depth: float64 (V,), metres along the view axis.
    /// triangles: uint32 (T, 3), indices into points.
    fn project<'py>(&self, py: Python<'py>, frame: f64) -> PyResult<Bound<'py, PyList>> {
        projected(py, &self.prepared, frame)
    }

    fn __repr__(&self) -> String {
        format!("<Scene {}>", self.prepared.scene.path.display())
    }
}

/// A projected part.
struct Part<'a> {
    node: &'a str,
    points: Vec<[f64; 2]>,
    depth: Vec<f64>,
    triangles: Vec<[u32; 3]>,
}

/// Projects the parts of a prepared shot to the screen, before any warp.
pub(super) fn projected<'py>(py: Python<'py>, prepared: &PreparedShot, frame: f64) -> PyResult<Bound<'py, PyList>> {
    if !frame.is_finite() {
        return Err(Failure::argument("frame", format!("is {frame}"), "give a finite number").into());
    }
    let parts = py.detach(|| {
        let (pose, camera) = prepared.view(frame);
        let mesh = screen::project(&pose, &camera);
        let part = |(posed, seen): (&crate::pose::PosedPart, &screen::ScreenPart)| Part {
            node: &prepared.scene.nodes[posed.node].name,
            points: seen.vertices.iter().map(|vertex| place(*vertex)).collect(),
            depth: seen.vertices.iter().map(|vertex| vertex.depth).collect(),
            triangles: screen::primitive(&prepared.scene, posed).triangles.clone(),
        };
        pose.parts.iter().zip(&mesh.parts).map(part).collect::<Vec<_>>()
    });
    let list = PyList::empty(py);
    for Part { node, points, depth, triangles } in parts {
        let dict = PyDict::new(py);
        dict.set_item("node", node)?;
        dict.set_item("points", from_points(py, points)?)?;
        dict.set_item("depth", PyArray1::from_vec(py, depth))?;
        dict.set_item("triangles", from_triangles(py, triangles)?)?;
        list.append(dict)?;
    }
    Ok(list)
}

/// Returns a screen position; NaN behind the camera.
fn place(vertex: screen::Projected) -> [f64; 2] {
    if vertex.w > 0.0 { vertex.point().0.to_array() } else { [f64::NAN; 2] }
}
