//! The brush for stiffness: strokes over the model, which become entries of its layer.
//!
//! In: the pen's way, the worker's answers about what lies under it. Out: one document change per stroke.

use super::gesture::{Gesture, PaintedLine, Painting};
use super::{Purpose, Session};
use crate::edit::worker::Question;
use crate::pipeline::{BrushPoint, PaintedPlace, StiffTriangle};
use crate::shot::edit::{add_stroke, remove_strokes};
use crate::shot::{BrushStroke, Shot, Source};
use crate::space::ScreenPoint;
use std::sync::Arc;

/// Minimum and maximum radius of the brush, in frame heights.
pub(crate) const BRUSH_RADII: [f64; 2] = [0.003, 0.5];

/// Minimum and maximum stiffness that the brush paints.
pub(crate) const BRUSH_STIFFNESSES: [f64; 2] = [0.01, 100.0];

/// Distance between two points of a stroke, in radii of the brush.
const SPACING: f64 = 0.3;

/// Number of points of a stroke that one movement of the pen adds at most.
const MAX_POINTS: usize = 48;

/// Distance on the model, in radii of the brush, from which two points belong to different strokes.
const APART: f64 = 2.0;

/// The settings of the brush.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Brush {
    /// Its radius in frame heights.
    pub radius: f64,
    /// The stiffness that it paints; 1 is that of the rest.
    pub stiffness: f64,
}

impl Default for Brush {
    fn default() -> Self {
        Self { radius: 0.04, stiffness: 8.0 }
    }
}

/// The painted triangles of a frame.
#[derive(Clone, Debug)]
pub(crate) struct PaintedFrame {
    frame: i32,
    triangles: Arc<[StiffTriangle]>,
}

impl Session {
    /// Begins a stroke of the brush.
    pub(super) fn begin_stroke(&mut self, at: ScreenPoint, erases: bool) {
        if matches!(self.document.shot().source, Source::Frame) {
            return self.say("A plate alone has no model to paint: add the scene that it shows to the shot.");
        }
        self.next_question += 1;
        self.gesture = Gesture::Paint(Painting {
            id: self.next_question,
            line: PaintedLine::default(),
            mirrored: PaintedLine::default(),
            layer: None,
            value: if erases { 1.0 } else { self.brush.stiffness },
            asked_at: at,
            way: Vec::new(),
            waiting: 0,
            is_up: false,
            base: Arc::new(self.document.shot().clone()),
        });
        self.ask_under_brush(&[at]);
    }

    /// Goes on with a stroke.
    pub(super) fn stroke_to(&mut self, to: ScreenPoint) {
        let Gesture::Paint(painting) = &self.gesture else { return };
        let from = painting.asked_at;
        let steps = ((to - from).0.length() / (SPACING * self.brush.radius)).floor() as usize;
        let count = steps.min(MAX_POINTS);
        let points: Vec<ScreenPoint> =
            (1..=count).map(|step| ScreenPoint(from.0.lerp(to.0, step as f64 / count as f64))).collect();
        self.ask_under_brush(&points);
    }

    fn ask_under_brush(&mut self, points: &[ScreenPoint]) {
        let (frame, mirrors) = (self.playhead.frame(), self.mirrors);
        let Gesture::Paint(painting) = &mut self.gesture else { return };
        for &at in points {
            painting.asked_at = at;
            painting.way.push(at);
            painting.waiting += 1;
            self.worker.ask(Question::Brush { id: painting.id, frame, at, mirrors });
        }
    }

    /// Takes the worker's answer about what lies under the brush, and on the other side of the model.
    pub(super) fn brushed(&mut self, id: u64, point: Option<(BrushPoint, Option<PaintedPlace>)>) {
        let radius = self.brush.radius;
        let own = if let Gesture::Paint(painting) = &mut self.gesture { Some(painting) } else { None };
        let own = own.filter(|painting| painting.id == id);
        let is_own = own.is_some();
        let Some(painting) = own.or_else(|| self.overtaken.stroke_mut(id)) else { return };
        painting.waiting = painting.waiting.saturating_sub(1);
        match point.filter(|(point, _)| painting.layer.is_none_or(|layer| layer == point.layer)) {
            None => (painting.line.goes_on, painting.mirrored.goes_on) = (false, false),
            Some((point, mirrored)) => {
                painting.layer = Some(point.layer);
                let (radius, value) = (rounded(radius * point.per_height), painting.value);
                painting.line.add(Some(&point.place), radius, value);
                painting.mirrored.add(mirrored.as_ref(), radius, value);
                if is_own {
                    self.show_painting();
                }
            }
        }
        if let Some(painting) = self.overtaken.take_answered_stroke() {
            self.write_stroke(painting);
        }
        self.end_stroke();
    }

    /// Shows the layer with the stroke as far as it goes.
    fn show_painting(&mut self) {
        let Gesture::Paint(Painting { layer: Some(layer), line, mirrored, base, .. }) = &self.gesture else { return };
        let mut shot = Shot::clone(base);
        let Some(own) = shot.layers.get_mut(*layer) else { return };
        own.strokes.extend(line.strokes.iter().chain(&mirrored.strokes).cloned());
        if self.dragged.is_none() {
            self.revision += 1;
        }
        self.dragged = Some(Arc::new(shot));
        self.refresh(Purpose::Paint);
    }

    /// Writes the stroke into the document once the pen is up and every question is answered.
    pub(super) fn end_stroke(&mut self) {
        let Gesture::Paint(Painting { is_up: true, waiting: 0, .. }) = self.gesture else { return };
        let Gesture::Paint(painting) = std::mem::replace(&mut self.gesture, Gesture::Idle) else { return };
        self.write_stroke(painting);
    }

    /// Writes a stroke whose questions are all answered into the document.
    fn write_stroke(&mut self, painting: Painting) {
        let Painting { line, mirrored, layer, value, .. } = painting;
        let named = layer.and_then(|layer| Some((layer, self.document.shot().layers.get(layer)?)));
        let Some((layer, owner)) = named.filter(|_| !line.strokes.is_empty()) else {
            return self.say("No layer's surface lies under the brush: paint over the model.");
        };
        if value == 1.0 && owner.strokes.is_empty() {
            self.let_go();
            return self.say("Nothing is painted there.");
        }
        let mut text = Ok(self.document.text().to_owned());
        for stroke in line.strokes.iter().chain(&mirrored.strokes) {
            text = text.and_then(|text| add_stroke(&text, &owner.name, stroke));
        }
        let label = if value == 1.0 { "Erase stiffness" } else { "Paint stiffness" };
        self.selection.layer = layer;
        self.document.end_series();
        if self.change(label, text, None) && self.mirrors && mirrored.strokes.is_empty() {
            self.say("Only this side is painted: the layer's model has no other side there.");
        }
    }

    /// Removes all that was painted on the selected layer.
    pub(crate) fn clear_painting(&mut self) {
        let Some(layer) = self.document.shot().layers.get(self.selection.layer) else { return };
        if layer.strokes.is_empty() {
            return self.say("Nothing is painted on this layer.");
        }
        let text = remove_strokes(self.document.text(), &layer.name);
        self.change("Remove painting", text, None);
    }

    /// Returns whether the brush is painting.
    #[must_use]
    pub(crate) const fn is_painting(&self) -> bool {
        matches!(self.gesture, Gesture::Paint(_))
    }

    /// Returns the way of the brush on the screen while it paints, and the stiffness that it paints.
    #[must_use]
    pub(crate) fn painted_way(&self) -> (&[ScreenPoint], f64) {
        if let Gesture::Paint(painting) = &self.gesture { (&painting.way, painting.value) } else { (&[], 1.0) }
    }

    /// Returns the centre of the brush while it is sized.
    #[must_use]
    pub(crate) const fn sized_brush(&self) -> Option<ScreenPoint> {
        if let Gesture::BrushSize { center } = self.gesture { Some(center) } else { None }
    }

    /// Requests the painted triangles of the shown frame, unless they are known.
    pub(crate) fn want_painted(&mut self) {
        let now = (self.revision, self.playhead.frame());
        let is_solved = self.current_solve.as_ref().is_some_and(|solve| (solve.revision, solve.frame) == now);
        if is_solved && self.gesture.is_idle() && self.painted_asked != Some(now) {
            self.painted_asked = Some(now);
            self.worker.ask(Question::Painted { revision: now.0, frame: now.1 });
        }
    }

    /// Takes the painted triangles of a frame.
    pub(super) fn take_painted(&mut self, (revision, frame): (u64, i32), triangles: Vec<StiffTriangle>) {
        if revision == self.revision {
            self.painted = Some(PaintedFrame { frame, triangles: triangles.into() });
        }
    }

    /// Returns the painted triangles of the shown frame; those of the shot before the last change until newer ones are known.
    #[must_use]
    pub(crate) fn painted(&self) -> &[StiffTriangle] {
        let known = self.painted.as_ref().filter(|painted| painted.frame == self.playhead.frame());
        known.map_or(&[], |painted| &painted.triangles)
    }
}

impl PaintedLine {
    /// Appends a place, to the last stroke if it is near enough; `None` interrupts the line.
    fn add(&mut self, place: Option<&PaintedPlace>, radius: f64, value: f64) {
        let goes_on = std::mem::replace(&mut self.goes_on, place.is_some());
        let Some(place) = place else { return };
        let far = |stroke: &BrushStroke| {
            let last = stroke.points.last().map_or([f64::INFINITY; 3], |&last| last);
            let square: f64 = last.iter().zip(place.at).map(|(a, b)| (a - b).powi(2)).sum();
            square.sqrt() > APART * stroke.radius
        };
        if !goes_on || self.strokes.last().is_none_or(far) {
            self.strokes.push(BrushStroke { nodes: Vec::new(), points: Vec::new(), radius, value });
        }
        let Some(stroke) = self.strokes.last_mut() else { return };
        if !stroke.nodes.contains(&place.node) {
            stroke.nodes.push(place.node.clone());
        }
        let fine = stroke.radius / 100.0;
        stroke.points.push(place.at.map(|x| rounded((x / fine).round() * fine)));
    }
}

/// Rounds to five significant digits.
fn rounded(value: f64) -> f64 {
    let power = 10.0_f64.powi(4 - value.abs().max(1e-9).log10().floor() as i32);
    (value * power).round() / power
}

#[cfg(test)]
mod tests {
    use super::rounded;

    #[test]
    fn numbers_are_short_and_near() {
        for (value, short) in [(0.123_456_78, 0.123_46), (-1234.5678, -1234.6), (0.0, 0.0), (3e-7, 3e-7)] {
            assert!((rounded(value) - short).abs() <= 1e-9_f64.max(short.abs() * 1e-9), "{value}: {}", rounded(value));
        }
    }
}
