//! Push buttons: reading and writing shot files, writing STMaps, pin commands.
//!
//! In: the parameters with their keys. Out: parameters, changed in one undo step; files.

use super::api::names::image;
use super::budget;
use super::call::Call;
use super::fault::Fault;
use super::host::{Clip, Effect, When};
use super::host_frame::host_frame_of;
use super::params::{BASES, FILTERS, PINS, SHAPES, ShapeFrom, number_of, pin_id};
use super::pen;
use super::pins;
use super::render::{image_of, picture_of};
use super::settings::{ShapeChoice, settings_of};
use super::values::ParamValues;
use crate::image::SequencePath;
use crate::live::{
    self, HostFrame, NewShot, OutputGuard, OwnedPicture, PinRegion, PinTrack, ShapeSource, StMapFile, Subject,
    WriteShot,
};
use crate::spelling::pluralised;
use std::ffi::CStr;
use std::path::PathBuf;

/// Maximum number of frames for which keys and maps are written; guards against a host's "infinite" range.
const MAX_FRAMES: i32 = 100_000;

/// Returns the pins that the buttons act on: those selected in the viewer, else the one whose number is entered.
fn selected(effect: Effect, values: ParamValues) -> Vec<usize> {
    let chosen: Vec<usize> = pen::pen_of(effect.key()).picker.chosen().collect();
    let typed = usize::try_from(values.int("selected") - 1).ok();
    if chosen.is_empty() { typed.into_iter().collect() } else { chosen }
}

/// Selects a pin, or clears the selection.
pub(super) fn select(effect: Effect, pin: Option<usize>) {
    pen::change(effect.key(), |pen| pen.picker.choose(pin));
}

/// Executes a pin button, in one undo step; returns a message for the user, if any. `None`: not a pin button.
pub(super) fn press_pins(effect: Effect, id: &str, values: ParamValues) -> Option<Option<String>> {
    let chosen = selected(effect, values);
    let acting = pins::acting(values);
    let (label, pins, work): (&CStr, Vec<usize>, PinWork) = match id {
        "previousPin" | "nextPin" => {
            let next = pins::neighbour(values, &chosen, if id == "nextPin" { 1 } else { -1 });
            let Some(next) = next else { return Some(Some("no pin is on; click into the viewer to add one".into())) };
            select(effect, Some(next));
            values.params.set_int("selected", next as i32 + 1);
            return Some(None);
        }
        "resetPins" => (c"Reset pins", chosen, pins::reset),
        "deletePins" => (c"Delete pins", chosen, pins::delete),
        "restToTargets" => {
            (c"Copy targets to pins", if chosen.is_empty() { acting } else { chosen }, pins::rest_to_target)
        }
        "clearPins" => (c"Clear all pins", (0..PINS).collect(), pins::delete),
        _ => return None,
    };
    if pins.is_empty() {
        return Some(Some("no pin is selected; choose one in the viewer, with Next pin, or by its number".into()));
    }
    values.params.begin_edit(label);
    pins.iter().for_each(|pin| work(values, *pin));
    values.params.end_edit();
    if id == "deletePins" || id == "clearPins" {
        select(effect, None);
    }
    Some(None)
}

/// An operation on one pin.
type PinWork = fn(ParamValues, usize);

/// Executes a file button and returns its result message; `None`: there is no such button.
pub(super) fn press(call: Call, id: &str, values: ParamValues) -> Option<Result<String, Fault>> {
    let host_frame = host_frame_of(call.effect, values.time);
    match id {
        "readShot" => Some(read(values, &host_frame)),
        "writeShot" => Some(write(call, values, &host_frame)),
        "writeStmaps" => Some(write_stmaps(call, values, &host_frame)),
        _ => None,
    }
}

fn read(values: ParamValues, host_frame: &HostFrame) -> Result<String, Fault> {
    let params = values.params;
    let file = live::read_shot(&values.shot()?, host_frame.frame)?;
    params.begin_edit(c"Read a shot");
    let [shape, basis] = [number_of(&SHAPES, ShapeFrom::Shot), number_of(&BASES, file.controls.basis)];
    let [columns, rows] = file.controls.dims.map(|count| count as i32);
    for (id, value) in [("shape", shape), ("shotPins", 0), ("columns", columns), ("rows", rows), ("basis", basis)] {
        params.set_int(id, value);
    }
    if let Some(filter) = file.filter {
        params.set_int("filter", number_of(&FILTERS, filter));
    }
    for id in ["strength", "smoothness"] {
        params.delete_keys(id);
        params.set_double(id, 1.0, When::Now);
    }
    for pin in 0..PINS {
        params.delete_keys(&pin_id(pin, "On"));
        params.set_int(&pin_id(pin, "On"), i32::from(pin < file.tracks.len()));
    }
    for (pin, track) in file.tracks.iter().take(PINS).enumerate() {
        set_track(values, host_frame, pin, track);
    }
    params.end_edit();
    let has_scale = file.tracks.iter().flat_map(|track| &track.keys).any(|key| key.scale.is_some());
    let scale = if has_scale { "; pin scales in the file are ignored" } else { "" };
    Ok(file.summary(PINS) + scale)
}

/// Writes a pin and its keys to the parameters.
fn set_track(values: ParamValues, host_frame: &HostFrame, pin: usize, track: &PinTrack) {
    let params = values.params;
    let [name, rest, target, turns, angle] = ["Name", "Rest", "Target", "Turns", "Angle"].map(|end| pin_id(pin, end));
    [&rest, &target, &turns, &angle].into_iter().for_each(|id| params.delete_keys(id));
    params.set_text(&name, &track.name);
    let region = track.region.unwrap_or(PinRegion { radius: 0.0, rigidity: 1.0, stiffness: 1.0 });
    for (end, value) in [
        ("Weight", 1.0),
        ("Radius", region.radius * host_frame.canonical_height()),
        ("Rigidity", region.rigidity),
        ("Stiffness", region.stiffness),
    ] {
        params.delete_keys(&pin_id(pin, end));
        params.set_double(&pin_id(pin, end), value, When::Now);
    }
    params.set_point(&rest, host_frame.canonical(track.rest), When::Now);
    params.set_int(&turns, i32::from(track.keys.iter().any(|key| key.rotation.is_some())));
    let offset = f64::from(values.int("frameOffset"));
    for key in &track.keys {
        let when = if track.keys.len() == 1 { When::Now } else { When::Key(key.frame - offset) };
        params.set_point(&target, host_frame.canonical(key.target), when);
        params.set_double(&angle, key.rotation.unwrap_or(0.0).to_degrees(), when);
    }
}

fn write(call: Call, values: ParamValues, host_frame: &HostFrame) -> Result<String, Fault> {
    let path = values.text("writePath").map(PathBuf::from).ok_or(Fault::NoPath("Write to"))?;
    let settings = settings_of(call, values.time, host_frame)?;
    let offset = values.int("frameOffset");
    let tracks: Vec<PinTrack> = settings.pins.iter().map(|pin| track(values, host_frame, *pin)).collect();
    let layer = values.text("layer");
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
        pin_frame: values.int("pinFrame"),
        new: NewShot {
            subject,
            frames: frames(call, values.time).map(|frame| frame.saturating_add(offset)),
            rate: rate(call),
            size: host_frame.frame,
        },
    })?;
    Ok(format!("wrote {} to {}", pluralised(tracks.len(), "pin", "pins"), path.display()))
}

/// Returns the source's frame rate in frames per second.
fn rate(call: Call) -> f64 {
    let source = call.effect.clip(image::SOURCE_CLIP).map(Clip::props);
    source.and_then(|props| props.double(image::FRAME_RATE)).filter(|rate| *rate > 0.0).unwrap_or(24.0)
}

/// Returns the first and last frame of the source, or the current frame for a still.
fn frames(call: Call, time: f64) -> [i32; 2] {
    let range = call.effect.clip(image::SOURCE_CLIP).and_then(|clip| clip.props().doubles(image::FRAME_RANGE));
    // A still has an infinite range: only the current frame counts.
    let range = range.filter(|[first, last]| (0.0..=f64::from(MAX_FRAMES)).contains(&(last - first)));
    range.unwrap_or([time; 2]).map(|frame| frame.round() as i32)
}

/// Returns a pin with its keys.
fn track(values: ParamValues, host_frame: &HostFrame, pin: usize) -> PinTrack {
    let ends = ["Rest", "Target", "Turns", "Angle"].iter();
    let times: Vec<f64> = ends.flat_map(|end| values.params.keys(&pin_id(pin, end))).collect();
    let name = values.text(&pin_id(pin, "Name")).unwrap_or_else(|| pin_id(pin, ""));
    let now = [values.time, f64::from(values.int("frameOffset"))];
    PinTrack::sampled(name, &times, now, |time| ParamValues { time, ..values }.pin(pin, host_frame))
}

/// Returns the path pattern of the STMaps: in the folder, else the entered pattern, which hosts may have expanded.
fn stmap_pattern(values: ParamValues) -> Result<PathBuf, Fault> {
    let Some(folder) = values.text("stmapFolder") else {
        return values.text("stmapPath").map(PathBuf::from).ok_or(Fault::NoPath("STMaps folder"));
    };
    let name = values.text("stmapName").unwrap_or_else(|| "stmap".into());
    let name = name.strip_suffix(".exr").unwrap_or(&name);
    if name.contains(['#', '%', '/', '\\']) {
        return Err(Fault::BadName(name.to_owned()));
    }
    let digits = "#".repeat(values.int("stmapPadding") as usize);
    Ok(PathBuf::from(folder).join(format!("{name}.{digits}.exr")))
}

fn write_stmaps(call: Call, values: ParamValues, host_frame: &HostFrame) -> Result<String, Fault> {
    let pattern = SequencePath::parse(&stmap_pattern(values)?)?;
    let [first, last] = frames(call, values.time);
    pattern.check_frame_count((last - first + 1) as usize)?;
    let shape = match settings_of(call, f64::from(first), host_frame)?.shape {
        ShapeChoice::Shot(shot) => ShapeSource::Shot(shot),
        ShapeChoice::Frame | ShapeChoice::Alpha => ShapeSource::Frame,
    };
    let guard = OutputGuard::of(&shape, host_frame.frame)?;
    (first..=last).try_for_each(|frame| live::check_stmap_path(&pattern.path_of(frame), &guard))?;
    let size = host_frame.frame;
    let written = size.window().area() as u128 * (budget::MAP_BYTES + budget::planes(4, 1));
    for frame in first..=last {
        if call.effect.is_aborted() {
            return Err(Fault::Aborted);
        }
        let time = f64::from(frame);
        let settings = settings_of(call, time, host_frame)?;
        let is_of_alpha = settings.shape == ShapeChoice::Alpha;
        let source = if is_of_alpha { image_of(call, image::SOURCE_CLIP, time)? } else { None };
        let read = source.as_ref().map_or(0, |source| budget::image(source, 1));
        let _memory = budget::reserve(call.effect, read + written, [size.width, size.height])?;
        let source = source.map(|source| picture_of(&source, host_frame));
        let warp = settings.warp(call.effect, host_frame, source.as_ref().and_then(OwnedPicture::coverage))?;
        let file = StMapFile { path: &pattern.path_of(frame), frame, rate: rate(call) };
        live::save_stmap(&warp, host_frame.frame, file, &guard)?;
    }
    Ok(format!("wrote {}", pluralised(last - first + 1, "STMap", "STMaps")))
}
