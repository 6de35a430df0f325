//! The buttons: shot files read and written, STMaps written.
//!
//! In: the parameters with their keys. Out: parameters, set in one step to undo; files.

use super::api::names::image;
use super::canvas::canvas_of;
use super::entry::Call;
use super::fault::Fault;
use super::host::{Clip, When};
use super::params::{BASES, FILTERS, PINS, SHAPES, ShapeFrom, number_of, pin_id};
use super::render::fetched;
use super::settings::{Moment, ShapeChoice, settings_of};
use crate::image::SequencePath;
use crate::live::{self, Canvas, NewShot, OwnedPicture, PinTrack, StMapFile, Subject, WriteShot};
use crate::spelling::counted;
use std::path::{Path, PathBuf};

/// Frames over which keys and maps are written at most: a host's "for ever" ends there.
const MOST_FRAMES: i32 = 100_000;

/// Does what a button says, and tells how it went; `None`: there is no such button.
pub(super) fn press(call: Call, id: &str, moment: Moment) -> Option<Result<String, Fault>> {
    let canvas = canvas_of(call.effect, moment.time);
    match id {
        "readShot" => Some(read(moment, &canvas)),
        "writeShot" => Some(write(call, moment, &canvas)),
        "writeStmaps" => Some(write_stmaps(call, moment, &canvas)),
        _ => None,
    }
}

fn read(moment: Moment, canvas: &Canvas) -> Result<String, Fault> {
    let params = moment.params;
    let file = live::read_shot(&moment.shot()?, canvas.frame)?;
    params.begin_edit(c"Read a shot");
    let [shape, basis] = [number_of(&SHAPES, ShapeFrom::Shot), number_of(&BASES, file.controls.basis)];
    let [columns, rows] = file.controls.dims.map(|count| count as i32);
    for (id, value) in [("shape", shape), ("shotPins", 0), ("columns", columns), ("rows", rows), ("basis", basis)] {
        params.set_int(id, value);
    }
    if let Some(filter) = file.filter {
        params.set_int("filter", number_of(&FILTERS, filter));
    }
    for id in ["strength", "stiffness"] {
        params.delete_keys(id);
        params.set_double(id, 1.0, When::Now);
    }
    for pin in 0..PINS {
        params.delete_keys(&pin_id(pin, "On"));
        params.set_int(&pin_id(pin, "On"), i32::from(pin < file.tracks.len()));
    }
    for (pin, track) in file.tracks.iter().take(PINS).enumerate() {
        set_track(moment, canvas, pin, track);
    }
    params.end_edit();
    let has_scale = file.tracks.iter().flat_map(|track| &track.keys).any(|key| key.scale.is_some());
    let scale = if has_scale { "; the scales that its pins hold are left out" } else { "" };
    Ok(file.told(PINS) + scale)
}

/// A pin and its keys as parameters.
fn set_track(moment: Moment, canvas: &Canvas, pin: usize, track: &PinTrack) {
    let params = moment.params;
    let [name, rest, target, turns, angle] = ["Name", "Rest", "Target", "Turns", "Angle"].map(|end| pin_id(pin, end));
    [&rest, &target, &turns, &angle].into_iter().for_each(|id| params.delete_keys(id));
    params.set_text(&name, &track.name);
    params.set_point(&rest, canvas.canonical(track.rest), When::Now);
    params.set_int(&turns, i32::from(track.keys.iter().any(|key| key.rotation.is_some())));
    let offset = f64::from(moment.int("frameOffset"));
    for key in &track.keys {
        let when = if track.keys.len() == 1 { When::Now } else { When::Key(key.frame - offset) };
        params.set_point(&target, canvas.canonical(key.target), when);
        params.set_double(&angle, key.rotation.unwrap_or(0.0).to_degrees(), when);
    }
}

fn write(call: Call, moment: Moment, canvas: &Canvas) -> Result<String, Fault> {
    let path = moment.text("writePath").map(PathBuf::from).ok_or(Fault::NoPath("Write to"))?;
    let settings = settings_of(call, moment.time, canvas)?;
    let offset = moment.int("frameOffset");
    let tracks: Vec<PinTrack> = settings.pins.iter().map(|pin| track(moment, canvas, *pin)).collect();
    let layer = moment.text("layer");
    let file = if settings.shape == ShapeChoice::Alpha { "picture.exr" } else { "plate.####.exr" };
    let picture = path.with_file_name(file);
    let subject =
        if settings.shape == ShapeChoice::Alpha { Subject::Picture(&picture) } else { Subject::Plate(&picture) };
    live::write_shot(&WriteShot {
        path: &path,
        base: if let ShapeChoice::Shot(shot) = &settings.shape { Some(&shot.path) } else { None },
        controls: &settings.controls,
        tracks: &tracks,
        layer: layer.as_deref(),
        filter: Some(settings.filter),
        pin_frame: moment.int("pinFrame"),
        new: NewShot {
            subject,
            frames: frames(call, moment.time).map(|frame| frame.saturating_add(offset)),
            rate: rate(call),
            size: canvas.frame,
        },
    })?;
    Ok(format!("wrote {} to {}", counted(tracks.len(), "pin", "pins"), path.display()))
}

/// Frames a second of the source.
fn rate(call: Call) -> f64 {
    let source = call.effect.clip(image::SOURCE_CLIP).map(Clip::props);
    source.and_then(|props| props.double(image::FRAME_RATE)).filter(|rate| *rate > 0.0).unwrap_or(24.0)
}

/// First and last frame of the source, or the frame that is shown.
fn frames(call: Call, time: f64) -> [i32; 2] {
    let range = call.effect.clip(image::SOURCE_CLIP).and_then(|clip| clip.props().doubles(image::FRAME_RANGE));
    // A still lasts "for ever": then there is nothing but the frame that is shown.
    let range = range.filter(|[first, last]| (0.0..=f64::from(MOST_FRAMES)).contains(&(last - first)));
    range.unwrap_or([time; 2]).map(|frame| frame.round() as i32)
}

/// A pin with its keys.
fn track(moment: Moment, canvas: &Canvas, pin: usize) -> PinTrack {
    let ends = ["Rest", "Target", "Turns", "Angle"].iter();
    let times: Vec<f64> = ends.flat_map(|end| moment.params.keys(&pin_id(pin, end))).collect();
    let name = moment.text(&pin_id(pin, "Name")).unwrap_or_else(|| pin_id(pin, ""));
    let now = [moment.time, f64::from(moment.int("frameOffset"))];
    PinTrack::sampled(name, &times, now, |time| Moment { time, ..moment }.pin(pin, canvas))
}

fn write_stmaps(call: Call, moment: Moment, canvas: &Canvas) -> Result<String, Fault> {
    let pattern = moment.text("stmapPath").ok_or(Fault::NoPath("STMaps to"))?;
    let pattern = SequencePath::parse(Path::new(&pattern))?;
    let [first, last] = frames(call, moment.time);
    pattern.check_frame_count((last - first + 1) as usize)?;
    (first..=last).try_for_each(|frame| live::check_stmap_path(&pattern.path_of(frame)))?;
    for frame in first..=last {
        if call.effect.is_aborted() {
            return Err(Fault::Aborted);
        }
        let time = f64::from(frame);
        let settings = settings_of(call, time, canvas)?;
        let is_of_alpha = settings.shape == ShapeChoice::Alpha;
        let source = if is_of_alpha { fetched(call, image::SOURCE_CLIP, time, canvas)? } else { None };
        let warp = settings.warp(canvas, source.as_ref().and_then(OwnedPicture::coverage))?;
        let file = StMapFile { path: &pattern.path_of(frame), frame, rate: rate(call) };
        live::save_stmap(&warp, canvas.frame, file)?;
    }
    Ok(format!("wrote {}", counted(last - first + 1, "STMap", "STMaps")))
}
