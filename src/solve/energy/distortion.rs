//! The interface of all distortion measures, and the distortion metrics of reports.
//!
//! In: handles. Out: the constant normal matrix, per iteration rotations and right side, metrics.

use super::rotation_response::RotationResponse;
use crate::solve::cancel::Cancel;
use crate::solve::linalg::normal_matrix::NormalMatrix;
use crate::solve::linalg::small_matrix::{SquareMatrix, area_of, determinant, dot, minus};

/// A sum of squares that is quadratic in the handles for fixed rotations. Results of methods that were interrupted by a
/// cancellation must not be used.
pub(crate) trait Distortion<const D: usize>: Send + Sync + std::fmt::Debug {
    /// Divisor that turns the sum into a mean of ‖J−R‖²: twice the area it covers.
    fn mass(&self) -> f64;

    /// Largest difference of handle indices that meet in the matrix.
    fn bandwidth(&self) -> usize;

    /// Adds the constant matrix.
    fn add_normal(&self, scale: f64, normal: &mut NormalMatrix, cancel: &Cancel);

    /// Local step: the best rotations at `handles`. Adds their right side, times `scale`, and returns the energy.
    fn local_step(&self, handles: &[[f64; D]], scale: f64, right_side: &mut [[f64; D]], cancel: &Cancel) -> f64;

    /// Cost of a local step and of [`Self::subtract_rotation_hessian`]; `None` where the latter is not implemented.
    fn flops(&self) -> Option<Flops> {
        None
    }

    /// Subtracts the rotation Hessian from the constant matrix of all coordinates (rows D·handle + coordinate), which gives
    /// the second derivative at `handles`.
    fn subtract_rotation_hessian(
        &self,
        _handles: &[[f64; D]],
        _hessian: RotationHessian,
        _normal: &mut NormalMatrix,
        _cancel: &Cancel,
    ) {
    }

    /// How best rotations follow the handles, their changes limited as in [`RotationHessian`]; `None` where
    /// [`Self::subtract_rotation_product`] is not implemented.
    fn rotation_response(&self, _handles: &[[f64; D]], _limit: f64) -> Option<RotationResponse<D>> {
        None
    }

    /// Subtracts the rotation Hessian times a direction of the handles, and times a factor, from a product with the constant matrix.
    fn subtract_rotation_product(
        &self,
        _response: &RotationResponse<D>,
        _along: (&[[f64; D]], f64),
        _product: &mut [[f64; D]],
        _cancel: &Cancel,
    ) {
    }

    /// The energy at `handles` under the rotations that are best at `rotations_at`.
    fn energy(&self, handles: &[[f64; D]], rotations_at: &[[f64; D]]) -> f64;

    /// Distortion metrics at `handles`.
    fn metrics(&self, handles: &[[f64; D]]) -> DistortionMetrics;
}

/// Numbers of fused multiply-adds.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Flops {
    /// Of a local step.
    pub(crate) local_step: f64,
    /// Of the rotation Hessian.
    pub(crate) rotation_hessian: f64,
}

/// Parameters of the rotation Hessian: the part of the second derivative that vanishes because rotations follow the handles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RotationHessian {
    /// Factor of the energy.
    pub(crate) scale: f64,
    /// Upper limit of 1/(s1 + s2), s1 and s2 the singular values of a sample: up to ½ every sample stays convex.
    pub(crate) limit: f64,
}

/// Area-weighted sums over samples.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DistortionMetrics {
    min_det: f64,
    area: f64,
    angular_sum: f64,
    area_sum: f64,
}

impl DistortionMetrics {
    pub(crate) fn new() -> Self {
        Self { min_det: f64::INFINITY, area: 0.0, angular_sum: 0.0, area_sum: 0.0 }
    }

    /// Adds a sample by its gradient.
    pub(crate) fn add<const D: usize>(&mut self, area: f64, gradient: &SquareMatrix<D>) {
        let det = determinant(gradient);
        let norm: f64 = gradient.iter().flatten().map(|x| x * x).sum();
        // In 2D s1² + s2² = ‖J‖² and s1·s2 = |det J|; in 3D these are means over the three directions.
        self.add_measured(area, det, norm / D as f64, if D == 2 { det.abs() } else { det.abs().powf(2.0 / D as f64) });
    }

    /// Adds a triangle by its rest and moved corners; degenerate triangles are ignored.
    pub(crate) fn add_triangle<const D: usize>(&mut self, rest: [&[f64; D]; 3], moved: [&[f64; D]; 3]) {
        let sides = |corners: [&[f64; D]; 3]| [minus(corners[1], corners[0]), minus(corners[2], corners[0])];
        let ([u, v], [a, b]) = (sides(rest), sides(moved));
        let doubled = area_of(&u, &v);
        if doubled <= 0.0 {
            return;
        }
        // In an orthonormal frame of the rest triangle the map is a 2 x 2 (or 3 x 2) matrix.
        let along = dot(&u, &u).sqrt();
        let (shear, height) = (dot(&u, &v) / along, doubled / along);
        let first: [f64; D] = std::array::from_fn(|d| a[d] / along);
        let second: [f64; D] = std::array::from_fn(|d| (b[d] - shear * first[d]) / height);
        let turned = if D == 2 && u[0] * v[1] - u[1] * v[0] < 0.0 { -1.0 } else { 1.0 };
        let det =
            if D == 2 { turned * (first[0] * second[1] - first[1] * second[0]) } else { area_of(&first, &second) };
        self.add_measured(0.5 * doubled, det, 0.5 * (dot(&first, &first) + dot(&second, &second)), det.abs());
    }

    /// Adds a sample by determinant, mean squared singular value, and squared geometric mean of them.
    fn add_measured(&mut self, area: f64, det: f64, power: f64, volume: f64) {
        let volume = volume.max(1e-12);
        self.min_det = self.min_det.min(det);
        self.area += area;
        self.angular_sum += area * (2.0 * power / volume - 2.0).max(0.0);
        self.area_sum += area * (volume + 1.0 / volume - 2.0);
    }

    /// Smallest determinant; 1 without samples.
    pub(crate) fn min_det(&self) -> f64 {
        if self.area > 0.0 { self.min_det } else { 1.0 }
    }

    /// Mean of s1/s2 + s2/s1 − 2.
    pub(crate) fn angular(&self) -> f64 {
        if self.area > 0.0 { self.angular_sum / self.area } else { 0.0 }
    }

    /// Mean of s1·s2 + 1/(s1·s2) − 2.
    pub(crate) fn area(&self) -> f64 {
        if self.area > 0.0 { self.area_sum / self.area } else { 0.0 }
    }
}
