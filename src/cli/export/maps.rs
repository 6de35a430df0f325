//! Screen-space maps per frame: the common part of `--to stmap`, `nuke` and `after-effects`.
//!
//! In: lattices and command-line flags. Out: the map of each frame; files, written if they are missing or out of date.

use super::map_size::map_size;
use super::source::Source;
use crate::cli::args::ExportArgs;
use crate::cli::warnings::Warnings;
use crate::export::{LatticeFile, LatticeTrack, Track};
use crate::image::{Depth, Existing, Expected, FrameMetadata, Inputs, SequencePath, check_kept};
use crate::lattice::Lattice;
use crate::pipeline::{
    PreparedShot, Silhouette, SurfaceMaps, Todo, digest_with, fields_of, lattices_of_file, parts_of_file,
    refuse_existing,
};
use crate::plate::{Field, SharedParts, WarpMap};
use crate::shot::digest;
use crate::space::{FrameSize, FrameWindow, PixelRect};
use crate::spelling::pluralised;
use anyhow::{anyhow, bail};
use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Write};
use std::path::Path;

/// The device recorded in the maps.
const DEVICE: &str = "CPU";

/// The shot that maps are made from; `None` for lattice files.
type MaybePrepared = Option<Box<PreparedShot>>;

/// The maps of a shot or of a lattice file.
pub(super) struct Maps {
    /// The lattices, screen space only.
    pub(super) lattices: LatticeFile,
    /// The frames with a warp, in increasing order.
    pub(super) frames: Vec<i32>,
    /// The display window.
    pub(super) size: FrameSize,
    /// The pixels that the maps cover.
    window: PixelRect,
    direction: Direction,
    scope: Scope,
    /// Digest of the contents of the shot's files, whose surfaces affect the maps; empty for lattice files.
    contents: String,
    /// Files that must not be overwritten.
    pub(super) inputs: Inputs,
}

/// The direction of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Direction {
    /// Stores where a pixel of the warped picture comes from.
    Backward,
    /// Stores where a pixel of the unwarped picture goes, and thus undoes the warp.
    Forward,
}

/// What moves with the layers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scope {
    /// The whole picture: each layer bends all of it, and its displacement fades out outside its box.
    Picture,
    /// A single layer by itself: its displacement continues outside its box.
    Layer,
    /// The surfaces of the scene: each pixel follows the surface that it shows.
    Surfaces,
}

/// What the maps of a shot are made from, beside its lattices.
pub(super) enum Drawings<'a> {
    /// Where the unwarped picture is transparent.
    Silhouette(Box<Silhouette<'a>>),
    /// The scene before and after the warp.
    Surfaces(Box<SurfaceMaps<'a>>),
}

/// What maps are made from.
struct Opened {
    lattices: LatticeFile,
    prepared: MaybePrepared,
    inputs: Inputs,
    size: FrameSize,
}

impl Opened {
    fn of(args: &ExportArgs) -> anyhow::Result<Self> {
        let source = Source::open(args)?;
        // A size that does not fit is refused before anything is solved.
        let (inputs, size) = (source.inputs(args)?, map_size(args, &source)?);
        let (lattices, prepared) = source.lattices(args)?;
        Ok(Self { lattices, prepared, inputs, size })
    }

    /// Returns the maps, and the shot.
    fn maps(self, args: &ExportArgs, scope: Scope) -> anyhow::Result<(Maps, MaybePrepared)> {
        let Self { mut lattices, prepared, inputs, size } = self;
        let mut contents = prepared.as_deref().map(PreparedShot::contents_digest).unwrap_or_default();
        let mut frames = frames_of(&lattices);
        if let (Scope::Surfaces, Some(prepared)) = (scope, &prepared) {
            if lattices.layers.iter().any(|layer| screen(layer).is_none()) {
                // The digest of a frame covers the lattices on the screen only.
                contents = digest_with(&contents, &prepared.shot.hash());
            }
            lattices.layers.retain(|layer| screen(layer).is_some());
        } else {
            keep_screen_layers(&mut lattices, args)?;
            frames = frames_of(&lattices);
        }
        let window = size.window().grown(args.overscan);
        let direction = if args.inverse { Direction::Forward } else { Direction::Backward };
        Ok((Maps { lattices, frames, size, window, direction, scope, contents, inputs }, prepared))
    }
}

impl Maps {
    /// Solves or reads the lattices; also returns the shot, if they come from one.
    pub(super) fn open(args: &ExportArgs) -> anyhow::Result<(Self, MaybePrepared)> {
        let opened = Opened::of(args)?;
        let scope = match &opened.prepared {
            _ if args.layer.len() == 1 => Scope::Layer,
            Some(prepared) if moves_surfaces(&opened.lattices, prepared) => Scope::Surfaces,
            _ => Scope::Picture,
        };
        let (maps, prepared) = opened.maps(args, scope)?;
        if scope == Scope::Picture && maps.lattices.layers.len() > 1 {
            let remedy = "export one at a time (--layer), or export a shot whose layers have no `matte` but its scene";
            writeln!(io::stderr(), "note: each layer bends the whole picture, the others' parts too; {remedy}")?;
        }
        Ok((maps, prepared))
    }

    /// Same as [`Self::open`], but with one set of maps for each layer on the screen, for elements with mattes.
    pub(super) fn open_layers(args: &ExportArgs) -> anyhow::Result<(Vec<(String, Self)>, MaybePrepared)> {
        let (maps, prepared) = Opened::of(args)?.maps(args, Scope::Layer)?;
        if let Some(prepared) = prepared.as_deref() {
            let layers = maps.lattices.layers.iter().filter_map(|layer| prepared.shot.layer_index(&layer.name));
            let note = prepared.note_on_shared(&layers.collect::<Vec<_>>());
            note.map_or(Ok(()), |note| writeln!(io::stderr(), "note: {note}"))?;
        }
        Ok((maps.by_layer(), prepared))
    }

    /// Splits into one set of maps per layer.
    fn by_layer(self) -> Vec<(String, Self)> {
        let Self { lattices: LatticeFile { frame_aspect, rate, layers }, size, window, direction, scope, .. } = self;
        let alone = |layer: LatticeTrack| {
            let (name, inputs, contents) = (layer.name.clone(), self.inputs.clone(), self.contents.clone());
            let lattices = LatticeFile { frame_aspect, rate, layers: vec![layer] };
            let frames = frames_of(&lattices);
            (name, Self { lattices, frames, size, window, direction, scope, contents, inputs })
        };
        layers.into_iter().map(alone).collect()
    }

    /// Returns width and height of a map in pixels.
    pub(super) const fn pixels(&self) -> [u32; 2] {
        [self.window.width, self.window.height]
    }

    /// Returns a digest of everything that affects the map of a frame.
    pub(super) fn digest(&self, frame: i32) -> String {
        let Self { lattices, frames: _, size, window, direction, scope, contents, inputs: _ } = self;
        let of_frame = |layer: &LatticeTrack| {
            let (own, whole) = (screen(layer).map(|track| track.get(&frame)), layer.wholes.get(&frame));
            let branches = layer.branches_at(frame).map(|branches| format!("{branches:?}")).unwrap_or_default();
            format!("{} {own:?} {whole:?}{branches}", layer.name)
        };
        let lattices: Vec<String> = lattices.layers.iter().map(of_frame).collect();
        digest_with(&digest(&format!("{lattices:?} {size:?} {window:?} {direction:?} {scope:?}")), contents)
    }

    /// Returns the metadata of a frame's file.
    fn metadata(&self, frame: i32) -> FrameMetadata {
        FrameMetadata {
            frame,
            frames_per_second: self.lattices.rate,
            shot_hash: self.digest(frame),
            device: DEVICE.into(),
            ..FrameMetadata::default()
        }
    }

    /// Computes the map of a frame: all layers, composed one after the other in the order of the shot. Where the warp
    /// folds, pixels outside the silhouette do not hide pixels inside it.
    pub(super) fn map(&self, frame: i32, drawings: Option<&mut Drawings>) -> anyhow::Result<WarpMap> {
        let silhouette = match (drawings, self.direction) {
            (Some(Drawings::Surfaces(surfaces)), Direction::Backward) => return Ok(surfaces.backward(frame)?),
            (Some(Drawings::Surfaces(surfaces)), Direction::Forward) => return Ok(surfaces.forward(frame)?),
            (Some(Drawings::Silhouette(silhouette)), _) => Some(&mut **silhouette),
            (None, _) => None,
        };
        if self.lattices.layers.iter().any(|layer| layer.branches_at(frame).is_some()) {
            return self.map_of_branches(frame, silhouette);
        }
        let field = |layer: &LatticeTrack| {
            if let Some(whole) = layer.wholes.get(&frame) {
                return Some(Field::of_whole(whole));
            }
            let lattice = screen(layer)?.get(&frame)?.clone();
            Some(if self.scope == Scope::Layer { Field::of_layer(lattice) } else { Field::of_picture(lattice) })
        };
        let field = Field::chain(self.lattices.layers.iter().filter_map(field).collect());
        let map = match self.direction {
            Direction::Backward => WarpMap::backward(&field, self.size, self.window),
            Direction::Forward => return Ok(WarpMap::forward(&field, self.size, self.window)),
        };
        let silhouette = silhouette.filter(|_| !map.folded_pixels.is_empty());
        let Some(coverage) = silhouette.map(|silhouette| silhouette.at(frame)).transpose()?.flatten() else {
            return Ok(map);
        };
        let covered = |pixel| coverage.at(pixel, self.size);
        Ok(WarpMap::backward_showing(&field, FrameWindow { frame: self.size, window: self.window }, covered))
    }

    /// As [`Self::map`], for the only layer if its lattice branches: each pixel follows the branch that covers most of it.
    fn map_of_branches(&self, frame: i32, silhouette: Option<&mut Silhouette>) -> anyhow::Result<WarpMap> {
        let [layer] = self.lattices.layers.as_slice() else {
            bail!(
                "some layers have branching lattices, and a lattice file does not store which pixels each layer moves; \
                 export one layer at a time (--layer)"
            );
        };
        let parts = match silhouette {
            Some(silhouette) => silhouette.branches(frame, (&layer.name, self.size))?,
            None => branches_of_track(layer, frame, self.size),
        };
        let place = FrameWindow { frame: self.size, window: self.window };
        let Some((parts, shape)) = parts else {
            return Ok(WarpMap::identity(self.size, self.window));
        };
        Ok(match self.direction {
            Direction::Backward => WarpMap::backward_of_shares(&parts, &shape, place),
            Direction::Forward => WarpMap::forward_of_parts(&parts, place),
        })
    }

    /// Prepares what the maps of a shot need: its scene before and after the warp, or else the silhouette of its
    /// unwarped picture, restricted to one layer if the maps are.
    pub(super) fn drawings<'a>(&self, prepared: &'a PreparedShot) -> anyhow::Result<Drawings<'a>> {
        if self.scope == Scope::Surfaces {
            let maps = SurfaceMaps::new(prepared, FrameWindow { frame: self.size, window: self.window })?;
            return Ok(Drawings::Surfaces(Box::new(maps)));
        }
        let only = match (self.scope, &self.lattices.layers[..]) {
            (Scope::Layer, [only]) => Some(only.name.as_str()),
            _ => None,
        };
        Ok(Drawings::Silhouette(Box::new(Silhouette::of(prepared, only))))
    }

    /// Describes the folds of a map; `None` if there are none.
    pub(super) fn fold_warning(&self, map: &WarpMap) -> Option<String> {
        let pixels = pluralised(map.folded_pixels.len(), "pixel", "pixels");
        let names: Vec<String> = self.lattices.layers.iter().map(|layer| format!("\"{}\"", layer.name)).collect();
        let layers = match &names[..] {
            [] => "the scene".to_owned(),
            [only] => format!("layer {only}"),
            _ => format!("layers {}", names.join(", ")),
        };
        let remedy = if self.direction == Direction::Forward {
            "the warp cannot be undone there"
        } else if names.len() <= 1 {
            "a map shows one part only; move the layer's pins less far, or hold what folds with more pins"
        } else {
            "a map shows one part only; move pins less far, hold what folds with more pins, or export one layer (--layer)"
        };
        (!map.folded_pixels.is_empty()).then(|| format!("the warp of {layers} folds over {pixels}: {remedy}"))
    }
}

/// Whether the layers move surfaces of the shot's scene, rather than whole pictures: each layer on the screen moves its
/// own nodes. Layers in the scene always do.
fn moves_surfaces(lattices: &LatticeFile, prepared: &PreparedShot) -> bool {
    let moves_own_nodes = |track: &LatticeTrack| {
        screen(track).is_none()
            || prepared.shot.layer_index(&track.name).is_some_and(|layer| prepared.moves_own_nodes(layer))
    };
    !lattices.layers.is_empty() && lattices.layers.iter().all(moves_own_nodes)
}

/// Returns the frames for which any layer has a lattice, in increasing order.
fn frames_of(lattices: &LatticeFile) -> Vec<i32> {
    let of_layer = |layer: &LatticeTrack| -> Vec<i32> {
        match &layer.track {
            Track::Screen(lattices) => lattices.keys().copied().collect(),
            Track::World(lattices) => lattices.keys().copied().collect(),
        }
    };
    let all: BTreeSet<i32> = lattices.layers.iter().flat_map(of_layer).collect();
    all.into_iter().collect()
}

/// Returns the branches stored in a file's track, for lattices without a shot.
fn branches_of_track(track: &LatticeTrack, frame: i32, size: FrameSize) -> Option<SharedParts> {
    let (listed, branches) = track.branches_at(frame)?;
    let lattices = lattices_of_file(branches, &screen(track)?.get(&listed)?.grid);
    fields_of(parts_of_file(branches, lattices, None, size))
}

fn screen(layer: &LatticeTrack) -> Option<&BTreeMap<i32, Lattice<2>>> {
    match &layer.track {
        Track::Screen(lattices) => Some(lattices),
        Track::World(_) => None,
    }
}

/// Removes layers that are not in screen space.
fn keep_screen_layers(lattices: &mut LatticeFile, args: &ExportArgs) -> anyhow::Result<()> {
    for layer in lattices.layers.iter().filter(|layer| screen(layer).is_none()) {
        let why =
            "is warped in the scene, which no screen-space map can represent; render it, or export gltf or blender";
        writeln!(io::stderr(), "note: layer '{}' {why}", layer.name)?;
    }
    lattices.layers.retain(|layer| screen(layer).is_some());
    if lattices.layers.is_empty() {
        return Err(anyhow!("no layer of {} is warped on the screen: there is no map to write", args.shot.display()));
    }
    Ok(())
}

/// The result of writing a sequence.
pub(super) struct Written {
    pub(super) new: usize,
    /// Number of existing frames kept.
    pub(super) kept: usize,
}

/// Returns the files of a sequence; fails if a frame would overwrite one of the inputs, or an existing file that may
/// not be replaced.
pub(super) fn check_frames(
    args: &ExportArgs,
    (pattern, inputs): (&Path, &Inputs),
    frames: &[i32],
) -> anyhow::Result<SequencePath> {
    let sequence = SequencePath::parse(pattern)?;
    sequence.check_frame_count(frames.len())?;
    frames.iter().try_for_each(|&frame| inputs.refuse(&sequence.path_of(frame)))?;
    if Existing::from(args.existing) == Existing::Refuse {
        refuse_existing(frames.iter().map(|&frame| sequence.path_of(frame)))?;
    }
    Ok(sequence)
}

/// Writes the frames of a sequence from [`check_frames`] and prints the warnings that `write` returns; with `--resume`,
/// frames that are up to date are kept.
pub(super) fn write_frames(
    args: &ExportArgs,
    (maps, sequence): (&Maps, &SequencePath),
    mut write: impl FnMut(&Path, &FrameMetadata) -> anyhow::Result<Option<String>>,
) -> anyhow::Result<Written> {
    let existing = Existing::from(args.existing);
    let depth = if existing == Existing::Verify { Depth::Pixels } else { Depth::Head };
    let todo = Todo::of(maps.frames.clone(), sequence, existing, |frame| {
        let expected = Expected { frame, shot_hash: &maps.digest(frame), size: None, device: DEVICE };
        check_kept(&sequence.path_of(frame), &expected, depth)
    });
    let todo = todo.begin(sequence)?;
    for note in todo.notes() {
        writeln!(io::stderr(), "note: {note}")?;
    }
    let mut warnings = Warnings::default();
    for &frame in &todo.frames {
        let path = sequence.path_of(frame);
        write(&path, &maps.metadata(frame))?.iter().for_each(|warning| warnings.add(frame, warning));
        tracing::info!("{} written", path.display());
    }
    warnings.lines().try_for_each(|line| writeln!(io::stderr(), "{line}"))?;
    Ok(Written { new: todo.frames.len(), kept: todo.kept })
}
