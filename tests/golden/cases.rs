//! The pictures: scenes and frames, and what is changed in their shots. One thing a case.

use pinwarp::image::{Frame, read_any, read_exr};
use pinwarp::lattice::{Basis, Grid, ScreenLattice};
use pinwarp::pipeline::{Existing, PipelineError, PreparedShot, RenderOptions, render};
use pinwarp::plate::{Field, Filter, LayerJob, PlateJob, WarpMap, WarpSettings, stmap_of, warp_plate};
use pinwarp::raster::{ChannelGroup, DeviceChoice};
use pinwarp::shot::{Goal, LayerSpace, Shot};
use pinwarp::solve::Settings;
use pinwarp::space::{FrameSize, ScreenVector};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, LazyLock, Mutex};

/// Rows of a picture.
const HEIGHT: u32 = 60;

/// One stored picture.
pub(crate) struct Case {
    /// Name of its file.
    pub(crate) name: &'static str,
    what: What,
}

enum What {
    /// A frame of a scene's shot, changed.
    Shot { scene: &'static str, frame: i32, change: Change },
    /// The flag's picture, warped as a plate.
    Plate(Filter),
    /// The STMap of that warp.
    Map,
}

/// What is changed in a shot.
#[derive(Clone, Copy)]
enum Change {
    /// The scene or its warp.
    Warp(fn(&mut Shot)),
    /// The samples or the channels: these cases of a scene share what is loaded and solved.
    Picture(fn(&mut Shot)),
}

/// A shot that is loaded and solved when it is first drawn.
type Kept = Arc<Mutex<Option<PreparedShot>>>;

/// A shot for all its pictures, on every device.
fn kept(name: &'static str) -> Kept {
    static ALL: Mutex<BTreeMap<&str, Kept>> = Mutex::new(BTreeMap::new());
    Arc::clone(ALL.lock().expect("nothing fails at it").entry(name).or_default())
}

impl Case {
    /// A raster draws it.
    pub(crate) fn is_drawn(&self) -> bool {
        matches!(self.what, What::Shot { scene, .. } if !["flag", "cat", "puppet"].contains(&scene))
    }

    pub(crate) fn draw(&self, device: DeviceChoice) -> Result<Frame, PipelineError> {
        match self.what {
            What::Shot { scene, frame, change } => {
                let shot = small(scene, change);
                let kept = kept(if matches!(change, Change::Picture(_)) { scene } else { self.name });
                let mut kept = kept.lock().expect("no other test fails at it");
                if kept.is_none() {
                    *kept = Some(PreparedShot::new(shot.clone())?);
                }
                let prepared = kept.as_mut().expect("it was set");
                (prepared.shot.samples, prepared.shot.output.channels) = (shot.samples, shot.output.channels);
                drawn(prepared, frame, device)
            }
            What::Plate(filter) => Ok(warped(filter)),
            What::Map => Ok(map()),
        }
    }

    /// The same by the CPU, with another change of the shot after its own.
    pub(crate) fn spoiled(&self, spoil: fn(&mut Shot)) -> Frame {
        let What::Shot { scene, frame, change } = self.what else { panic!("{} has no shot", self.name) };
        let mut shot = small(scene, change);
        spoil(&mut shot);
        let mut prepared = PreparedShot::new(shot).expect("the shot is right");
        drawn(&mut prepared, frame, DeviceChoice::Cpu).expect("it is drawn")
    }
}

/// A scene's shot, small and changed.
fn small(scene: &str, change: Change) -> Shot {
    let mut shot = Shot::read(&scenes().join(scene).join("shot.toml")).expect("the scene's shot is right");
    let columns = (shot.size.aspect() * f64::from(HEIGHT)).round();
    shot.size = FrameSize::new(columns as u32, HEIGHT);
    shot.samples = 4;
    shot.output.channels = vec![ChannelGroup::Beauty];
    let (Change::Warp(change) | Change::Picture(change)) = change;
    change(&mut shot);
    shot
}

fn scenes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes")
}

fn drawn(prepared: &mut PreparedShot, frame: i32, device: DeviceChoice) -> Result<Frame, PipelineError> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    prepared.shot.output.path = folder.path().join("frame.####.exr");
    let existing = Existing::Refuse;
    let options = RenderOptions { frames: vec![frame], device, existing, ..RenderOptions::default() };
    let summary = render(prepared, &options, &AtomicBool::new(false), &|_| {})?;
    assert_eq!((summary.rendered, summary.failed), (1, 0));
    Ok(read_exr(&folder.path().join(format!("frame.{frame:04}.exr"))).expect("the frame is readable"))
}

/// A lattice over the whole frame whose middle is pulled up and to the right.
fn pulled(aspect: f64) -> ScreenLattice {
    let mut lattice =
        Grid { dims: [6, 6], basis: Basis::Bspline, lo: [0.0, 0.0], hi: [aspect, 1.0], angle: 0.0 }.at_rest();
    for index in [14, 15, 20, 21] {
        lattice.handles[index][0] += 0.25;
        lattice.handles[index][1] += 0.15;
    }
    lattice
}

fn warped(filter: Filter) -> Frame {
    let plate = small_flag();
    let field = Field::of_picture(pulled(plate.frame_size().aspect()));
    let layers = vec![LayerJob { name: "all".into(), field, previous: None, next: None, matte: None, front: None }];
    let settings = WarpSettings { filter, ..WarpSettings::default() };
    let job = PlateJob { layers, settings: &settings, fill: None };
    warp_plate(&plate, &job).expect("nothing to refuse").0.into_frame()
}

/// The flag, every sixth pixel of it: aliased on purpose, so that filters tell apart.
fn small_flag() -> pinwarp::image::Plate {
    const EVERY: usize = 6;
    let mut frame = read_any(&scenes().join("flag/flag.png")).expect("the picture is there").into_frame();
    let [width, height] = [frame.data_window.width, frame.data_window.height].map(|side| side as usize);
    for channel in &mut frame.channels {
        let rows = channel.samples.chunks(width).step_by(EVERY);
        channel.samples = rows.flat_map(|row| row.iter().copied().step_by(EVERY)).collect();
    }
    let size = FrameSize::new(width.div_ceil(EVERY) as u32, height.div_ceil(EVERY) as u32);
    (frame.display, frame.data_window) = (size.window(), size.window());
    pinwarp::image::Plate::from_frame(frame)
}

fn map() -> Frame {
    let size = FrameSize::new(100, 60);
    stmap_of(&WarpMap::backward(&Field::of_picture(pulled(size.aspect())), size, size.window()))
}

/// Pulls the first pin a 25th of the frame farther.
pub(crate) fn pull_too_far(shot: &mut Shot) {
    for key in &mut shot.layers[0].pins[0].keys {
        if let Goal::Offset(offset) = &mut key.goal {
            *offset = ScreenVector(offset.0 + glam::DVec2::new(0.04, 0.0));
        }
    }
}

fn as_it_is(_: &mut Shot) {}

fn unwarped(shot: &mut Shot) {
    shot.layers.clear();
}

fn all_channels(shot: &mut Shot) {
    use ChannelGroup::{Beauty, Depth, Id, Motion, Normal};
    shot.output.channels = vec![Beauty, Depth, Motion, Normal, Id];
}

fn cryptomatte(shot: &mut Shot) {
    shot.output.channels = vec![ChannelGroup::Cryptomatte];
}

fn in_basis(shot: &mut Shot, basis: Basis) {
    shot.layers[0].basis = basis;
}

fn bernstein(shot: &mut Shot) {
    in_basis(shot, Basis::Bernstein);
}

fn bilinear(shot: &mut Shot) {
    in_basis(shot, Basis::Bilinear);
}

fn barytri(shot: &mut Shot) {
    in_basis(shot, Basis::Barytri);
}

fn paper(shot: &mut Shot) {
    shot.layers[0].settings = Settings::paper();
}

fn half_strength(shot: &mut Shot) {
    shot.layers[0].strength = 0.5;
}

fn coarse(shot: &mut Shot) {
    if let LayerSpace::Screen { dims, .. } = &mut shot.layers[0].space {
        *dims = [4, 4];
    }
}

fn one_sample(shot: &mut Shot) {
    shot.samples = 1;
}

fn wide_pixels(shot: &mut Shot) {
    shot.size = FrameSize { width: 80, height: HEIGHT, pixel_aspect: 4.0 / 3.0 };
}

fn open_shutter(shot: &mut Shot) {
    shot.shutter.angle = 360.0;
    shot.samples = 16;
}

/// All cases, for all tests.
pub(crate) fn cases() -> &'static [Case] {
    static CASES: LazyLock<Vec<Case>> = LazyLock::new(make_cases);
    &CASES
}

fn make_cases() -> Vec<Case> {
    use Change::{Picture, Warp};
    let case = |name, what| Case { name, what };
    let shot = |name, scene, frame, change| case(name, What::Shot { scene, frame, change });
    vec![
        shot("teapot.0001", "teapot", 1, Picture(as_it_is)),
        shot("teapot.0012", "teapot", 12, Picture(as_it_is)),
        shot("teapot.0024", "teapot", 24, Picture(as_it_is)),
        shot("teapot.unwarped", "teapot", 12, Warp(unwarped)),
        shot("teapot.channels", "teapot", 12, Picture(all_channels)),
        shot("teapot.cryptomatte", "teapot", 12, Picture(cryptomatte)),
        shot("teapot.bernstein", "teapot", 12, Warp(bernstein)),
        shot("teapot.bilinear", "teapot", 12, Warp(bilinear)),
        shot("teapot.barytri", "teapot", 12, Warp(barytri)),
        shot("teapot.paper", "teapot", 12, Warp(paper)),
        shot("teapot.half", "teapot", 12, Warp(half_strength)),
        shot("teapot.coarse", "teapot", 12, Warp(coarse)),
        shot("teapot.one_sample", "teapot", 12, Picture(one_sample)),
        shot("teapot.wide_pixels", "teapot", 12, Warp(wide_pixels)),
        shot("gingerman.0004", "gingerman", 4, Picture(as_it_is)),
        shot("gingerman.0008", "gingerman", 8, Picture(as_it_is)),
        shot("gingerman.0016", "gingerman", 16, Picture(as_it_is)),
        shot("gingerman.channels", "gingerman", 8, Picture(all_channels)),
        shot("walker.0003", "walker", 3, Picture(as_it_is)),
        shot("walker.0007", "walker", 7, Picture(as_it_is)),
        shot("walker.0031", "walker", 31, Picture(as_it_is)),
        shot("walker.channels", "walker", 7, Picture(all_channels)),
        shot("walker.open_shutter", "walker", 7, Warp(open_shutter)),
        shot("hare.0001", "hare", 1, Picture(as_it_is)),
        shot("hare.0008", "hare", 8, Picture(as_it_is)),
        shot("hare.0020", "hare", 20, Picture(as_it_is)),
        shot("hare.channels", "hare", 8, Picture(all_channels)),
        shot("flag.0001", "flag", 1, Picture(as_it_is)),
        shot("flag.0007", "flag", 7, Picture(as_it_is)),
        shot("cat.0008", "cat", 8, Picture(as_it_is)),
        shot("cat.0012", "cat", 12, Picture(as_it_is)),
        shot("puppet.0011", "puppet", 11, Picture(as_it_is)),
        case("plate.ewa", What::Plate(Filter::Ewa)),
        case("plate.cubic", What::Plate(Filter::Cubic)),
        case("plate.lanczos", What::Plate(Filter::Lanczos)),
        case("plate.nearest", What::Plate(Filter::Nearest)),
        case("plate.stmap", What::Map),
    ]
}
