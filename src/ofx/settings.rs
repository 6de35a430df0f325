//! Parameters as the engine wants them.
//!
//! In: the parameters of an instance at a time, and the canvas. Out: [`Settings`]. What a host leaves out has its default.

use super::api::names::prop;
use super::canvas::canvas_of;
use super::describe::MASK_CLIP;
use super::entry::Call;
use super::fault::Fault;
use super::host::{Effect, Params};
use super::params::{self, BASES, FILTERS, Kind, Options, PINS, SHAPES, ShapeFrom, pin_id};
use super::regions::connected;
use crate::live::{self, Basis, Canvas, Controls, Coverage, Moved, OwnPins, Pin, Shape, ShotShape, Warp};
use crate::plate::Filter;
use std::path::PathBuf;
use std::sync::Arc;

/// All that a moment of an instance is set to.
pub(super) struct Settings {
    pub(super) controls: Controls,
    pub(super) shape: ShapeChoice,
    pub(super) filter: Filter,
    /// Numbers of the pins that act, as users count them less one, in the order of the controls.
    pub(super) pins: Vec<usize>,
}

/// Where the shape comes from.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum ShapeChoice {
    Frame,
    /// The alpha of the whole source, which only a render has.
    Alpha,
    Shot(ShotShape),
}

/// Parameters at a time.
#[derive(Clone, Copy)]
pub(super) struct Moment<'a> {
    pub(super) params: Params<'a>,
    pub(super) time: f64,
}

impl<'a> Moment<'a> {
    /// The parameters of an effect at a time.
    pub(super) fn of(effect: Effect<'a>, time: f64) -> Result<Self, Fault> {
        Ok(Self { params: effect.params()?, time })
    }

    /// A whole number, choice or toggle, within its range.
    pub(super) fn int(self, id: &str) -> i32 {
        let kind = params::table().iter().find(|param| param.id == id).map(|param| &param.kind);
        let (default, [least, most]) = match kind {
            Some(Kind::Integer(default, range, _)) => (*default, *range),
            Some(Kind::Toggle(default)) => (*default, [0, 1]),
            Some(Kind::Choice(options)) => (0, [0, options.len() as i32 - 1]),
            _ => (0, [i32::MIN, i32::MAX]),
        };
        self.params.int(id, self.time).unwrap_or(default).clamp(least, most)
    }

    /// What a choice is set to.
    pub(super) fn choice<T: Copy, const N: usize>(self, id: &str, options: &Options<T, N>) -> T {
        options[self.int(id) as usize].1
    }

    fn double(self, id: &str) -> f64 {
        let kind = params::table().iter().find(|param| param.id == id).map(|param| &param.kind);
        let Some(Kind::Double(default, [least, most], ..)) = kind else { return 0.0 };
        self.params.double(id, self.time).unwrap_or(*default).clamp(*least, *most)
    }

    /// A text without blanks at its ends; `None`: empty.
    pub(super) fn text(self, id: &str) -> Option<String> {
        let text = self.params.text(id, self.time)?;
        let text = text.trim();
        (!text.is_empty()).then(|| text.to_owned())
    }

    fn is_on(self, id: &str) -> bool {
        self.int(id) != 0
    }

    /// A pin, on or off.
    pub(super) fn pin(self, index: usize, canvas: &Canvas) -> Option<Pin> {
        let [rest, target] = ["Rest", "Target"].map(|end| self.params.point(&pin_id(index, end), self.time));
        let turns = self.is_on(&pin_id(index, "Turns"));
        let rotation = turns.then(|| self.double(&pin_id(index, "Angle")).to_radians());
        Some(Pin { rotation, ..Pin::new(canvas.screen(rest?), canvas.screen(target?)) })
    }

    /// Whether a pin was ever put anywhere. One that was not has no keys, and lies in the corner with both ends.
    pub(super) fn is_placed(self, index: usize) -> bool {
        ["Rest", "Target"].map(|end| pin_id(index, end)).iter().any(|id| {
            let is_elsewhere = self.params.point(id, self.time).is_some_and(|at| at != [0.0, 0.0]);
            is_elsewhere || !self.params.keys(id).is_empty()
        })
    }

    fn shape(self) -> Result<ShapeChoice, Fault> {
        Ok(match self.choice("shape", &SHAPES) {
            ShapeFrom::Frame => ShapeChoice::Frame,
            ShapeFrom::Alpha => ShapeChoice::Alpha,
            ShapeFrom::Shot => ShapeChoice::Shot(self.shot()?),
        })
    }

    /// The shot file and how it is looked at.
    pub(super) fn shot(self) -> Result<ShotShape, Fault> {
        Ok(ShotShape {
            path: self.text("shotFile").map(PathBuf::from).ok_or(Fault::NoShotFile)?,
            camera: self.text("camera"),
            layer: self.text("layer"),
            frame: self.time + f64::from(self.int("frameOffset")),
            pin_frame: self.int("pinFrame"),
            own_pins: if self.is_on("shotPins") { OwnPins::Act } else { OwnPins::LeftOut },
        })
    }

    /// Everything, in the engine's words.
    pub(super) fn settings(self, canvas: &Canvas) -> Result<Settings, Fault> {
        let basis = self.choice("basis", &BASES);
        let least = if basis == Basis::Bspline { 4 } else { 2 };
        let shape = self.shape()?;
        let is_held = self.is_on("holdBorder") && shape != ShapeChoice::Alpha;
        let on = (0..PINS).filter(|pin| self.is_on(&pin_id(*pin, "On")) && self.is_placed(*pin));
        let (pins, placed) = on.filter_map(|pin| Some((pin, self.pin(pin, canvas)?))).unzip();
        Ok(Settings {
            controls: Controls {
                dims: ["columns", "rows"].map(|id| self.int(id).max(least) as usize),
                basis,
                stiffness: self.double("stiffness"),
                strength: self.double("strength"),
                moved: if is_held { Moved::Picture } else { Moved::Masked },
                pins: placed,
            },
            shape,
            filter: self.choice("filter", &FILTERS),
            pins,
        })
    }
}

impl Settings {
    /// Whether it is plain without solving that nothing moves.
    pub(super) fn is_at_rest(&self) -> bool {
        // A shot moves by pins and handles of its own, too.
        let is_shot = matches!(self.shape, ShapeChoice::Shot(_));
        self.controls.strength == 0.0 || !is_shot && self.controls.is_at_rest()
    }

    /// The warp; a shape from alpha that is not at hand is taken for the whole frame.
    pub(super) fn warp(&self, canvas: &Canvas, alpha: Option<Coverage>) -> Result<Arc<Warp>, Fault> {
        let shape = match (&self.shape, alpha) {
            (ShapeChoice::Alpha, Some(coverage)) => Shape::Coverage(coverage),
            (ShapeChoice::Shot(shot), _) => Shape::Shot(shot.clone()),
            _ => Shape::Frame,
        };
        Ok(live::warp(&self.controls, &shape, canvas.frame)?)
    }

    /// The warp as it is drawn over the viewer, where there are no pixels: over a picture's alpha the last one that was
    /// rendered. `None`: nothing can be shown.
    pub(super) fn shown(&self, canvas: &Canvas) -> Option<Arc<Warp>> {
        if self.shape == ShapeChoice::Alpha {
            return live::last_of_alpha(&self.controls);
        }
        self.warp(canvas, None).ok()
    }
}

/// The settings of an instance at a time; what a mask selects is free to leave the frame.
pub(super) fn settings_of(call: Call, time: f64, canvas: &Canvas) -> Result<Settings, Fault> {
    let mut settings = Moment::of(call.effect, time)?.settings(canvas)?;
    if connected(call, MASK_CLIP).is_some() {
        settings.controls.moved = Moved::Masked;
    }
    Ok(settings)
}

/// Time, canvas and settings of an action's arguments. Regions are canonical: they do not depend on the scale.
pub(super) fn at_arguments(call: Call) -> Result<(f64, Canvas, Settings), Fault> {
    let time = call.args.double(prop::TIME).unwrap_or(0.0);
    let canvas = canvas_of(call.effect, time);
    Ok((time, canvas, settings_of(call, time, &canvas)?))
}
