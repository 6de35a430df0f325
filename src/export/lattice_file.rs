//! The open format of solved lattices: JSON, one track per layer, one lattice per frame.
//!
//! In: a file. Out: validated lattices; or the reverse. docs/LATTICE.md describes the format.

use super::ExportError;
use super::raw::{RawBranch, RawBranches, RawFile, RawFrame, RawSpace, RawTrack};
use super::{LatticeBranch, LatticeBranches};
use crate::files::{GENERATOR, LATTICE_BYTES, read_text};
use crate::image::replace_text;
use crate::key_fault::KeyFault;
use crate::lattice::{BoxFrame, Grid, Lattice};
use crate::plate::WholeWarp;
use crate::spelling::pluralised;
use glam::DMat3;
use std::collections::BTreeMap;
use std::path::Path;

/// The latest version, written if a lattice branches or a box is rotated.
const VERSION: u32 = 2;

/// The version written otherwise, so that programs of the first version can read it.
const PLAIN_VERSION: u32 = 1;

/// Largest coordinate: beyond it screen points have no pixel, and metres no digits left.
const FARTHEST: f64 = 1e9;

/// Largest absolute frame number, as in shots.
const MAX_FRAME: i32 = 1_000_000;

/// The solved lattices of a shot.
#[derive(Clone, Debug, PartialEq)]
pub struct LatticeFile {
    /// Width of the frame in frame heights.
    pub frame_aspect: f64,
    /// Frame rate, in frames per second.
    pub rate: f64,
    /// One per layer, with distinct names.
    pub layers: Vec<LatticeTrack>,
}

/// The lattices of one layer.
#[derive(Clone, Debug, PartialEq)]
pub struct LatticeTrack {
    /// Name of the layer.
    pub name: String,
    /// Lattices by frame, never empty.
    pub track: Track,
    /// For tracks in the scene, the rigid frame of the box and handles at each frame; where missing, that of the scene.
    pub placements: BTreeMap<i32, BoxFrame>,
    /// For tracks on the screen whose lattice branches, the branches at each frame; the track's lattice is that of the largest.
    pub branches: BTreeMap<i32, LatticeBranches>,
    /// Whether a lattice of the track branches in the scene. The track holds the largest branches, and cannot be written to a file.
    pub has_branches_in_scene: bool,
    /// For tracks of whole pictures with a fixed border, the warps that contain the lattices. Not stored in files.
    pub wholes: BTreeMap<i32, WholeWarp>,
}

impl LatticeTrack {
    /// Returns the branches at a frame, and the listed frame that they belong to: the nearest one of the track, or of
    /// two equally near ones the earlier. `None` if the lattice does not branch there.
    #[must_use]
    pub(crate) fn branches_at(&self, frame: i32) -> Option<(i32, &LatticeBranches)> {
        let Track::Screen(lattices) = &self.track else { return None };
        let nearest = lattices.keys().copied().min_by_key(|listed| (i64::from(*listed) - i64::from(frame)).abs())?;
        Some((nearest, self.branches.get(&nearest)?))
    }
}

/// Lattices by frame, all with the same dims and basis.
#[derive(Clone, Debug, PartialEq)]
pub enum Track {
    /// On the screen.
    Screen(BTreeMap<i32, Lattice<2>>),
    /// In the scene.
    World(BTreeMap<i32, Lattice<3>>),
}

impl LatticeFile {
    /// Reads and checks a file.
    ///
    /// # Errors
    /// [`ExportError`], naming the file and the key.
    pub fn read(path: &Path) -> Result<Self, ExportError> {
        let text = read_text(path, LATTICE_BYTES);
        let text = text.map_err(|source| ExportError::Read { path: path.to_owned(), source })?;
        let raw = serde_json::from_str(&text).map_err(|source| ExportError::Json { path: path.to_owned(), source })?;
        check(raw).map_err(|fault| ExportError::invalid(path, fault))
    }

    /// Whether any lattice branches.
    #[must_use]
    pub(crate) fn has_branches(&self) -> bool {
        self.layers.iter().any(|layer| !layer.branches.is_empty())
    }

    /// Whether any box is rotated.
    fn has_rotated_boxes(&self) -> bool {
        self.layers.iter().any(|layer| match &layer.track {
            Track::Screen(lattices) => lattices.values().any(|lattice| lattice.grid.angle != 0.0),
            Track::World(_) => false,
        })
    }

    /// Returns only the given frames; `None` if no layer has any of them.
    #[cfg(any(test, feature = "cli"))]
    #[must_use]
    pub(crate) fn of_frames(mut self, frames: &[i32]) -> Option<Self> {
        for layer in &mut self.layers {
            match &mut layer.track {
                Track::Screen(lattices) => lattices.retain(|frame, _| frames.contains(frame)),
                Track::World(lattices) => lattices.retain(|frame, _| frames.contains(frame)),
            }
            layer.placements.retain(|frame, _| frames.contains(frame));
            layer.branches.retain(|frame, _| frames.contains(frame));
        }
        self.layers.retain(|layer| match &layer.track {
            Track::Screen(lattices) => !lattices.is_empty(),
            Track::World(lattices) => !lattices.is_empty(),
        });
        (!self.layers.is_empty()).then_some(self)
    }

    /// Writes the file atomically.
    ///
    /// # Errors
    /// [`ExportError::Write`] if the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), ExportError> {
        if let Some(index) = self.layers.iter().position(|layer| layer.has_branches_in_scene) {
            return Err(ExportError::Invalid {
                path: path.to_owned(),
                key: format!("layers[{index}]"),
                what: format!(
                    "the lattice of layer '{}' branches in the scene, which lattice files do not hold",
                    self.layers[index].name
                ),
                hint: "set topology = \"plain\" in its `lattice`, or export its meshes (--to gltf)".into(),
            });
        }
        let layers = self.layers.iter().map(|layer| match &layer.track {
            Track::Screen(lattices) => raw_track(layer, RawSpace::Screen, lattices),
            Track::World(lattices) => raw_track(layer, RawSpace::World, lattices),
        });
        let raw = RawFile {
            pinwarp_lattice: if self.has_branches() || self.has_rotated_boxes() { VERSION } else { PLAIN_VERSION },
            generator: Some(GENERATOR.to_owned()),
            frame_aspect: self.frame_aspect,
            rate: self.rate,
            layers: layers.collect(),
        };
        let text = serde_json::to_string(&raw).expect("numbers and names are valid JSON");
        Ok(replace_text(path, &(text + "\n"))?)
    }
}

/// Returns the lattice at a (fractional) frame, interpolated linearly between the lattices of the track; constant beyond its ends.
///
/// # Panics
/// If the track is empty, which validated tracks never are.
#[must_use]
pub fn lattice_at<const D: usize>(lattices: &BTreeMap<i32, Lattice<D>>, frame: f64) -> Lattice<D> {
    let before = lattices.range(..=frame.floor() as i32).next_back();
    let after = lattices.range(frame.ceil() as i32..).next();
    match (before, after) {
        (Some((&from, low)), Some((&to, high))) if from < to => {
            low.mixed(high, (frame - f64::from(from)) / f64::from(to - from))
        }
        _ => before.or(after).expect("a track has frames").1.clone(),
    }
}

fn check(raw: RawFile) -> Result<LatticeFile, KeyFault> {
    if !(PLAIN_VERSION..=VERSION).contains(&raw.pinwarp_lattice) {
        let what = format!("the version is {}, this program reads 1 to {VERSION}", raw.pinwarp_lattice);
        return Err(KeyFault::new("pinwarp_lattice", what, "export it again with this version"));
    }
    let is_plain = raw.pinwarp_lattice == PLAIN_VERSION;
    let positive = [("frame_aspect", raw.frame_aspect), ("rate", raw.rate)];
    if let Some((key, value)) = positive.into_iter().find(|(_, value)| !(value.is_finite() && *value > 0.0)) {
        return Err(KeyFault::new(key, format!("is {value}"), "give a number above 0"));
    }
    let mut layers: Vec<LatticeTrack> = Vec::with_capacity(raw.layers.len());
    for (index, layer) in raw.layers.into_iter().enumerate() {
        let key = format!("layers[{index}]");
        if layers.iter().any(|other| other.name == layer.name) {
            return Err(KeyFault::new(format!("{key}.name"), format!("duplicate name '{}'", layer.name), "rename one"));
        }
        let track = match layer.space {
            RawSpace::Screen => Track::Screen(lattices(&layer, &key)?),
            RawSpace::World => Track::World(lattices(&layer, &key)?),
        };
        let placements = placements(&layer, &key)?;
        let branches = branches(&layer, &key, is_plain)?;
        layers.push(LatticeTrack {
            placements,
            branches,
            has_branches_in_scene: false,
            wholes: BTreeMap::new(),
            name: layer.name,
            track,
        });
    }
    if layers.is_empty() {
        return Err(KeyFault::new("layers", "is empty", "export a shot whose layers have pins or moved handles"));
    }
    Ok(LatticeFile { frame_aspect: raw.frame_aspect, rate: raw.rate, layers })
}

fn lattices<const D: usize>(raw: &RawTrack, key: &str) -> Result<BTreeMap<i32, Lattice<D>>, KeyFault> {
    let dims = <[usize; D]>::try_from(raw.dims.as_slice()).map_err(|_| {
        let given = pluralised(raw.dims.len(), "entry", "entries");
        KeyFault::new(format!("{key}.dims"), format!("has {given}"), format!("this space has {D} axes"))
    })?;
    if raw.frames.is_empty() {
        return Err(KeyFault::new(format!("{key}.frames"), "is empty", "a track needs at least one frame"));
    }
    let mut found = BTreeMap::new();
    for (number, frame) in raw.frames.iter().enumerate() {
        let key = format!("{key}.frames[{number}]");
        let corner = |side: usize| point(&frame.bounds[side], || format!("{key}.box[{side}]"));
        if !(-MAX_FRAME..=MAX_FRAME).contains(&frame.frame) {
            let hint = format!("give a whole number from -{MAX_FRAME} to {MAX_FRAME}");
            return Err(KeyFault::new(format!("{key}.frame"), format!("is {}", frame.frame), hint));
        }
        let angle = frame.angle.unwrap_or(0.0);
        let grid = Grid { dims, basis: raw.basis, lo: corner(0)?, hi: corner(1)?, angle };
        grid.check().map_err(|error| KeyFault::new(key.clone(), error.to_string(), "export it again"))?;
        if frame.handles.len() != grid.handle_count() {
            let given = pluralised(frame.handles.len(), "handle", "handles");
            let what = format!("{given}, dims {dims:?} have {}", grid.handle_count());
            return Err(KeyFault::new(format!("{key}.handles"), what, "list all, x fastest"));
        }
        let handles = frame.handles.iter().enumerate();
        let handles = handles.map(|(k, handle)| point(handle, || format!("{key}.handles[{k}]")));
        let lattice = Lattice { grid, handles: handles.collect::<Result<_, _>>()? };
        if found.insert(frame.frame, lattice).is_some() {
            return Err(KeyFault::new(key, format!("duplicate frame {}", frame.frame), "remove one of the two"));
        }
    }
    Ok(found)
}

/// Returns the placements of the boxes of a track.
fn placements(raw: &RawTrack, key: &str) -> Result<BTreeMap<i32, BoxFrame>, KeyFault> {
    let placed =
        raw.frames.iter().enumerate().filter_map(|(number, frame)| Some((number, frame.frame, frame.placement?)));
    let frames = placed.map(|(number, frame, [x, y, z, origin])| {
        let key = || format!("{key}.frames[{number}].placement");
        if raw.space == RawSpace::Screen {
            return Err(KeyFault::new(key(), "is only allowed in scene-space tracks".to_owned(), "remove it"));
        }
        let placement = BoxFrame::new(DMat3::from_cols_array_2d(&[x, y, z]), origin.into());
        let hint = "give three perpendicular axes of length 1, right-handed, and an origin";
        Ok((frame, placement.ok_or_else(|| KeyFault::new(key(), "is not a rigid frame".to_owned(), hint))?))
    });
    frames.collect()
}

/// Returns the branches of a track.
fn branches(raw: &RawTrack, key: &str, is_plain: bool) -> Result<BTreeMap<i32, LatticeBranches>, KeyFault> {
    let mut found = BTreeMap::new();
    for (number, frame) in raw.frames.iter().enumerate() {
        let key = |own: &str| format!("{key}.frames[{number}].{own}");
        if frame.angle.is_some_and(|angle| angle != 0.0) && (is_plain || raw.space == RawSpace::World) {
            let hint = "only boxes of screen lattices in files of version 2 can be rotated";
            return Err(KeyFault::new(key("angle"), "is not allowed here", hint));
        }
        let Some(branches) = &frame.branches else { continue };
        if is_plain || raw.space == RawSpace::World {
            let hint = "only screen lattices in files of version 2 can branch";
            return Err(KeyFault::new(key("branches"), "is not allowed here", hint));
        }
        found.insert(frame.frame, checked_branches(branches, frame.handles.len(), key)?);
    }
    Ok(found)
}

fn checked_branches(
    raw: &RawBranches,
    handle_count: usize,
    key: impl Fn(&str) -> String,
) -> Result<LatticeBranches, KeyFault> {
    let points = raw.points.iter().enumerate();
    let points =
        points.map(|(k, place)| point(place, || key(&format!("branches.points[{k}]")))).collect::<Result<_, _>>()?;
    let mut list = Vec::with_capacity(raw.list.len());
    for (index, branch) in raw.list.iter().enumerate() {
        let own = |what: &str| key(&format!("branches.list[{index}].{what}"));
        let mut handles = vec![None; handle_count];
        for &(handle, x, y) in &branch.handles {
            let Some(place) = handles.get_mut(handle as usize) else {
                let what = format!("has handle {handle}, there are {handle_count}");
                return Err(KeyFault::new(own("handles"), what, "count from 0, x fastest"));
            };
            *place = Some(point(&[x, y], || own("handles"))?);
        }
        if handles.iter().all(Option::is_none) {
            return Err(KeyFault::new(own("handles"), "is empty", "list the handles that act on it"));
        }
        let is_wrong =
            |polygon: &Vec<u32>| polygon.len() < 3 || polygon.iter().any(|&corner| corner as usize >= raw.points.len());
        if let Some(place) = branch.region.iter().position(is_wrong) {
            let hint = "give three corners or more, as indices of `points`";
            return Err(KeyFault::new(own(&format!("region[{place}]")), "is no polygon".to_owned(), hint));
        }
        list.push(LatticeBranch { handles, region: branch.region.clone() });
    }
    if list.is_empty() {
        return Err(KeyFault::new(key("branches.list"), "is empty", "leave `branches` out"));
    }
    Ok(LatticeBranches { points, list })
}

fn raw_branches(branches: &LatticeBranches) -> RawBranches {
    let acting = |branch: &LatticeBranch| {
        let handles = (0..).zip(&branch.handles);
        handles.filter_map(|(index, place)| place.map(|[x, y]| (index, x, y))).collect()
    };
    let list = branches.list.iter();
    let list = list.map(|branch| RawBranch { handles: acting(branch), region: branch.region.clone() });
    RawBranches { points: branches.points.clone(), list: list.collect() }
}

fn point<const D: usize>(values: &[f64], key: impl Fn() -> String) -> Result<[f64; D], KeyFault> {
    match <[f64; D]>::try_from(values) {
        Ok(point) if point.iter().all(|x| x.abs() <= FARTHEST) => Ok(point),
        _ => Err(KeyFault::new(key(), format!("is {values:?}"), format!("give {D} numbers of at most {FARTHEST}"))),
    }
}

fn raw_track<const D: usize>(layer: &LatticeTrack, space: RawSpace, lattices: &BTreeMap<i32, Lattice<D>>) -> RawTrack {
    let frames = lattices.iter().map(|(&frame, lattice)| RawFrame {
        frame,
        bounds: [lattice.grid.lo.to_vec(), lattice.grid.hi.to_vec()],
        placement: layer.placements.get(&frame).map(|placed| {
            let DMat3 { x_axis, y_axis, z_axis } = placed.axes();
            [x_axis, y_axis, z_axis, placed.origin()].map(|column| column.to_array())
        }),
        angle: Some(lattice.grid.angle).filter(|angle| *angle != 0.0),
        handles: lattice.handles.iter().map(|handle| handle.to_vec()).collect(),
        branches: layer.branches.get(&frame).map(raw_branches),
    });
    let first = lattices.values().next().expect("a track has frames");
    RawTrack {
        name: layer.name.clone(),
        space,
        basis: first.grid.basis,
        dims: first.grid.dims.to_vec(),
        frames: frames.collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Basis;
    use glam::DVec3;

    fn grid<const D: usize>(shift: f64) -> Grid<D> {
        Grid { dims: [4; D], basis: Basis::Bspline, lo: [shift; D], hi: [1.0 + shift; D], angle: 0.0 }
    }

    fn file() -> LatticeFile {
        let screen = [(1, grid(0.0).at_rest()), (3, grid(0.5).at_rest())].into();
        let world = [(-2, grid(0.1).at_rest())].into();
        let track = |name: &str, track| LatticeTrack {
            name: name.to_owned(),
            track,
            placements: BTreeMap::new(),
            branches: BTreeMap::new(),
            has_branches_in_scene: false,
            wholes: BTreeMap::new(),
        };
        let mut layers = vec![track("body", Track::Screen(screen)), track("head", Track::World(world))];
        let turned = glam::DMat4::from_rotation_y(0.3);
        layers[1].placements.insert(-2, BoxFrame::of(glam::DMat4::from_translation(DVec3::ONE) * turned));
        LatticeFile { frame_aspect: 16.0 / 9.0, rate: 24.0, layers }
    }

    #[test]
    fn files_come_back_to_the_last_bit() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.lattice.json");
        file().write(&path).expect("written");
        assert_eq!(LatticeFile::read(&path).expect("read"), file());
    }

    #[test]
    fn branches_come_back_to_the_last_bit_and_plain_files_stay_of_the_first_version() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.lattice.json");
        let mut file = file();
        file.write(&path).expect("written");
        assert!(std::fs::read_to_string(&path).expect("read").contains("\"pinwarp_lattice\":1,"));
        let handles =
            |moved: f64| (0..16).map(|k| (k != 5).then_some([moved + 0.1 * f64::from(k), 1.0 / 3.0])).collect();
        let corners = [[0.1, 0.2], [0.7, 0.1 + 0.2], [0.3, 0.9]];
        let square = [[0.7, 0.1 + 0.2], [0.8, 0.3], [0.8, 0.5], [0.3, 0.9]];
        let branches = vec![(handles(0.0), vec![corners.to_vec()]), (handles(0.5), vec![square.to_vec()])];
        let branches = LatticeBranches::of(branches);
        assert_eq!((branches.points.len(), branches.list[1].region[0].clone()), (5, vec![1, 3, 4, 2]));
        file.layers[0].branches.insert(3, branches);
        file.write(&path).expect("written");
        let text = std::fs::read_to_string(&path).expect("read");
        assert_eq!(LatticeFile::read(&path).expect("read"), file);
        let changes = [
            ("\"pinwarp_lattice\":2", "\"pinwarp_lattice\":1", "layers[0].frames[1].branches: is not allowed here"),
            ("[[0,0.0,", "[[16,0.0,", "branches.list[0].handles: has handle 16"),
            ("[1,3,4,2]", "[1,3,5,2]", "branches.list[1].region[0]"),
            ("[1,3,4,2]", "[1,3]", "branches.list[1].region[0]"),
        ];
        for (from, to, wanted) in changes {
            assert!(text.contains(from), "{from} in {text}");
            std::fs::write(&path, text.replacen(from, to, 1)).expect("written");
            let error = LatticeFile::read(&path).expect_err("a fault").to_string();
            assert!(error.contains(wanted), "{error}");
        }
    }

    #[test]
    fn rotated_boxes_come_back_in_files_of_the_second_version() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.lattice.json");
        let mut file = file();
        let Track::Screen(lattices) = &mut file.layers[0].track else { unreachable!() };
        lattices.get_mut(&3).expect("frame 3").grid.angle = 0.1 + 0.2;
        file.write(&path).expect("written");
        let text = std::fs::read_to_string(&path).expect("read");
        assert_eq!((LatticeFile::read(&path).expect("read"), text.matches("angle").count()), (file, 1));
        for (from, to) in
            [("\"pinwarp_lattice\":2", "\"pinwarp_lattice\":1"), ("\"frame\":-2,", "\"frame\":-2,\"angle\":1.0,")]
        {
            assert!(text.contains(from), "{from} in {text}");
            std::fs::write(&path, text.replacen(from, to, 1)).expect("written");
            let error = LatticeFile::read(&path).expect_err("a fault").to_string();
            assert!(error.contains("].angle: is not allowed here"), "{error}");
        }
    }

    #[test]
    fn frames_between_are_mixed_and_ends_hold() {
        let Track::Screen(lattices) = &file().layers[0].track else { unreachable!() };
        let at = |frame: f64| lattice_at(lattices, frame);
        assert!((at(1.5).grid.lo[0] - 0.125).abs() < 1e-15 && (at(2.0).handles[0][0] + 0.75).abs() < 1e-15);
        assert_eq!((at(-7.0), at(1.0), at(9.5)), (lattices[&1].clone(), lattices[&1].clone(), lattices[&3].clone()));
    }

    #[test]
    fn faults_name_file_and_key() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("bad.json");
        file().write(&path).expect("written");
        let good = std::fs::read_to_string(&path).expect("read");
        let changes = [
            ("\"pinwarp_lattice\":1", "\"pinwarp_lattice\":7", "version"),
            ("\"dims\":[4,4]", "\"dims\":[4,5]", "layers[0].frames[0].handles: 16 handles"),
            ("\"dims\":[4,4]", "\"dims\":[4]", "layers[0].dims"),
            ("\"frame\":3", "\"frame\":1", "duplicate frame 1"),
            ("\"frame\":3", "\"frame\":2147483647", "layers[0].frames[1].frame: is 2147483647"),
            ("\"frame\":-2", "\"frame\":-1000001", "layers[1].frames[0].frame"),
            ("\"name\":\"head\"", "\"name\":\"body\"", "layers[1].name"),
            ("\"box\":[[0.0,0.0]", "\"box\":[[2.0,0.0]", "layers[0].frames[0]"),
            ("\"rate\"", "\"pace\"", "lattice-json"),
            ("\"rate\":24.0", "\"rate\":0.0", "rate"),
        ];
        for (from, to, wanted) in changes {
            assert!(good.contains(from), "{from}");
            std::fs::write(&path, good.replacen(from, to, 1)).expect("written");
            let error = LatticeFile::read(&path).expect_err("a fault").to_string();
            assert!(error.contains(wanted) && error.contains("bad.json"), "{error}");
        }
    }
}
