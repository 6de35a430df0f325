//! Shots: opening, checking, rendering into arrays or files.
//!
//! In: a shot file and overrides. Out: frames, reports, lattices.

use super::drawer::Drawer;
use super::failure::Failure;
use super::frame::rendered;
use super::lattice_file::LatticeFile;
use super::named::{channel_groups, device, group_names};
use super::options::Options;
use super::report::plain;
use super::scene::{Scene, projected};
use super::sequence::RenderedFrames;
use super::work::{Watch, away};
use crate::image::SequencePath;
use crate::pipeline::{self, Event, Existing, FrameChecks, FrameReport, PreparedShot, RenderOptions};
use crate::shot::CameraRule;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyRange};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// An open shot file, with its scene loaded and its pins anchored.
///
/// camera: replaces the shot's camera.
/// scale: resolution relative to the shot's size.
/// samples: samples per pixel.
/// channels: channel groups, such as ["beauty", "depth"].
/// output: path with a frame counter, for `write`.
/// allow_outside: allows the scene to refer to files outside its folder.
///
/// Frame numbers are the shot's. Several threads may use one shot; they take turns when it draws.
#[pyclass(frozen, module = "pinwarp")]
pub(super) struct Shot {
    prepared: Arc<PreparedShot>,
    drawer: Arc<Drawer>,
}

/// The result of a check.
#[derive(Serialize)]
struct CheckReport {
    notes: Vec<String>,
    frames: Vec<FrameReport>,
    failures: Vec<FrameFailure>,
}

/// A frame that failed.
#[derive(Serialize)]
struct FrameFailure {
    frame: i32,
    error: String,
}

/// The result of a render into files.
#[derive(Serialize)]
struct WriteReport {
    #[serde(flatten)]
    summary: pipeline::Summary,
    failures: Vec<FrameFailure>,
    warnings: Vec<(i32, String)>,
}

#[pymethods]
impl Shot {
    #[new]
    #[pyo3(
        signature = (path, **options),
        text_signature = "(path, *, camera=None, scale=1.0, samples=None, channels=None, output=None, allow_outside=False)"
    )]
    fn new(py: Python<'_>, path: PathBuf, options: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let mut shot = py.detach(|| crate::shot::Shot::read(&path)).map_err(Failure::from)?;
        let mut options = Options::new(options);
        shot.camera = options.take("camera")?.map_or(shot.camera, CameraRule::Named);
        shot.samples = options.take("samples")?.unwrap_or(shot.samples);
        shot.output.path = options.take("output")?.unwrap_or(shot.output.path);
        shot.allow_outside = options.take("allow_outside")?.unwrap_or(false);
        let scale: f64 = options.take("scale")?.unwrap_or(1.0);
        if let Some(names) = options.take::<Vec<String>>("channels")? {
            shot.output.channels = channel_groups(&names)?;
        }
        options.end()?;
        if !(scale > 0.0 && scale <= 16.0) {
            return Err(Failure::argument("scale", format!("is {scale}"), "give a factor above 0 and up to 16").into());
        }
        if !(1..=4096).contains(&shot.samples) {
            return Err(Failure::argument("samples", format!("is {}", shot.samples), "give 1 to 4096 a pixel").into());
        }
        shot.size = shot.size.scaled(scale);
        let prepared = away(py, None, |_| Ok(PreparedShot::new(shot)?))?;
        let prepared = Arc::new(prepared);
        Ok(Self { drawer: Arc::new(Drawer::new(Arc::clone(&prepared))), prepared })
    }

    /// Path of the shot file.
    #[getter]
    fn path(&self) -> &Path {
        &self.prepared.shot.path
    }

    /// The shot's frames as a range, which includes the last frame.
    #[getter]
    fn frames<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyRange>> {
        let frames = self.prepared.shot.frames;
        PyRange::new(py, frames.first as isize, frames.last as isize + 1)
    }

    /// Frames per second.
    #[getter]
    fn rate(&self) -> f64 {
        self.prepared.shot.frames.rate
    }

    /// Width and height of the frame in pixels.
    #[getter]
    fn size(&self) -> (u32, u32) {
        (self.prepared.shot.size.width, self.prepared.shot.size.height)
    }

    /// Names of the layers.
    #[getter]
    fn layers(&self) -> Vec<&str> {
        self.prepared.shot.layers.iter().map(|layer| layer.name.as_str()).collect()
    }

    /// Channel groups of a rendered frame.
    #[getter]
    fn channels(&self) -> Vec<&'static str> {
        group_names(&self.prepared.shot.output.channels)
    }

    /// Output path of `write`.
    #[getter]
    fn output(&self) -> &Path {
        &self.prepared.shot.output.path
    }

    /// Notes on what was chosen or ignored when the shot was opened.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.prepared.notes.clone()
    }

    /// The scene of the shot; for pictures and plates, the flat cards that represent them.
    #[getter]
    fn scene(&self) -> Scene {
        Scene { prepared: Arc::clone(&self.prepared) }
    }

    /// Renders a frame in memory and returns a Frame: a dict of channels by their names in EXR files ("R", "depth.Z").
    ///
    /// Each channel is a float32 array (H, W) with rows from the top, scene-linear, colour multiplied with alpha. Nothing is copied.
    /// EXR files hold the same samples, with colour rounded to half.
    ///
    /// device: "auto", "cpu", "vulkan" or the name of a device.
    /// progress: called with (0, 1) about twenty times per second; False cancels.
    #[pyo3(signature = (frame, device="auto", progress=None))]
    fn render<'py>(
        &self,
        py: Python<'py>,
        frame: i32,
        device: &str,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let choice = self::device(device)?;
        let drawn = away(py, progress, |watch| {
            watch.tell(0, 1);
            let drawn = self.drawer.draw(frame, &choice, watch)?;
            watch.tell(1, 1);
            Ok(drawn)
        })?;
        rendered(py, drawn, frame)
    }

    /// Returns an iterator that renders frames one after the other, each when it is requested.
    ///
    /// frames: frame numbers in the desired order; default: the shot's frames.
    /// progress: called with (frames done, frames in total); False cancels.
    #[pyo3(signature = (frames=None, device="auto", progress=None))]
    fn render_frames(
        &self,
        frames: Option<Vec<i32>>,
        device: &str,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<RenderedFrames> {
        let choice = self::device(device)?;
        let frames = self.wanted(frames)?;
        Ok(RenderedFrames::new(Arc::clone(&self.drawer), frames, choice, progress))
    }

    /// Renders frames to EXR files, as `pinwarp render` does, and returns a dict with rendered, kept, failed, failures (frame and error
    /// of each), warnings ([frame, text] each), times and more.
    ///
    /// existing: how to treat existing frames: "refuse", "overwrite" or "resume".
    /// preview: also writes a PNG beside every frame.
    /// progress: called with (frames done, frames in total); False ends the render after the frames in flight.
    #[pyo3(
        signature = (frames=None, progress=None, **options),
        text_signature = "($self, frames=None, progress=None, *, device='auto', existing='refuse', preview=False)"
    )]
    fn write<'py>(
        &self,
        py: Python<'py>,
        frames: Option<Vec<i32>>,
        progress: Option<&Bound<'py, PyAny>>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let mut given = Options::new(options);
        let options = RenderOptions {
            frames: self.wanted(frames)?,
            device: device(&given.take::<String>("device")?.unwrap_or_else(|| "auto".into()))?,
            existing: existing(given.take::<String>("existing")?.as_deref())?,
            has_preview: given.take("preview")?.unwrap_or(false),
            ..RenderOptions::default()
        };
        given.end()?;
        let report = away(py, progress, |watch| self.render_files(&options, watch))?;
        plain(py, &report)
    }

    /// Solves frames and returns the warnings that a render would give, as a dict: notes; frames, each with frame, warnings and layers
    /// (layer, pin_error_px, jerk, solve); failures.
    ///
    /// frames: default: all frames of the shot.
    /// progress: called with (frames done, frames in total); False cancels.
    #[pyo3(signature = (frames=None, progress=None))]
    fn check<'py>(
        &self,
        py: Python<'py>,
        frames: Option<Vec<i32>>,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let frames = self.wanted(frames)?;
        let report = away(py, progress, |watch| self.checked(&frames, watch))?;
        plain(py, &report)
    }

    /// Returns the solved lattices of frames, as `pinwarp export --to lattice-json` writes them, with its warnings.
    ///
    /// frames: default: all frames of the shot.
    /// progress: called with (frames done, frames in total); False cancels.
    #[pyo3(signature = (frames=None, progress=None))]
    fn lattices(
        &self,
        py: Python<'_>,
        frames: Option<Vec<i32>>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<LatticeFile> {
        let frames = self.wanted(frames)?;
        away(py, progress, |watch| self.solved(&frames, watch))
    }

    /// Returns the pins that act at a frame, at mid-shutter: a list of dicts with layer, name, rest and target ((x, y) in frame heights,
    /// y up), and presence (1, or less where a pin fades out near the camera).
    fn pins<'py>(&self, py: Python<'py>, frame: i32) -> PyResult<Bound<'py, PyList>> {
        let sample = away(py, None, |_| Ok(self.prepared.mid_exposure(frame)?))?;
        let list = PyList::empty(py);
        for (layer, state) in self.prepared.shot.layers.iter().zip(&sample.layers) {
            for pin in &state.pins {
                let dict = PyDict::new(py);
                dict.set_item("layer", &layer.name)?;
                dict.set_item("name", &layer.pins[pin.pin].name)?;
                dict.set_item("rest", (pin.rest.0.x, pin.rest.0.y))?;
                dict.set_item("target", (pin.target.0.x, pin.target.0.y))?;
                dict.set_item("presence", pin.presence)?;
                list.append(dict)?;
            }
        }
        Ok(list)
    }

    /// Returns the screen positions of all meshes at a frame, before any warp; see Scene.project.
    fn project<'py>(&self, py: Python<'py>, frame: f64) -> PyResult<Bound<'py, PyList>> {
        projected(py, &self.prepared, frame)
    }

    fn __repr__(&self) -> String {
        format!("<Shot {}>", self.prepared.shot.path.display())
    }
}

impl Shot {
    /// Returns the requested frames, or all.
    fn wanted(&self, frames: Option<Vec<i32>>) -> Result<Vec<i32>, Failure> {
        let own = self.prepared.shot.frames;
        let frames = frames.unwrap_or_else(|| (own.first..=own.last).collect());
        if frames.is_empty() {
            return Err(Failure::argument("frames", "is empty", "give at least one frame"));
        }
        Ok(frames)
    }

    fn checked(&self, frames: &[i32], watch: &Watch) -> Result<CheckReport, Failure> {
        let prepared = &*self.prepared;
        let output = SequencePath::parse(&prepared.shot.output.path)?;
        output.check_frame_count(frames.len())?;
        let mut checks = FrameChecks::default();
        let mut found = CheckReport { notes: prepared.notes.clone(), frames: Vec::new(), failures: Vec::new() };
        for (done, &frame) in frames.iter().enumerate() {
            watch.tell(done, frames.len());
            watch.check()?;
            match checks.report(prepared, frame, |_| true) {
                Ok(report) => found.frames.push(report),
                Err(error) => found.failures.push(FrameFailure { frame, error: error.to_string() }),
            }
        }
        watch.tell(frames.len(), frames.len());
        Ok(found)
    }

    fn solved(&self, frames: &[i32], watch: &Watch) -> Result<LatticeFile, Failure> {
        watch.tell(0, frames.len());
        _ = self.prepared.solve_trajectories(&|| watch.is_stopped(), &|_| {});
        // Checking once per frame suffices for cancellation; solved lattices are kept for all frames.
        let (mut checks, mut warnings) = (FrameChecks::default(), Vec::new());
        for (done, &frame) in frames.iter().enumerate() {
            watch.check()?;
            let report = checks.report(&self.prepared, frame, |_| true)?;
            warnings.extend(report.warnings.into_iter().map(|warning| (frame, warning)));
            watch.tell(done + 1, frames.len());
        }
        Ok(LatticeFile::of(pipeline::lattices(&self.prepared, frames, |_| {})?, warnings))
    }

    fn render_files(&self, options: &RenderOptions, watch: &Watch) -> Result<WriteReport, Failure> {
        let of = options.frames.len();
        let done = Mutex::new((0, Vec::new(), Vec::new()));
        watch.tell(0, of);
        let on_event = |event| {
            let mut done = done.lock().unwrap_or_else(PoisonError::into_inner);
            match event {
                Event::FrameDone(report) => {
                    done.0 += 1;
                    done.2.extend(report.warnings.into_iter().map(|warning| (report.frame, warning)));
                }
                Event::FrameFailed { frame, error } => {
                    done.0 += 1;
                    done.1.push(FrameFailure { frame, error });
                }
                _ => return,
            }
            watch.tell(done.0, of);
        };
        let summary = pipeline::render(&self.prepared, options, watch.stop_flag(), &on_event)?;
        let (_, failures, warnings) = done.into_inner().unwrap_or_else(PoisonError::into_inner);
        Ok(WriteReport { summary, failures, warnings })
    }
}

/// Parses how existing frames are treated.
fn existing(name: Option<&str>) -> Result<Existing, Failure> {
    match name {
        None | Some("refuse") => Ok(Existing::Refuse),
        Some("overwrite") => Ok(Existing::Overwrite),
        Some("resume") => Ok(Existing::Resume),
        Some(other) => {
            let hint = "give \"refuse\", \"overwrite\" or \"resume\"";
            Err(Failure::argument("existing", format!("is {other:?}"), hint))
        }
    }
}
