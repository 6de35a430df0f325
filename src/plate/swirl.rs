//! A disc that rotates and scales about its centre and is fixed at its rim.
//!
//! In: centre, radius, angle and logarithm of the scale at the centre. Out: a map of the plane and its inverse.

use glam::{DMat2, DVec2};

/// Largest |ln σ| of a step: 4/9 of the limit at which it folds.
const MAX_SWELL: f64 = 0.5;
/// Maximum number of Newton steps of an inverse.
const MAX_NEWTON: usize = 40;

/// One step:
///
/// ```text
/// x ↦ c + exp((ln σ + i θ) φ(q)) (x − c),   q = |x − c|²/r²,  φ(q) = (1 − q)³ for q < 1, else 0
/// ```
///
/// Rotation is one-to-one for any θ, since it preserves circles. Scaling is one-to-one while |ln σ| u |dφ/du| ≤ |ln σ|
/// 8/9 < 1 (u² = q, with the maximum at u² = 1/3), so large scales are split into steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Swirl {
    center: DVec2,
    radius: f64,
    /// θ, radians.
    angle: f64,
    /// ln σ.
    swell: f64,
}

impl Swirl {
    /// Returns the steps that rotate and scale the neighbourhood of `center` by an angle and the logarithm of a scale.
    pub(super) fn of(center: DVec2, radius: f64, [angle, swell]: [f64; 2]) -> Vec<Self> {
        if radius <= 0.0 || (angle == 0.0 && swell == 0.0) {
            return Vec::new();
        }
        let turn = Self { center, radius, angle, swell: 0.0 };
        let whole = (swell.abs() / MAX_SWELL).floor();
        let part = |swell: f64| Self { angle: 0.0, swell, ..turn };
        let swells = (0..whole as usize).map(|_| part(MAX_SWELL.copysign(swell)));
        let rest = part(swell - (whole * MAX_SWELL).copysign(swell));
        let all = std::iter::once(turn).chain(swells).chain([rest]);
        all.filter(|step| step.angle != 0.0 || step.swell != 0.0).collect()
    }

    pub(super) fn disc(&self) -> (DVec2, f64) {
        (self.center, self.radius)
    }

    /// Upper bound of the displacement.
    pub(super) fn reach(&self) -> f64 {
        // |x − c| φ is at most r / √7 (6/7)³.
        let most = self.radius / 7.0_f64.sqrt() * (6.0_f64 / 7.0).powi(3);
        self.angle.abs() * most + self.swell.abs().exp_m1() * self.radius
    }

    /// Returns the displacement of a point and its gradient; `None` outside the disc.
    pub(super) fn displace(&self, point: DVec2) -> Option<(DVec2, DMat2)> {
        let from_center = point - self.center;
        let q = from_center.length_squared() / (self.radius * self.radius);
        (q < 1.0).then(|| {
            let turned = self.turned(from_center, q);
            (turned - from_center, self.slope(from_center, q))
        })
    }

    /// Returns the offset from a point to its preimage, and the gradient of [`Self::displace`] there.
    pub(super) fn back(&self, point: DVec2) -> Option<(DVec2, DMat2)> {
        let from_center = point - self.center;
        let image_q = from_center.length_squared() / (self.radius * self.radius);
        (image_q < 1.0).then(|| {
            let q = self.unswollen(image_q);
            let [cos, sin] = [(self.angle * bump(q)).cos(), (self.angle * bump(q)).sin()];
            let scale = (-self.swell * bump(q)).exp();
            let source =
                DVec2::new(cos * from_center.x + sin * from_center.y, cos * from_center.y - sin * from_center.x);
            (source * scale - from_center, self.slope(source * scale, q))
        })
    }

    fn turned(&self, from_center: DVec2, q: f64) -> DVec2 {
        DVec2::from_angle(self.angle * bump(q)).rotate(from_center) * (self.swell * bump(q)).exp()
    }

    /// Gradient of the map less the identity: M (I + (ln σ I + θ i) x ⊗ ∇φ) − I, M = exp((ln σ + i θ) φ).
    fn slope(&self, from_center: DVec2, q: f64) -> DMat2 {
        let slope = from_center * (-6.0 * (1.0 - q).powi(2) / (self.radius * self.radius));
        let along = from_center * self.swell + from_center.perp() * self.angle;
        let inner = DMat2::IDENTITY + DMat2::from_cols(along * slope.x, along * slope.y);
        let outer = DMat2::from_angle(self.angle * bump(q)) * (self.swell * bump(q)).exp();
        outer * inner - DMat2::IDENTITY
    }

    /// Returns the q of the preimage of a point with `image_q`, by Newton's method on ln q + 2 ln σ φ(q), which increases with q.
    fn unswollen(&self, image_q: f64) -> f64 {
        if self.swell == 0.0 || image_q == 0.0 {
            return image_q;
        }
        let (mut lo, mut hi, mut q) = (0.0_f64, 1.0_f64, image_q);
        for _ in 0..MAX_NEWTON {
            let miss = (q / image_q).ln() + 2.0 * self.swell * bump(q);
            if miss < 0.0 {
                lo = q
            } else {
                hi = q
            }
            let next = q - miss / (1.0 / q - 6.0 * self.swell * (1.0 - q).powi(2));
            let next = if next > lo && next < hi { next } else { 0.5 * (lo + hi) };
            if (next - q).abs() <= 1e-16 {
                break;
            }
            q = next;
        }
        q
    }
}

/// Evaluates φ(q) within the disc.
fn bump(q: f64) -> f64 {
    (1.0 - q).powi(3)
}
