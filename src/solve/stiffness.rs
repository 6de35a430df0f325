//! Local stiffness of the shape: the stiffness of its triangles, multiplied by that of the regions of pins.
//!
//! In: a shape, pins with regions. Out: stiffness relative to the default of 1.

use super::linalg::small_matrix::{area_of, dot, minus};
use super::problem::{PointPin, Shape};
use super::second_differences::fade;

impl<const D: usize> Shape<D> {
    /// Stiffness of a triangle.
    pub(crate) fn stiffness_of(&self, triangle: usize) -> f64 {
        self.stiffness.get(triangle).copied().unwrap_or(1.0)
    }

    /// Returns the same shape with the stiffness of each triangle multiplied by that of the regions at its centroid.
    pub(crate) fn with_region_stiffness(&self, pins: &[PointPin<D>]) -> Self {
        if !has_stiff_regions(pins) {
            return self.clone();
        }
        let middle = |corners: &[u32; 3]| {
            let corners = corners.map(|corner| &self.points[corner as usize]);
            std::array::from_fn(|d| corners.iter().map(|corner| corner[d]).sum::<f64>() / 3.0)
        };
        let triangles = self.triangles.iter().enumerate();
        let stiffness = triangles.map(|(k, corners)| self.stiffness_of(k) * region_stiffness_at(pins, middle(corners)));
        Self { stiffness: stiffness.collect(), ..self.clone() }
    }

    /// Area-weighted mean stiffness; 1 if the shape has no stiffness per triangle.
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

/// Whether some pin changes the stiffness of its region.
fn has_stiff_regions<const D: usize>(pins: &[PointPin<D>]) -> bool {
    pins.iter().any(|pin| pin.region.is_some_and(|region| region.stiffness != 1.0))
}

/// Product of the stiffness multipliers of all regions at a point.
pub(crate) fn region_stiffness_at<const D: usize>(pins: &[PointPin<D>], point: [f64; D]) -> f64 {
    pins.iter().map(|pin| region_stiffness(pin, point)).product()
}

/// Stiffness multiplier of a pin's region at a point: the full value at the pin, falling to 1 at the rim of the region, and
/// weaker as the pin fades out.
pub(crate) fn region_stiffness<const D: usize>(pin: &PointPin<D>, point: [f64; D]) -> f64 {
    let Some(region) = pin.region else { return 1.0 };
    let away = minus(&point, &pin.at);
    1.0 + (region.stiffness - 1.0) * pin.weight.min(1.0) * fade(dot(&away, &away).sqrt() / region.radius)
}
