//! A ring that turns something about an axis in space, as seen from the front.
//!
//! In: the axis in view space (rightwards, upwards, towards the viewer), points in radii of the ring from its centre. Out: the ring's points,
//! distances from it, angles between points of it. Perspective is ignored, so that the ring keeps its size on the screen.

use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Number of straight pieces that make a ring.
const PIECES: usize = 72;

/// The axis points towards the viewer at least this much where the ring is followed around; rings seen from their edge are pulled along it.
const FACING: f64 = 0.3;

/// A ring about an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AxisRing {
    /// Unit length.
    axis: DVec3,
}

impl AxisRing {
    /// Returns the ring about an axis.
    pub(crate) fn about(axis: DVec3) -> Self {
        Self { axis: axis.normalize_or(DVec3::Z) }
    }

    /// Returns its points, the first and last of which are one.
    pub(crate) fn points(self) -> impl Iterator<Item = DVec3> {
        let (u, v) = self.across();
        (0..=PIECES).map(move |piece| {
            let (sin, cos) = (piece as f64 / PIECES as f64 * TAU).sin_cos();
            u * cos + v * sin
        })
    }

    /// Returns the distance of a point from the ring as seen, and whether the near half of the ring is there.
    pub(crate) fn distance(self, at: DVec2) -> (f64, bool) {
        let far = self.points().map(|point| ((point.truncate() - at).length(), point.z >= -1e-9));
        far.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, false))
    }

    /// Returns the angle about the axis, in radians, by which a drag turns that turned by the angle `before` last. Drags around the
    /// ring may turn more than once.
    pub(crate) fn angle(self, [from, to]: [DVec2; 2], before: f64) -> f64 {
        if self.axis.z.abs() >= FACING {
            return going_on(self.phase(to) - self.phase(from), before);
        }
        // The nearest point of the near half moves along the ring.
        let (u, v) = self.across();
        let (start, end) = (u * from.dot(u.truncate()) + v * from.dot(v.truncate()), DVec3::Z);
        let grabbed = (start + end * 1e-3).normalize_or(DVec3::Z);
        let grabbed =
            if grabbed.z < 0.0 { (grabbed - 2.0 * grabbed.z * DVec3::Z).normalize_or(DVec3::Z) } else { grabbed };
        let along = self.axis.cross(grabbed).truncate();
        (to - from).dot(along.normalize_or(DVec2::X))
    }

    /// Returns the angle at which a point of the plane of the ring lies.
    fn phase(self, at: DVec2) -> f64 {
        let (u, v) = self.across();
        let depth = -self.axis.truncate().dot(at) / self.axis.z;
        let point = at.extend(depth);
        point.dot(v).atan2(point.dot(u))
    }

    /// Returns two directions across the axis, the second a quarter turn about it from the first.
    fn across(self) -> (DVec3, DVec3) {
        let u = self.axis.any_orthonormal_vector();
        (u, self.axis.cross(u))
    }
}

/// Returns the angle, in radians, that is nearest to the one before, of all that differ from the given one by whole turns.
#[must_use]
pub(crate) fn going_on(angle: f64, before: f64) -> f64 {
    angle + TAU * ((before - angle) / TAU).round()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drag_along_the_ring_turns_by_the_angle_between_its_ends() {
        for axis in [DVec3::Z, DVec3::NEG_Z, DVec3::new(0.5, -0.3, 0.8), DVec3::new(-0.2, 0.7, -0.6)] {
            let ring = AxisRing::about(axis);
            let points: Vec<DVec3> = ring.points().collect();
            let turn = ring.angle([points[5].truncate(), points[14].truncate()], 0.0);
            assert!((turn - 9.0 / 72.0 * TAU).abs() < 1e-9, "{axis}: {turn}");
            let back = ring.angle([points[70].truncate(), points[2].truncate()], 0.0);
            assert!((back - 4.0 / 72.0 * TAU).abs() < 1e-9, "{axis}: {back}");
            assert!(ring.distance(points[9].truncate()).0 < 1e-9);
            let around = (0..200)
                .fold(0.0, |turned, piece| ring.angle([points[0].truncate(), points[piece % 72].truncate()], turned));
            assert!((around - 199.0 / 72.0 * TAU).abs() < 1e-9, "{axis}: {around} after more than two turns");
        }
    }

    #[test]
    fn a_ring_seen_from_its_edge_is_pulled_along() {
        // About y, the near side moves to the right; about x, down.
        let right = AxisRing::about(DVec3::Y).angle([DVec2::ZERO, DVec2::new(0.5, 0.0)], 0.0);
        let down = AxisRing::about(DVec3::X).angle([DVec2::ZERO, DVec2::new(0.0, -0.5)], 0.0);
        assert!((right - 0.5).abs() < 1e-6 && (down - 0.5).abs() < 1e-6, "{right} {down}");
        let across = AxisRing::about(DVec3::Y).angle([DVec2::ZERO, DVec2::new(0.0, 0.5)], 0.0);
        assert!(across.abs() < 1e-6, "{across}");
    }
}
