//! The geometry path and the plate path are one warp: a scene rendered unwarped, then warped as a picture, shows what
//! the same scene shows that was warped before it was drawn.
//!
//! Compared are pixels whose 5 x 5 neighbourhood shows one thing in both pictures: on outlines, samples of the raster and
//! of the filter fall differently.

use pinwarp::image::{Frame, read_exr};
use pinwarp::pipeline::{
    Existing, PlateWarp, PreparedShot, RenderOptions, WarpDirection, WarpJob, render, warp_frames,
};
use pinwarp::plate::{Holes, Matte, MotionEncoding, WarpSettings};
use pinwarp::raster::{ChannelGroup, DeviceChoice};
use pinwarp::shot::{Shot, Unmatted};
use pinwarp::space::FrameSize;
use std::path::Path;
use std::sync::LazyLock;
use std::sync::atomic::AtomicBool;
use tempfile::TempDir;

/// Frame in which spout and handle are pulled the most, and one on the way there.
pub(super) const FRAMES: [i32; 2] = [8, 12];

/// How much a group of channels may differ inside of things.
struct Limits {
    channels: &'static [&'static str],
    mean: f64,
    /// 99 of 100 samples differ by less.
    most: f64,
}

/// Beauty in linear light, depth in metres (the scene is half a metre deep), motion in pixels, ids exactly.
const LIMITS: [Limits; 5] = [
    Limits { channels: &["R", "G", "B", "A"], mean: 0.0015, most: 0.008 },
    Limits { channels: &["depth.Z"], mean: 0.001, most: 0.004 },
    Limits { channels: &["forward.u", "forward.v", "backward.u", "backward.v"], mean: 0.02, most: 0.07 },
    Limits { channels: &["N.X", "N.Y", "N.Z"], mean: 0.006, most: 0.06 },
    Limits { channels: &["id.object", "id.layer"], mean: 0.0, most: 0.0 },
];

/// The teapot that comes with the program, in small, and its frames solved alone.
fn teapot() -> Shot {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/teapot/shot.toml");
    let mut shot = Shot::read(&path).expect("a right shot");
    (shot.size, shot.samples) = (FrameSize::new(480, 270), 8);
    shot.layers[0].settings.temporal = 0.0;
    shot
}

/// As it is, but nothing moves.
pub(super) fn still(shot: &Shot) -> Shot {
    let mut still = shot.clone();
    still.layers.iter_mut().for_each(|layer| layer.strength = 0.0);
    still
}

pub(super) fn prepared(shot: Shot) -> PreparedShot {
    PreparedShot::new(shot).expect("the scene fits the shot")
}

pub(super) fn rendered(shot: Shot, folder: &Path) -> Vec<Frame> {
    rendered_of(&mut prepared(shot), folder)
}

fn rendered_of(prepared: &mut PreparedShot, folder: &Path) -> Vec<Frame> {
    prepared.shot.output.path = folder.join("f.####.exr");
    let options = RenderOptions { frames: FRAMES.into(), device: DeviceChoice::Cpu, ..RenderOptions::default() };
    let summary = render(prepared, &options, &AtomicBool::new(false), &|_| {}).expect("rendered");
    assert_eq!(summary.failed, 0);
    frames(folder, "f")
}

/// The files and pictures of a shot.
pub(super) struct Rendered {
    files: Vec<Vec<u8>>,
    pub(super) frames: Vec<Frame>,
}

impl Rendered {
    fn of(prepared: &mut PreparedShot) -> Self {
        let folder = TempDir::new().expect("a folder");
        let frames = rendered_of(prepared, folder.path());
        let file = |frame: &i32| std::fs::read(folder.path().join(format!("f.{frame:04}.exr"))).expect("a frame");
        Self { files: FRAMES.iter().map(file).collect(), frames }
    }

    /// A folder with the files.
    pub(super) fn folder(&self) -> TempDir {
        let folder = TempDir::new().expect("a folder");
        for (frame, file) in FRAMES.iter().zip(&self.files) {
            std::fs::write(folder.path().join(format!("f.{frame:04}.exr")), file).expect("written");
        }
        folder
    }
}

/// A shot, solved and rendered once, and its scene at rest; also for several tests.
pub(super) struct Pair {
    pub(super) shot: PreparedShot,
    pub(super) still: Rendered,
    pub(super) moved: Rendered,
}

impl Pair {
    pub(super) fn of(shot: Shot) -> Self {
        let still = Rendered::of(&mut prepared(still(&shot)));
        let mut shot = prepared(shot);
        let moved = Rendered::of(&mut shot);
        Self { shot, still, moved }
    }
}

pub(super) fn frames(folder: &Path, name: &str) -> Vec<Frame> {
    let path = |frame: i32| folder.join(format!("{name}.{frame:04}.exr"));
    FRAMES.iter().map(|&frame| read_exr(&path(frame)).expect("a frame")).collect()
}

/// The plates of a folder, warped by a shot.
pub(super) fn warped(prepared: &PreparedShot, holes: Holes, folder: &Path) -> Vec<Frame> {
    let settings =
        WarpSettings { motion: Some(MotionEncoding { pixels_per_unit: [1.0; 2] }), holes, ..WarpSettings::default() };
    let job = WarpJob {
        plate: folder.join("f.####.exr"),
        output: folder.join("w.####.exr"),
        warp: PlateWarp::Shot(prepared),
        settings,
        direction: WarpDirection::Forward,
        layers: Vec::new(),
        frames: FRAMES.into(),
        existing: Existing::Overwrite,
        device: DeviceChoice::Cpu,
        durability: pinwarp::image::Durability::Cached,
        inputs: Vec::new(),
    };
    let tell = |event| {
        if std::env::var_os("SHOW").is_some() {
            eprintln!("{event:?}");
        }
    };
    let summary = warp_frames(&job, &AtomicBool::new(false), &tell).expect("warped");
    assert_eq!((summary.warped, summary.failed), (FRAMES.len(), 0));
    frames(folder, "w")
}

/// A sample by its place in the display window; `None` outside the data window.
pub(super) fn at(frame: &Frame, channel: &str, x: i32, y: i32) -> Option<f32> {
    let window = frame.data_window;
    let (column, row) = (u32::try_from(x - window.x).ok()?, u32::try_from(y - window.y).ok()?);
    let is_inside = column < window.width && row < window.height;
    let samples = &frame.channel(channel).expect("the channel is in the frame").samples;
    is_inside.then(|| samples[(row * window.width + column) as usize])
}

/// What a 5 x 5 neighbourhood shows, where it shows one thing.
fn thing(frame: &Frame, x: i32, y: i32) -> Option<f32> {
    let id = |dx, dy| at(frame, "id.object", x + dx, y + dy);
    let middle = id(0, 0).filter(|&id| id > 0.0)?;
    (-2..=2).all(|dy| (-2..=2).all(|dx| id(dx, dy) == Some(middle))).then_some(middle)
}

/// Compares inside of things; the message says which limit is broken, or what was measured.
fn compare(plate: &Frame, geometry: &Frame) -> Result<String, String> {
    let (width, height) = (geometry.display.width as i32, geometry.display.height as i32);
    let pixels: Vec<(i32, i32)> = (0..height)
        .flat_map(|y| (0..width).map(move |x| (x, y)))
        .filter(|&(x, y)| thing(geometry, x, y).is_some_and(|id| thing(plate, x, y) == Some(id)))
        .collect();
    let covered = (0..height)
        .flat_map(|y| (0..width).map(move |x| (x, y)))
        .filter(|&(x, y)| thing(geometry, x, y).is_some())
        .count();
    if pixels.len() * 100 < covered * 97 {
        return Err(format!("only {} of {covered} inner pixels show the same thing", pixels.len()));
    }
    let mut said = format!("{} of {covered} pixels", pixels.len());
    for Limits { channels, mean, most } in &LIMITS {
        let apart = |name: &str, (x, y): (i32, i32)| {
            let sample = |frame| f64::from(at(frame, name, x, y).expect("inside both"));
            (sample(plate) - sample(geometry)).abs()
        };
        let mut gaps: Vec<f64> =
            channels.iter().flat_map(|name| pixels.iter().map(move |&at| apart(name, at))).collect();
        gaps.sort_by(f64::total_cmp);
        let found_mean = gaps.iter().sum::<f64>() / gaps.len() as f64;
        let found_most = gaps[gaps.len() * 99 / 100];
        said += &format!("; {}: mean {found_mean:.5}, 99 % {found_most:.5}", channels[0]);
        if found_mean > *mean || found_most > *most {
            return Err(said);
        }
    }
    Ok(said)
}

/// What is compared: everything warped by one layer, or one thing of several.
fn check(shot: &PreparedShot, pair: &Pair, holes: Holes) -> Vec<Result<String, String>> {
    let warped = warped(shot, holes, pair.still.folder().path());
    warped.iter().zip(&pair.moved.frames).map(|(plate, geometry)| compare(plate, geometry)).collect()
}

/// The teapot in a layer that takes everything.
fn whole_scene() -> Shot {
    let mut shot = teapot();
    shot.layers[0].nodes.clear();
    shot.layers[0].matte = Some(Matte::Alpha);
    shot
}

static WHOLE_SCENE: LazyLock<Pair> = LazyLock::new(|| Pair::of(whole_scene()));

#[test]
fn a_whole_scene_warped_as_a_picture_is_the_scene_warped() {
    for outcome in check(&WHOLE_SCENE.shot, &WHOLE_SCENE, Holes::Leave) {
        eprintln!("{}", outcome.unwrap_or_else(|said| panic!("{said}")));
    }
}

/// The number that `id.layer` gives the only layer of the shot.
const TEAPOT: u32 = 1;

#[test]
fn a_matted_thing_and_the_scene_behind_it_agree_too() {
    let mut shot = teapot();
    shot.layers[0].matte = Some(Matte::Id { channel: "id.layer".into(), values: vec![TEAPOT] });
    let pair = Pair::of(shot);
    for outcome in check(&pair.shot, &pair, Holes::Geometry) {
        eprintln!("{}", outcome.unwrap_or_else(|said| panic!("{said}")));
    }
}

/// The gnome of three layers in front of a meadow, in small.
fn walker() -> Shot {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/walker/shot.toml");
    let mut shot = Shot::read(&path).expect("a right shot");
    (shot.size, shot.samples) = (FrameSize::new(320, 180), 4);
    // Vectors point to the frames beside those of the pictures.
    shot.solve_range = [FRAMES[0] - 1, FRAMES[1] + 1];
    shot
}

/// Pixels of the frame in which colour is off by more than a tenth.
fn pixels_off(plate: &Frame, geometry: &Frame) -> usize {
    let places = (0..180).flat_map(|y| (0..320).map(move |x| (x, y)));
    let is_off = |&(x, y): &(i32, i32)| {
        let sample = |frame: &Frame, channel: &str| at(frame, channel, x, y).unwrap_or(0.0);
        ["R", "G", "B", "A"].iter().any(|channel| (sample(plate, channel) - sample(geometry, channel)).abs() > 0.1)
    };
    places.filter(is_off).count()
}

#[test]
fn layers_without_mattes_move_their_own_nodes_only() {
    let Pair { mut shot, still: plain, moved } = Pair::of(walker());
    let mut with_names = still(&walker());
    with_names.output.channels.push(ChannelGroup::Cryptomatte);
    let named = Rendered::of(&mut prepared(with_names));
    let mut off = |plates: &Rendered, unmatted: Unmatted| -> usize {
        shot.shot.layers.iter_mut().for_each(|layer| layer.unmatted = unmatted);
        let warped = warped(&shot, Holes::Geometry, plates.folder().path());
        let off = warped.iter().zip(&moved.frames).map(|(plate, geometry)| pixels_off(plate, geometry));
        off.inspect(|off| eprintln!("{unmatted:?}: {off} pixels off")).max().expect("frames")
    };
    // 57600 pixels: what differs are edges, where samples of raster and filter fall differently.
    assert!(off(&plain, Unmatted::OwnNodes) < 400, "drawn from the scene");
    assert!(off(&named, Unmatted::OwnNodes) < 400, "named by the plate's Cryptomatte");
    assert!(off(&plain, Unmatted::Picture) > 2000, "each layer bends the meadow and the others");
}

#[test]
fn a_warp_that_is_a_little_too_weak_is_found() {
    let mut shot = whole_scene();
    shot.layers[0].strength = 0.97;
    assert!(check(&prepared(shot), &WHOLE_SCENE, Holes::Leave)[1].is_err(), "3 % of the way are a pixel and a half");
}
