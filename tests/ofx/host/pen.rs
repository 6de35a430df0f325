//! Overlays: what a host does with them when its user draws, presses, drags and types.
//!
//! In: places, canonical. Out: actions on the overlay; what it drew.

use super::api::names::{action, image, interact, prop};
use super::api::{EntryPoint, Status};
use super::extras::CANVAS;
use super::session::{Host, Node, call, doubles, ints, text};
use super::world::{Drawn, Value, with};
use std::ffi::CStr;
use std::marker::PhantomData;

/// The overlay of a node.
#[derive(Clone, Copy)]
pub(crate) struct Overlay<'a> {
    pub(super) entry: EntryPoint,
    pub(super) handle: usize,
    pub(super) node: Node,
    pub(super) pixel: f64,
    pub(super) _host: PhantomData<&'a Host>,
}

impl Overlay<'_> {
    /// The same overlay, which may outlive its node.
    pub(crate) fn detached(self) -> Overlay<'static> {
        Overlay { _host: PhantomData, ..self }
    }

    /// Ends the overlay after its own properties are gone.
    pub(crate) fn close_half_gone(self) {
        with(|world| {
            let set = world.interacts.remove(&self.handle).expect("it was there");
            world.end_set(set, "set of an overlay");
            world.end(self.handle, "overlay");
        });
        call(self.entry, (action::DESTROY_INSTANCE, "CloseOverlay"), self.handle, Vec::new());
    }

    pub(super) fn act(&self, name: &CStr, short: &'static str, mut args: Vec<(&CStr, Vec<Value>)>) -> Status {
        args.extend([
            (prop::EFFECT_INSTANCE, vec![Value::Pointer(self.node.0)]),
            (interact::PIXEL_SCALE, doubles(&[self.pixel, self.pixel])),
            (interact::BACKGROUND_COLOUR, doubles(&[0.0, 0.0, 0.0])),
            (prop::TIME, doubles(&[0.0])),
            (image::RENDER_SCALE, doubles(&[1.0, 1.0])),
        ]);
        call(self.entry, (name, short), self.handle, args).0
    }

    /// What is drawn.
    pub(crate) fn draw(&self) -> Vec<Drawn> {
        let context = vec![(interact::DRAW_CONTEXT, vec![Value::Pointer(CANVAS)])];
        assert_eq!(self.act(interact::DRAW, "Draw", context), Status::OK);
        with(|world| std::mem::take(&mut world.drawn))
    }

    /// An action of the pen at a canonical place.
    pub(crate) fn pen(&self, name: &CStr, short: &'static str, at: [f64; 2]) -> Status {
        let args = vec![(interact::PEN_POSITION, doubles(&at)), (interact::PEN_PRESSURE, doubles(&[1.0]))];
        self.act(name, short, args)
    }

    /// Presses the pen, moves it in ten steps, lets go.
    pub(crate) fn drag(&self, from: [f64; 2], to: [f64; 2]) {
        self.pen(interact::PEN_DOWN, "PenDown", from);
        for step in 1..=10 {
            let share = f64::from(step) / 10.0;
            let at = [0, 1].map(|axis: usize| from[axis] + (to[axis] - from[axis]) * share);
            self.pen(interact::PEN_MOTION, "PenMotion", at);
        }
        self.pen(interact::PEN_UP, "PenUp", to);
    }

    /// A key goes down (or up).
    pub(crate) fn key(&self, name: &CStr, key: i32) {
        let args = vec![(interact::KEY_SYM, ints(&[key])), (interact::KEY_STRING, text(c""))];
        self.act(name, "KeyDown", args);
    }

    /// Ends the overlay.
    pub(crate) fn close(self) {
        self.act(action::DESTROY_INSTANCE, "CloseOverlay", Vec::new());
        with(|world| {
            let set = world.interacts.remove(&self.handle).expect("it was there");
            world.end_set(set, "set of an overlay");
            world.end(self.handle, "overlay");
        });
    }
}
