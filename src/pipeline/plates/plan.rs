//! Plans a warp: which frames, from which files to which. Refuses at once what would fail at every frame.
//!
//! In: a [`WarpJob`]. Out: a [`Plan`].

use super::headers::{self, Sources};
use super::shared_meshes::SharedGroup;
use super::{PlateWarp, WarpDirection, WarpJob};
use crate::export::{LatticeFile, Track};
use crate::image::{
    Depth, Expected, ImageError, Inputs, PictureKind, SequencePath, StaleReason, check_kept, is_there, picture_size,
};
use crate::pipeline::evaluate::topology::check_plain;
use crate::pipeline::run::contents::FrameDigests;
use crate::pipeline::run::output::input_files;
use crate::pipeline::run::resume::{Todo, refuse_existing};
use crate::pipeline::{Existing, PipelineError, PreparedShot};
use crate::plate::Holes;
use crate::shot::{LayerSpace, digest};
use crate::spelling;
use std::path::{Path, PathBuf};

/// A checked job.
pub(super) struct Plan {
    pub(super) plate: SequencePath,
    pub(super) output: SequencePath,
    /// Clean plates that fill holes.
    pub(super) clean: Option<SequencePath>,
    /// STMaps that replace lattices.
    pub(super) maps: Option<SequencePath>,
    /// Layers that warp, by index in the shot or file.
    pub(super) layers: Vec<usize>,
    /// The layers that share meshes, if they can be moved as one.
    pub(super) shared: Option<SharedGroup>,
    /// Frames to warp, and frames to keep.
    pub(super) todo: Todo,
    /// Notes for the user, reported before the run.
    pub(super) notes: Vec<String>,
    /// Digest of each frame's inputs.
    pub(super) digests: FrameDigests,
}

impl Plan {
    /// Creates the plan; `device`: the device that resamples colour.
    pub(super) fn of(job: &WarpJob, device: &str) -> Result<Self, PipelineError> {
        let (plate, output) = (SequencePath::of_input(&job.plate)?, SequencePath::parse(&job.output)?);
        check_kinds(&job.plate, &job.output)?;
        let sequence = |path: &PathBuf| SequencePath::of_input(path);
        let maps = if let PlateWarp::Maps(maps) = &job.warp { Some(sequence(maps)?) } else { None };
        let clean = if let Holes::Plate(clean) = &job.settings.holes { Some(sequence(clean)?) } else { None };
        let mut notes = notes_of(&job.warp);
        let layers = layers(job, &mut notes)?;
        check_inverse(job, &layers)?;
        check_matte(job, &layers)?;
        check_mattes_differ(job, &layers)?;
        notes.extend(note_unmatted(job, &layers));
        let mut shared = None;
        if let PlateWarp::Shot(prepared) = &job.warp {
            shared = SharedGroup::of(prepared, &layers);
            notes.extend(prepared.note_on_shared(&layers).filter(|_| shared.is_none()));
        }
        let wanted = wanted(job, (&plate, maps.as_ref()), &mut notes)?;
        output.check_frame_count(wanted.len())?;
        let mut inputs =
            if let PlateWarp::Shot(prepared) = &job.warp { input_files(prepared)? } else { Inputs::default() };
        job.inputs.iter().for_each(|path| inputs.add(path));
        [Some(&plate), clean.as_ref(), maps.as_ref()]
            .into_iter()
            .flatten()
            .try_for_each(|source| inputs.add_sequence(source))?;
        wanted.iter().try_for_each(|&frame| inputs.refuse(&output.path_of(frame)))?;
        if job.existing == Existing::Refuse {
            refuse_existing(wanted.iter().map(|&frame| output.path_of(frame)))?;
        }
        let sources = Sources { plate: &plate, clean: clean.as_ref(), maps: maps.as_ref() };
        headers::check_there(&sources, &wanted)?;
        let digests = digests(job, &layers, [Some(&plate), clean.as_ref(), maps.as_ref()]);
        let todo = KeptFrames { plate: &plate, output: &output, digests: &digests, device }.todo(wanted, job.existing);
        notes.extend(headers::check(job, &sources, &layers, &todo.frames)?);
        notes.extend(todo.notes());
        let todo = todo.begin(&output)?;
        Ok(Self { plate, output, clean, maps, layers, shared, todo, notes, digests })
    }
}

/// Returns the digests of the settings and files from which each frame is made.
fn digests(job: &WarpJob, layers: &[usize], sequences: [Option<&SequencePath>; 3]) -> FrameDigests {
    let shared = if let PlateWarp::Shot(prepared) = &job.warp { prepared.files().collect() } else { Vec::new() };
    FrameDigests::new(hash(job, layers), &shared, sequences.into_iter().flatten())
}

/// What a frame that is kept has to agree with.
struct KeptFrames<'a> {
    plate: &'a SequencePath,
    output: &'a SequencePath,
    digests: &'a FrameDigests,
    device: &'a str,
}

impl KeptFrames<'_> {
    /// Returns the frames to warp. A kept frame must have the size of its plate.
    fn todo(&self, wanted: Vec<i32>, existing: Existing) -> Todo {
        let depth = if existing == Existing::Verify { Depth::Pixels } else { Depth::Head };
        Todo::of(wanted, self.output, existing, |frame| {
            let path = self.output.path_of(frame);
            if !is_there(&path) {
                return Err(StaleReason::Missing);
            }
            let size = picture_size(&self.plate.path_of(frame)).ok();
            let expected = Expected { frame, shot_hash: &self.digests.of(frame), size, device: self.device };
            check_kept(&path, &expected, depth)
        })
    }
}

/// Checks that the plate is a picture file and that the output format can hold its channels.
fn check_kinds(plate: &Path, output: &Path) -> Result<(), PipelineError> {
    let fault =
        |path: &Path, what: &str| Err(ImageError::Pattern { pattern: path.to_owned(), what: what.into() }.into());
    let kind = PictureKind::known(plate)?;
    match (kind, PictureKind::of(output)) {
        (_, None) => fault(output, "is not the name of a picture file; let it end in .exr (or .png for PNG plates)"),
        (_, Some(PictureKind::Jpeg)) => {
            let hint = if kind == PictureKind::Exr { "use .exr" } else { "use .exr or .png" };
            Err(unusable(format!("{}: JPEG files cannot be written", output.display()), hint))
        }
        (PictureKind::Exr, Some(PictureKind::Png)) => {
            fault(output, "cannot hold the channels of an EXR plate; let it end in .exr")
        }
        _ => Ok(()),
    }
}

/// Returns the notes of the shot; lattices and maps have none.
fn notes_of(warp: &PlateWarp) -> Vec<String> {
    if let PlateWarp::Shot(prepared) = warp { prepared.notes.clone() } else { Vec::new() }
}

/// Returns the indices of the layers that warp; world layers cannot.
fn layers(job: &WarpJob, notes: &mut Vec<String>) -> Result<Vec<usize>, PipelineError> {
    let (place, all) = match &job.warp {
        PlateWarp::Shot(prepared) => (prepared.shot.path.display().to_string(), layers_of_shot(prepared)),
        PlateWarp::Lattices { file, .. } => ("the lattice file".to_owned(), layers_of_file(file)),
        PlateWarp::Maps(_) => return Ok(Vec::new()),
    };
    for name in &job.layers {
        if !all.iter().any(|(other, _)| other == name) {
            let hint = spelling::hint(name, all.iter().map(|(name, _)| *name));
            return Err(unusable(format!("{place} has no layer '{name}'"), hint));
        }
    }
    let chosen = all.iter().enumerate();
    let chosen = chosen.filter(|(_, (name, _))| job.layers.is_empty() || job.layers.iter().any(|other| other == name));
    let (flat, in_scene): (Vec<_>, Vec<_>) = chosen.partition(|(_, (_, is_flat))| *is_flat);
    let names: Vec<&str> = in_scene.iter().map(|(_, (name, _))| *name).collect();
    if flat.is_empty() {
        let what = match names.as_slice() {
            [] => format!("{place} has no layers"),
            names => format!(
                "{place} has lattices of the scene only ({}): plates are warped on the screen",
                names.join(", ")
            ),
        };
        let hint = "give its layers lattices of the screen, or render the scene with `pinwarp render`";
        return Err(unusable(what, hint));
    }
    if !names.is_empty() {
        notes.push(format!(
            "left out, since plates are warped on the screen: {} (lattices of the scene)",
            names.join(", ")
        ));
    }
    Ok(flat.into_iter().map(|(index, _)| index).collect())
}

/// Returns the layers' names, and whether each lattice lies on the screen.
fn layers_of_shot(prepared: &PreparedShot) -> Vec<(&str, bool)> {
    let is_flat = |space: &LayerSpace| matches!(space, LayerSpace::Screen { .. });
    prepared.shot.layers.iter().map(|layer| (layer.name.as_str(), is_flat(&layer.space))).collect()
}

fn layers_of_file(file: &LatticeFile) -> Vec<(&str, bool)> {
    file.layers.iter().map(|layer| (layer.name.as_str(), matches!(layer.track, Track::Screen(_)))).collect()
}

/// Refuses one matte for several layers of a lattice file, which would move the same pixels several times.
fn check_matte(job: &WarpJob, layers: &[usize]) -> Result<(), PipelineError> {
    let PlateWarp::Lattices { file, matte: Some(_), .. } = &job.warp else { return Ok(()) };
    if layers.len() <= 1 {
        return Ok(());
    }
    let what = format!("one matte for {} layers would move the same pixels {} times", layers.len(), layers.len());
    let names = layers.iter().map(|&layer| file.layers[layer].name.as_str());
    Err(unusable(what, format!("choose one with --layer; {}", spelling::list(names))))
}

/// Returns a note if several layers have no matte, and each therefore bends the whole picture including the other
/// layers' parts, unless the shot declares that as intended.
fn note_unmatted(job: &WarpJob, layers: &[usize]) -> Option<String> {
    let is_whole = |&&layer: &&usize| match &job.warp {
        PlateWarp::Shot(prepared) => prepared.bends_picture_unasked(layer),
        PlateWarp::Lattices { matte, .. } => matte.is_none(),
        PlateWarp::Maps(_) => false,
    };
    let names: Vec<String> =
        layers.iter().filter(is_whole).map(|&layer| format!("'{}'", job.warp.layer(layer).0)).collect();
    let remedy = match &job.warp {
        PlateWarp::Lattices { .. } => "warp with --shot, which knows their parts, or one --layer with its --matte",
        _ => "give each a `matte`, or say that it is meant: matte = \"none\"",
    };
    (names.len() > 1).then(|| {
        format!(
            "layers {} have no matte: each bends the whole picture, the others' parts too; {remedy}",
            names.join(", ")
        )
    })
}

/// Refuses two layers with the same matte, which would move the same pixels twice.
fn check_mattes_differ(job: &WarpJob, layers: &[usize]) -> Result<(), PipelineError> {
    let PlateWarp::Shot(prepared) = &job.warp else { return Ok(()) };
    let mattes = || layers.iter().filter_map(|&layer| Some((layer, prepared.shot.layers[layer].matte.as_ref()?)));
    for (place, (layer, matte)) in mattes().enumerate() {
        let Some((first, _)) = mattes().take(place).find(|(_, other)| other.is_same(matte)) else { continue };
        let [one, other] = [first, layer].map(|layer| &prepared.shot.layers[layer].name);
        let what = format!("layers '{one}' and '{other}' have the same matte, so the same pixels would move twice");
        let hint = "put the pins of both into one layer, give one of them another matte, or choose one with --layer";
        return Err(PipelineError::mismatch(&prepared.shot, &format!("layer[{layer}].matte"), what, hint));
    }
    Ok(())
}

/// Refuses to undo what has no inverse: branching lattices, STMaps, and warps with mattes, because what lay behind the moved
/// layers is not in the plate.
fn check_inverse(job: &WarpJob, layers: &[usize]) -> Result<(), PipelineError> {
    if let (PlateWarp::Shot(prepared), WarpDirection::Inverse) = (&job.warp, job.direction) {
        check_plain(prepared, "a warp that is undone")?;
    }
    let is_matted = match &job.warp {
        PlateWarp::Shot(prepared) => {
            layers.iter().any(|&layer| prepared.shot.layers[layer].matte.is_some() || prepared.moves_own_nodes(layer))
        }
        PlateWarp::Lattices { file, matte, .. } => {
            let branching = layers.iter().find(|&&layer| !file.layers[layer].branches.is_empty());
            if let (Some(&layer), WarpDirection::Inverse) = (branching, job.direction) {
                let name = &file.layers[layer].name;
                let what = format!("the lattice of layer '{name}' branches, which a warp that is undone cannot carry");
                return Err(unusable(&what, "choose another layer (--layer), or undo the warp of a plain lattice"));
            }
            matte.is_some()
        }
        PlateWarp::Maps(_) => {
            let hint = "make one with `pinwarp export --to stmap --inverse` and warp with that";
            let refused = job.direction == WarpDirection::Inverse;
            return if refused { Err(unusable("an STMap has no inverse of its own", hint)) } else { Ok(()) };
        }
    };
    if is_matted && job.direction == WarpDirection::Inverse {
        let what = "a warp with mattes cannot be undone: what the layers covered is not in the plate";
        return Err(unusable(
            what,
            "choose layers without a matte (--layer), or bend the whole picture there and back: matte = \"none\"",
        ));
    }
    Ok(())
}

/// Returns the requested frames.
fn wanted(
    job: &WarpJob,
    (plate, maps): (&SequencePath, Option<&SequencePath>),
    notes: &mut Vec<String>,
) -> Result<Vec<i32>, PipelineError> {
    if !job.frames.is_empty() {
        return Ok(job.frames.clone());
    }
    if let PlateWarp::Shot(prepared) = &job.warp {
        return Ok((prepared.shot.frames.first..=prepared.shot.frames.last).collect());
    }
    let found = match plate.frames_on_disk()? {
        Some(found) => Some(found),
        // With one picture for all frames, the warp determines the frames.
        None => match (maps, &job.warp) {
            (Some(maps), _) => maps.frames_on_disk()?,
            (None, PlateWarp::Lattices { file, .. }) => Some(frames_of(file)),
            (None, _) => None,
        },
    };
    let Some(found) = found else { return Ok(vec![1]) };
    match found.as_slice() {
        [] => {
            let what = format!("there are no frames {}", job.plate.display());
            Err(unusable(what, format!("the first would be {}; check the path", plate.path_of(1).display())))
        }
        &[first, .., last] => {
            notes.push(format!("{} frames found, {first} to {last}", found.len()));
            Ok(found)
        }
        [_] => Ok(found),
    }
}

/// Returns all frames for which the file has a screen lattice.
fn frames_of(file: &LatticeFile) -> Vec<i32> {
    let screens = file.layers.iter().filter_map(|layer| match &layer.track {
        Track::Screen(lattices) => Some(lattices),
        Track::World(_) => None,
    });
    let frames: std::collections::BTreeSet<i32> = screens.flat_map(|lattices| lattices.keys().copied()).collect();
    frames.into_iter().collect()
}

/// Returns a digest of all settings that affect the frames; files count by name, not by folder.
fn hash(job: &WarpJob, layers: &[usize]) -> String {
    let mut settings = job.settings.clone();
    if let Holes::Plate(clean) = &mut settings.holes {
        *clean = clean.file_name().map(PathBuf::from).unwrap_or_default();
    }
    let plate = job.plate.file_name();
    let source = match &job.warp {
        PlateWarp::Shot(prepared) => prepared.shot.hash(),
        PlateWarp::Lattices { file, strength, matte } => digest(&format!("{file:?} {strength} {matte:?}")),
        PlateWarp::Maps(maps) => format!("{:?}", maps.file_name()),
    };
    digest(&format!("{source} {plate:?} {settings:?} {:?} {layers:?}", job.direction))
}

fn unusable(what: impl Into<String>, hint: impl Into<String>) -> PipelineError {
    PipelineError::Unusable { what: what.into(), hint: hint.into() }
}
