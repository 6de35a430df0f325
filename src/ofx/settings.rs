//! Conversion of parameters to the engine's settings.
//!
//! In: the parameters of an instance at a time, and the frame they are measured in. Out: [`Settings`]; missing
//! parameters take their defaults.

use super::api::names::prop;
use super::call::{Call, PluginKind};
use super::clips::{MASK_CLIP, connected};
use super::fault::Fault;
use super::host::Effect;
use super::host_frame::host_frame_of;
use super::params::{BASES, FILTERS, PINS, SHAPES, ShapeFrom, pin_id};
use super::values::ParamValues;
use crate::live::{
    self, Controls, Coverage, Guard, HostFrame, LiveError, Moved, OwnPins, ShapeSource, ShotShape, Warp,
};
use crate::plate::Filter;
use std::path::PathBuf;
use std::sync::Arc;

/// The settings of an instance at a time.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Settings {
    pub(super) controls: Controls,
    pub(super) shape: ShapeChoice,
    pub(super) filter: Filter,
    /// Blend factor of the warped picture over the source, 0 to 1.
    pub(super) mix: f32,
    /// Indices of the active pins (the user's numbers minus one), in the order of the controls.
    pub(super) pins: Vec<usize>,
}

/// The source of the shape.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum ShapeChoice {
    Frame,
    /// The alpha of the whole source, available to renders only.
    Alpha,
    Shot(ShotShape),
}

impl ParamValues<'_> {
    fn shape(self) -> Result<ShapeChoice, Fault> {
        Ok(match self.choice("shape", &SHAPES) {
            ShapeFrom::Frame => ShapeChoice::Frame,
            ShapeFrom::Alpha => ShapeChoice::Alpha,
            ShapeFrom::Shot => ShapeChoice::Shot(self.shot()?),
        })
    }

    /// Returns the shot file and its viewing parameters.
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

    /// Returns the engine's settings.
    pub(super) fn settings(self, host_frame: &HostFrame) -> Result<Settings, Fault> {
        let basis = self.choice("basis", &BASES);
        let least = basis.min_handles() as i32;
        let shape = self.shape()?;
        let is_held = self.is_on("holdBorder") && shape != ShapeChoice::Alpha;
        let on = (0..PINS).filter(|pin| self.is_on(&pin_id(*pin, "On")) && self.is_placed(*pin));
        let (pins, placed) = on.filter_map(|pin| Some((pin, self.pin(pin, host_frame)?))).unzip();
        Ok(Settings {
            controls: Controls {
                dims: ["columns", "rows"].map(|id| self.int(id).max(least) as usize),
                basis,
                smoothness: self.double("smoothness"),
                strength: self.double("strength"),
                guard: if self.is_on("guard") { Guard::Limit } else { Guard::Report },
                moved: if is_held { Moved::Picture } else { Moved::Masked },
                pins: placed,
            },
            shape,
            filter: self.choice("filter", &FILTERS),
            mix: self.double("mix") as f32,
            pins,
        })
    }
}

impl Settings {
    /// Returns whether it is certain without solving that nothing moves.
    pub(super) fn is_at_rest(&self) -> bool {
        // A shot also moves by its own pins and handles.
        let is_shot = matches!(self.shape, ShapeChoice::Shot(_));
        self.mix == 0.0 || self.controls.strength == 0.0 || !is_shot && self.controls.is_at_rest()
    }

    /// Solves the warp; if the alpha that gives the shape is not available, the whole frame is used.
    pub(super) fn warp(
        &self,
        effect: Effect,
        host_frame: &HostFrame,
        alpha: Option<Coverage>,
    ) -> Result<Arc<Warp>, Fault> {
        let shape = match (&self.shape, alpha) {
            (ShapeChoice::Alpha, Some(coverage)) => ShapeSource::Coverage(coverage),
            (ShapeChoice::Shot(shot), _) => ShapeSource::Shot(shot.clone()),
            _ => ShapeSource::Frame,
        };
        live::warp_until(&self.controls, &shape, host_frame.frame, &|| effect.is_aborted()).map_err(|error| match error
        {
            LiveError::FarPin { pin, rest, target } => Fault::FarPin {
                number: self.pins.get(pin).map_or(pin, |number| *number) + 1,
                ends: [rest, target].map(|end| host_frame.canonical(end)),
            },
            error => error.into(),
        })
    }

    /// Returns the warp to draw over the viewer, where no pixels are available: for a shape from alpha, that of the
    /// last render. `None` if nothing can be shown.
    pub(super) fn shown(&self, effect: Effect, host_frame: &HostFrame) -> Option<Arc<Warp>> {
        if self.shape == ShapeChoice::Alpha {
            return live::last_of_alpha(&self.controls);
        }
        self.warp(effect, host_frame, None).ok()
    }
}

/// Returns the settings of an instance at a time; if a mask selects what moves, it may leave the frame.
pub(super) fn settings_of(call: Call, time: f64, host_frame: &HostFrame) -> Result<Settings, Fault> {
    let mut settings = ParamValues::of(call.effect, time)?.settings(host_frame)?;
    if connected(call, MASK_CLIP).is_some() {
        settings.controls.moved = Moved::Masked;
    }
    Ok(settings)
}

/// Returns the settings at the time samples of a motion-blurred frame; only one if nothing moves while the shutter is
/// open.
pub(super) fn exposed_settings(call: Call, time: f64, host_frame: &HostFrame) -> Result<Vec<Settings>, Fault> {
    let values = ParamValues::of(call.effect, time)?;
    let samples = values.int("blurSamples");
    if samples <= 1 || call.kind == PluginKind::StMap {
        return Ok(vec![settings_of(call, time, host_frame)?]);
    }
    let [open, angle] = ["shutterPhase", "shutter"].map(|id| values.double(id) / 360.0);
    let at = |sample: i32| time + open + angle * (f64::from(sample) + 0.5) / f64::from(samples);
    let mut exposed: Vec<Settings> =
        (0..samples).map(|sample| settings_of(call, at(sample), host_frame)).collect::<Result<_, _>>()?;
    if exposed.iter().all(|settings| *settings == exposed[0]) {
        exposed.truncate(1);
    }
    Ok(exposed)
}

/// Returns time, frame and settings for an action's arguments. Regions are canonical, independent of the render scale.
pub(super) fn at_arguments(call: Call) -> Result<(f64, HostFrame, Vec<Settings>), Fault> {
    let time = call.args.double(prop::TIME).unwrap_or(0.0);
    let host_frame = host_frame_of(call.effect, time);
    Ok((time, host_frame, exposed_settings(call, time, &host_frame)?))
}
