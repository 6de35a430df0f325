//! Checks the headers (and the pixels of maps) of the first and the last frame before anything is written: unknown names, missing files, shapes.
//!
//! In: a [`WarpJob`], its sequences, frames. Out: notes, or the error that every frame would cause.

use super::needed_memory::held_bytes;
use super::{PlateWarp, WarpJob};
use crate::files::check_regular;
use crate::image::{Plate, SequencePath, picture_extent, read_any_head, read_numbers};
use crate::memory;
use crate::pipeline::PipelineError;
use crate::plate::{Matte, check_fill, check_plate, check_stmap, map_of_stmap};
use crate::space::FrameSize;
use std::path::Path;

/// The input sequences of a warp.
pub(super) struct Sources<'a> {
    pub(super) plate: &'a SequencePath,
    pub(super) clean: Option<&'a SequencePath>,
    pub(super) maps: Option<&'a SequencePath>,
}

/// Refuses what would fail at every frame. An error that occurs in only one of the two frames is left to that frame.
pub(super) fn check(
    job: &WarpJob,
    sources: &Sources,
    layers: &[usize],
    frames: &[i32],
) -> Result<Vec<String>, PipelineError> {
    let mattes: Vec<(&str, &Matte)> = layers
        .iter()
        .filter_map(|&layer| {
            let (name, matte) = job.warp.layer(layer);
            Some((name, matte?))
        })
        .collect();
    let ends = [frames.first(), frames.last()].into_iter().flatten();
    let outcomes: Vec<_> = ends.filter_map(|&frame| check_frame(job, (sources, frame), &mattes).transpose()).collect();
    let is_good = outcomes.iter().any(Result::is_ok);
    let wanted = outcomes.into_iter().find(|outcome| outcome.is_ok() == is_good);
    wanted.unwrap_or_else(|| Ok(Vec::new()))
}

/// Checks that each source has at least one of the frames, kept ones included, as a regular file.
pub(super) fn check_there(sources: &Sources, frames: &[i32]) -> Result<(), PipelineError> {
    let all = [Some(sources.plate), sources.clean, sources.maps];
    all.into_iter().flatten().try_for_each(|source| check_source_there(source, frames))
}

fn check_source_there(source: &SequencePath, frames: &[i32]) -> Result<(), PipelineError> {
    let Some(&first) = frames.first() else { return Ok(()) };
    let mut there = frames.iter().map(|&frame| source.path_of(frame)).filter(|path| path.exists()).peekable();
    let irregular = there.peek().and_then(|path| Some((path.clone(), check_regular(path).err()?)));
    let what = match irregular {
        _ if there.any(|path| check_regular(&path).is_ok()) => return Ok(()),
        Some((path, fault)) => format!("cannot read {}: {fault}", path.display()),
        None => {
            let path = source.path_of(first);
            format!("cannot read {}: it is not there, nor is any other of the frames to warp", path.display())
        }
    };
    Err(PipelineError::Unusable { what, hint: "check the path".into() })
}

/// Checks one frame; `None` if a header cannot be read, which is reported when the frame is warped.
fn check_frame(
    job: &WarpJob,
    (sources, frame): (&Sources, i32),
    mattes: &[(&str, &Matte)],
) -> Result<Option<Vec<String>>, PipelineError> {
    let path = sources.plate.path_of(frame);
    let Ok(head) = read_any_head(&path) else { return Ok(None) };
    check_shape(&job.warp, &path, head.frame_size())?;
    if let Some(maps) = sources.maps {
        check_map(&maps.path_of(frame), &head)?;
    }
    if let Some(clean) = sources.clean {
        check_clean(&clean.path_of(frame), &head)?;
    }
    Ok(Some(check_plate(&head, mattes, &job.settings)?))
}

/// Checks that a map belongs to its plate, and from its pixels that it is one.
fn check_map(path: &Path, plate: &Plate) -> Result<(), PipelineError> {
    let Ok(head) = read_any_head(path) else { return Ok(()) };
    let named = |source| PipelineError::StMap { path: path.to_owned(), source };
    check_stmap(&head, plate).map_err(named)?;
    // A map that does not fit into memory, or that is damaged, is reported when its frame is warped.
    let Some(memory) = picture_extent(path).ok().and_then(|extent| memory::reserve(held_bytes(extent)).ok()) else {
        return Ok(());
    };
    let checked = read_numbers(path).map_or(Ok(()), |map| map_of_stmap(&map).map(drop).map_err(named));
    drop(memory);
    checked
}

/// Checks that a clean plate has the size of its plate.
fn check_clean(path: &Path, plate: &Plate) -> Result<(), PipelineError> {
    let Ok(clean) = read_any_head(path) else { return Ok(()) };
    check_fill(&clean, plate).map_err(|source| PipelineError::CleanPlate { path: path.to_owned(), source })
}

/// Checks the aspect ratio of a plate: proxies and overscan have the shot's; any other belongs to another shot.
pub(super) fn check_shape(warp: &PlateWarp, path: &Path, size: FrameSize) -> Result<(), PipelineError> {
    let (wanted, whose) = match warp {
        PlateWarp::Shot(prepared) => (prepared.shot.size.aspect(), "the shot is"),
        PlateWarp::Lattices { file, .. } => (file.frame_aspect, "the lattices are for"),
        PlateWarp::Maps(_) => return Ok(()),
    };
    if size.is_as_wide_as(wanted) {
        return Ok(());
    }
    let FrameSize { width, height, .. } = size;
    let what = format!(
        "{} shows {width} x {height} pixels, {:.4} wide to 1 high, {whose} {wanted:.4} to 1",
        path.display(),
        size.aspect()
    );
    let hint = "warp plates of the same shape (their display window counts), or correct `size` and `pixel_aspect`";
    Err(PipelineError::Unusable { what, hint: hint.into() })
}
