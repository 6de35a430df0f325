//! Transfers a lattice that was solved on one model to another model or picture.
//!
//! In: a screen lattice, and the relation between the two rest poses. Out: a lattice over the other's box.

use super::grid::{Grid, Lattice};
use crate::space::{RotatedBox, ScreenBox, ScreenPoint};
use glam::DVec2;
use std::f64::consts::{PI, TAU};

/// The relation between the rest poses of the original and the new subject.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum LatticeFit {
    /// Both have the same screen positions.
    AsIs,
    /// The lattice's box maps to this one.
    Box(RotatedBox),
    /// Pairs of points in the old and the new rest pose: a translation (one pair), or the best-fitting similarity transform.
    Landmarks(Vec<[ScreenPoint; 2]>),
}

/// A similarity transform of the screen: x ↦ to + factor · (x − from), a product of complex numbers.
#[derive(Clone, Copy, Debug)]
struct Similarity {
    factor: DVec2,
    from: DVec2,
    to: DVec2,
}

impl Similarity {
    /// Fits a similarity to pairs by least squares; without two different source points there is no rotation or scale.
    fn between(pairs: &[[ScreenPoint; 2]]) -> Self {
        let count = pairs.len().max(1) as f64;
        let mean = |side: usize| pairs.iter().map(|pair| pair[side].0).sum::<DVec2>() / count;
        let (from, to) = (mean(0), mean(1));
        let (mut product, mut square) = (DVec2::ZERO, 0.0);
        for [a, b] in pairs {
            let (a, b) = (a.0 - from, b.0 - to);
            product += DVec2::new(a.dot(b), a.perp_dot(b));
            square += a.length_squared();
        }
        let factor = if square > 0.0 && product.length() > 1e-12 * square { product / square } else { DVec2::X };
        Self { factor, from, to }
    }

    fn image(&self, point: DVec2) -> DVec2 {
        self.to + self.factor.rotate(point - self.from)
    }

    fn origin(&self, image: DVec2) -> DVec2 {
        let back = DVec2::new(self.factor.x, -self.factor.y) / self.factor.length_squared();
        self.from + back.rotate(image - self.to)
    }

    fn rotates(&self) -> bool {
        self.factor.y.abs() > 1e-12 * self.factor.x.abs() || self.factor.x <= 0.0
    }
}

impl<const D: usize> Lattice<D> {
    /// Interpolates linearly, in the frame of the box: this lattice at 0, the other at 1; both must have the same dims
    /// and basis. The angle of the box takes the shorter way.
    #[must_use]
    pub(crate) fn mixed(&self, other: &Self, share: f64) -> Self {
        debug_assert_eq!(self.handles.len(), other.handles.len(), "lattices of equal dims");
        let mix = |a: &[f64; D], b: &[f64; D]| std::array::from_fn(|d| a[d] * (1.0 - share) + b[d] * share);
        let [lo, hi] = [mix(&self.grid.lo, &other.grid.lo), mix(&self.grid.hi, &other.grid.hi)];
        let turn = (other.grid.angle - self.grid.angle + PI).rem_euclid(TAU) - PI;
        if other.grid.angle == self.grid.angle {
            let handles = self.handles.iter().zip(&other.handles).map(|(a, b)| mix(a, b)).collect();
            return Self { grid: Grid { lo, hi, ..self.grid.clone() }, handles };
        }
        let grid = Grid { lo, hi, angle: self.grid.angle + turn * share, ..self.grid.clone() };
        let handles = self.handles.iter().zip(&other.handles).map(|(a, b)| {
            let [a, b] = [self.grid.upright_from_point(*a), other.grid.upright_from_point(*b)];
            grid.point_from_upright(mix(&a, &b))
        });
        Self { handles: handles.collect(), grid }
    }

    /// Scales the deformation: 0 is the rest state, 1 the full deformation; larger values exaggerate it.
    #[must_use]
    pub(crate) fn with_strength(&self, strength: f64) -> Self {
        self.grid.at_rest().mixed(self, strength)
    }
}

impl Lattice<2> {
    /// Returns the lattice that deforms the new subject as this one deforms the old.
    ///
    /// With an empty list of landmarks the lattice is returned unchanged.
    #[must_use]
    pub(crate) fn transferred(&self, fit: &LatticeFit) -> Self {
        match fit {
            LatticeFit::AsIs => self.clone(),
            LatticeFit::Box(target) => self.over(*target),
            LatticeFit::Landmarks(pairs) => self.carried_by(&Similarity::between(pairs)),
        }
    }

    /// Returns the point of the old subject at rest that corresponds to a point of the new one.
    #[must_use]
    pub(crate) fn origin_of(&self, point: [f64; 2], fit: &LatticeFit) -> [f64; 2] {
        match fit {
            LatticeFit::AsIs => point,
            LatticeFit::Box(target) => {
                let unit = Grid::over(*target, self.grid.dims, self.grid.basis).unit_from_point(point);
                self.grid.point_from_unit(unit)
            }
            LatticeFit::Landmarks(pairs) => Similarity::between(pairs).origin(DVec2::from(point)).to_array(),
        }
    }

    /// Maps box to box, axis by axis.
    fn over(&self, target: RotatedBox) -> Self {
        let grid = Grid::over(target, self.grid.dims, self.grid.basis);
        let handles = self.handles.iter().map(|&handle| grid.point_from_unit(self.grid.unit_from_point(handle)));
        Self { handles: handles.collect(), grid }
    }

    /// Moves the box and the handles by a similarity, which rotates the box.
    fn carried_by(&self, there: &Similarity) -> Self {
        let ScreenBox { min, max } = self.grid.bounds().upright;
        let center = there.image((min.0 + max.0) * 0.5);
        let half = (max.0 - min.0) * (0.5 * there.factor.length());
        let upright = ScreenBox::new(ScreenPoint(center - half), ScreenPoint(center + half));
        let angle = self.grid.angle + if there.rotates() { there.factor.to_angle() } else { 0.0 };
        let grid = Grid::over(RotatedBox { upright, angle }, self.grid.dims, self.grid.basis);
        let handles = self.handles.iter().map(|&handle| there.image(handle.into()).to_array());
        Self { handles: handles.collect(), grid }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Basis;

    fn bent() -> Lattice<2> {
        let mut lattice =
            Grid { dims: [7, 6], basis: Basis::Bspline, lo: [0.2, 0.1], hi: [1.2, 0.9], angle: 0.0 }.at_rest();
        for (k, handle) in lattice.handles.iter_mut().enumerate() {
            *handle = [handle[0] + 0.04 * (k as f64).sin(), handle[1] + 0.04 * (1.7 * k as f64).cos()];
        }
        lattice
    }

    #[test]
    fn points_of_the_new_subject_have_an_origin() {
        let lattice = bent();
        let turn = DVec2::from_angle(0.4) * 1.5;
        let image = |point: DVec2| DVec2::new(3.0, -1.0) + turn.rotate(point);
        let marks = [[0.3, 0.2], [1.0, 0.4]].map(DVec2::from);
        let pairs = marks.map(|mark| [ScreenPoint(mark), ScreenPoint(image(mark))]).to_vec();
        let target = ScreenBox::new(ScreenPoint::new(1.0, 1.0), ScreenPoint::new(3.0, 2.6));
        for (fit, point, origin) in [
            (LatticeFit::AsIs, [0.5, 0.6], [0.5, 0.6]),
            (LatticeFit::Box(target.into()), [1.5, 1.8], [0.45, 0.5]),
            (LatticeFit::Landmarks(pairs), image(DVec2::new(0.7, 0.2)).to_array(), [0.7, 0.2]),
        ] {
            assert!(distance(ScreenPoint(lattice.origin_of(point, &fit).into()), origin.into()) < 1e-12, "{fit:?}");
        }
    }

    fn distance(a: ScreenPoint, b: DVec2) -> f64 {
        (a.0 - b).length()
    }

    #[test]
    fn landmarks_carry_the_warp_along() {
        let (lattice, turn) = (bent(), DVec2::from_angle(0.4) * 1.5);
        let image = |point: DVec2| DVec2::new(3.0, -1.0) + turn.rotate(point);
        let marks = [[0.3, 0.2], [1.0, 0.4], [0.6, 0.8]].map(DVec2::from);
        let pairs = marks.map(|mark| [ScreenPoint(mark), ScreenPoint(image(mark))]).to_vec();
        let there = lattice.transferred(&LatticeFit::Landmarks(pairs));
        assert!((there.grid.angle - 0.4).abs() < 1e-12, "{}", there.grid.angle);
        for mark in marks {
            let wanted = image(lattice.warp(ScreenPoint(mark)).0);
            assert!(distance(there.warp(ScreenPoint(image(mark))), wanted) < 1e-12);
        }
    }

    #[test]
    fn boxes_and_single_landmarks_are_exact() {
        let lattice = bent();
        let target = ScreenBox::new(ScreenPoint::new(0.0, 0.0), ScreenPoint::new(3.0, 0.8));
        let there = lattice.transferred(&LatticeFit::Box(target.into()));
        let warped = lattice.warp(ScreenPoint::new(0.7, 0.5)).0 - DVec2::new(0.2, 0.1);
        assert!(distance(there.warp(ScreenPoint::new(1.5, 0.4)), warped * DVec2::new(3.0, 1.0)) < 1e-12);
        let shifted =
            lattice.transferred(&LatticeFit::Landmarks(vec![[ScreenPoint::new(0.5, 0.5), ScreenPoint::new(0.9, 0.3)]]));
        let moved = lattice.warp(ScreenPoint::new(0.7, 0.5)).0 + DVec2::new(0.4, -0.2);
        assert!(distance(shifted.warp(ScreenPoint::new(1.1, 0.3)), moved) < 1e-12);
    }

    #[test]
    fn strength_goes_from_rest_to_all() {
        let lattice = bent();
        assert_eq!(lattice.with_strength(1.0), lattice);
        let rest = lattice.with_strength(0.0);
        assert!(distance(rest.warp(ScreenPoint::new(0.7, 0.5)), DVec2::new(0.7, 0.5)) < 1e-15);
    }

    #[test]
    fn boxes_that_rotate_are_mixed_without_shrinking() {
        let lattice = bent();
        let turned = |angle: f64| {
            let factor = DVec2::from_angle(angle);
            lattice.carried_by(&Similarity { factor, from: DVec2::ZERO, to: DVec2::ZERO })
        };
        let mixed = turned(3.0).mixed(&turned(-2.9), 0.5);
        let middle = 0.5 * (3.0 - 2.9) + PI;
        // Only the centre of the box takes the chord.
        let center = DVec2::new(0.7, 0.5);
        let shift = 0.5 * (DVec2::from_angle(3.0) + DVec2::from_angle(-2.9)).rotate(center);
        for point in [[0.3, 0.4], [1.1, 0.8]].map(DVec2::from) {
            let at = |point: DVec2| shift + DVec2::from_angle(middle).rotate(point - center);
            let wanted = at(lattice.warp(ScreenPoint(point)).0);
            assert!(distance(mixed.warp(ScreenPoint(at(point))), wanted) < 1e-12);
        }
    }
}
