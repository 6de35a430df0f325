//! The interface of all distortion energies, and the distortion metrics of reports.
//!
//! In: handles. Out: the constant normal matrix; per iteration the rotations and their right-hand side; metrics.

use super::rotation_response::RotationResponse;
use crate::solve::cancel::Cancel;
use crate::solve::linalg::normal_matrix::NormalMatrix;
use crate::solve::linalg::small_matrix::{SquareMatrix, area_of, determinant, dot, minus};

/// A sum of squares that is quadratic in the handles while its rotations are fixed. After a cancellation the results of an
/// interrupted method must be discarded.
pub(crate) trait Distortion<const D: usize>: Send + Sync + std::fmt::Debug {
    /// Divisor that turns the sum into the mean of ‖J − R‖²: twice the area that the energy covers.
    fn mass(&self) -> f64;

    /// Largest difference between handle indices that share an entry of the normal matrix.
    fn bandwidth(&self) -> usize;

    /// Adds `scale` times the constant normal matrix.
    fn add_normal(&self, scale: f64, normal: &mut NormalMatrix, cancel: &Cancel);

    /// Local step: finds the best rotations at `handles`, adds `scale` times their right-hand side, and returns the energy.
    fn local_step(&self, handles: &[[f64; D]], scale: f64, right_side: &mut [[f64; D]], cancel: &Cancel) -> f64;

    /// Costs of a local step and of [`Self::subtract_rotation_hessian`]; `None` if the latter is not implemented.
    fn flops(&self) -> Option<Flops> {
        None
    }

    /// Subtracts the rotation Hessian from the constant matrix of all coordinates (row D·handle + coordinate). The difference is
    /// the second derivative at `handles`.
    fn subtract_rotation_hessian(
        &self,
        _handles: &[[f64; D]],
        _hessian: RotationHessian,
        _normal: &mut NormalMatrix,
        _cancel: &Cancel,
    ) {
    }

    /// Computes the derivative of the best rotations with respect to the handles, limited as in [`RotationHessian`]; `None` if
    /// [`Self::subtract_rotation_product`] is not implemented.
    fn rotation_response(&self, _handles: &[[f64; D]], _limit: f64) -> Option<RotationResponse<D>> {
        None
    }

    /// Subtracts the rotation Hessian times a scaled direction of the handles from the product of the constant matrix and that
    /// direction.
    fn subtract_rotation_product(
        &self,
        _response: &RotationResponse<D>,
        _along: ScaledDirection<D>,
        _product: &mut [[f64; D]],
        _cancel: &Cancel,
    ) {
    }

    /// Energy at `handles` with the rotations that are best at `rotations_at`.
    fn energy(&self, handles: &[[f64; D]], rotations_at: &[[f64; D]]) -> f64;

    /// Distortion metrics at `handles`.
    fn metrics(&self, handles: &[[f64; D]]) -> DistortionMetrics;
}

/// A direction of the handles, or their positions, with a factor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ScaledDirection<'a, const D: usize> {
    /// One vector per handle.
    pub(crate) direction: &'a [[f64; D]],
    /// Factor by which what is computed for it is multiplied.
    pub(crate) scale: f64,
}

/// Costs in fused multiply-adds.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Flops {
    /// Cost of a local step.
    pub(crate) local_step: f64,
    /// Cost of the rotation Hessian.
    pub(crate) rotation_hessian: f64,
}

/// Parameters of the rotation Hessian: the part by which the change of the best rotations reduces the second derivative.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RotationHessian {
    /// Factor by which the energy is multiplied.
    pub(crate) scale: f64,
    /// Upper limit of 1/(s1 + s2), where s1 and s2 are the singular values of a sample; with at most ½ every sample is convex.
    pub(crate) limit: f64,
}

/// Distortion of a shape, accumulated from samples weighted by area.
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

    /// Adds a sample with the gradient J of the lattice.
    pub(crate) fn add<const D: usize>(&mut self, area: f64, gradient: &SquareMatrix<D>) {
        let det = determinant(gradient);
        let norm: f64 = gradient.iter().flatten().map(|x| x * x).sum();
        // In 2D s1² + s2² = ‖J‖² and s1·s2 = |det J|; in 3D the arguments are means over the three directions.
        self.add_measured(area, det, norm / D as f64, if D == 2 { det.abs() } else { det.abs().powf(2.0 / D as f64) });
    }

    /// Adds a triangle with its rest and moved corners; degenerate triangles are ignored.
    pub(crate) fn add_triangle<const D: usize>(&mut self, rest: [&[f64; D]; 3], moved: [&[f64; D]; 3]) {
        let sides = |corners: [&[f64; D]; 3]| [minus(corners[1], corners[0]), minus(corners[2], corners[0])];
        let ([u, v], [a, b]) = (sides(rest), sides(moved));
        let doubled = area_of(&u, &v);
        if doubled <= 0.0 {
            return;
        }
        // In orthonormal coordinates of the rest triangle the map is a 2 × 2 (in 3D a 3 × 2) matrix with columns `first` and
        // `second`.
        let along = dot(&u, &u).sqrt();
        let (shear, height) = (dot(&u, &v) / along, doubled / along);
        let first: [f64; D] = std::array::from_fn(|d| a[d] / along);
        let second: [f64; D] = std::array::from_fn(|d| (b[d] - shear * first[d]) / height);
        let turned = if D == 2 && u[0] * v[1] - u[1] * v[0] < 0.0 { -1.0 } else { 1.0 };
        let det =
            if D == 2 { turned * (first[0] * second[1] - first[1] * second[0]) } else { area_of(&first, &second) };
        self.add_measured(0.5 * doubled, det, 0.5 * (dot(&first, &first) + dot(&second, &second)), det.abs());
    }

    /// Adds a sample with its determinant, the mean square (`power`) and the squared geometric mean (`volume`) of its singular
    /// values.
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
