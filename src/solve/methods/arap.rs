//! As-rigid-as-possible deformation of a mesh without a lattice.
//!
//! O. Sorkine, M. Alexa, "As-rigid-as-possible surface modeling", SGP 2007, <https://doi.org/10.2312/SGP/SGP07/109-116>:
//! cotangent weights, one rotation per vertex over its spokes, handles as hard constraints.
//!
//! In: shape and pins (each acts on its nearest vertex). Out: moved vertices, #vertices.

use crate::solve::energy::{HalfEdges, edges};
use crate::solve::error::SolveError;
use crate::solve::linalg::small_matrix::{apply, best_rotation, dot, minus};
use crate::solve::linalg::sparse::SparseFactor;
use crate::solve::problem::{PointPin, Shape};
use crate::solve::settings::EdgeWeights;

/// Settings of the iteration.
#[derive(Clone, Copy, Debug)]
pub struct Arap {
    /// Maximum number of local-global iterations.
    pub iteration_limit: usize,
    /// The iteration stops when no vertex moves farther than this fraction of the diagonal of the shape's bounding box.
    pub tolerance: f64,
}

impl Default for Arap {
    fn default() -> Self {
        Self { iteration_limit: 2000, tolerance: 1e-6 }
    }
}

/// Weight of the rest positions relative to the mean diagonal of the matrix. It determines parts without a pin, which stay in
/// place, as isolated meshes do in differential methods.
const TETHER: f64 = 1e-9;

impl Arap {
    /// Moves the vertices; returns them and the number of iterations.
    ///
    /// # Errors
    /// [`SolveError::Singular`] if the matrix cannot be factored.
    pub fn deform<const D: usize>(
        &self,
        shape: &Shape<D>,
        pins: &[PointPin<D>],
    ) -> Result<(Vec<[f64; D]>, usize), SolveError> {
        let system = System::new(shape, pins)?;
        let mut points = shape.points.clone();
        let tolerance = self.tolerance * shape.diagonal();
        for iteration in 1..=self.iteration_limit {
            let next = system.step(&points);
            let moved = points.iter().zip(&next).map(|(a, b)| {
                let step = minus(a, b);
                dot(&step, &step)
            });
            let is_at_rest = moved.fold(0.0, f64::max).sqrt() <= tolerance;
            points = next;
            if is_at_rest {
                return Ok((points, iteration));
            }
        }
        Ok((points, self.iteration_limit))
    }
}

/// The global step, with its factored matrix.
struct System<'a, const D: usize> {
    shape: &'a Shape<D>,
    edges: HalfEdges,
    /// Positions of held vertices; `None` for free ones. #vertices.
    held: Vec<Option<[f64; D]>>,
    /// Matrix row of each free vertex, #vertices.
    rows: Vec<usize>,
    tether: f64,
    factor: SparseFactor,
}

impl<'a, const D: usize> System<'a, D> {
    fn new(shape: &'a Shape<D>, pins: &[PointPin<D>]) -> Result<Self, SolveError> {
        let edges = HalfEdges::new(shape.points.len(), &edges(shape, EdgeWeights::Cot));
        let held = held_vertices(shape, pins);
        let mut free = 0;
        let rows = held.iter().map(|held| {
            free += usize::from(held.is_none());
            free.saturating_sub(1)
        });
        let rows: Vec<usize> = rows.collect();
        let degree = |i: usize| edges.of(i).iter().map(|edge| edge.1).sum::<f64>();
        let count = held.len();
        let mean = (0..count).map(degree).sum::<f64>() / count.max(1) as f64;
        let tether = TETHER * mean.max(f64::MIN_POSITIVE);
        let mut entries = Vec::new();
        for i in (0..count).filter(|&i| held[i].is_none()) {
            entries.push((rows[i], rows[i], degree(i) + tether));
            let below = edges.of(i).iter().filter(|(j, _)| *j < i && held[*j].is_none());
            entries.extend(below.map(|&(j, weight)| (rows[i], rows[j], -weight)));
        }
        let factor = SparseFactor::new(free, &entries).ok_or_else(|| SolveError::Singular {
            what: "as-rigid-as-possible deformation".into(),
            hint: "remove triangles without area".into(),
        })?;
        Ok(Self { shape, edges, held, rows, tether, factor })
    }

    /// One iteration: best rotations at `points` (equation 6 of the paper), then
    /// Σ_j w (p'_i − p'_j) = Σ_j w ½ (R_i + R_j) (p_i − p_j) (equation 8), with held vertices on the right-hand side.
    fn step(&self, points: &[[f64; D]]) -> Vec<[f64; D]> {
        let rest = &self.shape.points;
        let rotations: Vec<_> = (0..rest.len())
            .map(|i| {
                let mut s = [[0.0; D]; D];
                for &(j, weight) in self.edges.of(i) {
                    let (before, now) = (minus(&rest[i], &rest[j]), minus(&points[i], &points[j]));
                    for a in 0..D {
                        (0..D).for_each(|b| s[a][b] += weight * before[a] * now[b]);
                    }
                }
                best_rotation(&s)
            })
            .collect();
        let mut sides = Vec::with_capacity(rest.len());
        for i in (0..rest.len()).filter(|&i| self.held[i].is_none()) {
            let mut side = rest[i].map(|x| self.tether * x);
            for &(j, weight) in self.edges.of(i) {
                let before = minus(&rest[i], &rest[j]);
                let (a, b) = (apply(&rotations[i], &before), apply(&rotations[j], &before));
                let held = self.held[j].unwrap_or([0.0; D]);
                (0..D).for_each(|d| side[d] += weight * (0.5 * (a[d] + b[d]) + held[d]));
            }
            sides.push(side);
        }
        self.factor.solve(&mut sides);
        (0..rest.len()).map(|i| self.held[i].unwrap_or_else(|| sides[self.rows[i]])).collect()
    }
}

/// Applies the displacement of each pin to its nearest vertex; a vertex with several pins gets their mean displacement.
fn held_vertices<const D: usize>(shape: &Shape<D>, pins: &[PointPin<D>]) -> Vec<Option<[f64; D]>> {
    let mut sums = vec![([0.0; D], 0.0); shape.points.len()];
    for pin in pins.iter().filter(|pin| pin.weight > 0.0) {
        let distance = |point: &[f64; D]| {
            let gap = minus(point, &pin.at);
            dot(&gap, &gap)
        };
        let points = shape.points.iter().map(distance).enumerate();
        let Some((vertex, _)) = points.min_by(|a, b| a.1.total_cmp(&b.1)) else { continue };
        let (sum, count) = &mut sums[vertex];
        (0..D).for_each(|d| sum[d] += pin.target[d] - pin.at[d]);
        *count += 1.0;
    }
    let place = |(point, (sum, count)): (&[f64; D], ([f64; D], f64))| {
        (count > 0.0).then(|| std::array::from_fn(|d| point[d] + sum[d] / count))
    };
    shape.points.iter().zip(sums).map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a strip of squares along x.
    fn strip() -> Shape<2> {
        let points = (0..12).map(|k| [f64::from(k / 2), f64::from(k % 2)]).collect();
        let triangles = (0..5).flat_map(|k| [[2 * k, 2 * k + 2, 2 * k + 3], [2 * k, 2 * k + 3, 2 * k + 1]]).collect();
        Shape::of_triangles(points, triangles)
    }

    #[test]
    fn a_rigid_motion_of_pins_is_one_of_the_mesh() {
        let turn = |[x, y]: [f64; 2]| [0.6 * x - 0.8 * y + 3.0, 0.8 * x + 0.6 * y - 1.0];
        let shape = strip();
        let pins: Vec<_> = [0, 1, 11].map(|k| PointPin::new(shape.points[k], turn(shape.points[k]))).to_vec();
        let (moved, _) = Arap { tolerance: 1e-12, ..Arap::default() }.deform(&shape, &pins).expect("solvable");
        for (found, rest) in moved.iter().zip(&shape.points) {
            let wanted = turn(*rest);
            assert!((found[0] - wanted[0]).hypot(found[1] - wanted[1]) < 1e-4, "{found:?} {wanted:?}");
        }
    }

    #[test]
    fn parts_without_pins_stay() {
        let mut shape = strip();
        shape.points.extend([[9.0, 9.0], [10.0, 9.0], [9.0, 10.0]]);
        shape.triangles.push([12, 13, 14]);
        let pins = [PointPin::new([0.0, 0.0], [1.0, 0.0])];
        let (moved, _) = Arap::default().deform(&shape, &pins).expect("solvable");
        assert!((moved[13][0] - 10.0).abs() < 1e-6 && (moved[11][0] - 6.0).abs() < 1e-3, "{moved:?}");
    }
}
