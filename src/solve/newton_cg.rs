//! Newton's method with conjugate gradients, for lattices in space: their second derivative is too wide a band to be factored.
//!
//! In: a state near the solution. Out: converged handles. A step solves with the second derivative by conjugate gradients,
//! preconditioned by the factor of local-global steps and projected onto directions that move no hard pin (N. Gould, M. Hribar
//! and J. Nocedal, "On the Solution of Equality Constrained Quadratic Programming Problems Arising in Optimization", 2001). The
//! first direction is the local-global step itself; a direction of negative curvature ends the search (T. Steihaug, "The
//! Conjugate Gradient Method and Trust Regions in Large Scale Optimization", 1983).

use super::cancel::Cancelled;
use super::energy::RotationResponse;
use super::minimization::{FinalPhase, Minimization, MinimizationResult, SAFEGUARD, largest_step};

/// Local-global steps before Newton's method: they rotate parts farther than a tangent step could.
const FIRST_STEPS: usize = 6;

/// Newton's method takes over at a local-global step this small (in box diagonals).
const NEAR: f64 = 3e-3;

/// Limits of 1/(s1 + s2), tried in this order: the second derivative itself, then what of it is convex.
const CONVEXITY_LIMITS: [f64; 2] = [f64::INFINITY, 0.5];

/// Step lengths that are tried where the full step would raise the energy.
const STEP_LENGTHS: [f64; 3] = [0.5, 0.25, 0.0625];

/// Step lengths that are tried along a direction of negative curvature.
const FAR_LENGTHS: [f64; 5] = [1.0, 2.0, 4.0, 8.0, 16.0];

/// Negative curvature where a local-global step is below this many tolerances belongs to a saddle between symmetric
/// solutions: the solve stays there, as one by factorisation would.
const SYMMETRIC: f64 = 100.0;

/// Part of its first length to which the residual of a step is brought: at most, and at least.
const FORCING: [f64; 2] = [0.3, 1e-2];

/// Directions of a step at most.
const DIRECTIONS: usize = 100;

/// Length of a step, in box diagonals, beyond which it is not solved any further: rotations are far from their tangents.
const LONGEST: f64 = 0.1;

/// Curvature over that of the constant matrix below which a direction counts as flat.
const FLAT: f64 = 1e-9;

/// A last step is solved until a direction moves no handle by more than this part of the tolerance.
const CERTAIN: f64 = 0.1;

/// A step this small (in box diagonals) is rounding.
const AT_REST: f64 = 1e-10;

type Vectors<const D: usize> = Vec<[f64; D]>;

impl<const D: usize> Minimization<'_, D> {
    /// Whether Newton's method takes over from the local-global step of this number and length at `handles`.
    pub(crate) fn should_switch_in_space(&self, (number, step): (usize, f64)) -> bool {
        let is_wanted = D == 3 && self.settings.acceleration > 0 && self.final_phase == FinalPhase::Newton;
        let rest = if number == 1 { self.step_tolerance() } else { AT_REST * self.diagonal };
        is_wanted && step > rest && (number >= FIRST_STEPS || step <= NEAR * self.diagonal)
    }

    /// Continues from `handles`, after so many linear solves; each step counts as one. `None` where the energy has no second
    /// derivative in space. `notify` is called with every accepted iterate and the last one.
    pub(crate) fn newton_in_space(
        &self,
        handles: &[[f64; D]],
        mut iterations: usize,
        notify: &mut dyn FnMut(&[[f64; D]]),
    ) -> Result<Option<MinimizationResult<D>>, Cancelled> {
        let constant = self.constant_right_side();
        let mut descent = Descent {
            problem: self,
            state: self.state_in_space(handles.to_vec(), &constant)?,
            constant,
            level: 0,
            least_level: 0,
            forcing: FORCING[0],
            last_square: f64::INFINITY,
        };
        let mut is_converged = false;
        while !is_converged && iterations < self.settings.iteration_limit {
            iterations += 1;
            let Some(outcome) = descent.step()? else { return Ok(None) };
            is_converged = outcome;
            notify(&descent.state.handles);
        }
        let mut handles = descent.state.handles;
        self.constraints.enforce(self.terms, &mut Vec::new(), &mut handles);
        notify(&handles);
        Ok(Some(MinimizationResult {
            handles,
            iterations,
            is_converged,
            has_given_way: false,
            is_minimum: None,
            energy: None,
        }))
    }

    fn step_tolerance(&self) -> f64 {
        self.settings.tolerance.max(AT_REST) * self.diagonal
    }

    fn state_in_space(&self, handles: Vectors<D>, constant: &[[f64; D]]) -> Result<State<D>, Cancelled> {
        let mut right_side = constant.to_vec();
        let energy = self.local_energy(&handles, &mut right_side);
        self.cancel.check()?;
        Ok(State { handles, energy, right_side })
    }

    /// The local-global step for a residual, which moves no hard row.
    fn preconditioned(&self, residual: &[[f64; D]], scratch: &mut Vectors<D>) -> Vectors<D> {
        let mut step = residual.to_vec();
        self.factor.solve(&mut step);
        self.constraints.project(self.terms, scratch, &mut step);
        step
    }
}

/// Handles with their energy and the right side of a local-global step.
struct State<const D: usize> {
    handles: Vectors<D>,
    energy: f64,
    right_side: Vectors<D>,
}

/// A step of conjugate gradients.
struct Direction<const D: usize> {
    by: Vectors<D>,
    /// The local-global step.
    first: Vectors<D>,
    /// What is left is negligible, also for a last step.
    is_solved: bool,
    /// The direction of negative curvature at which it ended.
    curve: Option<Vectors<D>>,
}

/// State of the descent.
struct Descent<'a, const D: usize> {
    problem: &'a Minimization<'a, D>,
    constant: Vectors<D>,
    state: State<D>,
    /// Which of [`CONVEXITY_LIMITS`] is in use.
    level: usize,
    /// Where to return to after a step: 0, or 1 near a saddle, whose symmetry is kept.
    least_level: usize,
    forcing: f64,
    /// Squared residual of the last step, in the norm of the preconditioner.
    last_square: f64,
}

impl<const D: usize> Descent<'_, D> {
    /// One step; true where it was the last.
    fn step(&mut self) -> Result<Option<bool>, Cancelled> {
        let problem = self.problem;
        let limit = CONVEXITY_LIMITS[self.level];
        let Some(response) = problem.distortion.rotation_response(&self.state.handles, limit) else { return Ok(None) };
        let mut residual = self.state.right_side.clone();
        problem.normal.subtract_matvec(&self.state.handles, &mut residual);
        let Direction { by, first, is_solved, curve } = self.direction(residual, &response)?;
        if curve.is_some() && length(&first) <= SYMMETRIC * problem.step_tolerance() {
            self.least_level = 1;
            self.level = 1;
            return Ok(Some(false));
        }
        let full = self.ahead(&by, 1.0);
        if is_solved && largest_step(&self.state.handles, &full) <= problem.step_tolerance() {
            self.state.handles = full;
            return Ok(Some(true));
        }
        let mut next = problem.state_in_space(full, &self.constant)?;
        for share in STEP_LENGTHS {
            if self.is_lower(&next) {
                break;
            }
            next = problem.state_in_space(self.ahead(&by, share), &self.constant)?;
        }
        if let Some(curve) = curve.filter(|_| self.is_lower(&next)) {
            next = self.descend(next, &curve, length(&first).max(length(&by)))?;
        }
        if self.is_lower(&next) {
            self.level = self.least_level;
        } else if self.level + 1 < CONVEXITY_LIMITS.len() {
            self.level += 1;
            return Ok(Some(false));
        } else {
            next = problem.state_in_space(self.ahead(&first, 1.0), &self.constant)?;
            self.level = self.least_level;
        }
        let is_far = largest_step(&self.state.handles, &next.handles) > NEAR * problem.diagonal;
        self.state = if is_far { self.relaxed(next)? } else { next };
        Ok(Some(false))
    }

    /// A local-global step from a state: far steps along tangents of rotations stretch the shape, which this takes back.
    fn relaxed(&self, state: State<D>) -> Result<State<D>, Cancelled> {
        let mut residual = state.right_side;
        self.problem.normal.subtract_matvec(&state.handles, &mut residual);
        let mut handles = state.handles;
        add(&mut handles, 1.0, &self.problem.preconditioned(&residual, &mut Vec::new()));
        self.problem.state_in_space(handles, &self.constant)
    }

    /// Follows a direction of negative curvature as long as the energy falls, with steps of growing length.
    fn descend(&self, mut state: State<D>, curve: &[[f64; D]], step: f64) -> Result<State<D>, Cancelled> {
        let origin = state.handles.clone();
        let unit = step / length(curve);
        for share in FAR_LENGTHS {
            let mut handles = origin.clone();
            add(&mut handles, share * unit, curve);
            let farther = self.problem.state_in_space(handles, &self.constant)?;
            if farther.energy.is_nan() || farther.energy >= state.energy {
                break;
            }
            state = farther;
        }
        Ok(state)
    }

    fn is_lower(&self, next: &State<D>) -> bool {
        next.energy <= self.state.energy * (1.0 + SAFEGUARD)
    }

    /// The handles plus a multiple of `by`.
    fn ahead(&self, by: &[[f64; D]], share: f64) -> Vectors<D> {
        let mut next = self.state.handles.clone();
        add(&mut next, share, by);
        next
    }

    /// Solves for a step by preconditioned conjugate gradients.
    fn direction(
        &mut self,
        mut residual: Vectors<D>,
        response: &RotationResponse<D>,
    ) -> Result<Direction<D>, Cancelled> {
        let Minimization { distortion, scales, cancel, .. } = *self.problem;
        let mut scratch = Vec::new();
        let first = self.problem.preconditioned(&residual, &mut scratch);
        let (mut along, mut by) = (first.clone(), vec![[0.0; D]; first.len()]);
        // The constant matrix times `along`, but for forces of hard rows, which do no work along any direction.
        let mut image = residual.clone();
        let mut square = dot(&residual, &along);
        let shrunk = if self.last_square.is_finite() { 0.9 * square / self.last_square } else { FORCING[0] };
        self.forcing = shrunk.clamp(FORCING[1], FORCING[0]);
        self.last_square = square;
        let (target, tolerance) = (self.forcing.powi(2) * square, self.problem.step_tolerance());
        for number in 0..DIRECTIONS {
            let mut product = image.clone();
            distortion.subtract_rotation_product(response, (&along, scales.shape), &mut product, cancel);
            cancel.check()?;
            let curvature = dot(&along, &product);
            if curvature.is_nan() || curvature <= FLAT * dot(&along, &image) {
                let by = if number == 0 { first.clone() } else { by };
                return Ok(Direction { by, first, is_solved: false, curve: Some(along) });
            }
            let share = square / curvature;
            add(&mut by, share, &along);
            add(&mut residual, -share, &product);
            let next = self.problem.preconditioned(&residual, &mut scratch);
            let last = std::mem::replace(&mut square, dot(&residual, &next));
            let is_certain = share * length(&along) <= CERTAIN * tolerance;
            let reached = length(&by);
            if reached > LONGEST * self.problem.diagonal {
                return Ok(Direction { by, first, is_solved: false, curve: None });
            }
            if square <= target && (is_certain || reached > 2.0 * tolerance) || square <= 0.0 {
                return Ok(Direction { by, first, is_solved: true, curve: None });
            }
            let kept = square / last;
            scale_add(&mut along, kept, &next);
            scale_add(&mut image, kept, &residual);
        }
        Ok(Direction { by, first, is_solved: false, curve: None })
    }
}

/// Σ a·b.
fn dot<const D: usize>(a: &[[f64; D]], b: &[[f64; D]]) -> f64 {
    let (a, b) = (a.as_flattened(), b.as_flattened());
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    let mut sums = [0.0; 8];
    for (a, b) in a.iter().zip(b) {
        (0..8).for_each(|lane| sums[lane] += a[lane] * b[lane]);
    }
    sums.iter().sum::<f64>() + a_rest.iter().zip(b_rest).map(|(x, y)| x * y).sum::<f64>()
}

/// Largest length of a vector.
fn length<const D: usize>(vectors: &[[f64; D]]) -> f64 {
    vectors.iter().map(|x| x.iter().map(|x| x * x).sum::<f64>()).fold(0.0, f64::max).sqrt()
}

/// sums + factor · by.
fn add<const D: usize>(sums: &mut [[f64; D]], factor: f64, by: &[[f64; D]]) {
    sums.as_flattened_mut().iter_mut().zip(by.as_flattened()).for_each(|(sum, x)| *sum += factor * x);
}

/// factor · sums + by.
fn scale_add<const D: usize>(sums: &mut [[f64; D]], factor: f64, by: &[[f64; D]]) {
    sums.as_flattened_mut().iter_mut().zip(by.as_flattened()).for_each(|(sum, x)| *sum = factor * *sum + x);
}
