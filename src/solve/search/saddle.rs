//! Second-order check of a stationary state, and the direction of descent from a saddle.
//!
//! In: a state at which the energy is stationary. Out: whether it is a minimum; a displacement along which the energy falls. The
//! direction of least curvature is found by locally optimal preconditioned conjugate gradients (A. Knyazev, "Toward the Optimal
//! Preconditioned Eigensolver", 2001).

use crate::solve::cancel::Cancelled;
use crate::solve::energy::RotationHessian;
use crate::solve::linalg::factorization::Factorization;
use crate::solve::linalg::normal_matrix::NormalMatrix;
use crate::solve::linalg::small_matrix::symmetric_eigen;
use crate::solve::minimization::Minimization;

/// Maximum number of steps towards the direction of least curvature.
const STEPS: usize = 60;

/// Quotient of curvatures of H and K from which on a direction counts as flat.
const FLAT: f64 = -1e-9;

/// The least curvature has converged if a step lowers it by less than this fraction.
const SETTLED: f64 = 1e-3;

/// Mean ‖ΔJ‖² of the first displacement from a saddle.
const AWAY: f64 = 1e-2;

/// Maximum number of trials, each with half the displacement, until the energy is lower.
const HALVINGS: usize = 12;

type Vectors<const D: usize> = Vec<[f64; D]>;

/// A direction with its products with K and H.
///
/// The direction of least curvature relative to the constant matrix K minimises ⟨v, H v⟩/⟨v, K v⟩ over directions that move no hard
/// pin; K preconditions. As H = K − G with G ≥ 0, the quotient is close to 1 for all but the soft directions, and the steps converge
/// fast.
#[derive(Clone)]
struct Direction<const D: usize> {
    by: Vectors<D>,
    constant: Vectors<D>,
    second: Vectors<D>,
}

impl<const D: usize> Minimization<'_, D> {
    /// Whether a stationary state is a minimum: the second derivative is positive definite, or the energy falls along no direction.
    pub(super) fn is_minimum(&self, handles: &[[f64; D]]) -> Result<bool, Cancelled> {
        let factor = Factorization::of_positive(self.second_derivative(handles), self.cancel);
        self.cancel.check()?;
        Ok(factor.is_some() || self.descent_direction(handles)?.is_none())
    }

    /// Returns a displacement from a saddle to a lower state; `None` if the energy falls along no direction.
    pub(super) fn descent_direction(&self, handles: &[[f64; D]]) -> Result<Option<Vectors<D>>, Cancelled> {
        let second = self.second_derivative(handles);
        let mut direction = self.with_products(self.projected(generic(handles.len())), &second);
        let mut last: Option<Direction<D>> = None;
        let mut least = f64::INFINITY;
        for _ in 0..STEPS {
            self.cancel.check()?;
            direction = direction.scaled();
            let curvature = dot(&direction.by, &direction.second);
            if curvature.is_nan() || curvature < FLAT && least - curvature < SETTLED * curvature.abs() {
                break;
            }
            least = curvature;
            let residual = combined(&direction.second, 1.0, &direction.constant, -curvature);
            let step = self.with_products(self.projected(residual), &second);
            let basis: Vec<Direction<D>> = [Some(direction.clone()), Some(step), last].into_iter().flatten().collect();
            let Some(next) = lowest(basis) else { break };
            last = Some(next.minus(&direction));
            direction = next;
        }
        let curvature = dot(&direction.by, &direction.second) / dot(&direction.by, &direction.constant);
        if curvature.is_nan() || curvature >= FLAT {
            return Ok(None);
        }
        let from = self.energy(handles);
        let stiffness = self.scales.shape * self.distortion.mass();
        let mut length = (AWAY * stiffness / dot(&direction.by, &direction.constant)).sqrt();
        for _ in 0..HALVINGS {
            let ahead = combined(handles, 1.0, &direction.by, length);
            if self.energy(&ahead) < from {
                return Ok(Some(combined(&direction.by, length, &direction.by, 0.0)));
            }
            length *= 0.5;
        }
        Ok(None)
    }

    /// Returns ⟨x, K x⟩.
    pub(super) fn squared_length(&self, x: &[[f64; D]]) -> f64 {
        let mut image = vec![[0.0; D]; x.len()];
        self.normal.subtract_matvec(x, &mut image);
        -dot(x, &image)
    }

    fn second_derivative(&self, handles: &[[f64; D]]) -> NormalMatrix {
        let mut second = self.normal.kron_identity::<D>(Vec::new());
        let hessian = RotationHessian { scale: self.scales.shape, limit: f64::INFINITY };
        self.distortion.subtract_rotation_hessian(handles, hessian, &mut second, self.cancel);
        second
    }

    /// Returns K⁻¹ times a residual, projected onto directions that move no hard pin.
    fn projected(&self, mut residual: Vectors<D>) -> Vectors<D> {
        self.factor.solve(&mut residual);
        self.constraints.project(self.terms, &mut Vec::new(), &mut residual);
        residual
    }

    fn with_products(&self, by: Vectors<D>, second: &NormalMatrix) -> Direction<D> {
        let (mut constant, mut image) = (vec![[0.0; D]; by.len()], vec![[0.0; D]; by.len()]);
        self.normal.subtract_matvec(&by, &mut constant);
        second.subtract_matvec(by.as_flattened().as_chunks::<1>().0, image.as_flattened_mut().as_chunks_mut::<1>().0);
        let negative = |vectors: Vectors<D>| vectors.into_iter().map(|x| x.map(|x| -x)).collect();
        Direction { by, constant: negative(constant), second: negative(image) }
    }
}

impl<const D: usize> Direction<D> {
    /// Scales the direction so that ⟨v, K v⟩ = 1.
    fn scaled(self) -> Self {
        let factor = 1.0 / dot(&self.by, &self.constant).sqrt();
        let of = |vectors: &Vectors<D>| combined(vectors, factor, vectors, 0.0);
        Self { by: of(&self.by), constant: of(&self.constant), second: of(&self.second) }
    }

    fn minus(&self, other: &Self) -> Self {
        self.plus(1.0, other, -1.0)
    }

    fn plus(&self, own: f64, other: &Self, share: f64) -> Self {
        Self {
            by: combined(&self.by, own, &other.by, share),
            constant: combined(&self.constant, own, &other.constant, share),
            second: combined(&self.second, own, &other.second, share),
        }
    }
}

/// Returns the direction of least curvature among the linear combinations of up to three.
fn lowest<const D: usize>(basis: Vec<Direction<D>>) -> Option<Direction<D>> {
    let mut orthonormal: Vec<Direction<D>> = Vec::new();
    for mut direction in basis {
        let length = dot(&direction.by, &direction.constant).sqrt();
        for _ in 0..2 {
            for other in &orthonormal {
                let share = dot(&direction.by, &other.constant);
                direction = direction.plus(1.0, other, -share);
            }
        }
        // A direction that depends linearly on the others is left out.
        if dot(&direction.by, &direction.constant).sqrt() > 1e-8 * length {
            orthonormal.push(direction.scaled());
        }
    }
    // Directions that are left out get a large curvature.
    let mut matrix = [[0.0; 3]; 3];
    for (a, row) in matrix.iter_mut().enumerate() {
        for (b, slot) in row.iter_mut().enumerate() {
            *slot = match (orthonormal.get(a), orthonormal.get(b)) {
                (Some(x), Some(y)) => dot(&x.by, &y.second),
                _ => f64::from(u8::from(a == b)) * 1e9,
            };
        }
    }
    let (values, vectors) = symmetric_eigen(&matrix);
    let best = (0..3).min_by(|&a, &b| values[a].total_cmp(&values[b]))?;
    let mut terms = orthonormal.iter().enumerate();
    let (_, first) = terms.next()?;
    let start = first.plus(vectors[0][best], first, 0.0);
    Some(terms.fold(start, |sum, (k, direction)| sum.plus(1.0, direction, vectors[k][best])))
}

/// A deterministic vector with components along all directions.
fn generic<const D: usize>(count: usize) -> Vectors<D> {
    (0..count).map(|k| std::array::from_fn(|d| (12.9898 * (k * D + d + 1) as f64).sin())).collect()
}

fn dot<const D: usize>(a: &[[f64; D]], b: &[[f64; D]]) -> f64 {
    a.as_flattened().iter().zip(b.as_flattened()).map(|(x, y)| x * y).sum()
}

fn combined<const D: usize>(a: &[[f64; D]], x: f64, b: &[[f64; D]], y: f64) -> Vectors<D> {
    a.iter().zip(b).map(|(a, b)| std::array::from_fn(|d| x * a[d] + y * b[d])).collect()
}
