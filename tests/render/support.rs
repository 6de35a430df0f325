//! Shots rendered into temporary folders, and their pixels.

use super::tiny::Tiny;
use pinwarp::image::{Frame, read_exr};
use pinwarp::pipeline::{PreparedShot, RenderOptions, Summary, render, render_on};
use pinwarp::raster::{DeviceChoice, Raster};
use pinwarp::shot::{Goal, Pin, Shot};
use pinwarp::space::{FrameSize, ScreenVector};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use tempfile::TempDir;

/// A shot, and the folder its scene lies in.
pub(crate) struct Studio {
    pub(crate) shot: Shot,
    folder: TempDir,
}

/// A layer of everything with a pin on the first corner of `Quad`, which stays where `keys` put it.
pub(crate) fn pinned_layer(keys: &str) -> String {
    format!(
        "[[layer]]\nname = \"all\"\nlattice = {{ dims = [4, 4] }}\n[[layer.pin]]\nname = \"corner\"\n\
         anchor = {{ node = \"Quad\", triangle = 0, barycentric = [1.0, 0.0, 0.0] }}\nkeys = [{keys}]\n"
    )
}

/// Writes a scene beside its shot.
pub(crate) fn write_scene(tiny: &Tiny, path: &Path) {
    std::fs::write(path, tiny.json().to_string()).expect("the folder can be written to");
}

impl Studio {
    /// A tiny scene at 64 x 40 pixels: a tenth of the frame's height is four pixels.
    pub(crate) fn tiny(tiny: &Tiny, layers: &str) -> Self {
        Self::of_json(&tiny.json(), layers)
    }

    /// The same from a scene's JSON.
    pub(crate) fn of_json(scene: &serde_json::Value, layers: &str) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        std::fs::write(folder.path().join("tiny.gltf"), scene.to_string()).expect("the folder can be written to");
        let text = format!(
            "version = 1\nscene = \"tiny.gltf\"\nframes = {{ first = 1, last = 9, rate = 24 }}\nsize = [64, 40]\n\
             samples = 1\n{layers}"
        );
        let shot = Shot::parse(&text, &folder.path().join("shot.toml")).expect("a right shot");
        Self { shot, folder }
    }

    /// The teapot that comes with the program, one sample a pixel.
    pub(crate) fn teapot(width: u32, height: u32) -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/teapot/shot.toml");
        let mut shot = Shot::read(&path).expect("a right shot");
        shot.size = FrameSize::new(width, height);
        shot.samples = 1;
        Self { shot, folder: tempfile::tempdir().expect("a temporary folder") }
    }

    /// The drawn girl that comes with the program, with these dims and this topology.
    pub(crate) fn puppet(dims: &str, topology: &str) -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/puppet/shot.toml");
        let text = std::fs::read_to_string(&path).expect("it comes with the program");
        let lattice = "dims = \"auto\", topology = \"branching\"";
        assert!(text.contains(lattice), "{text}");
        let text = text.replace(lattice, &format!("dims = {dims}, topology = \"{topology}\""));
        Self::of_shot(Shot::parse(&text, &path).expect("a right shot"))
    }

    /// A shot that comes with the program, or is made by the test, in a temporary folder.
    pub(crate) fn of_shot(shot: Shot) -> Self {
        Self { shot, folder: tempfile::tempdir().expect("a temporary folder") }
    }

    pub(crate) fn scene(&self) -> &Path {
        self.shot.scene().expect("the shots of these tests have scenes")
    }

    /// Turns a node of a tiny scene about its origin.
    pub(crate) fn turn_node(&mut self, node: usize, by: glam::DQuat) {
        let text = std::fs::read_to_string(self.scene()).expect("the scene is there");
        let mut scene: serde_json::Value = serde_json::from_str(&text).expect("a tiny scene is JSON");
        scene["nodes"][node]["rotation"] = serde_json::json!(by.to_array());
        std::fs::write(self.scene(), scene.to_string()).expect("the folder can be written to");
    }

    pub(crate) fn prepared(&self) -> PreparedShot {
        PreparedShot::new(self.shot.clone()).expect("the scene fits the shot")
    }

    /// Renders on the CPU, set up anew; the files, in the order asked for.
    pub(crate) fn files(&self, frames: &[i32]) -> Vec<PathBuf> {
        self.files_of(&mut self.prepared(), frames)
    }

    /// The same of the shot as it was prepared before.
    fn files_of(&self, prepared: &mut PreparedShot, frames: &[i32]) -> Vec<PathBuf> {
        let options = self.options(prepared, frames);
        let summary = render(prepared, &options, &AtomicBool::new(false), &|_| {});
        paths(prepared, frames, &summary.expect("the shot is rendered"))
    }

    /// The same on a device that is opened by the test.
    pub(crate) fn files_by<R: Raster>(
        &self,
        frames: &[i32],
        open: impl FnOnce(&PreparedShot) -> R,
    ) -> (Vec<PathBuf>, R) {
        let mut prepared = self.prepared();
        let mut device = open(&prepared);
        (self.files_on(&mut device, &mut prepared, frames), device)
    }

    /// The same on a device that is open for what was prepared before.
    pub(crate) fn files_on(
        &self,
        device: &mut dyn Raster,
        prepared: &mut PreparedShot,
        frames: &[i32],
    ) -> Vec<PathBuf> {
        let options = self.options(prepared, frames);
        let summary = render_on(device, prepared, &options, &AtomicBool::new(false), &|_| {});
        paths(prepared, frames, &summary.expect("the shot is rendered"))
    }

    pub(crate) fn frames(&self, frames: &[i32]) -> Vec<Frame> {
        self.files(frames).iter().map(|path| read_exr(path).expect("the frame is readable")).collect()
    }

    pub(crate) fn frame(&self, frame: i32) -> Frame {
        self.frames(&[frame]).remove(0)
    }

    /// A frame of the shot as it was prepared before.
    pub(crate) fn frame_of(&self, prepared: &mut PreparedShot, frame: i32) -> Frame {
        read_exr(&self.files_of(prepared, &[frame])[0]).expect("the frame is readable")
    }

    /// Options that render frames into a new folder.
    fn options(&self, prepared: &mut PreparedShot, frames: &[i32]) -> RenderOptions {
        let folder = tempfile::tempdir_in(self.folder.path()).expect("a temporary folder").keep();
        prepared.shot.output.path = folder.join("f.####.exr");
        RenderOptions { frames: frames.to_vec(), device: DeviceChoice::Cpu, ..RenderOptions::default() }
    }
}

/// The files of frames, all of which were rendered.
fn paths(prepared: &PreparedShot, frames: &[i32], summary: &Summary) -> Vec<PathBuf> {
    assert_eq!((summary.rendered, summary.failed), (frames.len(), 0));
    frames.iter().map(|frame| prepared.shot.output.path.with_file_name(format!("f.{frame:04}.exr"))).collect()
}

/// Sends a pin to one offset at all times, in frame heights.
pub(crate) fn hold(pin: &mut Pin, offset: [f64; 2]) {
    pin.keys.truncate(1);
    pin.keys[0].goal = Goal::Offset(ScreenVector::new(offset[0], offset[1]));
}

/// A sample by its place in the display window; what an empty pixel holds outside the data window.
pub(crate) fn at(frame: &Frame, channel: &str, x: i32, y: i32) -> f32 {
    let channel = frame.channel(channel).expect("the channel is in the frame");
    let window = frame.data_window;
    let (column, row) = (x - window.x, y - window.y);
    let is_inside = (0..window.width as i32).contains(&column) && (0..window.height as i32).contains(&row);
    if is_inside {
        channel.samples[row as usize * window.width as usize + column as usize]
    } else {
        channel.empty_value()
    }
}

/// Pixels of the display window.
pub(crate) fn pixels(frame: &Frame) -> impl Iterator<Item = (i32, i32)> + use<> {
    let (width, height) = (frame.display.width as i32, frame.display.height as i32);
    (0..height).flat_map(move |y| (0..width).map(move |x| (x, y)))
}

/// The pixel and its neighbours show one object and no hole.
pub(crate) fn is_interior(frame: &Frame, x: i32, y: i32) -> bool {
    let id = at(frame, "id.object", x, y);
    id > 0.0 && (-1..=1).all(|dy| (-1..=1).all(|dx| at(frame, "id.object", x + dx, y + dy) == id))
}

/// Number of interior pixels of `a` whose samples are not found in `b`, moved by whole pixels (x right, y down); and of
/// how many.
pub(crate) fn count_differences(a: &Frame, b: &Frame, channels: &[&str], moved: [i32; 2]) -> (usize, usize) {
    let [dx, dy] = moved;
    let inside = |&(x, y): &(i32, i32)| {
        let (x, y) = (x + dx, y + dy);
        x >= 0 && y >= 0 && x < b.display.width as i32 && y < b.display.height as i32 && is_interior(a, x - dx, y - dy)
    };
    let differs = |&(x, y): &(i32, i32)| {
        channels.iter().any(|name| {
            let (one, other) = (at(a, name, x, y), at(b, name, x + dx, y + dy));
            (one - other).abs() > 4e-3 * one.abs().max(1.0)
        })
    };
    let all: Vec<_> = pixels(a).filter(inside).collect();
    (all.iter().filter(|pixel| differs(pixel)).count(), all.len())
}
