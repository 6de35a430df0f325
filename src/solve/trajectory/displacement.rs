//! How far a model is from where the rigid fit of its pins takes it: the state of a knot, which neighbouring times can start from.
//!
//! In: displacements of handles, or of copies of handles, and of points. Out: displacements between two, and those of other copies.

use crate::solve::branching::CopyName;
use crate::solve::linalg::small_matrix::{distance, minus};
use std::collections::BTreeMap;

/// How far handles and points of the model are from where the rigid fit of the pins takes them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Displacement<const D: usize> {
    /// #handles, or #copies.
    pub(crate) handles: Vec<[f64; D]>,
    /// The names of copies; empty where every handle is one unknown.
    pub(crate) copies: Vec<CopyName>,
    /// #points.
    pub(crate) points: Vec<[f64; D]>,
}

impl<const D: usize> Displacement<D> {
    /// (1 − t) · self + t · to. Copies that `to` does not have go as they are: whoever starts from them fits them to the points.
    pub(crate) fn interpolated(&self, to: &Self, t: f64) -> Self {
        let points = mix(&self.points, &to.points, t);
        if self.copies == to.copies {
            return Self { handles: mix(&self.handles, &to.handles, t), copies: self.copies.clone(), points };
        }
        let known = to.handles_by_name(&self.copies, self.handles.len());
        let ends = self.handles.iter().zip(known).map(|(own, known)| known.unwrap_or(*own));
        let ends: Vec<_> = ends.collect();
        Self { handles: mix(&self.handles, &ends, t), copies: self.copies.clone(), points }
    }

    /// Between the second and the third of four states in a row, at t from 0 to 1. Points follow a cubic Hermite curve, so that the motion has no kinks at
    /// knots; its tangents are the mean of the differences on both sides, limited to three times the shorter one: nothing overshoots where
    /// the motion starts or stops (F. Fritsch and R. Carlson, "Monotone Piecewise Cubic Interpolation", 1980). Handles are mixed.
    pub(crate) fn on_curve([before, from, to, after]: [Option<&Self>; 4], t: f64) -> Option<Self> {
        let (from, to) = (from?, to?);
        let mut mixed = from.interpolated(to, t);
        for (index, place) in mixed.points.iter_mut().enumerate() {
            let step = minus(&to.points[index], &from.points[index]);
            let tangent = |beside: Option<[f64; D]>| beside.map_or(step, |beside| limited_mean(&beside, &step));
            let first = tangent(before.map(|before| minus(&from.points[index], &before.points[index])));
            let last = tangent(after.map(|after| minus(&after.points[index], &to.points[index])));
            for d in 0..D {
                place[d] += t * (1.0 - t) * ((1.0 - t) * (first[d] - step[d]) - t * (last[d] - step[d]));
            }
        }
        Some(mixed)
    }

    /// Farthest that a point moves to another displacement.
    pub(crate) fn farthest(&self, to: &Self) -> f64 {
        self.points.iter().zip(&to.points).map(|(a, b)| distance(a, b)).fold(0.0, f64::max)
    }

    /// The displacements of other copies, `count` of them (no names: of handles): of the same name, or the only one of the same handle.
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

/// The mean of two vectors, at most three times as long as the shorter one.
fn limited_mean<const D: usize>(a: &[f64; D], b: &[f64; D]) -> [f64; D] {
    let mean: [f64; D] = std::array::from_fn(|d| f64::midpoint(a[d], b[d]));
    let [length, most] = [norm(&mean), 3.0 * norm(a).min(norm(b))];
    if length > most { mean.map(|x| x * (most / length)) } else { mean }
}

fn norm<const D: usize>(a: &[f64; D]) -> f64 {
    distance(a, &[0.0; D])
}

fn mix<const D: usize>(from: &[[f64; D]], to: &[[f64; D]], t: f64) -> Vec<[f64; D]> {
    let between = |(a, b): (&[f64; D], &[f64; D])| std::array::from_fn(|d| a[d] * (1.0 - t) + b[d] * t);
    from.iter().zip(to).map(between).collect()
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
        let state = Displacement { handles: vec![[1.0], [2.0], [3.0]], copies, points: Vec::new() };
        // One that splits, one that has changed its name among others, one that stays, one of a handle that had none.
        let wanted = [name(0, 3), name(0, 7), name(1, 5), name(1, 8), name(2, 3)];
        let found = state.handles_by_name(&wanted, wanted.len());
        assert_eq!(found, [Some([1.0]), Some([1.0]), None, Some([3.0]), None]);
        assert_eq!(state.handles_by_name(&[], 3), [Some([1.0]), None, None], "without copies");
        let plain = Displacement { handles: vec![[1.0], [2.0]], copies: Vec::new(), points: Vec::new() };
        assert_eq!(plain.handles_by_name(&[name(1, 3), name(1, 8)], 2), [Some([2.0]); 2]);
    }

    #[test]
    fn curves_have_no_kinks_and_do_not_overshoot() {
        let state = |x: f64| Displacement { handles: vec![[x]], copies: Vec::new(), points: vec![[x]] };
        let at = |knots: [f64; 4], t: f64| {
            let states = knots.map(state);
            Displacement::on_curve(states.each_ref().map(Some), t).expect("two states").points[0][0]
        };
        let knots = [0.0, 1.0, 3.0, 4.0, 4.0];
        let window = |k: usize| [knots[k], knots[k + 1], knots[k + 2], knots[k + 3]];
        let (before, after) = (at(window(0), 1.0 - 1e-6), at(window(1), 1e-6));
        assert!((3.0 - before - (after - 3.0)).abs() < 1e-9, "the speed is the same on both sides of a knot");
        assert!((at([0.0, 1.0, 2.0, 3.0], 0.3) - 1.3).abs() < 1e-12, "an even motion stays even");
        for step in 0..=20 {
            let t = f64::from(step) / 20.0;
            assert!(at([0.0, 0.0, 0.0, 9.0], t) == 0.0, "what rests, rests");
            assert!((0.0..=9.0).contains(&at([0.0, 0.0, 9.0, 9.0], t)), "a snap");
        }
        let ends = [None, Some(&state(1.0)), Some(&state(2.0)), None].map(|end| end.cloned());
        assert_eq!(
            Displacement::on_curve(ends.each_ref().map(Option::as_ref), 0.25).map(|x| x.points),
            Some(vec![[1.25]])
        );
    }

    #[test]
    fn states_between_keep_the_copies_of_the_first() {
        let state = |names: &[CopyName], x: f64| Displacement {
            handles: vec![[x]; names.len()],
            copies: names.to_vec(),
            points: vec![[x]],
        };
        let middle = state(&[name(0, 1), name(0, 4)], 1.0).interpolated(&state(&[name(0, 1), name(0, 2)], 3.0), 0.5);
        assert_eq!(middle.copies, [name(0, 1), name(0, 4)]);
        assert_eq!((middle.handles, middle.points), (vec![[2.0], [1.0]], vec![[2.0]]));
    }
}
