//! Overlay lines for the lattice, pins and targets, the same in every viewer.
//!
//! In: a [`Warp`], the pins and the selection. Out: [`Stroke`]s in the units of the viewer's [`HostFrame`].

use super::{Controls, GridLine, HostFrame, Picker, Warp};
use crate::space::ScreenPoint;

/// Half the size of a handle, in screen pixels.
const HALF_PX: f64 = 4.0;
/// Line segments per side of a cell.
const PIECES: usize = 6;
const GRID: [f32; 4] = [0.55, 0.75, 1.0, 0.45];
const FOLD: [f32; 4] = [1.0, 0.1, 0.1, 0.9];
const EVEN: [f32; 4] = [0.7, 0.7, 0.7, 0.5];
const SHRUNK: [f32; 4] = [0.1, 0.4, 1.0, 0.9];
const STRETCHED: [f32; 4] = [1.0, 0.45, 0.0, 0.9];
const REST: [f32; 4] = [0.95, 0.95, 0.95, 0.9];
const TARGET: [f32; 4] = [1.0, 0.6, 0.1, 1.0];
const CHOSEN: [f32; 4] = [0.3, 1.0, 0.4, 1.0];

/// A polyline of the overlay.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Stroke {
    /// Points, in units of the host frame.
    pub(crate) points: Vec<[f64; 2]>,
    /// Red, green, blue, opacity.
    pub(crate) colour: [f32; 4],
    /// Line width, in screen pixels.
    pub(crate) width: f32,
}

/// How the lattice is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LatticeStyle {
    /// In a single colour.
    Plain,
    /// Coloured by stretch.
    Stretch,
    /// Not drawn.
    Hidden,
}

/// A pin as displayed; with a shot, at the position of the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PinMark {
    /// Number of the pin, in the viewer's numbering.
    pub(crate) pin: usize,
    /// Position before the warp, in units of the host frame.
    pub(crate) rest: [f64; 2],
    /// Target position.
    pub(crate) target: [f64; 2],
}

/// A viewer that shows the picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Viewer {
    /// The displayed picture.
    pub(crate) host_frame: HostFrame,
    /// Width and height of a screen pixel, in units of the host frame.
    pub(crate) pixel: [f64; 2],
}

impl Viewer {
    /// Returns the pins of `controls` with their `numbers`, at their displayed positions. `warp`: the warp of these
    /// controls, if available.
    #[must_use]
    pub(crate) fn marks(&self, controls: &Controls, numbers: &[usize], warp: Option<&Warp>) -> Vec<PinMark> {
        let ends = |index: usize| match warp.and_then(|warp| warp.pins.get(index)) {
            Some(pin) => [pin.rest, pin.target],
            None => [controls.pins[index].rest, controls.pins[index].target],
        };
        let mark = |(index, pin): (usize, &usize)| {
            let [rest, target] = ends(index).map(|point| self.host_frame.canonical(point));
            PinMark { pin: *pin, rest, target }
        };
        numbers.iter().take(controls.pins.len()).enumerate().map(mark).collect()
    }

    /// Returns the warped lattice, and the outlines of folded cells.
    #[must_use]
    pub(crate) fn lattice(&self, warp: Option<&Warp>, style: LatticeStyle) -> Vec<Stroke> {
        let Some(warp) = warp.filter(|_| style != LatticeStyle::Hidden) else { return Vec::new() };
        let lines = warp.grid_lines(PIECES);
        let mut strokes: Vec<Stroke> = match style {
            LatticeStyle::Stretch => lines.iter().flat_map(|line| self.stretched(line)).collect(),
            _ => lines.iter().map(|line| stroke(self.canonical(&line.moved), GRID, 1.0)).collect(),
        };
        let closed = |outline: &Vec<ScreenPoint>| outline.iter().chain(outline.first()).copied().collect::<Vec<_>>();
        strokes.extend(warp.folds.iter().map(|outline| stroke(self.canonical(&closed(outline)), FOLD, 2.0)));
        strokes
    }

    /// Returns pins as crosses, targets as squares, and the selection box.
    #[must_use]
    pub(crate) fn pins(&self, marks: &[PinMark], picker: &Picker) -> Vec<Stroke> {
        let colour = |mark: &PinMark| if picker.is_selected(mark.pin) { CHOSEN } else { TARGET };
        let pins = marks.iter().flat_map(|mark| self.strokes_of(mark, colour(mark)));
        pins.chain(picker.corners().map(|corners| outline(corners, CHOSEN, 1.0))).collect()
    }

    fn canonical(&self, points: &[ScreenPoint]) -> Vec<[f64; 2]> {
        points.iter().map(|point| self.host_frame.canonical(*point)).collect()
    }

    /// Splits a line into segments, coloured by their length relative to that before the warp.
    fn stretched(&self, line: &GridLine) -> Vec<Stroke> {
        let [rest, moved] = [&line.rest, &line.moved].map(|points| points.windows(2));
        let pieces = rest.zip(moved).map(|(rest, moved)| {
            let [before, after] = [rest, moved].map(|ends| (ends[1] - ends[0]).0.length());
            stroke(self.canonical(moved), stretch_colour(after / before), 1.5)
        });
        pieces.collect()
    }

    fn strokes_of(&self, mark: &PinMark, colour: [f32; 4]) -> [Stroke; 4] {
        let half = self.pixel.map(|size| size * HALF_PX);
        let around = |[x, y]: [f64; 2]| [[x - half[0], y - half[1]], [x + half[0], y + half[1]]];
        let [[x1, y1], [x2, y2]] = around(mark.rest);
        [
            stroke(vec![mark.rest, mark.target], colour, 1.0),
            stroke(vec![[x1, y1], [x2, y2]], REST, 1.5),
            stroke(vec![[x1, y2], [x2, y1]], REST, 1.5),
            outline(around(mark.target), colour, 2.0),
        ]
    }
}

/// Maps a length ratio to a colour, from blue (half or less) through grey to orange (twice or more).
fn stretch_colour(ratio: f64) -> [f32; 4] {
    let share = ratio.max(1e-9).log2().clamp(-1.0, 1.0) as f32;
    let end = if share < 0.0 { SHRUNK } else { STRETCHED };
    std::array::from_fn(|channel| EVEN[channel] + (end[channel] - EVEN[channel]) * share.abs())
}

fn stroke(points: Vec<[f64; 2]>, colour: [f32; 4], width: f32) -> Stroke {
    Stroke { points, colour, width }
}

/// Returns the outline of a box given by opposite corners.
fn outline([[x1, y1], [x2, y2]]: [[f64; 2]; 2], colour: [f32; 4], width: f32) -> Stroke {
    stroke(vec![[x1, y1], [x2, y1], [x2, y2], [x1, y2], [x1, y1]], colour, width)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::live::{Coverage, Moved, Pin, SelectMode, ShapeSource, warp};

    fn viewer() -> Viewer {
        Viewer { host_frame: HostFrame::new([0.0, 0.0, 200.0, 100.0], 1.0, [1.0, 1.0]), pixel: [0.5, 0.25] }
    }

    fn controls(target: [f64; 2]) -> Controls {
        let pin = Pin::new(ScreenPoint::new(0.5, 0.2), ScreenPoint::new(target[0], target[1]));
        let held = ScreenPoint::new(1.5, 0.8);
        Controls { pins: vec![pin, Pin::new(held, held)], ..Controls::default() }
    }

    #[test]
    fn pins_are_crosses_and_targets_are_squares() {
        let controls = Controls { pins: vec![controls([0.7, 0.2]).pins[0]], ..Controls::default() };
        let marks = viewer().marks(&controls, &[7], None);
        assert_eq!(marks, [PinMark { pin: 7, rest: [50.0, 20.0], target: [70.0, 20.0] }]);
        let mut picker = Picker::default();
        let strokes = viewer().pins(&marks, &picker);
        assert_eq!(strokes.len(), 4);
        assert_eq!(strokes[1].points, [[48.0, 19.0], [52.0, 21.0]]);
        assert_eq!((strokes[3].points.len(), strokes[3].colour), (5, TARGET));
        picker.press([70.0, 20.0], &[(7, marks[0].target)], [1.0, 1.0], SelectMode::Replace);
        assert_eq!(viewer().pins(&marks, &picker)[3].colour, CHOSEN);
        picker.press([0.0, 0.0], &[], [1.0, 1.0], SelectMode::Replace);
        picker.motion([3.0, 4.0]);
        assert_eq!(viewer().pins(&marks, &picker)[4].points[2], [3.0, 4.0], "the box that is drawn comes last");
    }

    #[test]
    fn cells_without_a_part_of_the_shape_are_not_outlined() {
        // Two squares at the ends of the picture change places through what is empty between them.
        let frame = viewer().host_frame.frame;
        let (window, aspect) = (frame.window(), frame.aspect());
        let is_opaque = |k: u32| {
            let [x, y] = [k % window.width, k / window.width];
            let is_within = 3 * y > window.height && 3 * y < 2 * window.height;
            is_within && (8 * x < window.width || 8 * x > 7 * window.width)
        };
        let alpha: Vec<f32> = (0..window.width * window.height).map(|k| f32::from(u8::from(is_opaque(k)))).collect();
        let shape = ShapeSource::Coverage(Coverage { window, alpha: &alpha });
        let pin = |from: f64, to: f64, y: f64| Pin::new(ScreenPoint::new(from, y), ScreenPoint::new(to, y));
        let ends = [[0.12, aspect - 0.12], [aspect - 0.12, 0.12]];
        let mut pins: Vec<Pin> =
            ends.into_iter().flat_map(|[from, to]| [pin(from, to, 0.4), pin(from, to, 0.6)]).collect();
        // The left square is mirrored, so that it folds, too.
        pins.extend([pin(0.06, aspect - 0.06, 0.5), pin(0.18, aspect - 0.18, 0.5)]);
        let controls = Controls { dims: [24, 12], pins, moved: Moved::Masked, ..Controls::default() };
        let found = warp(&controls, &shape, frame).expect("solves");
        let all = found.lattice.as_ref().map_or(0, |lattice| lattice.folded_cells().len());
        let cells = found.report.as_ref().map_or(0, |report| report.folded_model_cells);
        assert!(found.folds.len() == cells && cells < all, "{} of {all}, {cells} of the shape", found.folds.len());
    }

    #[test]
    fn folds_are_outlined_and_stretch_is_coloured() {
        let frame = viewer().host_frame.frame;
        // Two pins swap places; a whole picture with a fixed border would not fold.
        let swapped = [[0.6, 1.4], [1.4, 0.6], [0.05, 0.05], [1.95, 1.95]]
            .map(|[rest, target]| Pin::new(ScreenPoint::new(rest, 0.5), ScreenPoint::new(target, 0.5)));
        let crossed = Controls { pins: swapped.to_vec(), moved: Moved::Masked, ..Controls::default() };
        let [calm, folded] = [controls([0.6, 0.2]), crossed]
            .map(|controls| warp(&controls, &ShapeSource::Frame, frame).expect("solves"));
        let is_red = |stroke: &Stroke| stroke.colour == FOLD;
        assert!(!viewer().lattice(Some(&calm), LatticeStyle::Plain).iter().any(is_red));
        assert!(viewer().lattice(Some(&folded), LatticeStyle::Plain).iter().any(is_red));
        let cells = folded.report.as_ref().map(|report| report.folded_model_cells);
        assert_eq!(Some(folded.folds.len()), cells);
        let strokes = viewer().lattice(Some(&calm), LatticeStyle::Stretch);
        let [most, least] = [f32::max, f32::min].map(|pick| strokes.iter().map(|line| line.colour[0]).reduce(pick));
        assert!(most > Some(EVEN[0] + 0.05) && least < Some(EVEN[0] - 0.05), "{most:?} {least:?}");
        assert!(viewer().lattice(Some(&folded), LatticeStyle::Hidden).is_empty());
        let near = |a: [f32; 4], b: [f32; 4]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
        let found = [0.25, 1.0, 4.0].map(stretch_colour);
        assert!(found.iter().zip([SHRUNK, EVEN, STRETCHED]).all(|(found, end)| near(*found, end)), "{found:?}");
    }
}
