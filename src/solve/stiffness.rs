//! How stiff the shape is where: painted on its triangles, and starched around pins.
//!
//! In: a shape, pins with regions. Out: multiples of the stiffness 1 that everything has by itself.

use super::bend::fade;
use super::small::{area_of, dot, minus};
use super::{PointPin, Shape};

impl<const D: usize> Shape<D> {
    /// Stiffness of a triangle.
    pub(crate) fn stiffness_of(&self, triangle: usize) -> f64 {
        self.stiffness.get(triangle).copied().unwrap_or(1.0)
    }

    /// The same shape with the starch of the pins painted on, at the middle of each triangle.
    pub(crate) fn starched(&self, pins: &[PointPin<D>]) -> Self {
        if !is_starched(pins) {
            return self.clone();
        }
        let middle = |corners: &[u32; 3]| {
            let corners = corners.map(|corner| &self.points[corner as usize]);
            std::array::from_fn(|d| corners.iter().map(|corner| corner[d]).sum::<f64>() / 3.0)
        };
        let triangles = self.triangles.iter().enumerate();
        let stiffness = triangles.map(|(k, corners)| self.stiffness_of(k) * starch_at(pins, middle(corners)));
        Self { stiffness: stiffness.collect(), ..self.clone() }
    }

    /// Mean stiffness over the area; 1 where there is none.
    pub(crate) fn mean_stiffness(&self) -> f64 {
        let area = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|corner| &self.points[corner as usize]);
            area_of(&minus(b, a), &minus(c, a))
        };
        let (total, stiff) =
            self.triangles.iter().zip(&self.stiffness).fold((0.0, 0.0), |sums, (corners, stiffness)| {
                let area = area(corners);
                (sums.0 + area, sums.1 + area * stiffness)
            });
        if total > 0.0 && stiff > 0.0 { stiff / total } else { 1.0 }
    }
}

/// Some pin starches its region.
fn is_starched<const D: usize>(pins: &[PointPin<D>]) -> bool {
    pins.iter().any(|pin| pin.region.is_some_and(|region| region.starch != 1.0))
}

/// What the pins multiply the stiffness by at a point: full at a pin, fading to 1 at the rim of its region, and fading
/// with the pin. Where regions overlap, both count.
pub(crate) fn starch_at<const D: usize>(pins: &[PointPin<D>], point: [f64; D]) -> f64 {
    let regions = pins.iter().filter_map(|pin| Some((pin, pin.region?)));
    let factors = regions.map(|(pin, region)| {
        let away = minus(&point, &pin.at);
        1.0 + (region.starch - 1.0) * pin.weight.min(1.0) * fade(dot(&away, &away).sqrt() / region.radius)
    });
    factors.product()
}
