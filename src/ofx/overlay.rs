//! The overlay: lattice, pins and targets over the viewer, chosen and dragged with the pen.
//!
//! In: pen, keys, draw actions of an overlay. Out: lines; parameters, a drag being one step to undo.

use super::api::names::{action, interact, prop};
use super::api::{EffectHandle, InteractHandle, PropertySet, Status};
use super::canvas::canvas_of;
use super::fault::Fault;
use super::host::{
    self, Colour, Effect, HostError, Interact, Kept, Painter, Props, Suites, When, action_name, guarded,
};
use super::params::{PINS, pin_id};
use super::settings::{Moment, Settings};
use crate::live::{Canvas, Choosing, Picker, Pull, Warp};
use std::ffi::{CStr, c_char, c_void};

/// Pixels of the screen from a handle within which the pen hits it, and half the size of a handle.
const REACH_PX: f64 = 9.0;
const HALF_PX: f64 = 4.0;
/// Pieces in which a cell's side is drawn.
const PIECES: usize = 6;
const GRID: Colour = [0.55, 0.75, 1.0, 0.45];
const REST: Colour = [0.95, 0.95, 0.95, 0.9];
const TARGET: Colour = [1.0, 0.6, 0.1, 1.0];
const CHOSEN: Colour = [0.3, 1.0, 0.4, 1.0];

/// What is kept for each overlay, by its handle.
static VIEWS: Kept<View> = Kept::new();

/// One overlay.
#[derive(Clone, Default)]
struct View {
    /// The effect it belongs to, by its handle.
    effect: usize,
    picker: Picker,
    is_adding: bool,
    /// Pins that are dragged: index, place of pin and target when the pen went down, canonical.
    starts: Vec<(usize, [[f64; 2]; 2])>,
}

/// A pin as it is drawn, canonical.
struct Dot {
    pin: usize,
    rest: [f64; 2],
    target: [f64; 2],
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
    VIEWS.retain(|view| view.effect != effect.key());
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
    let view = if name == interact::DRAW { VIEWS.get(overlay.key()) } else { VIEWS.remove(overlay.key()) };
    let mut view = view.unwrap_or_default();
    let effect = args.pointer(prop::EFFECT_INSTANCE).or_else(|| own.pointer(prop::EFFECT_INSTANCE));
    let effect = effect.ok_or(HostError::Missing("effect of the overlay"))?;
    let effect = Effect { suites, handle: EffectHandle(effect) };
    let time = args.double(prop::TIME).unwrap_or(0.0);
    let event = Event { effect, args, overlay, moment: Moment::of(effect, time)?, canvas: canvas_of(effect, time) };
    if name == interact::DRAW {
        return event.draw(&view.picker, own);
    }
    view.effect = effect.key();
    let status = event.pen_or_key(&mut view, name, own);
    if name != action::DESTROY_INSTANCE {
        VIEWS.insert(overlay.key(), view);
    }
    status
}

impl Event<'_> {
    /// Pins that act, where they are shown: over a shot they are where the model takes them.
    fn dots(&self, settings: &Settings, warp: Option<&Warp>) -> Vec<Dot> {
        let place = |index: usize| match warp.and_then(|warp| warp.pins.get(index)) {
            Some(place) => [place.rest, place.target],
            None => [settings.controls.pins[index].rest, settings.controls.pins[index].target],
        };
        let dot = |(index, pin): (usize, &usize)| {
            let [rest, target] = place(index).map(|point| self.canvas.canonical(point));
            Dot { pin: *pin, rest, target }
        };
        settings.pins.iter().enumerate().map(dot).collect()
    }

    /// Canonical size of a pixel of the screen.
    fn pixel(&self, own: Props) -> [f64; 2] {
        let told = |props: Props| props.doubles(interact::PIXEL_SCALE).filter(|scale: &[f64; 2]| scale[0] > 0.0);
        told(self.args).or_else(|| told(own)).unwrap_or([1.0, 1.0]).map(f64::abs)
    }

    fn draw(&self, picker: &Picker, own: Props) -> Result<Status, Fault> {
        let context = self.args.pointer(interact::DRAW_CONTEXT);
        let Some(painter) = Painter::new(self.effect.suites.draw, context) else { return Ok(Status::REPLY_DEFAULT) };
        let settings = self.moment.settings(&self.canvas)?;
        let warp = settings.shown(&self.canvas);
        if let Some(warp) = &warp {
            self.draw_lattice(&painter, warp);
        }
        let half = self.pixel(own).map(|size| size * HALF_PX);
        let square = |[x, y]: [f64; 2]| [[x - half[0], y - half[1]], [x + half[0], y + half[1]]];
        for dot in self.dots(&settings, warp.as_deref()) {
            let colour = if picker.is_chosen(dot.pin) { CHOSEN } else { TARGET };
            painter.line(&[dot.rest, dot.target], colour, 1.0);
            let [[x1, y1], [x2, y2]] = square(dot.rest);
            painter.line(&[[x1, y1], [x2, y2]], REST, 1.5);
            painter.line(&[[x1, y2], [x2, y1]], REST, 1.5);
            painter.outline(square(dot.target), colour, 2.0);
        }
        if let Some(corners) = picker.corners() {
            painter.outline(corners, CHOSEN, 1.0);
        }
        Ok(Status::OK)
    }

    fn draw_lattice(&self, painter: &Painter, warp: &Warp) {
        for line in warp.grid_lines(PIECES) {
            let points: Vec<[f64; 2]> = line.moved.iter().map(|at| self.canvas.canonical(*at)).collect();
            painter.line(&points, GRID, 1.0);
        }
    }

    fn pen_or_key(&self, view: &mut View, name: &CStr, own: Props) -> Result<Status, Fault> {
        let was_dragging = view.picker.is_dragging();
        let at = self.args.doubles(interact::PEN_POSITION).unwrap_or_default();
        let key = self.args.int(interact::KEY_SYM).unwrap_or(0);
        let is_shift = [interact::KEY_SHIFT_LEFT, interact::KEY_SHIFT_RIGHT].contains(&key);
        let pull = if name == interact::PEN_DOWN {
            self.press(view, at, own)?
        } else if name == interact::PEN_MOTION {
            view.picker.motion(at)
        } else if name == interact::PEN_UP {
            // A drag ends, and so does its step to undo, whatever became of the settings meanwhile.
            let points = self.moment.settings(&self.canvas).map(|settings| self.points(&settings));
            view.picker.release(at, &points.unwrap_or_default())
        } else if name == interact::KEY_DOWN && key == interact::KEY_ESCAPE
            || name == interact::LOSE_FOCUS
            || name == action::DESTROY_INSTANCE
        {
            view.is_adding &= name == interact::KEY_DOWN;
            view.picker.cancel()
        } else {
            if is_shift && (name == interact::KEY_DOWN || name == interact::KEY_UP) {
                view.is_adding = name == interact::KEY_DOWN;
            }
            Pull::Nothing
        };
        match pull {
            Pull::Nothing => return Ok(Status::REPLY_DEFAULT),
            Pull::Chosen => {}
            Pull::Dragged(by) => self.drag(view, by),
        }
        if was_dragging && !view.picker.is_dragging() {
            self.moment.params.end_edit();
        }
        if name != action::DESTROY_INSTANCE {
            self.overlay.redraw();
        }
        Ok(Status::OK)
    }

    /// What the pen can hit: targets, with their pins' numbers.
    fn points(&self, settings: &Settings) -> Vec<(usize, [f64; 2])> {
        let by_pin = self.moment.int("handles") == 1;
        let warp = settings.shown(&self.canvas);
        self.dots(settings, warp.as_deref())
            .iter()
            .map(|dot| (dot.pin, if by_pin { dot.rest } else { dot.target }))
            .collect()
    }

    fn press(&self, view: &mut View, at: [f64; 2], own: Props) -> Result<Pull, Fault> {
        let settings = self.moment.settings(&self.canvas)?;
        let choosing = if view.is_adding { Choosing::Adding } else { Choosing::Anew };
        let reach = self.pixel(own).map(|size| size * REACH_PX);
        let points = self.points(&settings);
        if points.is_empty() {
            return Ok(Pull::Nothing);
        }
        let pull = view.picker.press(at, &points, reach, choosing);
        let chosen = settings.pins.iter().zip(&settings.controls.pins).filter(|(pin, _)| view.picker.is_chosen(**pin));
        let ends = chosen.map(|(pin, place)| (*pin, [place.rest, place.target].map(|at| self.canvas.canonical(at))));
        view.starts = ends.collect();
        if view.picker.is_dragging() {
            self.moment.params.begin_edit(c"Move pins");
        }
        Ok(pull)
    }

    fn drag(&self, view: &View, by: [f64; 2]) {
        let moved = |at: [f64; 2]| [at[0] + by[0], at[1] + by[1]];
        for (pin, [rest, target]) in &view.starts {
            self.moment.params.set_point(&pin_id(*pin, "Target"), moved(*target), When::Now);
            if self.moment.int("handles") == 1 {
                self.moment.params.set_point(&pin_id(*pin, "Rest"), moved(*rest), When::Now);
            }
        }
    }
}
