//! Writes parameters to a shot file: a new one, or pins in an existing one.
//!
//! In: a [`WriteShot`]. Out: a checked file; comments and everything that the parameters do not cover are kept.

use super::read::{PinTrack, TrackKey};
use super::{Controls, LiveError, Moved, OutputGuard, OwnPins, ShapeSource, ShotShape, solve};
use crate::image::replace_text;
use crate::plate::Filter;
use crate::shot::edit::{Factor, KeyedPin, LayerEdit, put_filter, put_layer};
use crate::shot::{Anchor, Goal, PinKey, Rotation, Shot};
use crate::solve::Guard;
use crate::space::{FrameSize, ScreenPoint};
use std::path::Path;

/// A pin this close to its position in the file keeps the file's anchor, in frame heights.
const SAME: f64 = 1e-9;

/// A request to write a shot file.
#[derive(Clone, Debug)]
pub(crate) struct WriteShot<'a> {
    /// Output file; relative paths start at its directory.
    pub path: &'a Path,
    /// The shot to start from, in the same directory; `None`: the existing contents of the file, if any.
    pub base: Option<&'a Path>,
    /// Lattice, strength and smoothness; pins are taken from the tracks.
    pub controls: &'a Controls,
    /// The pins, with all their keys.
    pub tracks: &'a [PinTrack],
    /// The layer that receives the pins; `None`: the first.
    pub layer: Option<&'a str>,
    /// Filter for colour; `None`: as in the file.
    pub filter: Option<Filter>,
    /// The frame in which pins are placed, if the shot has a scene.
    pub pin_frame: i32,
    /// Contents of a new file.
    pub new: NewShot<'a>,
}

/// Contents of a file that does not exist yet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NewShot<'a> {
    /// What is warped.
    pub subject: Subject<'a>,
    /// First and last frame.
    pub frames: [i32; 2],
    /// Frame rate, in frames per second.
    pub rate: f64,
    /// Size of the frame.
    pub size: FrameSize,
}

/// What a shot warps, as known to the host.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Subject<'a> {
    /// Whole frames, with #### for the number; the shape is the frame.
    Plate(&'a Path),
    /// A picture whose alpha is the shape.
    Picture(&'a Path),
}

/// Writes pins and lattice so that `pinwarp warp` (for pictures: `pinwarp render`) solves the same lattices. Writing is idempotent.
/// Strength and smoothness are multiplied into those of the base; a host that continues with the written file sets its own to 1.
///
/// # Errors
/// [`LiveError`] if the base or the file is not a shot, the file is the base, one of its inputs or not a regular file,
/// it cannot be written, or other pins would act besides these.
pub(crate) fn write_shot(job: &WriteShot) -> Result<(), LiveError> {
    job.check_base()?;
    job.guard()?.check(job.path)?;
    let origin = job.origin();
    let text = match origin {
        Some(path) => std::fs::read_to_string(path).map_err(|source| io(path, source))?,
        None => job.blank(),
    };
    let rests = origin.map(|path| job.own_pins(path)).transpose()?.unwrap_or_default();
    let pins: Vec<KeyedPin> =
        job.tracks.iter().map(|track| job.keyed(track, origin, &rests)).collect::<Result<_, _>>()?;
    let Controls { dims, basis, strength, smoothness, .. } = *job.controls;
    let factor = if job.base.is_some() { Factor::Times } else { Factor::Exactly };
    let edit = LayerEdit { dims, basis, strength: factor(strength), smoothness: factor(smoothness), pins: &pins };
    let mut text = put_layer(&text, job.layer, &edit)?;
    if let Some(filter) = job.filter {
        text = put_filter(&text, filter)?;
    }
    // Never write a file that could not be read back.
    Shot::parse(&text, job.path)?;
    Ok(replace_text(job.path, &text)?)
}

fn io(path: &Path, source: std::io::Error) -> LiveError {
    crate::shot::ShotError::Io { path: path.to_owned(), source }.into()
}

impl WriteShot<'_> {
    /// Returns the file whose text is extended; `None` for a new one.
    fn origin(&self) -> Option<&Path> {
        self.base.or_else(|| Some(self.path).filter(|path| path.exists()))
    }

    /// The base is never overwritten, and must be in the same directory so that relative paths stay valid.
    fn check_base(&self) -> Result<(), LiveError> {
        let Some(base) = self.base else { return Ok(()) };
        let place = |path: &Path| std::fs::canonicalize(path).ok();
        let folder =
            |path: &Path| place(path.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new(".")));
        let what = if place(base).is_some() && place(base) == place(self.path) {
            "it is the shot that is read"
        } else if folder(base) != folder(self.path) {
            "relative paths of the shot that is read would not be found from this folder"
        } else {
            return Ok(());
        };
        let hint = format!("write to another file in the folder of {}", base.display());
        Err(LiveError::Layer { path: self.path.to_owned(), what: what.into(), hint })
    }

    /// Guards the inputs of the base; a file that is extended in place has no other inputs.
    fn guard(&self) -> Result<OutputGuard, LiveError> {
        let Some(base) = self.base else { return Ok(OutputGuard::default()) };
        OutputGuard::of(&ShapeSource::Shot(self.shape(base)), self.new.size)
    }

    /// Returns the text of a shot without pins.
    fn blank(&self) -> String {
        let NewShot { subject, frames: [first, last], rate, size } = self.new;
        let (key, path) = match subject {
            Subject::Plate(path) => ("plate", path),
            Subject::Picture(path) => ("image", path),
        };
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let path = path.strip_prefix(folder).unwrap_or(path).to_string_lossy().replace('\\', "/");
        let FrameSize { width, height, pixel_aspect } = size;
        let name = self.layer.unwrap_or("pins");
        let matte = match (self.controls.moved, subject) {
            (Moved::Masked, Subject::Plate(_)) => {
                "matte   = \"alpha\"    # what the host's mask selects: name its channel\n"
            }
            _ => "",
        };
        // A plate that moves as a whole has no guard.
        let can_fold = matches!(subject, Subject::Picture(_)) || self.controls.moved == Moved::Masked;
        let guard = match self.controls.guard {
            Guard::Report if can_fold => "solve   = { guard = \"report\" }\n",
            _ => "",
        };
        format!(
            "version = 1\n{key:<7} = {path:?}\nframes  = {{ first = {first}, last = {last}, rate = {rate:?} }}\n\
             size    = [{width}, {height}]\npixel_aspect = {pixel_aspect:?}\n\n[[layer]]\nname    = {name:?}\n{guard}{matte}"
        )
    }

    fn shape(&self, path: &Path) -> ShotShape {
        ShotShape {
            path: path.to_owned(),
            camera: None,
            layer: self.layer.map(str::to_owned),
            frame: f64::from(self.pin_frame),
            pin_frame: self.pin_frame,
            own_pins: OwnPins::Act,
        }
    }

    /// Returns the names and rest positions of the layer's pins; fails if any would act besides the tracks.
    fn own_pins(&self, path: &Path) -> Result<Vec<(String, ScreenPoint)>, LiveError> {
        let base = solve::base(&ShapeSource::Shot(self.shape(path)), self.new.size)?;
        let prepared = base.prepared.as_ref().expect("shots have a scene");
        let rests = prepared.rests_of(base.layer, f64::from(self.pin_frame));
        let names = prepared.shot.layers[base.layer].pins.iter().map(|pin| pin.name.clone());
        let own: Vec<_> = names.zip(rests.iter().map(|rest| rest.point)).collect();
        let is_known = |name: &str| self.tracks.iter().any(|track| track.name == name);
        match own.iter().find(|(name, _)| !is_known(name)) {
            None => Ok(own),
            Some((name, _)) => Err(LiveError::Layer {
                path: path.to_owned(),
                what: format!("it has a pin '{name}' that would act in addition to the new ones"),
                hint: "read the shot first, remove the pin, or write another file".into(),
            }),
        }
    }

    fn keyed<'t>(
        &self,
        track: &'t PinTrack,
        origin: Option<&Path>,
        own: &[(String, ScreenPoint)],
    ) -> Result<KeyedPin<'t>, LiveError> {
        let is_same =
            |(name, rest): &&(String, ScreenPoint)| *name == track.name && (*rest - track.rest).0.length() < SAME;
        let anchor = match own.iter().find(is_same) {
            Some(_) => None,
            None => Some(Anchor::Screen { at: track.rest, frame: self.cast_frame(track.rest, origin)? }),
        };
        Ok(KeyedPin {
            name: &track.name,
            anchor,
            keys: track.keys.iter().map(|key| pin_key(key, track.rest)).collect(),
        })
    }

    /// Returns the frame in which a new pin is cast; `None` if it hits nothing, or there is no scene.
    fn cast_frame(&self, rest: ScreenPoint, origin: Option<&Path>) -> Result<Option<i32>, LiveError> {
        let Some(path) = origin else { return Ok(None) };
        let base = solve::base(&ShapeSource::Shot(self.shape(path)), self.new.size)?;
        let prepared = base.prepared.as_ref().filter(|prepared| prepared.shot.scene().is_some());
        let hit = prepared.and_then(|prepared| prepared.cast(self.pin_frame, &[rest]).pop().flatten());
        Ok(hit.map(|_| self.pin_frame))
    }
}

fn pin_key(key: &TrackKey, rest: ScreenPoint) -> PinKey {
    PinKey {
        frame: key.frame,
        goal: Goal::Offset(key.target - rest),
        rotate_degrees: key.rotation.map(|angle| Rotation::InView(angle.to_degrees())),
        scale: key.scale,
        ease: key.ease,
    }
}
