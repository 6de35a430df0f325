//! The warp of a whole screen: lattices one after another, and how they are extrapolated beyond their boxes.
//!
//! In: lattices of the screen. Out: where any point of the screen goes, the gradient there, and where it came from.

use super::WholeWarp;
use super::extrapolation::ExtrapolatedLattice;
use super::flow::Flow;
use crate::lattice::ScreenLattice;
use crate::space::ScreenPoint;
use glam::{DMat2, DVec2};
use std::sync::Arc;

/// Newton steps after which an inverse counts as not found.
const MOST_STEPS: usize = 40;
/// An inverse is found when its image is this near, in frame heights: a 500th of a thousandth of a pixel at 4K.
const CLOSE: f64 = 1e-9;

/// Where every point of the screen goes.
///
/// ```
/// use pinwarp::lattice::{Basis, Grid};
/// use pinwarp::plate::Field;
/// use pinwarp::space::ScreenPoint;
/// let mut lattice = Grid { dims: [4, 4], basis: Basis::Bspline, lo: [0.0, 0.0], hi: [1.0, 1.0] }.at_rest();
/// lattice.handles.iter_mut().for_each(|handle| handle[0] += 0.25);
/// let point = ScreenPoint::new(0.5, 0.5);
/// let moved = Field::of_picture(lattice).carry(point);
/// assert!((moved.0.x - 0.75).abs() < 1e-12);
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Field {
    parts: Vec<Part>,
}

/// One of the maps that follow each other.
#[derive(Clone, Debug, PartialEq)]
enum Part {
    Lattice(ExtrapolatedLattice),
    Flow(Arc<Flow>),
}

impl Part {
    fn lattice(&self) -> Option<&ExtrapolatedLattice> {
        if let Self::Lattice(lattice) = self { Some(lattice) } else { None }
    }

    fn is_at_rest(&self) -> bool {
        match self {
            Self::Lattice(lattice) => lattice.is_at_rest(),
            Self::Flow(flow) => flow.is_at_rest(),
        }
    }

    fn is_one_to_one(&self) -> bool {
        self.is_at_rest() || self.lattice().is_none_or(ExtrapolatedLattice::is_one_to_one)
    }

    fn max_displacement(&self) -> f64 {
        match self {
            Self::Lattice(lattice) => lattice.max_displacement(),
            Self::Flow(flow) => flow.reach(),
        }
    }

    fn is_smooth_within(&self, lo: DVec2, hi: DVec2) -> bool {
        match self {
            Self::Lattice(lattice) => lattice.is_smooth_within(lo, hi),
            Self::Flow(flow) => flow.is_smooth_within(lo, hi),
        }
    }

    /// Displacement, and the gradient of the map.
    fn displace(&self, point: DVec2) -> (DVec2, DMat2) {
        match self {
            Self::Lattice(lattice) => {
                let (by, slope) = lattice.displace(point);
                (by, DMat2::IDENTITY + slope)
            }
            Self::Flow(flow) => flow.displace(point),
        }
    }
}

impl Field {
    /// Nothing moves.
    #[must_use]
    pub const fn identity() -> Self {
        Self { parts: Vec::new() }
    }

    /// The warp of a layer that stands alone (geometry, matted plates): around the box a point moves as the nearest box
    /// point does.
    #[must_use]
    pub fn of_layer(lattice: ScreenLattice) -> Self {
        Self { parts: vec![Part::Lattice(ExtrapolatedLattice::clamped(&lattice))] }
    }

    /// The warp of a whole picture: around the box the displacement goes on smoothly and fades to zero, so that the
    /// background neither slides nor kinks (docs/PLATES.md).
    #[must_use]
    pub fn of_picture(lattice: ScreenLattice) -> Self {
        Self { parts: vec![Part::Lattice(ExtrapolatedLattice::fading(&lattice))] }
    }

    /// The warp of a whole picture whose border rests: nothing folds, and pins are met.
    #[must_use]
    pub fn of_whole(whole: &WholeWarp) -> Self {
        Self { parts: vec![Part::Lattice(whole.extrapolated()), Part::Flow(Arc::clone(whole.flow()))] }
    }

    /// One field after the other: the first moves the picture, the next moves what came out.
    #[must_use]
    pub fn chain(fields: Vec<Self>) -> Self {
        Self { parts: fields.into_iter().flat_map(|field| field.parts).collect() }
    }

    /// Nothing moves anywhere.
    #[must_use]
    pub fn is_identity(&self) -> bool {
        self.parts.iter().all(Part::is_at_rest)
    }

    /// It is known that no two points meet.
    pub(super) fn is_one_to_one(&self) -> bool {
        self.parts.iter().all(Part::is_one_to_one)
    }

    /// Where a point goes.
    #[must_use]
    pub fn carry(&self, point: ScreenPoint) -> ScreenPoint {
        ScreenPoint(point.0 + self.displace(point.0).0)
    }

    /// Where a point goes, and the gradient there (column = derivative along x, y).
    #[must_use]
    pub fn evaluate_with_gradient(&self, point: ScreenPoint) -> (ScreenPoint, DMat2) {
        let (moved, gradient) = self.displace(point.0);
        (ScreenPoint(point.0 + moved), gradient)
    }

    /// The point that goes to `point`, looked for from `start` on; `None` where the search ends elsewhere. In folds
    /// there are several; the one that the search meets first counts.
    #[must_use]
    pub fn inverse(&self, point: ScreenPoint, start: ScreenPoint) -> Option<ScreenPoint> {
        self.back(point.0, start.0 - point.0).map(|(offset, _)| ScreenPoint(point.0 + offset))
    }

    /// No point moves further, in frame heights.
    #[must_use]
    pub fn max_displacement(&self) -> f64 {
        self.parts.iter().map(Part::max_displacement).sum()
    }

    /// Distances of rest handles, an axis, of every lattice.
    pub(super) fn spacings(&self) -> impl Iterator<Item = DVec2> {
        self.parts.iter().filter_map(Part::lattice).map(ExtrapolatedLattice::spacing)
    }

    /// Whether the field is smooth between four points that lie near each other.
    pub(super) fn is_smooth_between(&self, mut points: [DVec2; 4]) -> bool {
        self.parts.iter().all(|lattice| {
            let lo = points.into_iter().fold(DVec2::INFINITY, DVec2::min);
            let hi = points.into_iter().fold(DVec2::NEG_INFINITY, DVec2::max);
            // Sides between the points are curved.
            let bulge = (hi - lo) * 0.1;
            let is_smooth = lattice.is_smooth_within(lo - bulge, hi + bulge);
            points = points.map(|point| point + lattice.displace(point).0);
            is_smooth
        })
    }

    /// How far a point moves (exactly 0 where nothing does), and the gradient of [`Self::carry`].
    pub(super) fn displace(&self, point: DVec2) -> (DVec2, DMat2) {
        displace(&self.parts, point)
    }

    /// What has to be added to a point to find where it came from, and the gradient of [`Self::carry`] there.
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

/// Flows know their inverse; lattices that follow each other are searched together.
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

/// Newton's method on o + d(x + o) = 0; a step is halved until the miss shrinks.
fn search(parts: &[Part], point: DVec2, start: DVec2) -> Option<(DVec2, DMat2)> {
    let mut offset = start;
    let (mut moved, mut gradient) = displace(parts, point + offset);
    let mut miss = offset + moved;
    for _ in 0..MOST_STEPS {
        if miss.length_squared() <= CLOSE * CLOSE {
            // Where nothing moves this is 0, to the bit.
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

/// J⁻¹ r; near a crease, where J is singular, the damped least-squares step (J^T J + μ I)⁻¹ J^T r.
fn newton_step(gradient: DMat2, miss: DVec2) -> DVec2 {
    let scale = gradient.x_axis.length_squared() + gradient.y_axis.length_squared();
    if gradient.determinant().abs() > 1e-3 * scale {
        return gradient.inverse() * miss;
    }
    let turned = gradient.transpose();
    (turned * gradient + DMat2::IDENTITY * (1e-4 * scale + 1e-12)).inverse() * (turned * miss)
}
