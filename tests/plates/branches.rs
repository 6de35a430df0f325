//! Lattices that branch over finished frames: a plate of the unwarped model, warped, shows what the same shot renders.

use super::agreement::{FRAMES, Pair, at, frames, prepared, warped};
use super::assets::asset;
use super::drawn_girl::small_girl;
use pinwarp::export::LatticeFile;
use pinwarp::image::{Durability, Frame};
use pinwarp::pipeline::{Existing, PlateWarp, PreparedShot, WarpDirection, WarpJob, lattices, warp_frames};
use pinwarp::plate::{Holes, WarpSettings};
use pinwarp::raster::DeviceChoice;
use pinwarp::shot::Shot;
use pinwarp::solve::Topology;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;
use std::sync::atomic::AtomicBool;

/// What a plate and the geometry show differently.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Apart {
    /// Pixels that the geometry covers.
    pub(super) covered: usize,
    /// Pixels of which only one has something: what the plate does not know.
    pub(super) holes: usize,
    /// Pixels that both cover, with colour that differs by more than a tenth.
    pub(super) off: usize,
    /// Pixels inside that a seam makes transparent.
    pub(super) seams: usize,
    /// Pixels that both cover, with vectors that differ by more than half a pixel.
    pub(super) vectors: usize,
}

pub(super) fn apart(plate: &Frame, geometry: &Frame) -> Apart {
    let (width, height) = (geometry.display.width as i32, geometry.display.height as i32);
    let mut found = Apart::default();
    let has_vectors = geometry.channel("forward.u").is_some();
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let sample = |frame: &Frame, channel: &str| at(frame, channel, x, y).unwrap_or(0.0);
        let [ours, theirs] = [plate, geometry].map(|frame| sample(frame, "A"));
        assert!(ours < 1.0 + 1e-4, "alpha {ours} at {x}, {y}");
        let gap = |channel: &str| (sample(plate, channel) - sample(geometry, channel)).abs();
        found.covered += usize::from(theirs > 0.5);
        if (ours - theirs).abs() > 0.5 {
            found.holes += 1;
        } else if ["R", "G", "B", "A"].iter().any(|channel| gap(channel) > 0.1) {
            found.off += 1;
        }
        let around = (-2..=2).flat_map(|dy| (-2..=2).map(move |dx| [x + dx, y + dy]));
        let is_inner = around.into_iter().all(|[x, y]| at(geometry, "A", x, y).is_some_and(|alpha| alpha > 0.999));
        found.seams += usize::from(is_inner && (0.5..0.95).contains(&ours));
        let is_inside = ours > 0.999 && theirs > 0.999;
        let vectors = ["forward.u", "forward.v", "backward.u", "backward.v"];
        found.vectors += usize::from(has_vectors && is_inside && vectors.iter().any(|channel| gap(channel) > 0.5));
    }
    found
}

/// What differs in each frame.
pub(super) fn check(shot: &PreparedShot, pair: &Pair) -> Vec<Apart> {
    let warped = warped(shot, Holes::Leave, pair.still.folder().path());
    let both = warped.iter().zip(&pair.moved.frames);
    let found: Vec<Apart> = both.map(|(plate, geometry)| apart(plate, geometry)).collect();
    FRAMES.iter().zip(&found).for_each(|(frame, apart)| println!("frame {frame}: {apart:?}"));
    found
}

/// The drawn girl that comes with the program.
static PUPPET: LazyLock<Pair> = LazyLock::new(|| Pair::of(puppet()));

/// The girl at half her size, with so few handles that a lattice can have twice as many spans across; her frames are solved alone.
fn puppet_path() -> PathBuf {
    static PATH: LazyLock<PathBuf> = LazyLock::new(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("coarse_puppet");
        std::fs::create_dir_all(&folder).expect("a folder");
        let text = small_girl(&folder);
        let path = folder.join("shot.toml");
        let lattice = "lattice = { dims = \"auto\"";
        assert!(text.contains(lattice), "{text}");
        let alone = "solve = { temporal = 0 }\nlattice = { dims = [24, 57]";
        std::fs::write(&path, text.replace(lattice, alone)).expect("written");
        path
    });
    PATH.clone()
}

fn puppet() -> Shot {
    Shot::read(&puppet_path()).expect("a right shot")
}

#[test]
fn a_drawing_as_a_plate_goes_where_the_drawing_goes() {
    let branching = check(&PUPPET.shot, &PUPPET);
    assert!(branching.iter().all(|apart| apart.covered > 40_000 && apart.holes + apart.off < 60), "{branching:?}");
    let mut shot = puppet();
    shot.layers[0].settings.topology = Topology::Plain;
    let plain = check(&prepared(shot), &PUPPET).remove(0);
    assert!(plain.holes + plain.off > 2000, "another warp is found: {plain:?}");
}

/// The plates of a folder, warped by what was written for the same shot.
pub(super) fn warped_by(warp: PlateWarp, folder: &Path) -> Vec<Frame> {
    let job = WarpJob {
        plate: folder.join("f.####.exr"),
        output: folder.join("w.####.exr"),
        warp,
        settings: WarpSettings::default(),
        direction: WarpDirection::Forward,
        layers: Vec::new(),
        frames: FRAMES.into(),
        existing: Existing::Overwrite,
        device: DeviceChoice::Cpu,
        durability: Durability::Cached,
        inputs: Vec::new(),
    };
    let summary = warp_frames(&job, &AtomicBool::new(false), &|_| {}).expect("warped");
    assert_eq!((summary.warped, summary.failed), (FRAMES.len(), 0));
    frames(folder, "w")
}

#[test]
fn lattice_files_and_maps_carry_branches() {
    let (pair, path) = (&*PUPPET, puppet_path());
    let plates = pair.still.folder();
    let file = lattices(&pair.shot, &FRAMES, |_| ()).expect("solvable");
    let [written, finer] = ["a.json", "b.json"].map(|name| plates.path().join(name));
    file.write(&written).expect("written");
    assert_eq!(LatticeFile::read(&written).expect("read"), file);
    // 24 x 57 handles have 21 x 54 spans.
    let pinwarp = |words: &[&str]| {
        let done = Command::new(env!("CARGO_BIN_EXE_pinwarp")).args(words).output().expect("it runs");
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    };
    let [from, to] = [&written, &finer].map(|path| path.to_str().expect("UTF-8"));
    pinwarp(&["resize", from, "--dims", "45,57", "-o", to]);
    let maps = plates.path().join("m.####.exr");
    let map_path = maps.to_str().expect("UTF-8");
    pinwarp(&["export", path.to_str().expect("UTF-8"), "--to", "stmap", "--frames", "8,12", "-o", map_path]);
    let of_file = |file| PlateWarp::Lattices { file, strength: 1.0, matte: None };
    let finer = LatticeFile::read(&finer).expect("read");
    let cases = [("file", of_file(file)), ("finer", of_file(finer)), ("maps", PlateWarp::Maps(maps))];
    for (name, warp) in cases {
        let warped = warped_by(warp, plates.path());
        let both = warped.iter().zip(&pair.moved.frames);
        let found: Vec<Apart> = both.map(|(plate, geometry)| apart(plate, geometry)).collect();
        println!("{name}: {found:?}");
        assert!(found.iter().all(|apart| apart.holes + apart.off < 60), "{name}: {found:?}");
    }
}

/// A fox that walks: a front paw is pulled ahead, over the other leg; the rest is held. Its frames are solved alone.
fn walking_fox(angle: f64) -> Option<Shot> {
    let scene = asset("gltf-samples/Fox.glb")?;
    let mut text = format!(
        "version = 1\nscene = '{}'\ncamera = 'left'\nframes = {{ first = 1, last = 17, rate = 24, clip = 'Walk' }}\n\
         size = [640, 360]\nsamples = 8\nshutter = {{ angle = {angle} }}\n[output]\nchannels = ['beauty', 'depth', 'motion', 'id']\n\
         [[layer]]\nname = 'all'\nlattice = {{ dims = [40, 30], topology = 'branching' }}\nsolve = {{ temporal = 0 }}\n",
        scene.display()
    );
    let pins = [[1.037, 0.13], [1.445, 0.184], [0.86, 0.13], [0.60, 0.14], [1.0, 0.62], [0.7, 0.65], [1.62, 0.7]];
    for (number, [x, y]) in pins.into_iter().enumerate() {
        let offset = if number == 0 { [0.12, 0.08] } else { [0.0; 2] };
        write!(
            text,
            "[[layer.pin]]\nname = 'p{number}'\nanchor = {{ screen = [{x}, {y}], frame = 1 }}\n\
             keys = [{{ frame = 1, offset = {offset:?} }}]\n"
        )
        .expect("a string takes all");
    }
    Some(Shot::parse(&text, Path::new("/fox.toml")).expect("a right shot"))
}

#[test]
fn legs_that_cross_in_a_plate_move_by_themselves() {
    let Some(pair) = walking_fox(0.0).map(Pair::of) else { return };
    let found = check(&pair.shot, &pair);
    // What one leg hid of the other is not in the plate.
    assert!(found.iter().all(|apart| apart.covered > 40_000 && apart.holes < 1500), "{found:?}");
    // Outlines are softened twice.
    assert!(found.iter().all(|apart| apart.off < 2000 && apart.seams < 20), "{found:?}");
    assert!(found.iter().all(|apart| apart.vectors < apart.covered / 100), "{found:?}");
}

#[test]
fn blurred_edges_of_branches_keep_their_share() {
    let Some(pair) = walking_fox(180.0).map(Pair::of) else { return };
    let found = check(&pair.shot, &pair);
    assert!(found.iter().all(|apart| apart.holes < 2000 && apart.off < 6000), "{found:?}");
}
