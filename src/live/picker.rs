//! Selection and dragging of points in a viewer.
//!
//! In: the positions of the pen and of the points. Out: what changed. Units are those of the viewer.

use std::collections::BTreeSet;

/// What happens to the previous selection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SelectMode {
    /// It is replaced.
    Replace,
    /// It is extended (Shift is held).
    Add,
}

/// The result of a pen event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum PenResult {
    /// Nothing changed.
    Nothing,
    /// The selection or the selection box changed.
    SelectionChanged,
    /// The selected points are dragged by this much since the pen went down.
    Dragged([f64; 2]),
}

/// State of the pen.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Pen {
    Up,
    /// Dragging the selected points; where the pen went down.
    Drags([f64; 2]),
    /// Drawing a selection box; its corners.
    Boxes([[f64; 2]; 2]),
}

/// The selection and the pen state of one viewer.
#[derive(Clone, Debug)]
pub(crate) struct Picker {
    chosen: BTreeSet<usize>,
    pen: Pen,
}

impl Default for Picker {
    fn default() -> Self {
        Self { chosen: BTreeSet::new(), pen: Pen::Up }
    }
}

impl Picker {
    /// Pen down: starts a drag on the nearest point within `reach`, and otherwise a selection box.
    pub(crate) fn press(
        &mut self,
        at: [f64; 2],
        points: &[(usize, [f64; 2])],
        reach: [f64; 2],
        mode: SelectMode,
    ) -> PenResult {
        let distance = |point: [f64; 2]| ((point[0] - at[0]) / reach[0]).hypot((point[1] - at[1]) / reach[1]);
        let near = points.iter().filter(|(_, point)| distance(*point) <= 1.0);
        let Some((hit, _)) = near.min_by(|a, b| distance(a.1).total_cmp(&distance(b.1))) else {
            if mode == SelectMode::Replace {
                self.chosen.clear();
            }
            self.pen = Pen::Boxes([at, at]);
            return PenResult::SelectionChanged;
        };
        if mode == SelectMode::Replace && !self.chosen.contains(hit) {
            self.chosen.clear();
        }
        self.chosen.insert(*hit);
        self.pen = Pen::Drags(at);
        PenResult::SelectionChanged
    }

    /// Pen motion.
    pub(crate) fn motion(&mut self, at: [f64; 2]) -> PenResult {
        match &mut self.pen {
            Pen::Up => PenResult::Nothing,
            Pen::Drags(from) => PenResult::Dragged([at[0] - from[0], at[1] - from[1]]),
            Pen::Boxes(corners) => {
                corners[1] = at;
                PenResult::SelectionChanged
            }
        }
    }

    /// Pen up: adds the points in the box to the selection.
    pub(crate) fn release(&mut self, at: [f64; 2], points: &[(usize, [f64; 2])]) -> PenResult {
        let pull = self.motion(at);
        if let Pen::Boxes([a, b]) = self.pen {
            let holds = |point: [f64; 2]| (0..2).all(|axis| (point[axis] - a[axis]) * (point[axis] - b[axis]) <= 0.0);
            self.chosen.extend(points.iter().filter(|(_, point)| holds(*point)).map(|(id, _)| *id));
        }
        self.pen = Pen::Up;
        pull
    }

    /// Cancels a drag: returns [`PenResult::Dragged`] back to its start.
    pub(crate) fn cancel(&mut self) -> PenResult {
        match std::mem::replace(&mut self.pen, Pen::Up) {
            Pen::Up => PenResult::Nothing,
            Pen::Drags(_) => PenResult::Dragged([0.0, 0.0]),
            Pen::Boxes(_) => PenResult::SelectionChanged,
        }
    }

    /// Ends the pen action without moving the points; the selection stays.
    pub(crate) fn let_go(&mut self) {
        self.pen = Pen::Up;
    }

    /// Replaces the selection.
    pub(crate) fn choose(&mut self, ids: impl IntoIterator<Item = usize>) {
        self.chosen = ids.into_iter().collect();
    }

    /// Returns the selected points, in order.
    pub(crate) fn chosen(&self) -> impl Iterator<Item = usize> {
        self.chosen.iter().copied()
    }

    /// Whether a point is selected.
    #[must_use]
    pub(crate) fn is_selected(&self, id: usize) -> bool {
        self.chosen.contains(&id)
    }

    /// Whether the pen neither drags nor draws a box.
    #[must_use]
    pub(crate) fn is_up(&self) -> bool {
        self.pen == Pen::Up
    }

    /// Whether the pen drags points.
    #[must_use]
    pub(crate) fn is_dragging(&self) -> bool {
        matches!(self.pen, Pen::Drags(_))
    }

    /// Returns opposite corners of the selection box that is being drawn.
    #[must_use]
    pub(crate) fn corners(&self) -> Option<[[f64; 2]; 2]> {
        if let Pen::Boxes(corners) = self.pen { Some(corners) } else { None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINTS: [(usize, [f64; 2]); 3] = [(0, [0.0, 0.0]), (1, [4.0, 0.0]), (5, [40.0, 0.0])];

    fn chosen(picker: &Picker) -> Vec<usize> {
        picker.chosen().collect()
    }

    #[test]
    fn the_nearest_point_is_hit_and_a_chosen_one_takes_the_others_along() {
        let mut picker = Picker::default();
        picker.press([2.5, 0.0], &POINTS, [5.0, 5.0], SelectMode::Replace);
        assert_eq!(chosen(&picker), [1]);
        picker.release([2.5, 0.0], &POINTS);
        picker.press([40.0, 0.0], &POINTS, [5.0, 5.0], SelectMode::Add);
        picker.release([40.0, 0.0], &POINTS);
        picker.press([4.0, 0.0], &POINTS, [5.0, 5.0], SelectMode::Replace);
        assert_eq!((chosen(&picker), picker.motion([5.0, 1.0])), (vec![1, 5], PenResult::Dragged([1.0, 1.0])));
        assert_eq!((picker.cancel(), picker.motion([9.0, 9.0])), (PenResult::Dragged([0.0, 0.0]), PenResult::Nothing));
    }

    #[test]
    fn a_box_chooses_what_it_holds_in_any_direction() {
        let mut picker = Picker::default();
        picker.press([10.0, 8.0], &POINTS, [5.0, 5.0], SelectMode::Replace);
        assert_eq!(picker.motion([3.0, -1.0]), PenResult::SelectionChanged);
        assert_eq!(picker.corners(), Some([[10.0, 8.0], [3.0, -1.0]]));
        picker.release([3.0, -1.0], &POINTS);
        assert_eq!(chosen(&picker), [1]);
        picker.press([100.0, 8.0], &POINTS, [5.0, 5.0], SelectMode::Replace);
        picker.release([100.0, 8.0], &POINTS);
        assert!(chosen(&picker).is_empty(), "a click on nothing lets go");
    }

    #[test]
    fn a_press_selects_and_a_motion_drags() {
        use crate::live::{PenResult, Picker, SelectMode};
        let (mut picker, points) = (Picker::default(), [(7, [10.0, 10.0]), (9, [50.0, 10.0])]);
        assert_eq!(picker.press([11.0, 10.0], &points, [5.0, 5.0], SelectMode::Replace), PenResult::SelectionChanged);
        assert!(picker.is_selected(7) && !picker.is_selected(9));
        assert_eq!(picker.motion([31.0, 15.0]), PenResult::Dragged([20.0, 5.0]));
    }
}
