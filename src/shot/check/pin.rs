//! Validates `[[layer.pin]]` and `[[layer.handle]]`: anchors, keys, units.
//!
//! In: raw pins and handles. Out: [`Pin`]s and [`HandleTrack`]s, each with at least one key.

use super::connectivity::SHAPE_HINT;
use super::place::PinKind;
use super::{Check, Kind, LayerDefaults};
use crate::shot::raw::{RawAnchor, RawHandle, RawOrder, RawOrderKey, RawPin, RawSpace};
use crate::shot::{Anchor, Ease, Goal, HandleKey, HandleTrack, OrderKey, Pin, PinKey};
use crate::space::{ScreenPoint, ScreenVector};
use crate::spelling::number;

/// Magnitude in frame heights (or box sizes) above which a number must have been meant as pixels.
const LARGEST_COORDINATE: f64 = 32.0;

/// Magnitude in widths of the frame up to which a number in frame heights is never taken for pixels.
const WIDTHS_BEYOND: f64 = 2.0;

/// Allowed deviation of the sum of barycentric weights from 1: they are often written by hand with three digits.
const BARYCENTRIC_TOLERANCE: f64 = 1e-3;

impl Check<'_> {
    pub(super) fn pins(&mut self, raw: Vec<RawPin>, layer: &str, shot: &LayerDefaults) -> Vec<Pin> {
        let key = |index: usize| format!("{layer}.pin[{index}]");
        let pins: Vec<Pin> = raw
            .into_iter()
            .enumerate()
            .map(|(index, raw)| {
                let (key, kind) = (key(index), PinKind::of(&raw, shot));
                Pin {
                    anchor: self.anchor_of(&raw, &format!("{key}.anchor"), shot),
                    mirror: None,
                    unit: raw.unit,
                    region: raw.region.map(|region| self.region(&region, &format!("{key}.region"), (raw.unit, shot))),
                    weight: raw.weight.unwrap_or(1.0),
                    is_muted: raw.mute,
                    order: self.order(raw.order.as_ref(), &format!("{key}.order"), shot),
                    keys: self.pin_keys(&raw, &format!("{key}.keys"), &kind),
                    rotate_keys: self.rotate_keys(&raw, &key, &kind),
                    scale_keys: self.scale_keys(&raw, &key),
                    name: raw.name.unwrap_or_else(|| format!("pin{}", index + 1)),
                }
            })
            .collect();
        let names = pins.iter().enumerate().map(|(index, pin)| (format!("{}.name", key(index)), pin.name.as_str()));
        self.unique(names, "pin of this layer");
        pins
    }

    /// Returns the anchor of a pin. That of a mirrored pin without one is replaced later.
    fn anchor_of(&mut self, raw: &RawPin, key: &str, shot: &LayerDefaults) -> Anchor {
        match &raw.anchor {
            Some(anchor) => self.anchor(anchor, key, shot),
            None => {
                if raw.mirror.is_none() {
                    let hint = "give { screen = [x, y], frame = .. }, or write what `pinwarp pick` prints";
                    self.fault(key, "is missing", hint);
                }
                Anchor::Screen { at: ScreenPoint::default(), frame: None }
            }
        }
    }

    fn anchor(&mut self, raw: &RawAnchor, key: &str, shot: &LayerDefaults) -> Anchor {
        match (raw.screen, &raw.node) {
            (Some(at), _) => self.screen_anchor(raw, at, key, shot),
            (None, Some(node)) => self.surface_anchor(raw, node, key),
            (None, None) => {
                let hint = "give { screen = [x, y] } or { node = \"..\", triangle = .., barycentric = [..] }, \
                            as `pinwarp pick` prints it";
                self.fault(key, "is neither a point of the screen nor of a surface", hint);
                Anchor::Screen { at: ScreenPoint::default(), frame: raw.frame }
            }
        }
    }

    fn screen_anchor(&mut self, raw: &RawAnchor, at: [f64; 2], key: &str, shot: &LayerDefaults) -> Anchor {
        let surface_keys = ["node", "primitive", "triangle", "barycentric", "rest"];
        for other in surface_keys.map(|other| format!("{key}.{other}")) {
            if self.document.has(&other) {
                self.fault(&other, "an anchor is on the screen or on a surface, not both", "remove it or `screen`");
            }
        }
        self.screen_unit(&at, &format!("{key}.screen"), shot);
        if shot.space == RawSpace::World && raw.frame.is_none() {
            let hint = format!("add frame = {}, or write what `pinwarp pick` prints", shot.reference_frame);
            self.fault(key, "a world layer's pins hold points of the model, this is a point of the screen", hint);
        }
        Anchor::Screen { at: ScreenPoint::new(at[0], at[1]), frame: raw.frame }
    }

    fn surface_anchor(&mut self, raw: &RawAnchor, node: &str, key: &str) -> Anchor {
        if raw.frame.is_some() {
            let hint = "remove it, or give `screen` instead of `node`";
            self.fault(&format!("{key}.frame"), "a point of a surface needs no frame to be cast in", hint);
        }
        let hint = "write what `pinwarp pick` prints, or { screen = [x, y], frame = .. }";
        if raw.triangle.is_none() {
            self.fault(&format!("{key}.triangle"), "is missing", hint);
        }
        if raw.barycentric.is_none() {
            self.fault(&format!("{key}.barycentric"), "is missing", hint);
        }
        let barycentric = raw.barycentric.unwrap_or([1.0, 0.0, 0.0]);
        Anchor::Surface {
            node: node.to_owned(),
            primitive: raw.primitive.unwrap_or(0),
            triangle: raw.triangle.unwrap_or(0),
            barycentric: self.barycentric(barycentric, &format!("{key}.barycentric")),
            rest: raw.rest,
        }
    }

    /// Returns the weights, normalised to sum to 1 (up to rounding).
    fn barycentric(&mut self, weights: [f64; 3], key: &str) -> [f64; 3] {
        let sum: f64 = weights.iter().sum();
        if (sum - 1.0).abs() > BARYCENTRIC_TOLERANCE {
            self.fault(key, format!("the weights sum to {}, not 1", number(sum)), "divide each by their sum");
        } else if weights.iter().any(|&weight| weight < -BARYCENTRIC_TOLERANCE) {
            self.fault(key, "a negative weight lies outside the triangle", "pick the triangle that holds the point");
        }
        let weights = weights.map(|weight| weight.max(0.0));
        let sum: f64 = weights.iter().sum();
        weights.map(|weight| weight / sum)
    }

    /// Returns the order of a pin or of a part.
    pub(super) fn order(&mut self, raw: Option<&RawOrder>, key: &str, shot: &LayerDefaults) -> Vec<OrderKey> {
        let Some(raw) = raw else { return Vec::new() };
        if shot.source != Kind::Images {
            let (what, hint) = match shot.source {
                Kind::Frame => ("the parts of a plate have no shape that could overlap", SHAPE_HINT),
                _ => ("in a scene parts lie in front of each other by their depth", "remove it, or warp an `image`"),
            };
            self.fault(key, what, hint);
        }
        match raw {
            RawOrder::Always(value) => vec![OrderKey { frame: 0.0, value: *value }],
            RawOrder::Keys(keys) => {
                self.increasing(keys.iter().map(|key| key.frame), key);
                keys.iter().map(|&RawOrderKey { frame, value }| OrderKey { frame, value }).collect()
            }
        }
    }

    fn pin_keys(&mut self, raw: &RawPin, key: &str, kind: &PinKind) -> Vec<PinKey> {
        self.increasing(raw.keys.iter().map(|key| key.frame), key);
        let keys: Vec<PinKey> = raw
            .keys
            .iter()
            .enumerate()
            .map(|(index, raw_key)| {
                let key = format!("{key}[{index}]");
                self.ease(raw_key.ease, &key);
                PinKey {
                    frame: raw_key.frame,
                    goal: self.goal(raw_key, &key, kind),
                    rotate_degrees: raw_key.rotate.map(|rotate| self.rotation(rotate, &format!("{key}.rotate"), kind)),
                    scale: raw_key.scale,
                    ease: raw_key.ease,
                }
            })
            .collect();
        if keys.is_empty() { vec![resting_key(kind.shot)] } else { keys }
    }

    pub(super) fn handles(
        &mut self,
        raw: Vec<RawHandle>,
        layer: &str,
        dims: [usize; 3],
        shot: &LayerDefaults,
    ) -> Vec<HandleTrack> {
        let mut handles: Vec<HandleTrack> = Vec::with_capacity(raw.len());
        for (index, raw) in raw.into_iter().enumerate() {
            let key = format!("{layer}.handle[{index}]");
            let place = self.handle_index(&raw, dims, &key, shot);
            if handles.iter().any(|other| other.index == place) {
                let what = format!("handle {:?} is listed twice", raw.index);
                self.fault(&format!("{key}.index"), what, "keep one of them");
            }
            handles.push(HandleTrack { index: place, keys: self.handle_keys(&raw, &format!("{key}.keys"), shot) });
        }
        handles
    }

    fn handle_keys(&mut self, raw: &RawHandle, key: &str, shot: &LayerDefaults) -> Vec<HandleKey> {
        self.increasing(raw.keys.iter().map(|key| key.frame), key);
        let mut keys = Vec::with_capacity(raw.keys.len());
        for (index, raw_key) in raw.keys.iter().enumerate() {
            let key = format!("{key}[{index}]");
            self.ease(raw_key.ease, &key);
            let offset = self.handle_offset(&raw_key.offset, &key, shot);
            keys.push(HandleKey { frame: raw_key.frame, offset, ease: raw_key.ease });
        }
        if keys.is_empty() {
            keys.push(HandleKey { frame: f64::from(shot.reference_frame), offset: [0.0; 3], ease: Ease::Linear });
        }
        keys
    }

    pub(super) fn increasing(&mut self, frames: impl Iterator<Item = f64>, key: &str) {
        let frames: Vec<f64> = frames.collect();
        for (index, pair) in frames.windows(2).enumerate().filter(|(_, pair)| pair[1] <= pair[0]) {
            let what = format!("frame {} does not come after frame {} of the key before", pair[1], pair[0]);
            let hint = "put the keys in the order of their frames, one a frame";
            self.fault(&format!("{key}[{}].frame", index + 1), what, hint);
        }
    }

    pub(super) fn ease(&mut self, ease: Ease, key: &str) {
        let Ease::Bezier([x1, _, x2, _]) = ease else { return };
        if [x1, x2].iter().any(|x| !(0.0..=1.0).contains(x)) {
            let [x1, x2] = [x1, x2].map(number);
            let what = format!("the curve [x1, y1, x2, y2] runs back in time: x1 = {x1}, x2 = {x2}");
            self.fault(&format!("{key}.ease.bezier"), what, "keep x1 and x2 within 0 to 1");
        }
    }

    /// Reports numbers that cannot be in lattice box sizes.
    pub(super) fn box_unit(&mut self, values: &[f64], key: &str) {
        let Some(value) = values.iter().find(|value| value.abs() > LARGEST_COORDINATE) else { return };
        let hint = format!("offsets in box sizes stay within {LARGEST_COORDINATE}; 1 is the whole box");
        self.fault(key, format!("{} box sizes look like pixels", number(*value)), hint);
    }

    /// Reports numbers that cannot be in frame heights. In a long frame they may be as large as it is wide, or a few widths beyond.
    pub(super) fn screen_unit(&mut self, values: &[f64], key: &str, shot: &LayerDefaults) {
        let largest = LARGEST_COORDINATE.max(WIDTHS_BEYOND * shot.size.aspect());
        let Some(value) = values.iter().find(|value| value.abs() > largest) else { return };
        let height = shot.size.height;
        let in_heights = rounded(value / f64::from(height.max(1)));
        let [value, in_heights] = [*value, in_heights].map(number);
        let hint = format!("divide pixels by the height of the frame: {value} px of {height} is {in_heights}");
        self.fault(key, format!("{value} frame heights look like pixels"), hint);
    }
}

/// Rounds to four decimals; numbers so large that none of them counts stay as they are.
fn rounded(value: f64) -> f64 {
    if value.abs() < 1e9 { (value * 1e4).round() / 1e4 } else { value }
}

/// Returns the key of a pin without keys, which holds its position.
fn resting_key(shot: &LayerDefaults) -> PinKey {
    let goal = match shot.space {
        RawSpace::Screen => Goal::Offset(ScreenVector::default()),
        RawSpace::World => Goal::SceneOffset([0.0; 3]),
    };
    PinKey { frame: f64::from(shot.reference_frame), goal, rotate_degrees: None, scale: None, ease: Ease::Linear }
}
