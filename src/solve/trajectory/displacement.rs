//! Displacements of a model from the rigid fit of its pins. They are the state of a knot, and start the solves of neighbouring
//! times. They are vectors in a frame that rotates with the model, so that a box that rotates about a model at rest leaves them
//! as they are.
//!
//! In: displacements of handles, or of copies of handles, and of points. Out: interpolated displacements, and displacements
//! assigned to other copies.

use crate::solve::branching::CopyName;
use crate::solve::linalg::small_matrix::distance;
use std::collections::BTreeMap;

/// Displacements of handles and points of the model from their images under the rigid fit of the pins.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Displacement<const D: usize> {
    /// Displacements of handles, #handles, or of copies, #copies.
    pub(crate) handles: Vec<[f64; D]>,
    /// Names of the copies; empty if every handle is one unknown.
    pub(crate) copies: Vec<CopyName>,
    /// Displacements of the points, #points.
    pub(crate) points: Vec<[f64; D]>,
    /// Angle of the box relative to the frame of the model, in radians. The handles are those of this box.
    pub(crate) box_angle: f64,
}

/// Largest difference of box angles, in radians, at which a handle of one box stands for the same handle of the other.
const SAME_HANDLES: f64 = 0.1;

impl<const D: usize> Displacement<D> {
    /// Linear interpolation (1 − t) · self + t · to, over the copies of `self`. A copy that `to` does not have keeps its
    /// displacement, and so do all if the box has rotated; a solve that starts from the result fits them to the points.
    pub(crate) fn interpolated(&self, to: &Self, t: f64) -> Self {
        let (points, box_angle) = (mix(&self.points, &to.points, t), self.box_angle);
        if !self.has_handles_of(to.box_angle) {
            return Self { points, ..self.clone() };
        }
        if self.copies == to.copies {
            return Self {
                handles: mix(&self.handles, &to.handles, t),
                copies: self.copies.clone(),
                points,
                box_angle,
            };
        }
        let known = to.handles_by_name(&self.copies, self.handles.len());
        let ends = self.handles.iter().zip(known).map(|(own, known)| known.unwrap_or(*own));
        let ends: Vec<_> = ends.collect();
        Self { handles: mix(&self.handles, &ends, t), copies: self.copies.clone(), points, box_angle }
    }

    /// Whether the handles of a box with this angle have nearly the same places in the model.
    pub(crate) fn has_handles_of(&self, box_angle: f64) -> bool {
        (self.box_angle - box_angle).sin().abs() < SAME_HANDLES && (self.box_angle - box_angle).cos() > 0.0
    }

    /// Linear interpolation of the points alone, each by its own part of the way to those of `to`.
    pub(crate) fn points_between(&self, to: &Self, part: impl Fn(usize) -> f64) -> Vec<[f64; D]> {
        let between = |(point, (a, b)): (usize, (&[f64; D], &[f64; D]))| mixed(a, b, part(point));
        self.points.iter().zip(&to.points).enumerate().map(between).collect()
    }

    /// Distances between corresponding points.
    pub(crate) fn distances(&self, to: &Self) -> impl Iterator<Item = f64> {
        self.points.iter().zip(&to.points).map(|(a, b)| distance(a, b))
    }

    /// Largest distance between corresponding points.
    pub(crate) fn farthest(&self, to: &Self) -> f64 {
        self.distances(to).fold(0.0, f64::max)
    }

    /// Displacements for `count` other copies, by name: that of the copy with the same name, or of the only copy of the same
    /// handle. If `names` is empty, the unknowns are handles.
    pub(crate) fn handles_by_name(&self, names: &[CopyName], count: usize) -> Vec<Option<[f64; D]>> {
        let mut by_handle: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for index in 0..self.handles.len() {
            by_handle.entry(self.copies.get(index).map_or(index, |copy| copy.handle)).or_default().push(index);
        }
        let of = |index: usize| {
            let name = names.get(index);
            let own = by_handle.get(&name.map_or(index, |name| name.handle))?;
            let same = own.iter().find(|&&place| name.is_some() && self.copies.get(place) == name);
            let found = same.or(if own.len() == 1 { own.first() } else { None })?;
            Some(self.handles[*found])
        };
        (0..count).map(of).collect()
    }
}

fn mix<const D: usize>(from: &[[f64; D]], to: &[[f64; D]], t: f64) -> Vec<[f64; D]> {
    from.iter().zip(to).map(|(a, b)| mixed(a, b, t)).collect()
}

fn mixed<const D: usize>(from: &[f64; D], to: &[f64; D], t: f64) -> [f64; D] {
    std::array::from_fn(|d| from[d] * (1.0 - t) + to[d] * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn name(handle: usize, triangle: usize) -> CopyName {
        CopyName { handle, triangle }
    }

    #[test]
    fn copies_find_their_own_or_the_only_one_of_their_handle() {
        let copies = vec![name(0, 3), name(1, 3), name(1, 8)];
        let state = Displacement { handles: vec![[1.0], [2.0], [3.0]], copies, points: Vec::new(), box_angle: 0.0 };
        // A copy of a handle that splits, one renamed while its handle has others, one unchanged, one of a handle that had none.
        let wanted = [name(0, 3), name(0, 7), name(1, 5), name(1, 8), name(2, 3)];
        let found = state.handles_by_name(&wanted, wanted.len());
        assert_eq!(found, [Some([1.0]), Some([1.0]), None, Some([3.0]), None]);
        assert_eq!(state.handles_by_name(&[], 3), [Some([1.0]), None, None], "without copies");
        let plain =
            Displacement { handles: vec![[1.0], [2.0]], copies: Vec::new(), points: Vec::new(), box_angle: 0.0 };
        assert_eq!(plain.handles_by_name(&[name(1, 3), name(1, 8)], 2), [Some([2.0]); 2]);
    }

    #[test]
    fn states_between_keep_the_copies_of_the_first() {
        let state = |names: &[CopyName], x: f64| Displacement {
            handles: vec![[x]; names.len()],
            copies: names.to_vec(),
            points: vec![[x]],
            box_angle: 0.0,
        };
        let middle = state(&[name(0, 1), name(0, 4)], 1.0).interpolated(&state(&[name(0, 1), name(0, 2)], 3.0), 0.5);
        assert_eq!(middle.copies, [name(0, 1), name(0, 4)]);
        assert_eq!((middle.handles, middle.points), (vec![[2.0], [1.0]], vec![[2.0]]));
    }
}
