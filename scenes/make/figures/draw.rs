//! Primitives of the figures: rounded limbs that blend into each other, ellipses, curves.
//!
//! In: a few points and radii. Out: distance fields (negative inside) and closed outlines.

use glam::DVec2;

/// A limb: a capsule whose radius changes from `radii[0]` to `radii[1]`.
#[derive(Clone, Copy)]
pub(crate) struct Limb {
    from: DVec2,
    to: DVec2,
    radii: [f64; 2],
    /// Distance over which it blends with the limbs before it.
    reach: f64,
}

impl Limb {
    pub(crate) const fn new(from: DVec2, to: DVec2, radii: [f64; 2]) -> Self {
        Self { from, to, radii, reach: 0.12 }
    }

    /// A circle.
    pub(crate) const fn ball(center: DVec2, radius: f64) -> Self {
        Self::new(center, DVec2::new(center.x + 1e-6, center.y), [radius; 2])
    }

    pub(crate) const fn melting(self, reach: f64) -> Self {
        Self { reach, ..self }
    }

    /// Distance, negative inside.
    pub(crate) fn field(&self, at: DVec2) -> f64 {
        let axis = self.to - self.from;
        let share = ((at - self.from).dot(axis) / axis.length_squared()).clamp(0.0, 1.0);
        at.distance(self.from + axis * share) - (self.radii[0] + (self.radii[1] - self.radii[0]) * share)
    }
}

/// The limb and its mirror image at x = 0.
pub(crate) fn both(limb: Limb) -> [Limb; 2] {
    let flip = |at: DVec2| DVec2::new(-at.x, at.y);
    [limb, Limb { from: flip(limb.from), to: flip(limb.to), ..limb }]
}

/// Consecutive limbs through `points`, with a radius at each.
pub(crate) fn chain(points: &[(DVec2, f64)]) -> Vec<Limb> {
    points.windows(2).map(|ends| Limb::new(ends[0].0, ends[1].0, [ends[0].1, ends[1].1])).collect()
}

/// Distance to blended limbs (I. Quílez's quadratic smooth minimum).
pub(crate) fn melted(limbs: &[Limb], at: DVec2) -> f64 {
    limbs.iter().fold(1e3, |distance, limb| {
        let other = limb.field(at);
        let overlap = (1.0 - (distance - other).abs() / limb.reach).max(0.0);
        distance.min(other) - overlap * overlap * limb.reach * 0.25
    })
}

/// Distance to an ellipse, exact on its border only.
pub(crate) fn ellipse(at: DVec2, center: DVec2, radii: DVec2) -> f64 {
    (((at - center) / radii).length() - 1.0) * radii.min_element()
}

/// A closed curve as a dense polygon, counter-clockwise.
pub(crate) struct Outline(pub(crate) Vec<DVec2>);

impl Outline {
    const FINE: usize = 240;

    /// An ellipse, rotated by `tilt` degrees.
    pub(crate) fn ellipse(center: DVec2, radii: DVec2, tilt: f64) -> Self {
        let turn = DVec2::from_angle(tilt.to_radians());
        let angle = |k: usize| std::f64::consts::TAU * k as f64 / Self::FINE as f64;
        Self((0..Self::FINE).map(|k| center + turn.rotate(DVec2::from_angle(angle(k)) * radii)).collect())
    }

    /// A smile: an arc through three points, `width` thick in the middle, thin at its ends.
    pub(crate) fn smile([left, middle, right]: [DVec2; 3], width: f64) -> Self {
        let bend = 2.0 * middle - 0.5 * (left + right);
        let place = |t: f64| left * (1.0 - t) * (1.0 - t) + bend * 2.0 * t * (1.0 - t) + right * t * t;
        let slope = |t: f64| (bend - left) * (2.0 * (1.0 - t)) + (right - bend) * (2.0 * t);
        let side = |t: f64, sign: f64| {
            let thick = width * (0.35 + 0.65 * (1.0 - (2.0 * t - 1.0).powi(2)));
            place(t) + slope(t).perp().normalize() * (0.5 * sign * thick)
        };
        let share = |k: usize| k as f64 / 100.0;
        let below = (0..=100).map(|k| side(share(k), -1.0));
        Self(below.chain((0..=100).rev().map(|k| side(share(k), 1.0))).collect())
    }

    /// A star with `rays` points.
    pub(crate) fn star(center: DVec2, radius: f64, rays: usize) -> Self {
        let corner = |k: usize| {
            let angle = std::f64::consts::TAU * (0.25 + k as f64 / (2 * rays) as f64);
            center + DVec2::from_angle(angle) * if k.is_multiple_of(2) { radius } else { 0.48 * radius }
        };
        Self((0..2 * rays).map(corner).collect())
    }

    /// `count` points at equal distances along the curve. A curve that has exactly `count` points is returned
    /// unchanged.
    pub(crate) fn points(&self, count: usize) -> Vec<DVec2> {
        let curve = &self.0;
        if curve.len() == count {
            return curve.clone();
        }
        let mut lengths = vec![0.0];
        for k in 0..curve.len() {
            lengths.push(lengths[k] + curve[k].distance(curve[(k + 1) % curve.len()]));
        }
        let total = lengths[curve.len()];
        (0..count)
            .map(|index| {
                let wanted = total * index as f64 / count as f64;
                let k = lengths.partition_point(|&length| length <= wanted) - 1;
                let share = (wanted - lengths[k]) / (lengths[k + 1] - lengths[k]);
                curve[k].lerp(curve[(k + 1) % curve.len()], share)
            })
            .collect()
    }
}
