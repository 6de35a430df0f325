//! The overlay: draws lattice, pins and targets over the viewer; adds, selects and drags pins.
//!
//! In: pen, key and draw actions of an overlay. Out: lines; parameters, each change in one undo step.

use super::api::names::{action, interact, prop};
use super::api::{EffectHandle, InteractHandle, PropertySet, Status};
use super::fault::Fault;
use super::host::{self, Effect, HostError, Interact, Painter, Props, Suites, When, action_name, guarded};
use super::host_frame::{HostFrame, host_frame_of};
use super::params::{HANDLES, Handles, OVERLAYS, PINS, pin_id};
use super::pen::{self, Pen};
use super::pins;
use super::settings::Settings;
use super::values::ParamValues;
use crate::live::{PenResult, SelectMode, Viewer};
use std::ffi::{CStr, c_char, c_void};

/// Hit radius of a handle in screen pixels.
const REACH_PX: f64 = 9.0;

/// Maximum pen movement during a click in screen pixels.
const CLICK_PX: f64 = 3.0;

/// An action on an overlay.
struct Event<'a> {
    effect: Effect<'a>,
    args: Props<'a>,
    overlay: Interact<'a>,
    values: ParamValues<'a>,
    host_frame: HostFrame,
}

/// The overlay's entry point, for hosts that draw with OpenGL and for those with the Draw suite.
pub(super) unsafe extern "C" fn entry(
    name: *const c_char,
    handle: *const c_void,
    args: PropertySet,
    _out: PropertySet,
) -> Status {
    guarded(|| {
        // SAFETY: the host passes action names as NUL-terminated strings.
        let name = unsafe { action_name(name) };
        let Some(name) = name.filter(|_| !handle.is_null()) else { return Status::ERR_BAD_HANDLE };
        if name == action::DESTROY_INSTANCE {
            // The effect may be partly destroyed, so the host is not called.
            pen::close(handle as usize);
            return Status::OK;
        }
        let Ok(suites) = host::suites() else { return Status::ERR_MISSING_HOST_FEATURE };
        act(&suites, name, InteractHandle(handle.cast_mut()), args).unwrap_or(Status::REPLY_DEFAULT)
    })
}

/// Ends an undo block left open by an overlay that closed during a drag. Only for actions that may set parameters.
pub(super) fn end_open_edit(effect: Effect) {
    let is_open = pen::change(effect.key(), |pen| pen.picker.is_up() && std::mem::take(&mut pen.is_editing));
    if let (true, Ok(params)) = (is_open, effect.params()) {
        params.end_edit();
    }
}

fn act(suites: &Suites, name: &CStr, handle: InteractHandle, args: PropertySet) -> Result<Status, Fault> {
    if name == action::DESCRIBE {
        return Ok(Status::OK);
    }
    let overlay = Interact { suites, handle };
    // Hosts send this to overlays of partly destroyed effects, too.
    let known = pen::effect_of(overlay.key());
    if name == interact::LOSE_FOCUS && known.is_none_or(|effect| pen::change(effect, Pen::rest)) {
        return Ok(Status::REPLY_DEFAULT);
    }
    let (args, own) = (Props::new(suites.property, args), overlay.props());
    if name == action::CREATE_INSTANCE {
        let of_pins = (0..PINS).flat_map(|pin| ["On", "Rest", "Target"].map(|end| pin_id(pin, end)));
        let ids: Vec<String> = ["overlay", "selected"].map(str::to_owned).into_iter().chain(of_pins).collect();
        own.set_texts(interact::SLAVE_TO_PARAM, &ids.iter().map(String::as_str).collect::<Vec<_>>());
        return Ok(Status::OK);
    }
    let effect = args.pointer(prop::EFFECT_INSTANCE).or_else(|| own.pointer(prop::EFFECT_INSTANCE));
    let effect = EffectHandle(effect.ok_or(HostError::Missing("effect of the overlay"))?);
    if host::has_ended(effect) {
        return Ok(Status::REPLY_DEFAULT);
    }
    let effect = Effect { suites, handle: effect };
    let time = args.double(prop::TIME).unwrap_or(0.0);
    let values = ParamValues::of(effect, time)?;
    let event = Event { effect, args, overlay, values, host_frame: host_frame_of(effect, time) };
    if name == interact::DRAW {
        return event.draw(&pen::pen_of(effect.key()), own);
    }
    end_open_edit(effect);
    let mut pen = pen::pen_of(effect.key());
    let status = event.pen_or_key(&mut pen, name, own);
    pen::keep(effect.key(), overlay.key(), pen);
    status
}

impl Event<'_> {
    fn viewer(&self, own: Props) -> Viewer {
        let told = |props: Props| props.doubles(interact::PIXEL_SCALE).filter(|scale: &[f64; 2]| scale[0] > 0.0);
        let pixel = told(self.args).or_else(|| told(own)).unwrap_or([1.0, 1.0]).map(f64::abs);
        Viewer { host_frame: self.host_frame, pixel }
    }

    fn draw(&self, pen: &Pen, own: Props) -> Result<Status, Fault> {
        let context = self.args.pointer(interact::DRAW_CONTEXT);
        let Some(painter) = Painter::new(self.effect.suites.draw, context) else { return Ok(Status::REPLY_DEFAULT) };
        let settings = self.values.settings(&self.host_frame)?;
        let warp = settings.shown(self.effect, &self.host_frame);
        let viewer = self.viewer(own);
        let marks = viewer.marks(&settings.controls, &settings.pins, warp.as_deref());
        let style = self.values.choice("overlay", &OVERLAYS);
        for stroke in viewer.lattice(warp.as_deref(), style).iter().chain(&viewer.pins(&marks, &pen.picker)) {
            painter.line(&stroke.points, stroke.colour, stroke.width);
        }
        Ok(Status::OK)
    }

    fn pen_or_key(&self, pen: &mut Pen, name: &CStr, own: Props) -> Result<Status, Fault> {
        let at = self.args.doubles(interact::PEN_POSITION).unwrap_or_default();
        let result = if name == interact::PEN_DOWN {
            self.press(pen, at, own)?
        } else if name == interact::PEN_MOTION {
            pen.picker.motion(at)
        } else if name == interact::PEN_UP {
            self.release(pen, at, own)
        } else if name == interact::KEY_DOWN {
            return self.key(pen, self.args.int(interact::KEY_SYM).unwrap_or(0));
        } else {
            if name == interact::KEY_UP && is_shift(self.args.int(interact::KEY_SYM).unwrap_or(0)) {
                pen.is_adding = false;
            }
            if name == interact::LOSE_FOCUS { pen.picker.cancel() } else { PenResult::Nothing }
        };
        Ok(self.settle(pen, result))
    }

    /// Applies the pen's result, and ends the undo block when the drag is over.
    fn settle(&self, pen: &mut Pen, result: PenResult) -> Status {
        match result {
            PenResult::Nothing => return Status::REPLY_DEFAULT,
            PenResult::SelectionChanged => {}
            PenResult::Dragged(by) => self.drag(pen, by),
        }
        if pen.picker.is_up() && std::mem::take(&mut pen.is_editing) {
            self.values.params.end_edit();
            self.effect.clear_messages();
        }
        self.overlay.redraw();
        Status::OK
    }

    /// Returns the points that the pen can hit, targets or rest positions by what a drag moves, with their pins'
    /// indices.
    fn points(&self, settings: &Settings, viewer: Viewer) -> Vec<(usize, [f64; 2])> {
        let by_pin = self.values.choice("handles", &HANDLES) == Handles::Pins;
        let warp = settings.shown(self.effect, &self.host_frame);
        let marks = viewer.marks(&settings.controls, &settings.pins, warp.as_deref());
        marks.iter().map(|mark| (mark.pin, if by_pin { mark.rest } else { mark.target })).collect()
    }

    fn press(&self, pen: &mut Pen, at: [f64; 2], own: Props) -> Result<PenResult, Fault> {
        let settings = self.values.settings(&self.host_frame)?;
        let mode = if pen.is_adding { SelectMode::Add } else { SelectMode::Replace };
        let viewer = self.viewer(own);
        let (points, reach) = (self.points(&settings, viewer), viewer.pixel.map(|size| size * REACH_PX));
        if points.is_empty() && !self.values.is_on("clickAdds") {
            return Ok(PenResult::Nothing);
        }
        let result = pen.picker.press(at, &points, reach, mode);
        let chosen = settings.pins.iter().zip(&settings.controls.pins).filter(|(pin, _)| pen.picker.is_selected(**pin));
        let ends =
            chosen.map(|(pin, place)| (*pin, [place.rest, place.target].map(|at| self.host_frame.canonical(at))));
        pen.starts = ends.collect();
        if pen.picker.is_dragging() {
            self.values.params.begin_edit(c"Move pins");
            pen.is_editing = true;
        }
        Ok(result)
    }

    /// Handles the release of the pen. A drag ends, and so does its undo block, even if the settings have become
    /// invalid; a click on empty space adds a pin.
    fn release(&self, pen: &mut Pen, at: [f64; 2], own: Props) -> PenResult {
        let viewer = self.viewer(own);
        let is_click = pen
            .picker
            .corners()
            .is_some_and(|[from, _]| (0..2).all(|axis| (at[axis] - from[axis]).abs() <= CLICK_PX * viewer.pixel[axis]));
        let points = self.values.settings(&self.host_frame).map(|settings| self.points(&settings, viewer));
        let result = pen.picker.release(at, &points.unwrap_or_default());
        if is_click && !pen.is_adding && self.values.is_on("clickAdds") {
            self.add(pen, at);
        }
        result
    }

    fn add(&self, pen: &mut Pen, at: [f64; 2]) {
        let Some(pin) = pins::free(self.values) else {
            self.effect.inform("all 32 pins are in use; delete one first");
            return;
        };
        self.edit(c"Add a pin", || pins::place(self.values, pin, at));
        pen.picker.choose([pin]);
    }

    /// Runs a change in one undo step.
    fn edit(&self, label: &CStr, change: impl FnOnce()) {
        self.values.params.begin_edit(label);
        change();
        self.values.params.end_edit();
        self.effect.clear_messages();
    }

    fn key(&self, pen: &mut Pen, key: i32) -> Result<Status, Fault> {
        let selected: Vec<usize> = pen.picker.chosen().collect();
        let step = match key {
            interact::KEY_BRACKET_LEFT => -1,
            interact::KEY_BRACKET_RIGHT => 1,
            _ => 0,
        };
        match key {
            interact::KEY_ESCAPE => {
                let result = pen.picker.cancel();
                return Ok(self.settle(pen, result));
            }
            interact::KEY_SHIFT_LEFT | interact::KEY_SHIFT_RIGHT => {
                pen.is_adding = true;
                return Ok(Status::REPLY_DEFAULT);
            }
            _ if pen.is_editing => return Ok(Status::REPLY_DEFAULT),
            interact::KEY_DELETE | interact::KEY_BACKSPACE if !selected.is_empty() => {
                self.edit(c"Delete pins", || selected.iter().for_each(|pin| pins::delete(self.values, *pin)));
                pen.picker.choose([]);
            }
            interact::KEY_R if !selected.is_empty() => {
                self.edit(c"Reset pins", || selected.iter().for_each(|pin| pins::reset(self.values, *pin)));
            }
            interact::KEY_BRACKET_LEFT | interact::KEY_BRACKET_RIGHT => {
                let Some(next) = pins::neighbour(self.values, &selected, step) else {
                    return Ok(Status::REPLY_DEFAULT);
                };
                pen.picker.choose([next]);
            }
            _ => return Ok(Status::REPLY_DEFAULT),
        }
        self.overlay.redraw();
        Ok(Status::OK)
    }

    fn drag(&self, pen: &Pen, by: [f64; 2]) {
        let moved = |at: [f64; 2]| [at[0] + by[0], at[1] + by[1]];
        for (pin, [rest, target]) in &pen.starts {
            self.values.params.set_point(&pin_id(*pin, "Target"), moved(*target), When::Now);
            if self.values.choice("handles", &HANDLES) == Handles::Pins {
                self.values.params.set_point(&pin_id(*pin, "Rest"), moved(*rest), When::Now);
            }
        }
    }
}

fn is_shift(key: i32) -> bool {
    [interact::KEY_SHIFT_LEFT, interact::KEY_SHIFT_RIGHT].contains(&key)
}
