//! Distortion measures of a deformed mesh.
//!
//! In: rest shape and moved vertices. Out: sums over the triangles, with σ1 ≥ σ2 the singular values of the map of a triangle and
//! ρ its fraction of the total rest area. Liu et al., "A Local/Global Approach to Mesh Parameterization", 2008, for `ang_liu` and
//! `area_liu`. Triangles without rest area are left out.

use crate::solve::linalg::small_matrix::{area_of, dot, minus, singular_values};
use crate::solve::problem::Shape;
use serde::Serialize;

/// Distortion of a mesh. Without distortion all measures are 0, except `ang_liu` and `area_liu` (2), `min_*` and `max_s` (1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(crate) struct Measures {
    /// `ang_liu` − 2.
    pub angular: f64,
    /// `area_liu` − 2.
    pub area: f64,
    /// Σ ρ (σ1/σ2 + σ2/σ1).
    pub ang_liu: f64,
    /// Σ ρ (σ1σ2 + 1/(σ1σ2)).
    pub area_liu: f64,
    /// Mean change of the angles of the triangles, in radians.
    pub ang_rad: f64,
    /// `ang_rad` weighted by rest area.
    pub ang_rad_w: f64,
    /// Σ ρ |σ1σ2 − 1|.
    pub area_abs: f64,
    /// Mean |σ1σ2 − 1|.
    pub area_abs_u: f64,
    /// Σ |A'/ΣA' − A/ΣA|.
    pub area_norm: f64,
    /// Σ ρ ((σ1−1)² + (σ2−1)²).
    pub arap: f64,
    /// Number of flipped triangles (det J ≤ 0).
    pub flips: usize,
    /// Smallest det J; in 3D, where triangles have no orientation, the smallest σ1σ2.
    pub min_det: f64,
    /// Smallest singular value.
    pub min_s: f64,
    /// Largest singular value.
    pub max_s: f64,
}

/// Measures of one triangle.
struct Element {
    rest_area: f64,
    moved_area: f64,
    singular: [f64; 2],
    det: f64,
    /// Mean change of the three angles, in radians.
    angle: f64,
}

impl Measures {
    /// Measures all triangles of a shape that have rest area; `moved` is #vertices.
    #[must_use]
    pub(crate) fn of<const D: usize>(shape: &Shape<D>, moved: &[[f64; D]]) -> Self {
        let elements: Vec<Element> = shape
            .triangles
            .iter()
            .filter_map(|corners| {
                let corners = corners.map(|corner| corner as usize);
                Element::of(corners.map(|k| shape.points[k]), corners.map(|k| moved[k]))
            })
            .collect();
        if elements.is_empty() {
            return Self { ang_liu: 2.0, area_liu: 2.0, min_det: 1.0, min_s: 1.0, max_s: 1.0, ..Self::default() };
        }
        Self::sum(&elements)
    }

    fn sum(elements: &[Element]) -> Self {
        let total = |pick: fn(&Element) -> f64| elements.iter().map(pick).sum::<f64>();
        let (rest, now, count) = (total(|e| e.rest_area), total(|e| e.moved_area), elements.len() as f64);
        let mean = |pick: fn(&Element) -> f64| elements.iter().map(|e| e.rest_area / rest * pick(e)).sum::<f64>();
        let least = |pick: fn(&Element) -> f64| elements.iter().map(pick).fold(f64::INFINITY, f64::min);
        let ang_liu = mean(|e| finite(e.singular[0] / e.singular[1] + e.singular[1] / e.singular[0]));
        let area_liu = mean(|e| finite(e.product() + 1.0 / e.product()));
        Self {
            angular: ang_liu - 2.0,
            area: area_liu - 2.0,
            ang_liu,
            area_liu,
            ang_rad: total(|e| e.angle) / count,
            ang_rad_w: mean(|e| e.angle),
            area_abs: mean(|e| (e.product() - 1.0).abs()),
            area_abs_u: total(|e| (e.product() - 1.0).abs()) / count,
            area_norm: elements
                .iter()
                .map(|e| (e.moved_area / now.max(f64::MIN_POSITIVE) - e.rest_area / rest).abs())
                .sum(),
            arap: mean(|e| (e.singular[0] - 1.0).powi(2) + (e.singular[1] - 1.0).powi(2)),
            flips: elements.iter().filter(|e| e.det <= 0.0).count(),
            min_det: least(|e| e.det),
            min_s: least(|e| e.singular[1]),
            max_s: -least(|e| -e.singular[0]),
        }
    }
}

impl Element {
    fn of<const D: usize>(rest: [[f64; D]; 3], moved: [[f64; D]; 3]) -> Option<Self> {
        let sides = |corners: &[[f64; D]; 3]| [minus(&corners[1], &corners[0]), minus(&corners[2], &corners[0])];
        let ([u, v], [a, b]) = (sides(&rest), sides(&moved));
        let (doubled, moved_doubled) = (area_of(&u, &v), area_of(&a, &b));
        // An area within the rounding error of the sides counts as zero.
        if doubled <= 1e-14 * (dot(&u, &u) + dot(&v, &v)) {
            return None;
        }
        // In orthonormal coordinates of the rest triangle the map has two columns.
        let along = dot(&u, &u).sqrt();
        let (shear, height) = (dot(&u, &v) / along, doubled / along);
        let first: [f64; D] = std::array::from_fn(|d| a[d] / along);
        let second: [f64; D] = std::array::from_fn(|d| (b[d] - shear * first[d]) / height);
        let sign = if D == 2 { (turn(&u, &v) * turn(&a, &b)).signum() } else { 1.0 };
        let changes = (0..3).map(|k| (angle(&moved, k) - angle(&rest, k)).abs());
        Some(Self {
            rest_area: 0.5 * doubled,
            moved_area: 0.5 * moved_doubled,
            singular: singular_values(&first, &second),
            det: sign * moved_doubled / doubled,
            angle: changes.sum::<f64>() / 3.0,
        })
    }

    fn product(&self) -> f64 {
        self.singular[0] * self.singular[1]
    }
}

/// Signed area of the parallelogram of u and v in the plane of the first two axes.
fn turn<const D: usize>(u: &[f64; D], v: &[f64; D]) -> f64 {
    u[0] * v[1] - u[1] * v[0]
}

/// Angle at a corner, in radians; 0 where an adjacent side has no length.
fn angle<const D: usize>(corners: &[[f64; D]; 3], k: usize) -> f64 {
    let u = minus(&corners[(k + 1) % 3], &corners[k]);
    let v = minus(&corners[(k + 2) % 3], &corners[k]);
    area_of(&u, &v).atan2(dot(&u, &v))
}

/// Limits the distortion of collapsed triangles to 1e9, because JSON has no infinity.
fn finite(value: f64) -> f64 {
    if value < 1e9 { value } else { 1e9 }
}
