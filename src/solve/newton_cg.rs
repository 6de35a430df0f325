//! Newton's method with conjugate gradients, for lattices in 3D, whose second derivative has too wide a band to be factored.
//!
//! In: a state near the solution. Out: converged handles. Directions are projected (N. Gould, M. Hribar and J. Nocedal, "On the
//! Solution of Equality Constrained Quadratic Programming Problems Arising in Optimization", 2001), and negative curvature ends a solve
//! (T. Steihaug, "The Conjugate Gradient Method and Trust Regions in Large Scale Optimization", 1983).

use super::cancel::Cancelled;
use super::energy::{RotationResponse, ScaledDirection};
use super::minimization::{FinalPhase, Minimization, MinimizationResult, SAFEGUARD, largest_step};

/// Number of local-global steps before Newton's method. They can rotate parts farther than a step along the tangent.
const FIRST_STEPS: usize = 6;

/// Newton's method takes over when a local-global step is at most this long, in box diagonals.
const NEAR: f64 = 3e-3;

/// Upper limits of 1/(s1 + s2), tried in this order: the true second derivative, then its convex part.
const CONVEXITY_LIMITS: [f64; 2] = [f64::INFINITY, 0.5];

/// Step lengths that are tried where the full step would raise the energy.
const STEP_LENGTHS: [f64; 3] = [0.5, 0.25, 0.0625];

/// Multiples of the step length that are tried along a direction of negative curvature.
const FAR_LENGTHS: [f64; 5] = [1.0, 2.0, 4.0, 8.0, 16.0];

/// Where the local-global step is below this many tolerances, negative curvature belongs to a saddle between symmetric solutions.
/// The solve stays at the saddle, as it does with a factored matrix.
const SYMMETRIC: f64 = 100.0;

/// Largest and smallest fraction of its initial norm to which the residual of a step is reduced.
const FORCING: [f64; 2] = [0.3, 1e-2];

/// Maximum number of directions per step.
const DIRECTIONS: usize = 100;

/// Length of a step, in box diagonals, at which its solve is ended: beyond it the linearised rotations are inaccurate.
const LONGEST: f64 = 0.1;

/// Ratio of the curvature to that of the constant matrix below which a direction counts as flat.
const FLAT: f64 = 1e-9;

/// The last step is solved until a direction moves no handle by more than this fraction of the tolerance.
const CERTAIN: f64 = 0.1;

/// Length of a step, in box diagonals, below which it is rounding error.
const AT_REST: f64 = 1e-10;

/// The solve ends where a local-global step promises to lower the energy by less than this fraction of it, or even to raise it.
/// Further steps would follow rounding errors: stiff terms drown those that determine soft handles.
const ROUNDING: f64 = 1e-13;

type Vectors<const D: usize> = Vec<[f64; D]>;

impl<const D: usize> Minimization<'_, D> {
    /// Whether Newton's method takes over after the local-global step of the given number and length.
    pub(crate) fn should_switch_in_space(&self, (number, step): (usize, f64)) -> bool {
        let is_wanted = D == 3 && self.settings.acceleration > 0 && self.final_phase == FinalPhase::Newton;
        let rest = if number == 1 { self.step_tolerance() } else { AT_REST * self.diagonal };
        is_wanted && step > rest && (number >= FIRST_STEPS || step <= NEAR * self.diagonal)
    }

    /// Continues from `handles`. Each step solves with the second derivative by conjugate gradients, preconditioned by the factor of the
    /// local-global steps and projected onto directions that move no hard pin; the first direction is the local-global step itself.
    ///
    /// `iterations` is the number of linear solves so far; each step counts as one, up to `limit`.
    /// Returns `None` if the energy does not implement its second derivative in 3D. `notify` receives every iterate and the result.
    pub(crate) fn newton_in_space(
        &self,
        handles: &[[f64; D]],
        (mut iterations, limit): (usize, usize),
        notify: &mut dyn FnMut(&[[f64; D]]),
    ) -> Result<Option<MinimizationResult<D>>, Cancelled> {
        let constant = self.constant_right_side();
        let mut descent = Descent {
            problem: self,
            state: self.state_in_space(handles.to_vec(), &constant)?,
            constant,
            level: 0,
            min_level: 0,
            forcing: FORCING[0],
            last_square: f64::INFINITY,
        };
        let mut is_converged = false;
        while !is_converged && iterations < limit {
            iterations += 1;
            let Some(outcome) = descent.step()? else { return Ok(None) };
            is_converged = outcome;
            notify(&descent.state.handles);
        }
        let mut handles = descent.state.handles;
        self.constraints.enforce(self.terms, &mut Vec::new(), &mut handles);
        notify(&handles);
        Ok(Some(MinimizationResult::of(handles, iterations, is_converged)))
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

    /// Returns the local-global step for a residual, projected so that it moves no hard row.
    fn preconditioned(&self, residual: &[[f64; D]], scratch: &mut Vectors<D>) -> Vectors<D> {
        let mut step = residual.to_vec();
        self.factor.solve(&mut step);
        self.constraints.project(self.terms, scratch, &mut step);
        step
    }
}

/// Handles with their energy and the right-hand side of a local-global step.
struct State<const D: usize> {
    handles: Vectors<D>,
    energy: f64,
    right_side: Vectors<D>,
}

/// Step found by conjugate gradients.
struct Direction<const D: usize> {
    by: Vectors<D>,
    /// The local-global step.
    first: Vectors<D>,
    /// Whether the remaining residual is negligible, also for a last step.
    is_solved: bool,
    /// Direction of negative curvature at which the solve ended.
    curve: Option<Vectors<D>>,
}

/// State of the descent.
struct Descent<'a, const D: usize> {
    problem: &'a Minimization<'a, D>,
    constant: Vectors<D>,
    state: State<D>,
    /// Index into [`CONVEXITY_LIMITS`].
    level: usize,
    /// Level to which the descent returns after a step: 0, or 1 near a saddle whose symmetry is kept.
    min_level: usize,
    /// Fraction to which the residual of the present step is reduced.
    forcing: f64,
    /// Squared residual of the last step, in the norm of the preconditioner.
    last_square: f64,
}

impl<const D: usize> Descent<'_, D> {
    /// Takes a step; returns whether it was the last, or `None` if the energy does not implement its second derivative in 3D.
    fn step(&mut self) -> Result<Option<bool>, Cancelled> {
        let problem = self.problem;
        let limit = CONVEXITY_LIMITS[self.level];
        let Some(response) = problem.distortion.rotation_response(&self.state.handles, limit) else { return Ok(None) };
        let mut residual = self.state.right_side.clone();
        problem.normal.subtract_matvec(&self.state.handles, &mut residual);
        let Some(direction) = self.direction(residual, &response)? else { return Ok(Some(true)) };
        let Direction { by, first, is_solved, curve } = direction;
        if curve.is_some() && length(&first) <= SYMMETRIC * problem.step_tolerance() {
            self.min_level = 1;
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
            self.level = self.min_level;
        } else if self.level + 1 < CONVEXITY_LIMITS.len() {
            self.level += 1;
            return Ok(Some(false));
        } else {
            next = problem.state_in_space(self.ahead(&first, 1.0), &self.constant)?;
            self.level = self.min_level;
        }
        let is_far = largest_step(&self.state.handles, &next.handles) > NEAR * problem.diagonal;
        self.state = if is_far { self.relaxed(next)? } else { next };
        Ok(Some(false))
    }

    /// Takes a local-global step, which removes the stretch that a long step along the tangents of rotations introduces.
    fn relaxed(&self, state: State<D>) -> Result<State<D>, Cancelled> {
        let mut residual = state.right_side;
        self.problem.normal.subtract_matvec(&state.handles, &mut residual);
        let mut handles = state.handles;
        add(&mut handles, 1.0, &self.problem.preconditioned(&residual, &mut Vec::new()));
        self.problem.state_in_space(handles, &self.constant)
    }

    /// Follows a direction of negative curvature in steps of growing length while the energy falls.
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

    /// Returns the handles plus a multiple of `by`.
    fn ahead(&self, by: &[[f64; D]], share: f64) -> Vectors<D> {
        let mut next = self.state.handles.clone();
        add(&mut next, share, by);
        next
    }

    /// Solves for a step by preconditioned conjugate gradients; `None` if only rounding errors are left.
    fn direction(
        &mut self,
        mut residual: Vectors<D>,
        response: &RotationResponse<D>,
    ) -> Result<Option<Direction<D>>, Cancelled> {
        let Minimization { distortion, scales, cancel, .. } = *self.problem;
        let mut scratch = Vec::new();
        let first = self.problem.preconditioned(&residual, &mut scratch);
        let (mut along, mut by) = (first.clone(), vec![[0.0; D]; first.len()]);
        // Product of the constant matrix and `along`, except for forces of hard rows, which do no work along projected directions.
        let mut image = residual.clone();
        let mut square = dot(&residual, &along);
        let shrunk = if self.last_square.is_finite() { 0.9 * square / self.last_square } else { FORCING[0] };
        self.forcing = shrunk.clamp(FORCING[1], FORCING[0]);
        self.last_square = square;
        if square <= ROUNDING * self.state.energy {
            return Ok(None);
        }
        let (target, tolerance) = (self.forcing.powi(2) * square, self.problem.step_tolerance());
        for number in 0..DIRECTIONS {
            let mut product = image.clone();
            let scaled = ScaledDirection { direction: &along, scale: scales.shape };
            distortion.subtract_rotation_product(response, scaled, &mut product, cancel);
            cancel.check()?;
            let curvature = dot(&along, &product);
            if curvature.is_nan() || curvature <= FLAT * dot(&along, &image) {
                let by = if number == 0 { first.clone() } else { by };
                return Ok(Some(Direction { by, first, is_solved: false, curve: Some(along) }));
            }
            let share = square / curvature;
            add(&mut by, share, &along);
            add(&mut residual, -share, &product);
            let next = self.problem.preconditioned(&residual, &mut scratch);
            let last = std::mem::replace(&mut square, dot(&residual, &next));
            let is_certain = share * length(&along) <= CERTAIN * tolerance;
            let reached = length(&by);
            if reached > LONGEST * self.problem.diagonal {
                return Ok(Some(Direction { by, first, is_solved: false, curve: None }));
            }
            if square <= target && (is_certain || reached > 2.0 * tolerance) || square <= 0.0 {
                return Ok(Some(Direction { by, first, is_solved: true, curve: None }));
            }
            let kept = square / last;
            scale_add(&mut along, kept, &next);
            scale_add(&mut image, kept, &residual);
        }
        Ok(Some(Direction { by, first, is_solved: false, curve: None }))
    }
}

/// Dot product over all coordinates, with eight partial sums.
fn dot<const D: usize>(a: &[[f64; D]], b: &[[f64; D]]) -> f64 {
    let (a, b) = (a.as_flattened(), b.as_flattened());
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    let mut sums = [0.0; 8];
    for (a, b) in a.iter().zip(b) {
        (0..8).for_each(|lane| sums[lane] += a[lane] * b[lane]);
    }
    sums.iter().sum::<f64>() + a_rest.iter().zip(b_rest).map(|(x, y)| x * y).sum::<f64>()
}

/// Length of the longest vector.
fn length<const D: usize>(vectors: &[[f64; D]]) -> f64 {
    vectors.iter().map(|x| x.iter().map(|x| x * x).sum::<f64>()).fold(0.0, f64::max).sqrt()
}

/// Adds factor · by to `sums`.
fn add<const D: usize>(sums: &mut [[f64; D]], factor: f64, by: &[[f64; D]]) {
    sums.as_flattened_mut().iter_mut().zip(by.as_flattened()).for_each(|(sum, x)| *sum += factor * x);
}

/// Replaces `sums` by factor · sums + by.
fn scale_add<const D: usize>(sums: &mut [[f64; D]], factor: f64, by: &[[f64; D]]) {
    sums.as_flattened_mut().iter_mut().zip(by.as_flattened()).for_each(|(sum, x)| *sum = factor * *sum + x);
}
