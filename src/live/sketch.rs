//! The lattice, pins and their targets as lines over the picture, the same in every viewer.
//!
//! In: a [`Warp`], the pins, which of them are chosen. Out: [`Stroke`]s in the units of the viewer's [`Canvas`].

use super::{Canvas, Controls, Picker, Warp};

/// Half the size of a handle, pixels of the screen.
const HALF_PX: f64 = 4.0;
/// Pieces in which a cell's side is drawn.
const PIECES: usize = 6;
const GRID: [f32; 4] = [0.55, 0.75, 1.0, 0.45];
const REST: [f32; 4] = [0.95, 0.95, 0.95, 0.9];
const TARGET: [f32; 4] = [1.0, 0.6, 0.1, 1.0];
const CHOSEN: [f32; 4] = [0.3, 1.0, 0.4, 1.0];

/// A line through points of the viewer.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// In units of the canvas.
    pub points: Vec<[f64; 2]>,
    /// Red, green, blue, opacity.
    pub colour: [f32; 4],
    /// Pixels of the screen.
    pub width: f32,
}

/// A pin as it is shown: over a shot it is where the model takes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dot {
    /// Its number, whatever the viewer counts by.
    pub pin: usize,
    /// Where its point is before the warp, in units of the canvas.
    pub rest: [f64; 2],
    /// Where it goes.
    pub target: [f64; 2],
}

/// A viewer over the picture.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// The picture under it.
    pub canvas: Canvas,
    /// Size of a pixel of the screen in units of the canvas, across and up.
    pub pixel: [f64; 2],
}

impl View {
    /// The pins of `controls` with their `numbers`, where they are shown. `warp`: that of these controls, if there is one.
    #[must_use]
    pub fn dots(&self, controls: &Controls, numbers: &[usize], warp: Option<&Warp>) -> Vec<Dot> {
        let ends = |index: usize| match warp.and_then(|warp| warp.pins.get(index)) {
            Some(pin) => [pin.rest, pin.target],
            None => [controls.pins[index].rest, controls.pins[index].target],
        };
        let dot = |(index, pin): (usize, &usize)| {
            let [rest, target] = ends(index).map(|point| self.canvas.canonical(point));
            Dot { pin: *pin, rest, target }
        };
        numbers.iter().take(controls.pins.len()).enumerate().map(dot).collect()
    }

    /// What is drawn, the lowest first: the lattice after the warp, pins as crosses, targets as squares, the box that is
    /// being drawn.
    #[must_use]
    pub fn sketch(&self, warp: Option<&Warp>, dots: &[Dot], picker: &Picker) -> Vec<Stroke> {
        let lines = warp.map(|warp| warp.grid_lines(PIECES)).unwrap_or_default();
        let grid = lines
            .iter()
            .map(|line| stroke(line.moved.iter().map(|at| self.canvas.canonical(*at)).collect(), GRID, 1.0));
        let marks =
            dots.iter().flat_map(|dot| self.marks(dot, if picker.is_chosen(dot.pin) { CHOSEN } else { TARGET }));
        let drawn = picker.corners().map(|corners| outline(corners, CHOSEN, 1.0));
        grid.chain(marks).chain(drawn).collect()
    }

    fn marks(&self, dot: &Dot, colour: [f32; 4]) -> [Stroke; 4] {
        let half = self.pixel.map(|size| size * HALF_PX);
        let around = |[x, y]: [f64; 2]| [[x - half[0], y - half[1]], [x + half[0], y + half[1]]];
        let [[x1, y1], [x2, y2]] = around(dot.rest);
        [
            stroke(vec![dot.rest, dot.target], colour, 1.0),
            stroke(vec![[x1, y1], [x2, y2]], REST, 1.5),
            stroke(vec![[x1, y2], [x2, y1]], REST, 1.5),
            outline(around(dot.target), colour, 2.0),
        ]
    }
}

fn stroke(points: Vec<[f64; 2]>, colour: [f32; 4], width: f32) -> Stroke {
    Stroke { points, colour, width }
}

/// The outline of a box with these opposite corners.
fn outline([[x1, y1], [x2, y2]]: [[f64; 2]; 2], colour: [f32; 4], width: f32) -> Stroke {
    stroke(vec![[x1, y1], [x2, y1], [x2, y2], [x1, y2], [x1, y1]], colour, width)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::live::{Choosing, Pin};
    use crate::space::ScreenPoint;

    #[test]
    fn pins_are_crosses_and_targets_are_squares() {
        let controls = Controls {
            pins: vec![Pin::new(ScreenPoint::new(0.1, 0.2), ScreenPoint::new(0.5, 0.2))],
            ..Controls::default()
        };
        let view = View { canvas: Canvas::new([0.0, 0.0, 200.0, 100.0], 1.0, [1.0, 1.0]), pixel: [0.5, 0.25] };
        let dots = view.dots(&controls, &[7], None);
        assert_eq!(dots, [Dot { pin: 7, rest: [10.0, 20.0], target: [50.0, 20.0] }]);
        let mut picker = Picker::default();
        let strokes = view.sketch(None, &dots, &picker);
        assert_eq!(strokes.len(), 4);
        assert_eq!(strokes[1].points, [[8.0, 19.0], [12.0, 21.0]]);
        assert_eq!((strokes[3].points.len(), strokes[3].colour), (5, TARGET));
        picker.press([50.0, 20.0], &[(7, dots[0].target)], [1.0, 1.0], Choosing::Anew);
        assert_eq!(view.sketch(None, &dots, &picker)[3].colour, CHOSEN);
        picker.press([0.0, 0.0], &[], [1.0, 1.0], Choosing::Anew);
        picker.motion([3.0, 4.0]);
        let drawn = view.sketch(None, &dots, &picker);
        assert_eq!(drawn[4].points[2], [3.0, 4.0], "the box that is drawn comes last");
    }
}
