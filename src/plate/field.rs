//! The warp of the whole screen: a sequence of lattices, each extrapolated beyond its box.
//!
//! In: screen lattices. Out: the image of any screen point, the gradient there, and the inverse.

use super::extrapolation::ExtrapolatedLattice;
use super::flow::Flow;
use super::surface_field::SurfaceField;
use super::{SurfacePicture, WholeWarp};
use crate::lattice::ScreenLattice;
use crate::space::{FrameSize, ScreenPoint};
use glam::{DMat2, DVec2};
use std::sync::Arc;

/// Maximum number of Newton steps before an inverse counts as not found.
const MAX_STEPS: usize = 40;
/// Convergence tolerance of the inverse, in frame heights: a 500th of a thousandth of a pixel at 4K.
const CLOSE: f64 = 1e-9;

/// A warp of the screen plane.
///
/// ```
/// use pinwarp::lattice::{Basis, Grid};
/// use pinwarp::plate::Field;
/// use pinwarp::space::ScreenPoint;
/// let mut lattice = Grid { dims: [4, 4], basis: Basis::Bspline, lo: [0.0, 0.0], hi: [1.0, 1.0], angle: 0.0 }.at_rest();
/// lattice.handles.iter_mut().for_each(|handle| handle[0] += 0.25);
/// let point = ScreenPoint::new(0.5, 0.5);
/// let moved = Field::of_picture(lattice).carry(point);
/// assert!((moved.0.x - 0.75).abs() < 1e-12);
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Field {
    parts: Vec<Part>,
    /// Whether it moves parts of a shape that may pass in front of each other.
    is_of_branch: bool,
}

/// One of the maps that are applied in sequence.
#[derive(Clone, Debug, PartialEq)]
enum Part {
    Lattice(ExtrapolatedLattice),
    Flow(Arc<Flow>),
    Surfaces(Arc<SurfaceField>),
}

impl Part {
    fn lattice(&self) -> Option<&ExtrapolatedLattice> {
        if let Self::Lattice(lattice) = self { Some(lattice) } else { None }
    }

    fn is_at_rest(&self) -> bool {
        match self {
            Self::Lattice(lattice) => lattice.is_at_rest(),
            Self::Flow(flow) => flow.is_at_rest(),
            Self::Surfaces(surfaces) => surfaces.max_displacement() == 0.0,
        }
    }

    fn is_one_to_one(&self) -> bool {
        self.is_at_rest() || self.lattice().is_none_or(ExtrapolatedLattice::is_one_to_one)
    }

    fn max_displacement(&self) -> f64 {
        match self {
            Self::Lattice(lattice) => lattice.max_displacement(),
            Self::Flow(flow) => flow.reach(),
            Self::Surfaces(surfaces) => surfaces.max_displacement(),
        }
    }

    fn is_smooth_within(&self, lo: DVec2, hi: DVec2) -> bool {
        match self {
            Self::Lattice(lattice) => lattice.is_smooth_within(lo, hi),
            Self::Flow(flow) => flow.is_smooth_within(lo, hi),
            Self::Surfaces(_) => false,
        }
    }

    /// Returns the displacement and the gradient of the map.
    fn displace(&self, point: DVec2) -> (DVec2, DMat2) {
        match self {
            Self::Lattice(lattice) => {
                let (by, slope) = lattice.displace(point);
                (by, DMat2::IDENTITY + slope)
            }
            Self::Flow(flow) => flow.displace(point),
            Self::Surfaces(surfaces) => surfaces.displace(point),
        }
    }
}

impl Field {
    const fn of_parts(parts: Vec<Part>) -> Self {
        Self { parts, is_of_branch: false }
    }

    /// Returns the identity.
    #[must_use]
    pub const fn identity() -> Self {
        Self::of_parts(Vec::new())
    }

    /// Returns the warp of an isolated layer (geometry, matted plates): outside the box a point moves as the nearest
    /// point of the box does.
    #[must_use]
    pub fn of_layer(lattice: ScreenLattice) -> Self {
        Self::of_parts(vec![Part::Lattice(ExtrapolatedLattice::clamped(&lattice))])
    }

    /// Returns the warp of a branch of a lattice: as [`Self::of_layer`], but parts of the shape on it that lie over each other, as
    /// crossing legs do, are no fold.
    #[must_use]
    pub(crate) fn of_branch(lattice: ScreenLattice) -> Self {
        Self { is_of_branch: true, ..Self::of_layer(lattice) }
    }

    /// Returns the warp of a whole picture: outside the box the displacement continues smoothly and fades to zero, so
    /// that the background neither slides nor kinks (docs/PLATES.md).
    #[must_use]
    pub fn of_picture(lattice: ScreenLattice) -> Self {
        Self::of_parts(vec![Part::Lattice(ExtrapolatedLattice::fading(&lattice))])
    }

    /// Returns the warp of a whole picture with a fixed border: nothing folds, and pins reach their targets.
    #[must_use]
    pub(crate) fn of_whole(whole: &WholeWarp) -> Self {
        Self::of_parts(vec![Part::Lattice(whole.extrapolated()), Part::Flow(Arc::clone(whole.flow()))])
    }

    /// Returns the warp of surfaces, from their pictures before and after it. It can be applied, but neither undone
    /// nor concatenated with other fields.
    #[must_use]
    pub(crate) fn of_surfaces(pictures: [SurfacePicture; 2], frame: FrameSize) -> Self {
        Self::of_parts(vec![Part::Surfaces(Arc::new(SurfaceField::of(pictures, frame)))])
    }

    /// Returns the field of surfaces, if this is one.
    pub(super) fn surfaces(&self) -> Option<&SurfaceField> {
        if let [Part::Surfaces(surfaces)] = self.parts.as_slice() { Some(surfaces) } else { None }
    }

    /// Concatenates fields: each one warps the result of the previous one.
    #[must_use]
    pub(crate) fn chain(fields: Vec<Self>) -> Self {
        let is_of_branch = fields.iter().any(|field| field.is_of_branch);
        Self { parts: fields.into_iter().flat_map(|field| field.parts).collect(), is_of_branch }
    }

    /// Whether the warp is the identity everywhere.
    #[must_use]
    pub(crate) fn is_identity(&self) -> bool {
        self.parts.iter().all(Part::is_at_rest)
    }

    /// Whether the warp is that of a branch: only what is turned over is then a fold.
    pub(super) const fn is_of_branch(&self) -> bool {
        self.is_of_branch
    }

    /// Whether the warp is known to be one-to-one.
    pub(super) fn is_one_to_one(&self) -> bool {
        self.parts.iter().all(Part::is_one_to_one)
    }

    /// Returns the image of a point.
    #[must_use]
    pub fn carry(&self, point: ScreenPoint) -> ScreenPoint {
        ScreenPoint(point.0 + self.displace(point.0).0)
    }

    /// Returns the image of a point and the gradient there (column = derivative along x, y).
    #[cfg(test)]
    #[must_use]
    pub(crate) fn evaluate_with_gradient(&self, point: ScreenPoint) -> (ScreenPoint, DMat2) {
        let (moved, gradient) = self.displace(point.0);
        (ScreenPoint(point.0 + moved), gradient)
    }

    /// Returns the preimage of `point`, searched for from `start`; `None` if the search does not converge. In folds,
    /// where several preimages exist, returns the one that the search finds first.
    #[must_use]
    pub(crate) fn inverse(&self, point: ScreenPoint, start: ScreenPoint) -> Option<ScreenPoint> {
        self.back(point.0, start.0 - point.0).map(|(offset, _)| ScreenPoint(point.0 + offset))
    }

    /// Upper bound of the displacement, in frame heights.
    #[must_use]
    pub(crate) fn max_displacement(&self) -> f64 {
        self.parts.iter().map(Part::max_displacement).sum()
    }

    /// Returns the distances between rest handles along each axis, for every lattice.
    pub(super) fn spacings(&self) -> impl Iterator<Item = DVec2> {
        self.parts.iter().filter_map(Part::lattice).map(ExtrapolatedLattice::spacing)
    }

    /// Whether the field is smooth on the quadrilateral of four nearby points.
    pub(super) fn is_smooth_between(&self, mut points: [DVec2; 4]) -> bool {
        self.parts.iter().all(|lattice| {
            let lo = points.into_iter().fold(DVec2::INFINITY, DVec2::min);
            let hi = points.into_iter().fold(DVec2::NEG_INFINITY, DVec2::max);
            // The images of straight sides are curved.
            let bulge = (hi - lo) * 0.1;
            let is_smooth = lattice.is_smooth_within(lo - bulge, hi + bulge);
            points = points.map(|point| point + lattice.displace(point).0);
            is_smooth
        })
    }

    /// Returns the displacement of a point (exactly 0 where nothing moves), and the gradient of [`Self::carry`].
    pub(super) fn displace(&self, point: DVec2) -> (DVec2, DMat2) {
        displace(&self.parts, point)
    }

    /// Returns the offset from a point to its preimage, and the gradient of [`Self::carry`] there.
    pub(super) fn back(&self, point: DVec2, start: DVec2) -> Option<(DVec2, DMat2)> {
        back(&self.parts, point, start)
    }
}

fn displace(parts: &[Part], point: DVec2) -> (DVec2, DMat2) {
    let (mut moved, mut gradient) = (DVec2::ZERO, DMat2::IDENTITY);
    for part in parts {
        let (by, slope) = part.displace(point + moved);
        moved += by;
        gradient = slope * gradient;
    }
    (moved, gradient)
}

/// Inverts the parts from last to first: flows have a direct inverse; consecutive lattices are searched together.
fn back(parts: &[Part], point: DVec2, start: DVec2) -> Option<(DVec2, DMat2)> {
    let Some(last) = parts.iter().rposition(|part| part.lattice().is_none()) else {
        return search(parts, point, start);
    };
    let (before, after) = (&parts[..last], &parts[last + 1..]);
    let (mut offset, mut gradient) = (DVec2::ZERO, DMat2::IDENTITY);
    if !after.is_empty() {
        (offset, gradient) = search(after, point, DVec2::ZERO)?;
    }
    if let Part::Flow(flow) = &parts[last] {
        let (by, slope) = flow.back(point + offset);
        offset += by;
        gradient *= slope;
    }
    if before.is_empty() {
        return Some((offset, gradient));
    }
    let (by, slope) = back(before, point + offset, start - offset)?;
    Some((offset + by, gradient * slope))
}

/// Solves o + d(x + o) = 0 by Newton's method, halving each step until the residual shrinks.
fn search(parts: &[Part], point: DVec2, start: DVec2) -> Option<(DVec2, DMat2)> {
    let mut offset = start;
    let (mut moved, mut gradient) = displace(parts, point + offset);
    let mut miss = offset + moved;
    for _ in 0..MAX_STEPS {
        if miss.length_squared() <= CLOSE * CLOSE {
            // Bit-exactly 0 where nothing moves.
            return Some((-moved, gradient));
        }
        let step = newton_step(gradient, miss);
        let mut step_length = 1.0;
        loop {
            let next = offset - step * step_length;
            let (next_moved, next_gradient) = displace(parts, point + next);
            let next_miss = next + next_moved;
            if next_miss.length_squared() < miss.length_squared() {
                (offset, moved, gradient, miss) = (next, next_moved, next_gradient, next_miss);
                break;
            }
            step_length *= 0.5;
            if step_length < 1e-3 || !next_miss.is_finite() {
                return None;
            }
        }
    }
    None
}

/// Returns J⁻¹ r, or near a crease, where J is singular, the damped least-squares step (J^T J + μ I)⁻¹ J^T r.
fn newton_step(gradient: DMat2, miss: DVec2) -> DVec2 {
    let scale = gradient.x_axis.length_squared() + gradient.y_axis.length_squared();
    if gradient.determinant().abs() > 1e-3 * scale {
        return gradient.inverse() * miss;
    }
    let turned = gradient.transpose();
    (turned * gradient + DMat2::IDENTITY * (1e-4 * scale + 1e-12)).inverse() * (turned * miss)
}
