//! The overlay: lattice, pins and targets over the viewer, chosen and dragged with the pen.
//!
//! In: pen, keys, draw actions of an overlay. Out: lines; parameters, a drag being one step to undo.

use super::api::names::{action, interact, prop};
use super::api::{EffectHandle, InteractHandle, PropertySet, Status};
use super::canvas::canvas_of;
use super::fault::Fault;
use super::host::{self, Effect, HostError, Interact, Kept, Painter, Props, Suites, When, action_name, guarded};
use super::params::{HANDLES, Handles, PINS, pin_id};
use super::settings::{Moment, Settings};
use crate::live::{Canvas, Choosing, Picker, Pull, View};
use std::ffi::{CStr, c_char, c_void};

/// Pixels of the screen from a handle within which the pen hits it.
const REACH_PX: f64 = 9.0;

/// What is kept for each overlay, by its handle.
static PENS: Kept<Pen> = Kept::new();

/// The pen over one overlay, and what it chose.
#[derive(Clone, Default)]
struct Pen {
    /// The effect it belongs to, by its handle.
    effect: usize,
    picker: Picker,
    is_adding: bool,
    /// Pins that are dragged: index, place of pin and target when the pen went down, canonical.
    starts: Vec<(usize, [[f64; 2]; 2])>,
}

/// An action on an overlay.
struct Event<'a> {
    effect: Effect<'a>,
    args: Props<'a>,
    overlay: Interact<'a>,
    moment: Moment<'a>,
    canvas: Canvas,
}

/// The overlay's entry, for hosts that draw with OpenGL and for those with the Draw suite.
pub(super) unsafe extern "C" fn entry(
    name: *const c_char,
    handle: *const c_void,
    args: PropertySet,
    _out: PropertySet,
) -> Status {
    guarded(|| {
        // SAFETY: the host ends the names of actions with zero.
        let name = unsafe { action_name(name) };
        let Some(name) = name.filter(|_| !handle.is_null()) else { return Status::ERR_BAD_HANDLE };
        let Ok(suites) = host::suites() else { return Status::ERR_MISSING_HOST_FEATURE };
        act(&suites, name, InteractHandle(handle.cast_mut()), args).unwrap_or(Status::REPLY_DEFAULT)
    })
}

/// Lets go of the overlays of an effect that ends.
pub(super) fn forget(effect: Effect) {
    PENS.retain(|pen| pen.effect != effect.key());
}

fn act(suites: &Suites, name: &CStr, handle: InteractHandle, args: PropertySet) -> Result<Status, Fault> {
    if name == action::DESCRIBE {
        return Ok(Status::OK);
    }
    let (overlay, args) = (Interact { suites, handle }, Props::new(suites, args));
    let own = overlay.props();
    if name == action::CREATE_INSTANCE {
        let ids: Vec<String> = (0..PINS).flat_map(|pin| ["On", "Rest", "Target"].map(|end| pin_id(pin, end))).collect();
        own.set_texts(interact::SLAVE_TO_PARAM, &ids.iter().map(String::as_str).collect::<Vec<_>>());
        return Ok(Status::OK);
    }
    // The effect may be gone before its overlay: what is kept must go all the same.
    let pen = if name == interact::DRAW { PENS.get(overlay.key()) } else { PENS.remove(overlay.key()) };
    let mut pen = pen.unwrap_or_default();
    let effect = args.pointer(prop::EFFECT_INSTANCE).or_else(|| own.pointer(prop::EFFECT_INSTANCE));
    let effect = effect.ok_or(HostError::Missing("effect of the overlay"))?;
    let effect = Effect { suites, handle: EffectHandle(effect) };
    let time = args.double(prop::TIME).unwrap_or(0.0);
    let event = Event { effect, args, overlay, moment: Moment::of(effect, time)?, canvas: canvas_of(effect, time) };
    if name == interact::DRAW {
        return event.draw(&pen.picker, own);
    }
    pen.effect = effect.key();
    let status = event.pen_or_key(&mut pen, name, own);
    if name != action::DESTROY_INSTANCE {
        PENS.insert(overlay.key(), pen);
    }
    status
}

impl Event<'_> {
    fn view(&self, own: Props) -> View {
        let told = |props: Props| props.doubles(interact::PIXEL_SCALE).filter(|scale: &[f64; 2]| scale[0] > 0.0);
        let pixel = told(self.args).or_else(|| told(own)).unwrap_or([1.0, 1.0]).map(f64::abs);
        View { canvas: self.canvas, pixel }
    }

    fn draw(&self, picker: &Picker, own: Props) -> Result<Status, Fault> {
        let context = self.args.pointer(interact::DRAW_CONTEXT);
        let Some(painter) = Painter::new(self.effect.suites.draw, context) else { return Ok(Status::REPLY_DEFAULT) };
        let settings = self.moment.settings(&self.canvas)?;
        let warp = settings.shown(&self.canvas);
        let view = self.view(own);
        let dots = view.dots(&settings.controls, &settings.pins, warp.as_deref());
        for stroke in view.sketch(warp.as_deref(), &dots, picker) {
            painter.line(&stroke.points, stroke.colour, stroke.width);
        }
        Ok(Status::OK)
    }

    fn pen_or_key(&self, pen: &mut Pen, name: &CStr, own: Props) -> Result<Status, Fault> {
        let was_dragging = pen.picker.is_dragging();
        let at = self.args.doubles(interact::PEN_POSITION).unwrap_or_default();
        let key = self.args.int(interact::KEY_SYM).unwrap_or(0);
        let is_shift = [interact::KEY_SHIFT_LEFT, interact::KEY_SHIFT_RIGHT].contains(&key);
        let pull = if name == interact::PEN_DOWN {
            self.press(pen, at, own)?
        } else if name == interact::PEN_MOTION {
            pen.picker.motion(at)
        } else if name == interact::PEN_UP {
            // A drag ends, and so does its step to undo, whatever became of the settings meanwhile.
            let settings = self.moment.settings(&self.canvas);
            let points = settings.map(|settings| self.points(&settings, self.view(own)));
            pen.picker.release(at, &points.unwrap_or_default())
        } else if name == interact::KEY_DOWN && key == interact::KEY_ESCAPE
            || name == interact::LOSE_FOCUS
            || name == action::DESTROY_INSTANCE
        {
            pen.is_adding &= name == interact::KEY_DOWN;
            pen.picker.cancel()
        } else {
            if is_shift && (name == interact::KEY_DOWN || name == interact::KEY_UP) {
                pen.is_adding = name == interact::KEY_DOWN;
            }
            Pull::Nothing
        };
        match pull {
            Pull::Nothing => return Ok(Status::REPLY_DEFAULT),
            Pull::Chosen => {}
            Pull::Dragged(by) => self.drag(pen, by),
        }
        if was_dragging && !pen.picker.is_dragging() {
            self.moment.params.end_edit();
        }
        if name != action::DESTROY_INSTANCE {
            self.overlay.redraw();
        }
        Ok(Status::OK)
    }

    /// What the pen can hit: targets, with their pins' numbers.
    fn points(&self, settings: &Settings, view: View) -> Vec<(usize, [f64; 2])> {
        let by_pin = self.moment.choice("handles", &HANDLES) == Handles::Pins;
        let warp = settings.shown(&self.canvas);
        let dots = view.dots(&settings.controls, &settings.pins, warp.as_deref());
        dots.iter().map(|dot| (dot.pin, if by_pin { dot.rest } else { dot.target })).collect()
    }

    fn press(&self, pen: &mut Pen, at: [f64; 2], own: Props) -> Result<Pull, Fault> {
        let settings = self.moment.settings(&self.canvas)?;
        let choosing = if pen.is_adding { Choosing::Adding } else { Choosing::Anew };
        let view = self.view(own);
        let (points, reach) = (self.points(&settings, view), view.pixel.map(|size| size * REACH_PX));
        if points.is_empty() {
            return Ok(Pull::Nothing);
        }
        let pull = pen.picker.press(at, &points, reach, choosing);
        let chosen = settings.pins.iter().zip(&settings.controls.pins).filter(|(pin, _)| pen.picker.is_chosen(**pin));
        let ends = chosen.map(|(pin, place)| (*pin, [place.rest, place.target].map(|at| self.canvas.canonical(at))));
        pen.starts = ends.collect();
        if pen.picker.is_dragging() {
            self.moment.params.begin_edit(c"Move pins");
        }
        Ok(pull)
    }

    fn drag(&self, pen: &Pen, by: [f64; 2]) {
        let moved = |at: [f64; 2]| [at[0] + by[0], at[1] + by[1]];
        for (pin, [rest, target]) in &pen.starts {
            self.moment.params.set_point(&pin_id(*pin, "Target"), moved(*target), When::Now);
            if self.moment.choice("handles", &HANDLES) == Handles::Pins {
                self.moment.params.set_point(&pin_id(*pin, "Rest"), moved(*rest), When::Now);
            }
        }
    }
}
