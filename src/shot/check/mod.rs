//! Validates the raw values of a shot file: every rule that relates keys to each other.
//!
//! In: a [`Document`]. Out: a [`Shot`], or all faults of the file.

mod camera;
mod channel_keys;
mod connectivity;
mod image;
mod layer;
mod mirror;
mod output;
mod picture_cuts;
mod pin;
mod place;
mod plate;
mod select;
mod size;
mod stiffness;
mod transfer;

use super::document::{Document, syntax_error};
use super::raw::{RawClip, RawFrames, RawShot, RawShutter, RawSpace};
use super::{ClipName, FrameRange, KeyLines, PlateSize, Shot, ShotError, Shutter, Source, hints, schema, structure};
use crate::space::FrameSize;
use std::collections::HashSet;
use toml::de::DeValue;

/// The only supported version.
const VERSION: &str = "1";

/// Checks a document. `plate_size`: the size of a plate in one of these frames, from first to last.
///
/// # Errors
/// [`ShotError`]: all independent faults.
pub(super) fn shot(document: &Document, plate_size: PlateSize) -> Result<Shot, ShotError> {
    // Another version may have other keys, so no further checks make sense.
    if let Some(fault) = version_fault(document) {
        return Err(fault);
    }
    let mut check = Check { document, plate_size, faults: structure::faults(document) };
    match toml::from_str::<RawShot>(document.text) {
        Ok(raw) => {
            let shot = check.shot(raw);
            check.finish().map_or(Ok(shot), Err)
        }
        Err(error) => {
            // The schema check gives more, and clearer, messages.
            let fallback = || syntax_error(document.text, document.path, &error);
            Err(check.finish().unwrap_or_else(fallback))
        }
    }
}

fn version_fault(document: &Document) -> Option<ShotError> {
    let version = document.root.get_ref().get("version")?;
    match version.get_ref() {
        DeValue::Integer(number) if number.as_str() != VERSION => Some(document.fault(
            "version",
            format!("this file has version {number}, this program reads version {VERSION}"),
            "write `version = 1`, or use the release of pinwarp that wrote the file",
        )),
        _ => None,
    }
}

/// A document, and the faults found so far.
struct Check<'a> {
    document: &'a Document<'a>,
    plate_size: PlateSize<'a>,
    faults: Vec<ShotError>,
}

impl Check<'_> {
    /// Records a fault; at most one per key and its contents, as the first usually causes the others.
    fn fault(&mut self, key: &str, what: impl Into<String>, hint: impl Into<String>) {
        let is_inside = |rest: &str| rest.is_empty() || rest.starts_with(['.', '[']);
        let is_named = |fault: &ShotError| match fault {
            ShotError::Invalid { key: named, .. } => named.strip_prefix(key).is_some_and(is_inside),
            _ => false,
        };
        if !self.faults.iter().any(is_named) {
            self.faults.push(self.document.fault(key, what, hint));
        }
    }

    fn finish(self) -> Option<ShotError> {
        ShotError::from_faults(self.faults)
    }

    fn shot(&mut self, raw: RawShot) -> Shot {
        let path = self.document.path.to_owned();
        let source = self.source(&raw);
        let frames = self.frames(&raw.frames);
        let plate = raw.plate.as_deref().map(|path| self.plate_path(path, "plate"));
        let size = self.size(&raw, &source, (plate.as_deref(), &frames));
        let solve_range = self.solve_range(raw.solve_range, frames);
        let defaults = LayerDefaults {
            step: raw.step,
            strength: raw.strength,
            reference_frame: solve_range[0],
            size,
            space: RawSpace::Screen,
            source: Kind::of(&source),
        };
        let warp = self.warp(&raw.warp, &source);
        let layers = self.layers(raw.layer, &defaults);
        Shot {
            lines: KeyLines::default(),
            plate,
            warp,
            camera: self.camera(raw.camera, (solve_range[0], Kind::of(&source))),
            visibility: self.visibility((raw.hide, raw.show), Kind::of(&source)),
            allow_outside: false,
            clip: raw.frames.clip.map(ClipName::from),
            is_looped: raw.frames.is_looped,
            frames,
            solve_range,
            shutter: raw.shutter.map_or(Shutter::CLOSED, Shutter::from),
            size,
            samples: raw.samples,
            environment: raw.environment,
            exposure_stops: raw.exposure,
            layers,
            output: self.output(&raw.output, &frames, &source),
            source,
            path,
        }
    }

    fn frames(&mut self, raw: &RawFrames) -> FrameRange {
        let RawFrames { first, last, rate, .. } = *raw;
        if first > last {
            let what = format!("the range {first} to {last} is empty");
            self.fault("frames.last", what, format!("give a last frame of {first} or later"));
        }
        FrameRange { first, last, rate, clip_start: raw.clip_start.unwrap_or(first) }
    }

    fn solve_range(&mut self, raw: Option<[i32; 2]>, frames: FrameRange) -> [i32; 2] {
        let [first, last] = raw.unwrap_or([frames.first, frames.last]);
        if first > last && raw.is_some() {
            let what = format!("the range {first} to {last} is empty");
            self.fault("solve_range", what, format!("give a last frame of {first} or later"));
        }
        [first, last]
    }

    /// Returns whether an unknown key of the shot was probably meant to be one of these.
    fn has_unknown_key(&self, meant: &[&str]) -> bool {
        let table = self.document.root.get_ref().as_table();
        let known = schema::inlined()["properties"].as_object();
        let stands_for = |(table, known)| meant.iter().any(|meant| hints::stands_for(table, meant, known));
        table.zip(known).is_some_and(stands_for)
    }

    /// Reports duplicate names.
    fn unique<'n>(&mut self, names: impl Iterator<Item = (String, &'n str)>, what: &str) {
        let mut seen = HashSet::new();
        for (key, name) in names {
            if !seen.insert(name) {
                self.fault(&key, format!("a {what} named {name:?} is there already"), "choose another name");
            }
        }
    }
}

/// The defaults that layers inherit from the shot, and pins from their layer.
struct LayerDefaults {
    step: u32,
    strength: f64,
    /// The first frame that is solved, where implicit keys lie: trimming `frames` does not move them.
    reference_frame: i32,
    size: FrameSize,
    /// The space of the layer's lattice.
    space: RawSpace,
    /// The kind of geometry that the shot's lattices deform.
    source: Kind,
}

/// The kind of geometry that lattices deform, which determines what layers may name.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// Nodes of a scene.
    Scene,
    /// Pictures, as flat nodes.
    Images,
    /// The frame itself, without nodes.
    Frame,
}

impl Kind {
    fn of(source: &Source) -> Self {
        match source {
            Source::Scene(_) => Self::Scene,
            Source::Images(_) => Self::Images,
            Source::Frame => Self::Frame,
        }
    }
}

impl From<RawShutter> for Shutter {
    fn from(raw: RawShutter) -> Self {
        Self { angle: raw.angle, phase: raw.phase.unwrap_or(-0.5 * raw.angle) }
    }
}

impl From<RawClip> for ClipName {
    fn from(raw: RawClip) -> Self {
        match raw {
            RawClip::Name(name) => Self::Name(name),
            RawClip::Index(index) => Self::Index(index as usize),
        }
    }
}
