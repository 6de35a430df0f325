//! The OpenFX plugin in a host that calls actions in any order, with any properties and values.
//!
//! The host is that of the tests: it notes every misuse of a handle, an image or a property, and fails for it. Addresses
//! that a host gives (handles, suites, pixels) are right; AddressSanitizer sees what the plugin does with them.
#![no_main]
#![allow(dead_code, unused_imports, reason = "the host offers more than this target needs")]

#[path = "../../../ofx/host/mod.rs"]
mod host;

use arbitrary::Arbitrary;
use host::profile::ALL;
use host::{Depth, Frame, Host, Node, Pixels, Value, Which, feed};
use host::api::RectI;
use host::api::names::{action, image, interact, param, prop};
use std::ffi::CStr;

/// Actions that a host may send to an instance at any time.
const ACTIONS: [(&CStr, &str); 14] = [
    (action::BEGIN_SEQUENCE_RENDER, "BeginSequenceRender"),
    (action::END_SEQUENCE_RENDER, "EndSequenceRender"),
    (action::RENDER, "Render"),
    (action::IS_IDENTITY, "IsIdentity"),
    (action::GET_REGION_OF_DEFINITION, "GetRegionOfDefinition"),
    (action::GET_REGIONS_OF_INTEREST, "GetRegionsOfInterest"),
    (action::GET_CLIP_PREFERENCES, "GetClipPreferences"),
    (action::GET_TIME_DOMAIN, "GetTimeDomain"),
    (action::GET_FRAMES_NEEDED, "GetFramesNeeded"),
    (action::INSTANCE_CHANGED, "InstanceChanged"),
    (action::BEGIN_INSTANCE_CHANGED, "BeginInstanceChanged"),
    (action::SYNC_PRIVATE_DATA, "SyncPrivateData"),
    (action::PURGE_CACHES, "PurgeCaches"),
    (c"OfxActionOfTheFuture", "unknown"),
];

/// Properties that arguments of actions have.
const PROPERTIES: [&CStr; 10] = [
    prop::TIME,
    prop::NAME,
    prop::TYPE,
    prop::CHANGE_REASON,
    image::RENDER_SCALE,
    image::RENDER_WINDOW,
    image::FIELD_TO_RENDER,
    image::REGION_OF_INTEREST,
    image::FRAME_RANGE,
    c"OfxPropOfTheFuture",
];

/// Texts that a host may give: names of actions' objects, file names, broken UTF-8.
const TEXTS: [&CStr; 10] = [
    c"",
    prop::TYPE_PARAMETER,
    prop::TYPE_CLIP,
    prop::CHANGE_USER_EDITED,
    image::SOURCE_CLIP,
    image::FIELD_NONE,
    c"pin1Target",
    c"/nonexistent/shot.toml",
    c"100% \xff\xfe",
    c"writeShot",
];

#[derive(Arbitrary, Clone, Copy, Debug)]
enum Any {
    Int(i32),
    Double(f64),
    Text(u8),
}

impl From<Any> for Value {
    fn from(any: Any) -> Self {
        match any {
            Any::Int(value) => Self::Int(value),
            Any::Double(value) => Self::Double(value),
            Any::Text(number) => Self::Text(pick(&TEXTS, number).to_owned()),
        }
    }
}

#[derive(Arbitrary, Debug)]
enum Pen {
    Draw,
    Down([i16; 2]),
    Motion([i16; 2]),
    Up([i16; 2]),
    Key(i32),
}

#[derive(Arbitrary, Debug)]
enum Step {
    Create,
    Destroy(u8),
    /// The host's side of an instance ends without a word to the plugin.
    BreakOff(u8),
    LoadAgain,
    Feed {
        node: u8,
        is_output: bool,
        size: [u8; 2],
        origin: [i8; 2],
        channels: u8,
        depth: u8,
        scale: u8,
        aspect: f64,
    },
    Disconnect {
        node: u8,
    },
    Project {
        node: u8,
        size: [f64; 2],
    },
    Set {
        node: u8,
        param: u16,
        number: i32,
        point: [f64; 2],
    },
    Key {
        node: u8,
        param: u16,
        time: i8,
        number: i32,
        point: [f64; 2],
    },
    Pin {
        node: u8,
        number: u8,
        rest: [u8; 2],
        target: [u8; 2],
    },
    Press {
        node: u8,
        param: u16,
    },
    Render {
        node: u8,
        time: f64,
        scale: [f64; 2],
        window: Option<[i16; 4]>,
    },
    Region {
        node: u8,
        scale: [f64; 2],
    },
    Interest {
        node: u8,
        part: [f64; 4],
    },
    Ask {
        node: u8,
        action: u8,
        args: Vec<(u8, Vec<Any>)>,
    },
    Overlay {
        node: u8,
        pixel: f64,
        pens: Vec<Pen>,
    },
    AbortAt(Option<u8>),
}

#[derive(Arbitrary, Debug)]
struct Traffic {
    profile: u8,
    is_stmap: bool,
    steps: Vec<Step>,
}

fn pick<T: Copy>(list: &[T], number: u8) -> T {
    list[usize::from(number) % list.len()]
}

/// Most instances at a time, and most steps of a case: more of them find nothing new.
const LIMITS: [usize; 2] = [4, 24];

/// The instances, and the parameters they have.
struct Session {
    host: Host,
    nodes: Vec<Node>,
    params: Vec<(String, String)>,
}

impl Session {
    fn new(traffic: &Traffic) -> Self {
        let which = if traffic.is_stmap { Which::StMap } else { Which::PinWarp };
        let mut host = Host::start(pick(ALL, traffic.profile), which);
        let params = host.parameters().into_iter().map(|(id, kind, _)| (id, kind)).collect();
        let nodes = vec![host.node()];
        host.through(nodes[0], &Pixels::scenery([32, 18], 4));
        Self { host, nodes, params }
    }

    /// An instance; there is at least one.
    fn node(&mut self, number: u8) -> Node {
        if self.nodes.is_empty() {
            self.nodes.push(self.host.node());
        }
        pick(&self.nodes, number)
    }

    fn end(&mut self, number: u8) -> Node {
        let node = self.node(number);
        self.nodes.retain(|other| *other != node);
        node
    }

    fn feed(&mut self, step: &Step) {
        let Step::Feed { node, is_output, size, origin, channels, depth, scale, aspect } = step else { return };
        let node = self.node(*node);
        let [x1, y1] = origin.map(i32::from);
        let [x2, y2] = [x1 + i32::from(size[0] % 64), y1 + i32::from(size[1] % 64)];
        let channels = pick(&[1, 3, 4], *channels);
        let bounds = RectI { x1, y1, x2, y2 };
        let pixels = Pixels::new(bounds, channels, |x, y, channel| ((x ^ y) as f32 + channel as f32).sin());
        let mut form = feed(Some(pixels), bounds, channels).with_depth(pick(&Depth::ALL, *depth));
        let scale = pick(&[1.0, 0.5, 0.25], *scale);
        form.scale = [scale, scale];
        if aspect.is_finite() && (0.1..10.0).contains(aspect) {
            form.aspect = *aspect;
        }
        self.host.feed_as(node, if *is_output { image::OUTPUT_CLIP } else { image::SOURCE_CLIP }, form);
    }

    /// Sets a parameter, or a key of it, to a value of its own type. Large lattices only cost time.
    fn set(&mut self, node: u8, param: u16, time: Option<i8>, number: i32, point: [f64; 2]) {
        let node = self.node(node);
        let (id, kind) = self.params[usize::from(param) % self.params.len()].clone();
        let number = if ["columns", "rows"].contains(&id.as_str()) && number > 12 { 12 } else { number };
        let is = |known: &CStr| kind.as_bytes() == known.to_bytes();
        // Values are of types of their own, so this cannot be a function.
        macro_rules! put {
            ($value:expr) => {
                match time {
                    Some(time) => self.host.key(node, &id, f64::from(time), $value),
                    None => self.host.set(node, &id, $value),
                }
            };
        }
        if is(param::TYPE_DOUBLE) {
            put!(point[0]);
        } else if is(param::TYPE_DOUBLE_2D) {
            put!(point);
        } else if is(param::TYPE_STRING) {
            put!(pick(&TEXTS, number as u8).to_str().unwrap_or_default());
        } else if [param::TYPE_INTEGER, param::TYPE_BOOLEAN, param::TYPE_CHOICE].into_iter().any(is) {
            put!(number);
        }
    }

    fn overlay(&mut self, node: u8, pixel: f64, pens: &[Pen]) {
        let node = self.node(node);
        let Some(overlay) = self.host.overlay(node, pixel) else { return };
        for pen in pens.iter().take(LIMITS[1]) {
            match pen {
                Pen::Draw => _ = overlay.draw(),
                Pen::Down(at) => _ = overlay.pen(interact::PEN_DOWN, "PenDown", at.map(f64::from)),
                Pen::Motion(at) => _ = overlay.pen(interact::PEN_MOTION, "PenMotion", at.map(f64::from)),
                Pen::Up(at) => _ = overlay.pen(interact::PEN_UP, "PenUp", at.map(f64::from)),
                Pen::Key(key) => overlay.key(interact::KEY_DOWN, *key),
            }
        }
        overlay.close();
    }

    fn render(&mut self, node: u8, time: f64, scale: [f64; 2], window: Option<[i16; 4]>) {
        let node = self.node(node);
        // A window is a part of what was fed: hosts promise that the output holds it.
        let window = window.map(|corners| {
            let [x1, y1, x2, y2] = corners.map(i32::from);
            RectI { x1, y1, x2, y2 }
        });
        self.host.try_render(node, Frame { time, scale, window, ..Frame::default() });
    }

    fn take(&mut self, step: &Step) {
        match step {
            Step::Create if self.nodes.len() < LIMITS[0] => self.nodes.push(self.host.node()),
            Step::Create => {}
            Step::Destroy(number) => {
                let node = self.end(*number);
                self.host.destroy(node);
            }
            Step::BreakOff(number) => {
                let node = self.end(*number);
                self.host.break_off(node);
            }
            Step::LoadAgain => self.host.load_again(),
            Step::Feed { .. } => self.feed(step),
            Step::Disconnect { node } => {
                let node = self.node(*node);
                self.host.feed(node, image::SOURCE_CLIP, None);
            }
            Step::Project { node, size } => {
                let node = self.node(*node);
                self.host.project(node, *size);
            }
            Step::Set { node, param, number, point } => self.set(*node, *param, None, *number, *point),
            Step::Key { node, param, time, number, point } => self.set(*node, *param, Some(*time), *number, *point),
            Step::Pin { node, number, rest, target } => {
                let node = self.node(*node);
                if self.params.iter().any(|(id, _)| id == "pin1On") {
                    let number = 1 + usize::from(*number % 32);
                    self.host.pin(node, number, rest.map(f64::from), target.map(f64::from));
                }
            }
            Step::Press { node, param } => {
                let node = self.node(*node);
                let id = self.params[usize::from(*param) % self.params.len()].0.clone();
                self.host.press(node, &id);
            }
            Step::Render { node, time, scale, window } => self.render(*node, *time, *scale, *window),
            Step::Region { node, scale } => {
                let node = self.node(*node);
                self.host.region(node, *scale);
            }
            Step::Interest { node, part } => {
                let node = self.node(*node);
                self.host.interest(node, *part);
            }
            Step::Ask { node, action, args } => {
                let node = self.node(*node);
                let args = args.iter().take(8).map(|(name, values)| {
                    (pick(&PROPERTIES, *name), values.iter().take(4).map(|any| (*any).into()).collect())
                });
                self.host.ask(pick(&ACTIONS, *action), node.0, args.collect());
            }
            Step::Overlay { node, pixel, pens } => self.overlay(*node, *pixel, pens),
            Step::AbortAt(question) => _ = self.host.abort_at(question.map(u32::from)),
        }
    }
}

libfuzzer_sys::fuzz_target!(|traffic: Traffic| {
    let mut session = Session::new(&traffic);
    for step in traffic.steps.iter().take(LIMITS[1]) {
        session.take(step);
    }
    session.host.abort_at(None);
    session.host.forgive_open_edits();
    session.host.finish();
});
