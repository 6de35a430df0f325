//! Screen-space maps per frame: the common part of `--to stmap`, `nuke` and `after-effects`.
//!
//! In: lattices and command-line flags. Out: the map of each frame; files, written if they are missing or out of date.

use super::source::Source;
use crate::cli::args::ExportArgs;
use crate::export::{LatticeFile, LatticeTrack, Track};
use crate::image::{Depth, Existing, Expected, FrameMetadata, Inputs, SequencePath, check_kept};
use crate::lattice::Lattice;
use crate::pipeline::{
    PreparedShot, Silhouette, Todo, digest_with, fields_of, lattices_of_file, parts_of_file, refuse_existing,
};
use crate::plate::{Field, SharedParts, WarpMap};
use crate::shot::digest;
use crate::space::{FrameSize, PixelRect};
use crate::spelling::pluralised;
use anyhow::{anyhow, bail};
use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Write};
use std::path::Path;

/// Height in pixels of the maps of a lattice file, which has no resolution.
const DEFAULT_HEIGHT: f64 = 1080.0;

/// The device recorded in the maps.
const DEVICE: &str = "CPU";

/// The maps of a shot or of a lattice file.
pub(super) struct Maps {
    /// The lattices, screen space only.
    pub(super) lattices: LatticeFile,
    /// The display window.
    pub(super) size: FrameSize,
    /// The pixels that the maps cover.
    window: PixelRect,
    direction: Direction,
    extrapolation: Extrapolation,
    /// The indices of the layers in the shot, if each moves its own nodes; `None` if each bends the whole picture.
    parts: Option<Vec<usize>>,
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

/// The displacement outside the boxes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Extrapolation {
    /// Fades out, for a whole picture.
    Picture,
    /// Continues, for a single layer.
    Layer,
}

impl Maps {
    /// Solves or reads the lattices; also returns the shot, if they come from one.
    pub(super) fn open(args: &ExportArgs) -> anyhow::Result<(Self, Option<Box<PreparedShot>>)> {
        let source = Source::open(args)?;
        let inputs = source.inputs(args)?;
        let (mut lattices, prepared) = source.lattices(args)?;
        keep_screen_layers(&mut lattices, args)?;
        let size = match (args.size, prepared.as_ref().map(|prepared| prepared.shot.size)) {
            (Some([width, height]), _) => {
                FrameSize { width, height, pixel_aspect: lattices.frame_aspect * f64::from(height) / f64::from(width) }
            }
            (None, Some(size)) => size,
            (None, None) => {
                FrameSize::new((DEFAULT_HEIGHT * lattices.frame_aspect).round().max(1.0) as u32, DEFAULT_HEIGHT as u32)
            }
        };
        let size = squared(size);
        let window = size.window().grown(args.overscan);
        let direction = if args.inverse { Direction::Forward } else { Direction::Backward };
        let extrapolation = if args.layer.is_some() { Extrapolation::Layer } else { Extrapolation::Picture };
        let parts = prepared
            .as_deref()
            .filter(|_| extrapolation == Extrapolation::Picture)
            .and_then(|prepared| parts_of(&lattices, prepared));
        if extrapolation == Extrapolation::Picture && parts.is_none() && lattices.layers.len() > 1 {
            let remedy = "export one at a time (--layer), or export a shot whose layers have no `matte` but its scene";
            writeln!(io::stderr(), "note: each layer bends the whole picture, the others' parts too; {remedy}")?;
        }
        if let (Some(prepared), [only], None) = (&prepared, lattices.layers.as_slice(), &parts)
            && prepared.shot.layer_index(&only.name).is_some_and(|layer| prepared.moves_own_nodes(layer))
        {
            let remedy = "apply it to an element that shows nothing else";
            writeln!(
                io::stderr(),
                "note: layer '{}' moves its own nodes, but a map bends the whole picture: {remedy}",
                only.name
            )?;
        }
        if let (Some(prepared), Some(layers)) = (prepared.as_deref(), &parts) {
            prepared.note_on_shared(layers).map_or(Ok(()), |note| writeln!(io::stderr(), "note: {note}"))?;
        }
        let contents = prepared.as_deref().map(PreparedShot::contents_digest).unwrap_or_default();
        Ok((Self { lattices, size, window, direction, extrapolation, parts, contents, inputs }, prepared))
    }

    /// Splits into one set of maps per layer, for elements with mattes.
    pub(super) fn by_layer(self) -> Vec<(String, Self)> {
        let Self {
            lattices: LatticeFile { frame_aspect, rate, layers },
            size,
            window,
            direction,
            inputs,
            contents,
            ..
        } = self;
        let alone = |layer: LatticeTrack| {
            let (name, inputs, contents) = (layer.name.clone(), inputs.clone(), contents.clone());
            let lattices = LatticeFile { frame_aspect, rate, layers: vec![layer] };
            (
                name,
                Self {
                    lattices,
                    size,
                    window,
                    direction,
                    extrapolation: Extrapolation::Layer,
                    parts: None,
                    contents,
                    inputs,
                },
            )
        };
        layers.into_iter().map(alone).collect()
    }

    /// Returns width and height of a map in pixels.
    pub(super) const fn pixels(&self) -> [u32; 2] {
        [self.window.width, self.window.height]
    }

    /// Returns the frames with a warp, in increasing order.
    pub(super) fn frames(&self) -> Vec<i32> {
        let of_layer = |layer: &LatticeTrack| screen(layer).map(|track| track.keys().copied().collect::<Vec<_>>());
        let all: BTreeSet<i32> = self.lattices.layers.iter().filter_map(of_layer).flatten().collect();
        all.into_iter().collect()
    }

    /// Returns a digest of everything that affects the map of a frame.
    pub(super) fn digest(&self, frame: i32) -> String {
        let Self { lattices, size, window, direction, extrapolation, parts, contents, inputs: _ } = self;
        let of_frame = |layer: &LatticeTrack| {
            let (own, whole) = (screen(layer).map(|track| track.get(&frame)), layer.wholes.get(&frame));
            let branches = layer.branches_at(frame).map(|branches| format!("{branches:?}")).unwrap_or_default();
            format!("{} {own:?} {whole:?}{branches}", layer.name)
        };
        let lattices: Vec<String> = lattices.layers.iter().map(of_frame).collect();
        digest_with(
            &digest(&format!("{lattices:?} {size:?} {window:?} {direction:?} {extrapolation:?} {parts:?}")),
            contents,
        )
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
    pub(super) fn map(&self, frame: i32, mut silhouette: Option<&mut Silhouette>) -> anyhow::Result<WarpMap> {
        if self.lattices.layers.iter().any(|layer| layer.branches_at(frame).is_some()) {
            return self.map_of_branches(frame, silhouette);
        }
        if let (Some(layers), Some(silhouette)) = (&self.parts, silhouette.as_deref_mut())
            && let Some(coverage) = silhouette.of_layers(frame, layers)?
        {
            let of_layer = |layer: &LatticeTrack| screen(layer)?.get(&frame).cloned();
            let fields = self.lattices.layers.iter().map(of_layer).map(|lattice| lattice.map(Field::of_layer));
            let fields = fields.map(|field| field.unwrap_or_else(Field::identity));
            let (parts, place) = (fields.zip(coverage).collect::<Vec<_>>(), (self.size, self.window));
            return Ok(match self.direction {
                Direction::Backward => WarpMap::backward_of_parts(&parts, place),
                Direction::Forward => WarpMap::forward_of_parts(&parts, place),
            });
        }
        let field = |layer: &LatticeTrack| {
            if let Some(whole) = layer.wholes.get(&frame) {
                return Some(Field::of_whole(whole));
            }
            let lattice = screen(layer)?.get(&frame)?.clone();
            Some(match self.extrapolation {
                Extrapolation::Picture => Field::of_picture(lattice),
                Extrapolation::Layer => Field::of_layer(lattice),
            })
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
        Ok(WarpMap::backward_showing(&field, (self.size, self.window), covered))
    }

    /// As [`Self::map`], for lattices with branches: each pixel follows the branch that covers most of it.
    fn map_of_branches(&self, frame: i32, mut silhouette: Option<&mut Silhouette>) -> anyhow::Result<WarpMap> {
        let layers = &self.lattices.layers;
        let covered = match (&self.parts, silhouette.as_deref_mut()) {
            (Some(layers), Some(silhouette)) => silhouette.of_layers(frame, layers)?,
            _ => None,
        };
        if covered.is_none() && layers.len() > 1 {
            bail!(
                "some layers have branching lattices, and a lattice file does not store which pixels each layer moves; \
                 export one layer at a time (--layer)"
            );
        }
        let mut parts = Vec::new();
        let place = (self.size, self.window);
        for (index, layer) in layers.iter().enumerate() {
            let own = match silhouette.as_deref() {
                Some(silhouette) => silhouette.branches(frame, (&layer.name, self.size))?,
                None => branches_of_track(layer, frame, self.size),
            };
            match (own, &covered) {
                (Some((own, shape)), None) => {
                    return Ok(match self.direction {
                        Direction::Backward => WarpMap::backward_of_shares(&own, &shape, place),
                        Direction::Forward => WarpMap::forward_of_parts(&own, place),
                    });
                }
                (Some((own, _)), Some(covered)) => {
                    parts.extend(own.into_iter().map(|(field, share)| (field, share.within(&covered[index]))));
                }
                (None, covered) => {
                    let lattice = screen(layer).and_then(|track| track.get(&frame)).cloned();
                    let field = lattice.map_or_else(Field::identity, Field::of_layer);
                    parts.extend(covered.as_ref().map(|covered| (field, covered[index].clone())));
                }
            }
        }
        Ok(match self.direction {
            Direction::Backward => WarpMap::backward_of_parts(&parts, place),
            Direction::Forward => WarpMap::forward_of_parts(&parts, place),
        })
    }

    /// Returns the visibility of the shot's unwarped picture, restricted to one layer if the maps are.
    pub(super) fn silhouette<'a>(&self, prepared: &'a PreparedShot) -> Silhouette<'a> {
        let only = match (self.extrapolation, &self.lattices.layers[..]) {
            (Extrapolation::Layer, [only]) => Some(only.name.as_str()),
            _ => None,
        };
        Silhouette::of(prepared, only)
    }

    /// Describes the folds of a frame's map; `None` if there are none.
    pub(super) fn fold_note(&self, frame: i32, map: &WarpMap) -> Option<String> {
        let pixels = pluralised(map.folded_pixels.len(), "pixel", "pixels");
        let names: Vec<String> = self.lattices.layers.iter().map(|layer| format!("\"{}\"", layer.name)).collect();
        let layers =
            if let [only] = &names[..] { format!("layer {only}") } else { format!("layers {}", names.join(", ")) };
        let remedy = if self.direction == Direction::Forward {
            "the warp cannot be undone there"
        } else if names.len() == 1 {
            "a map shows one part only; move the layer's pins less far, or hold what folds with more pins"
        } else {
            "a map shows one part only; move pins less far, hold what folds with more pins, or export one layer (--layer)"
        };
        (!map.folded_pixels.is_empty())
            .then(|| format!("frame {frame}: the warp of {layers} folds over {pixels}: {remedy}"))
    }
}

/// Returns the layers of the shot that the lattices belong to, if there are several, or one with branches, and each
/// moves its own nodes.
fn parts_of(lattices: &LatticeFile, prepared: &PreparedShot) -> Option<Vec<usize>> {
    let of_track =
        |track: &LatticeTrack| prepared.shot.layer_index(&track.name).filter(|&layer| prepared.moves_own_nodes(layer));
    let layers: Option<Vec<usize>> = lattices.layers.iter().map(of_track).collect();
    let has_branches = lattices.has_branches();
    layers.filter(|layers| layers.len() > 1 || has_branches)
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

/// Removes layers that were not selected or are not in screen space.
fn keep_screen_layers(lattices: &mut LatticeFile, args: &ExportArgs) -> anyhow::Result<()> {
    let names: Vec<String> = lattices.layers.iter().map(|layer| layer.name.clone()).collect();
    if let Some(wanted) = &args.layer {
        lattices.layers.retain(|layer| layer.name == *wanted);
        if lattices.layers.is_empty() {
            let hint = crate::spelling::hint(wanted, names.iter().map(String::as_str));
            bail!("{} has no warped layer '{wanted}'; {hint}", args.shot.display());
        }
    }
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

/// Makes pixels exactly square if they are square up to rounding.
fn squared(size: FrameSize) -> FrameSize {
    let is_square = (size.pixel_aspect - 1.0).abs() * f64::from(size.width) <= 1.0;
    if is_square { FrameSize::new(size.width, size.height) } else { size }
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

/// Writes the frames of a sequence from [`check_frames`]; with `--resume`, frames that are up to date are kept.
pub(super) fn write_frames(
    args: &ExportArgs,
    (maps, sequence): (&Maps, &SequencePath),
    mut write: impl FnMut(&Path, &FrameMetadata) -> anyhow::Result<()>,
) -> anyhow::Result<Written> {
    let existing = Existing::from(args.existing);
    let depth = if existing == Existing::Verify { Depth::Pixels } else { Depth::Head };
    let todo = Todo::of(maps.frames(), sequence, existing, |frame| {
        let expected = Expected { frame, shot_hash: &maps.digest(frame), size: None, device: DEVICE };
        check_kept(&sequence.path_of(frame), &expected, depth)
    });
    let todo = todo.begin(sequence)?;
    for note in todo.notes() {
        writeln!(io::stderr(), "note: {note}")?;
    }
    for &frame in &todo.frames {
        let path = sequence.path_of(frame);
        write(&path, &maps.metadata(frame))?;
        tracing::info!("{} written", path.display());
    }
    Ok(Written { new: todo.frames.len(), kept: todo.kept })
}
