//! The parameters of an instance at a time.
//!
//! In: an instance, a time. Out: values clamped to their ranges; missing parameters take their defaults.

use super::fault::Fault;
use super::host::{Effect, Params};
use super::params::{self, Options, ParamKind, pin_id};
use crate::live::{HostFrame, Pin, PinRegion};

/// The parameter values at a time.
#[derive(Clone, Copy)]
pub(super) struct ParamValues<'a> {
    pub(super) params: Params<'a>,
    pub(super) time: f64,
}

impl<'a> ParamValues<'a> {
    /// Returns the parameters of an effect at a time.
    pub(super) fn of(effect: Effect<'a>, time: f64) -> Result<Self, Fault> {
        Ok(Self { params: effect.params()?, time })
    }

    /// Returns an integer, choice or toggle, clamped to its range.
    pub(super) fn int(self, id: &str) -> i32 {
        let kind = params::table().iter().find(|param| param.id == id).map(|param| &param.kind);
        debug_assert!(kind.is_some(), "there is no parameter {id}");
        let (default, [least, most]) = match kind {
            Some(ParamKind::Integer(default, range, _)) => (*default, *range),
            Some(ParamKind::Toggle(default)) => (*default, [0, 1]),
            Some(ParamKind::Choice(options)) => (0, [0, options.len() as i32 - 1]),
            _ => (0, [i32::MIN, i32::MAX]),
        };
        self.params.int(id, self.time).unwrap_or(default).clamp(least, most)
    }

    /// Returns the meaning of a choice's current option.
    pub(super) fn choice<T: Copy, const N: usize>(self, id: &str, options: &Options<T, N>) -> T {
        options[self.int(id) as usize].1
    }

    pub(super) fn double(self, id: &str) -> f64 {
        let kind = params::table().iter().find(|param| param.id == id).map(|param| &param.kind);
        debug_assert!(kind.is_some(), "there is no parameter {id}");
        let Some(ParamKind::Double(default, [least, most], ..)) = kind else { return 0.0 };
        self.params.double(id, self.time).unwrap_or(*default).clamp(*least, *most)
    }

    /// Returns a text, trimmed; `None` if empty.
    pub(super) fn text(self, id: &str) -> Option<String> {
        let text = self.params.text(id, self.time)?;
        let text = text.trim();
        (!text.is_empty()).then(|| text.to_owned())
    }

    pub(super) fn is_on(self, id: &str) -> bool {
        self.int(id) != 0
    }

    /// Returns a pin, switched on or off.
    pub(super) fn pin(self, index: usize, host_frame: &HostFrame) -> Option<Pin> {
        let [rest, target] = ["Rest", "Target"].map(|end| self.params.point(&pin_id(index, end), self.time));
        let turns = self.is_on(&pin_id(index, "Turns"));
        let number = |end: &str| self.double(&pin_id(index, end));
        let region = PinRegion {
            radius: number("Radius") / host_frame.canonical_height(),
            rigidity: number("Rigidity"),
            stiffness: number("Stiffness"),
        };
        let does_something = region.radius > 0.0 && (region.rigidity > 0.0 || region.stiffness != 1.0);
        Some(Pin {
            rotation: turns.then(|| number("Angle").to_radians()),
            weight: number("Weight"),
            region: does_something.then_some(region),
            ..Pin::new(host_frame.screen(rest?), host_frame.screen(target?))
        })
    }

    /// Returns whether a pin was ever placed. One that was not has no keys, and both its ends lie in the corner.
    pub(super) fn is_placed(self, index: usize) -> bool {
        ["Rest", "Target"].map(|end| pin_id(index, end)).iter().any(|id| {
            let is_elsewhere = self.params.point(id, self.time).is_some_and(|at| at != [0.0, 0.0]);
            is_elsewhere || !self.params.keys(id).is_empty()
        })
    }
}
