//! The derivative of the best rotations in 3D with respect to the handles, for products of the second derivative with directions.
//!
//! In: gradients of samples, changes of the gradients. Out: changes of the rotations. With R the rotation nearest to J, S = RᵀJ
//! and M = tr(S) I − S, whose eigenvalues are the sums of two singular values: dR = R [ω]×, M ω = axial(RᵀdJ), and the second
//! derivative of ‖J − R‖² is 2 ‖dJ‖² − 2 axial · M⁻¹ axial (B. Smith et al., "Analytic Eigensystems for Isotropic Distortion
//! Energies", 2019, where the eigenvectors of M are the twist modes).

use super::polar::{LaneMatrix, cofactors, nearest_rotations};
use crate::solve::linalg::simd::{LANES, Lanes, lane_of, load, multiply_add, store};
use crate::solve::linalg::small_matrix::{SquareMatrix, nearest_rotation, symmetric_eigen, times, transpose};
use pulp::Simd;

/// Where the smallest sum of two singular values may be below this, M is inverted by its eigenvectors and the non-convex part is
/// left out: a gradient that is nearly flat or inverted has no stable nearest rotation.
const MIN_SUM: f64 = 0.5;

/// Responses of all samples of an energy at one state.
#[derive(Clone, Debug, Default)]
pub(crate) struct RotationResponse<const D: usize> {
    /// Responses of the packets of samples.
    pub(super) packets: Vec<PacketResponse<D>>,
    /// Responses of the rigid regions of pins.
    pub(super) regions: Vec<SampleResponse<D>>,
}

/// R and M⁻¹ of one gradient.
#[derive(Clone, Copy, Debug)]
pub(super) struct SampleResponse<const D: usize> {
    rotation: SquareMatrix<D>,
    inverse: SquareMatrix<D>,
}

/// R and M⁻¹ of four gradients, one per lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct PacketResponse<const D: usize> {
    rotation: [[Lanes; D]; D],
    inverse: [[Lanes; D]; D],
}

impl<const D: usize> SampleResponse<D> {
    /// Computes the response at a gradient; the eigenvalues of M⁻¹ are limited to `limit`.
    pub(super) fn at(gradient: &SquareMatrix<D>, limit: f64) -> Self {
        let rotation = nearest_rotation(gradient);
        let stretch = times(&transpose(&rotation), gradient);
        Self { rotation, inverse: limited_inverse(&spread(&stretch), limit) }
    }

    /// Returns matrices Q with weight · axial · M⁻¹ axial = Σ ⟨Q, dJ⟩², one for each eigenvalue of M⁻¹.
    pub(super) fn squares(&self, weight: f64) -> [SquareMatrix<D>; D] {
        let (values, vectors) = symmetric_eigen(&self.inverse);
        std::array::from_fn(|k| {
            let root = (weight * values[k].max(0.0)).sqrt();
            // Coefficients of ⟨v, axial(Rᵀ dJ)⟩ for the entries of dJ: R times the cross product matrix of v.
            std::array::from_fn(|row| {
                std::array::from_fn(|axis| {
                    let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
                    root * (vectors[last][k] * self.rotation[row][next] - vectors[next][k] * self.rotation[row][last])
                })
            })
        })
    }

    /// Returns dR for a change of the gradient.
    pub(super) fn turned(&self, change: &SquareMatrix<D>) -> SquareMatrix<D> {
        let local = times(&transpose(&self.rotation), change);
        let axial: [f64; D] =
            std::array::from_fn(|k| local[(k + 2) % 3][(k + 1) % 3] - local[(k + 1) % 3][(k + 2) % 3]);
        let turn: [f64; D] = std::array::from_fn(|row| (0..D).map(|k| self.inverse[row][k] * axial[k]).sum());
        let crossed = |row: &[f64; D]| {
            std::array::from_fn(|c| row[(c + 1) % 3] * turn[(c + 2) % 3] - row[(c + 2) % 3] * turn[(c + 1) % 3])
        };
        self.rotation.map(|row| crossed(&row))
    }
}

/// Returns M = tr(S) I − S for the symmetric part of S.
fn spread<const D: usize>(stretch: &SquareMatrix<D>) -> SquareMatrix<D> {
    let trace: f64 = (0..D).map(|k| stretch[k][k]).sum();
    std::array::from_fn(|a| {
        std::array::from_fn(|b| f64::from(u8::from(a == b)) * trace - 0.5 * (stretch[a][b] + stretch[b][a]))
    })
}

/// Returns the inverse of M with its eigenvalues limited to `limit`, and to ½ (which is convex) where M is nearly singular.
fn limited_inverse<const D: usize>(m: &SquareMatrix<D>, limit: f64) -> SquareMatrix<D> {
    let (values, vectors) = symmetric_eigen(m);
    let of = |value: f64| {
        let most = if value < MIN_SUM { limit.min(0.5) } else { limit };
        if value * most > 1.0 { 1.0 / value } else { most }
    };
    let shares = values.map(of);
    std::array::from_fn(|a| std::array::from_fn(|b| (0..D).map(|k| vectors[a][k] * shares[k] * vectors[b][k]).sum()))
}

impl<const D: usize> PacketResponse<D> {
    /// Computes the responses at four gradients, see [`SampleResponse::at`].
    #[inline(always)]
    pub(super) fn at<S: Simd>(simd: S, gradients: &LaneMatrix<S, D>, limit: f64) -> Self {
        let rotation = nearest_rotations(simd, gradients);
        let spread = spread_of(simd, &rotation, gradients);
        let (cofactors, det) = cofactors(simd, &spread);
        let inverse = cofactors.map(|row| row.map(|x| store::<S>(simd.div_f64s(x, det))));
        let mut response = Self { rotation: rotation.map(|row| row.map(|x| store::<S>(x))), inverse };
        let (spread, det) = (spread.map(|row| row.map(|x| store::<S>(x))), store::<S>(det));
        for lane in 0..LANES {
            // `half` is the sum of all singular values and bounds each eigenvalue of M from above, so det / half² is a lower
            // bound of the smallest.
            let half = 0.5 * (0..D).map(|k| spread[k][k][lane]).sum::<f64>();
            let least = if half > 0.0 { det[lane] / (half * half) } else { 0.0 };
            if least < MIN_SUM || least * limit < 1.0 {
                let m: SquareMatrix<D> = lane_of(&spread, lane);
                for (slots, row) in response.inverse.iter_mut().zip(limited_inverse(&m, limit)) {
                    slots.iter_mut().zip(row).for_each(|(slot, x)| slot[lane] = x);
                }
            }
        }
        response
    }

    /// Returns dR for changes of four gradients.
    #[inline(always)]
    pub(super) fn turned<S: Simd>(&self, simd: S, change: &LaneMatrix<S, D>) -> LaneMatrix<S, D> {
        let rotation = self.rotation.map(|row| row.map(|lanes| load::<S>(&lanes)));
        let zero = simd.splat_f64s(0.0);
        let local =
            |a: usize, b: usize| (0..D).fold(zero, |sum, k| multiply_add(simd, rotation[k][a], change[k][b], sum));
        let mut axial = [zero; D];
        for (k, slot) in axial.iter_mut().enumerate() {
            let (a, b) = ((k + 1) % 3, (k + 2) % 3);
            *slot = simd.sub_f64s(local(b, a), local(a, b));
        }
        let mut turn = [zero; D];
        for (slot, row) in turn.iter_mut().zip(&self.inverse) {
            *slot = row.iter().zip(&axial).fold(zero, |sum, (x, &a)| multiply_add(simd, load::<S>(x), a, sum));
        }
        let mut turned = *change;
        for (slots, row) in turned.iter_mut().zip(&rotation) {
            for (c, slot) in slots.iter_mut().enumerate() {
                let (a, b) = ((c + 1) % 3, (c + 2) % 3);
                *slot = simd.sub_f64s(simd.mul_f64s(row[a], turn[b]), simd.mul_f64s(row[b], turn[a]));
            }
        }
        turned
    }
}

/// Returns the symmetric part of tr(S) I − S, S = RᵀJ, for four gradients.
#[inline(always)]
fn spread_of<S: Simd, const D: usize>(
    simd: S,
    rotation: &LaneMatrix<S, D>,
    gradient: &LaneMatrix<S, D>,
) -> LaneMatrix<S, D> {
    let (zero, half) = (simd.splat_f64s(0.0), simd.splat_f64s(0.5));
    let entry =
        |a: usize, b: usize| (0..D).fold(zero, |sum, k| multiply_add(simd, rotation[k][a], gradient[k][b], sum));
    let mut spread = *gradient;
    let mut trace = zero;
    for a in 0..D {
        trace = simd.add_f64s(trace, entry(a, a));
    }
    for (a, row) in spread.iter_mut().enumerate() {
        for (b, slot) in row.iter_mut().enumerate() {
            let mean = simd.mul_f64s(half, simd.add_f64s(entry(a, b), entry(b, a)));
            *slot = if a == b { simd.sub_f64s(trace, mean) } else { simd.neg_f64s(mean) };
        }
    }
    spread
}
