//! A factored problem: computes and factors once what does not depend on targets, for any number of minimisations.
//!
//! In: grid, shape, pins, handles, settings; later only targets. Out: minimisations, and reports of their results.

use super::active_cells::active_cells;
use super::barrier::{Barrier, BarrierPart};
use super::branching::{BranchedLattice, Branching, CopyName, HeldPins, settings_for};
use super::cancel::Cancel;
use super::energy::{Distortion, RotationHessian, WithPinNeighbourhoods};
use super::error::SolveError;
use super::least_squares::LeastSquaresRows;
use super::linalg::factorization::Factorization;
use super::linalg::normal_matrix::NormalMatrix;
use super::linalg::small_matrix::{distance, dot};
use super::minimization::{FinalPhase, Minimization, MinimizationResult};
use super::model_folds::ModelCells;
use super::pin_residuals::{Evidence, MIN_RESIDUAL};
use super::point_weights::PointWeights;
use super::prefactored::{Prefactored, Retargeted, TargetTerms};
use super::problem::{HandlePin, ModelPoint, PointPin, Problem, Shape};
use super::regularizer::RegularizerTerm;
use super::report::{Solution, SolveReport, Stationarity};
use super::rigid_motion::{RigidMotion, open_roll};
use super::settings::{Guard, Scaling, Settings, Start};
use super::targets::Targets;
use super::terms::{Scales, Terms};
use super::yielding::{YieldingPair, yielding_pairs};
use super::yielding_rows::YieldingRows;
use super::{energy, pin_residuals, pins, validate};
use crate::lattice::{Folds, Grid, Lattice};
use crate::spelling::pluralised;
use std::borrow::Cow;
use std::sync::Arc;

/// Grid, samples of the shape, pinned points and moved handles, with the factored matrix.
#[derive(Debug)]
pub(crate) struct System<const D: usize> {
    grid: Grid<D>,
    settings: Settings,
    distortion: Box<dyn Distortion<D>>,
    /// Matrix without the proximal term; empty if there is no such term.
    constant: NormalMatrix,
    /// Matrix and factor under the assumption that all pins hold exactly.
    prefactored: Prefactored,
    /// Matrix and factor for the targets in the problem, if some pins give way for them.
    yielded: Option<Prefactored>,
    scales: Scales,
    /// The targets in the problem.
    targets: Targets<D>,
    terms: Terms<D>,
    /// Copies of handles; `None` if every handle is one unknown.
    branching: Option<Arc<Branching<D>>>,
    /// The point of the shape that each pin holds, and its piece; empty if every handle is one unknown.
    snapped: Vec<([f64; D], usize)>,
    /// The cells that hold the model; empty until [`Self::mark_active_cells`] is called.
    model_cells: ModelCells<D>,
    /// Barrier that keeps active cells from folding, if the settings ask for it.
    barrier: Option<Barrier<D>>,
    /// Stiffness of the shape at each unknown: the diagonal of the matrix of its energy.
    stiffness: Vec<f64>,
    /// Warnings about the shape.
    warnings: Vec<String>,
}

/// The copies of handles, and the point of the shape that each pin holds, with its piece.
type SnappedBranching<const D: usize> = (Branching<D>, Vec<([f64; D], usize)>);

/// Components of a system.
pub(crate) struct Parts<const D: usize> {
    pub(crate) distortion: Box<dyn Distortion<D>>,
    pub(crate) pin_rows: LeastSquaresRows<D>,
    /// `None` if every handle is one unknown.
    pub(crate) branching: Option<SnappedBranching<D>>,
    pub(crate) warnings: Vec<String>,
    /// Rows of the proximal term, one per point of the model.
    pub(crate) proximal: LeastSquaresRows<D>,
}

/// Weight of known displacements when others are interpolated, relative to the stiffness of the shape.
const INTERPOLATION: f64 = 100.0;

/// Weight of the Tikhonov term, which draws handles to the rigid fit, as a fraction of the mean diagonal of shape and
/// regulariser. It determines handles that nothing else constrains, and changes the others by less than the tolerance.
const TIKHONOV: f64 = 1e-9;

/// Weight of the same term in space where pins lie near a line ([`open_roll`]), relative to the stiffness of the shape: turning the
/// shape over then costs about as much as bending it strongly.
const ROLL: f64 = 1.5;

impl<const D: usize> System<D> {
    /// Samples the shape and factors the matrix.
    pub(crate) fn new(problem: &Problem<D>, cancel: &Cancel) -> Result<Self, SolveError> {
        let mut system = Self::with_points(problem, &[], cancel)?;
        system.mark_active_cells(problem.shape);
        Ok(system)
    }

    /// Finds the active cells, which only reports need.
    pub(crate) fn mark_active_cells(&mut self, shape: &Shape<D>) {
        self.model_cells = ModelCells::of(&self.grid, shape);
    }

    /// Same as [`Self::new`], without active cells, and with points of the model for a proximal term
    /// ([`Self::set_proximal_targets`]).
    pub(crate) fn with_points(
        problem: &Problem<D>,
        points: &[ModelPoint<D>],
        cancel: &Cancel,
    ) -> Result<Self, SolveError> {
        validate::problem(problem)?;
        let (grid, settings) = (problem.grid, problem.settings);
        let warnings = validate::shape_warnings(problem);
        if let Some(branching) = Branching::of(problem)? {
            let settings = &settings_for(grid, settings);
            let problem = &Problem { settings, ..*problem };
            let snapped = branching.snapped_points(problem.pins);
            let held = HeldPins { pins: problem.pins, snapped: &snapped };
            let parts = Parts {
                distortion: branching.distortion(problem.shape, held, settings, cancel),
                pin_rows: branching.pin_rows(held, settings),
                proximal: branching.point_rows(points),
                branching: Some((branching, snapped)),
                warnings,
            };
            return Self::assemble(problem, parts, cancel);
        }
        let distortion = energy::build(grid, problem.shape, problem.pins, settings, cancel)?;
        let parts = Parts {
            distortion: WithPinNeighbourhoods::around(distortion, grid, problem.pins, settings),
            pin_rows: pins::pin_rows(grid, problem.pins, settings),
            branching: None,
            warnings,
            proximal: pins::point_rows(grid, points),
        };
        Self::assemble(problem, parts, cancel)
    }

    /// Factors a checked problem from components that are already built.
    pub(crate) fn assemble(problem: &Problem<D>, parts: Parts<D>, cancel: &Cancel) -> Result<Self, SolveError> {
        let Parts { distortion, pin_rows, branching, warnings, proximal } = parts;
        let (branching, snapped) = branching.map_or_else(Default::default, |(own, snapped)| (Some(own), snapped));
        let (grid, settings) = (problem.grid, problem.settings);
        let targets = Targets { pins: problem.pins.to_vec(), handles: problem.handles.to_vec() };
        let mut moved = vec![false; grid.handle_count()];
        targets.handles.iter().for_each(|handle| moved[handle.index] = true);
        let regularizer = match &branching {
            Some(branching) => RegularizerTerm::Rows(branching.bend(settings.scaling)),
            None => RegularizerTerm::new(settings.regularizer, grid, &moved, settings.scaling),
        };
        let count = branching.as_ref().map_or(grid.handle_count(), Branching::count);
        let terms = Terms {
            pins: pin_rows,
            handles: pins::handle_rows(&moved_unknowns(branching.as_ref(), &targets.handles)),
            regularizer: Arc::new(regularizer),
            proximal,
            yielding: None,
        };
        let mut scales = Scales::of(grid, settings, distortion.mass());
        let bandwidth = terms.pins.bandwidth().max(terms.regularizer.bandwidth()).max(distortion.bandwidth());
        let bandwidth = bandwidth.max(terms.proximal.bandwidth());
        let mut normal = NormalMatrix::zero(count, bandwidth);
        distortion.add_normal(scales.shape, &mut normal, cancel);
        cancel.check()?;
        let stiffness = normal.diagonal();
        terms.regularizer.add_normal(scales.regularizer, &mut normal, cancel);
        if settings.scaling == Scaling::Dimensionless {
            scales.tikhonov = TIKHONOV * normal.mean_diagonal();
            if settings.start == Start::RigidFit {
                let stiffness = scales.shape * distortion.mass() / (count as f64 * grid.diagonal().powi(2));
                scales.tikhonov += ROLL * stiffness * open_roll(grid, &targets);
            }
            (0..count).for_each(|handle| normal.add(handle, handle, scales.tikhonov));
        }
        terms.pins.add_normal(scales.pins, &mut normal, cancel);
        terms.handles.add_normal(scales.handles, &mut normal, cancel);
        let constant = if terms.proximal.len() > 0 { normal.clone() } else { NormalMatrix::zero(0, 0) };
        let barrier = match (settings.guard, &branching) {
            (Guard::Report, _) => None,
            (Guard::Limit, Some(branching)) => Some(branching.barrier(cancel)),
            (Guard::Limit, None) => {
                let is_active = active_cells(grid, problem.shape);
                let cells = is_active.iter().enumerate().filter_map(|(cell, is_active)| is_active.then_some(cell));
                let part = BarrierPart { cells: cells.collect(), unknowns: None };
                Some(Barrier::new(grid, vec![part], cancel))
            }
        };
        cancel.check()?;
        let mut system = Self {
            grid: grid.clone(),
            settings: settings.clone(),
            distortion,
            constant,
            prefactored: Prefactored::new(normal, &terms, &targets.pins, settings, cancel)?,
            yielded: None,
            scales,
            targets,
            terms,
            branching: branching.map(Arc::new),
            snapped,
            model_cells: ModelCells::default(),
            barrier,
            stiffness,
            warnings,
        };
        system.apply_yielding(cancel)?;
        Ok(system)
    }

    /// Lets pins give way for the targets in the problem, where these demand too much.
    fn apply_yielding(&mut self, cancel: &Cancel) -> Result<(), SolveError> {
        let Retargeted { terms, yielded } = self.yielding(&self.targets, self.terms.clone(), cancel)?;
        (self.terms, self.yielded) = (terms, yielded);
        Ok(())
    }

    /// Returns the terms in which pins give way where the targets demand too much, and the matrix factored for them.
    fn yielding(
        &self,
        targets: &Targets<D>,
        mut terms: Terms<D>,
        cancel: &Cancel,
    ) -> Result<Retargeted<D>, SolveError> {
        terms.yielding = None;
        let pairs = self.yielding_pairs(targets);
        if pairs.is_empty() {
            return Ok(Retargeted { terms, yielded: None });
        }
        terms.yielding = Some(Arc::new(YieldingRows::new(&terms.pins, &targets.pins, &pairs, self.scales.pins)));
        let normal = self.softened(&self.prefactored.normal, &terms, cancel);
        let yielded = Prefactored::new(normal, &terms, &targets.pins, &self.settings, cancel)?;
        Ok(Retargeted { terms, yielded: Some(yielded) })
    }

    fn yielding_pairs(&self, targets: &Targets<D>) -> Vec<YieldingPair> {
        // If pins and moved handles outnumber the handles of the grid, least squares spread the residual, and no pair yields.
        if targets.pins.len() + targets.handles.len() > self.grid.handle_count() {
            return Vec::new();
        }
        let firmness = self.scales.pins / (self.scales.shape * self.distortion.mass());
        let mut pairs = yielding_pairs(&self.grid, targets, &self.settings, firmness);
        if let Some(branching) = &self.branching {
            let pins = |pair: &YieldingPair| pair.pins.map(|pin| &targets.pins[pin]);
            pairs.iter_mut().for_each(|pair| pair.compliance *= branching.coupling(pins(pair)));
            pairs.retain(|pair| pair.compliance > 0.0);
        }
        pairs
    }

    /// Returns a matrix in which the rows of `terms` that yield replace the rows of pins that hold exactly.
    fn softened(&self, normal: &NormalMatrix, terms: &Terms<D>, cancel: &Cancel) -> NormalMatrix {
        let Some(yielding) = &terms.yielding else { return normal.clone() };
        let mut softened = normal.widened(yielding.rows.bandwidth());
        terms.pins.add_normal(-self.scales.pins, &mut softened, cancel);
        yielding.rows.add_normal(self.scales.pins, &mut softened, cancel);
        softened
    }

    /// Draws the points of the proximal term to `places` with the given weights.
    pub(crate) fn set_proximal_targets(
        &mut self,
        places: impl IntoIterator<Item = [f64; D]>,
        weights: &PointWeights,
        cancel: &Cancel,
    ) -> Result<(), SolveError> {
        places.into_iter().enumerate().for_each(|(row, place)| self.terms.proximal.set_target(row, place));
        let scale = weights.greatest();
        let has_changed = weights.share(&mut self.terms.proximal);
        if !has_changed && scale == self.scales.proximal || self.terms.proximal.len() == 0 {
            return Ok(());
        }
        self.scales.proximal = scale;
        let mut normal = self.constant.clone();
        self.terms.proximal.add_normal(scale, &mut normal, cancel);
        self.terms.yielding = None;
        self.prefactored = Prefactored::new(normal, &self.terms, &self.targets.pins, &self.settings, cancel)?;
        self.apply_yielding(cancel)
    }

    /// Whether the energy implements its second derivative, so that [`Self::is_convex`] tests it.
    pub(crate) fn has_second_derivative(&self) -> bool {
        self.distortion.flops().is_some()
    }

    /// Whether the second derivative of the energy with a proximal term of the given weights is positive definite at `handles`.
    /// False where pins give way to the barrier. If the energy does not implement its second derivative, true where the barrier
    /// does not act.
    pub(crate) fn is_convex(&self, handles: &[[f64; D]], weights: &PointWeights, cancel: &Cancel) -> bool {
        let barrier = self.barrier.as_ref().filter(|barrier| !barrier.is_clear(handles));
        if barrier.is_some() && self.gives_way(handles) {
            return false;
        }
        if !self.has_second_derivative() || self.terms.proximal.len() == 0 {
            return barrier.is_none();
        }
        let mut normal = self.softened(&self.constant, &self.terms, cancel);
        let mut proximal = self.terms.proximal.clone();
        weights.share(&mut proximal);
        proximal.add_normal(weights.greatest(), &mut normal, cancel);
        let normal = if let Some(barrier) = barrier { normal.widened(barrier.bandwidth()) } else { normal };
        let mut second = normal.kron_identity::<D>(Vec::new());
        let hessian = RotationHessian { scale: self.scales.shape, limit: f64::INFINITY };
        self.distortion.subtract_rotation_hessian(handles, hessian, &mut second, cancel);
        if let Some(barrier) = barrier {
            barrier.add_curvature(handles, self.scales.shape * self.distortion.mass(), &mut second);
        }
        Factorization::of_positive(second, cancel).is_some()
    }

    /// Whether the barrier acts on a state that misses the target of a pin or moved handle.
    pub(crate) fn gives_way(&self, unknowns: &[[f64; D]]) -> bool {
        let is_missed = |rows: &LeastSquaresRows<D>| {
            let residuals = (0..rows.len()).map(|row| rows.residual(row, unknowns));
            residuals.map(|by| dot(&by, &by).sqrt()).any(|residual| residual > MIN_RESIDUAL * self.grid.diagonal())
        };
        !self.is_free_of_barrier(unknowns) && [self.terms.acting_pins(), &self.terms.handles].into_iter().any(is_missed)
    }

    /// Whether the barrier does not act on a state.
    pub(crate) fn is_free_of_barrier(&self, unknowns: &[[f64; D]]) -> bool {
        self.barrier.as_ref().is_none_or(|barrier| barrier.is_clear(unknowns))
    }

    /// Names of the unknowns, which identify them at any time; empty if every handle is one unknown.
    pub(crate) fn copy_names(&self) -> Vec<CopyName> {
        self.branching.as_ref().map_or_else(Vec::new, |branching| branching.copy_names())
    }

    /// Interpolates the displacements of all unknowns from the known ones and from those of the points of the proximal term, by
    /// least squares of the gradients over the shape. Returns `None` if they are not determined, or there is no proximal term.
    pub(crate) fn interpolated(
        &self,
        known: &[Option<[f64; D]>],
        points: &[[f64; D]],
        cancel: &Cancel,
    ) -> Option<Vec<[f64; D]>> {
        if self.terms.proximal.len() == 0 {
            return None;
        }
        let mut normal = self.constant.clone();
        self.terms.pins.add_normal(-self.scales.pins, &mut normal, cancel);
        self.terms.handles.add_normal(-self.scales.handles, &mut normal, cancel);
        let weight = INTERPOLATION * self.scales.shape * self.distortion.mass();
        let mut displacements = vec![[0.0; D]; known.len()];
        let mut rows = self.terms.proximal.clone();
        PointWeights::Uniform(weight).share(&mut rows);
        points.iter().enumerate().for_each(|(row, point)| rows.set_target(row, *point));
        rows.add_normal(weight, &mut normal, cancel);
        rows.add_right_side(weight, &mut displacements);
        for (unknown, known) in known.iter().enumerate() {
            if let Some(known) = known {
                normal.add(unknown, unknown, weight);
                (0..D).for_each(|d| displacements[unknown][d] += weight * known[d]);
            }
        }
        Factorization::new(&normal, cancel)?.solve(&mut displacements);
        Some(displacements)
    }

    /// Positions to which the points of the proximal term are drawn; initially their rest positions.
    pub(crate) fn point_targets(&self) -> Vec<[f64; D]> {
        (0..self.terms.proximal.len()).map(|row| self.terms.proximal.target(row)).collect()
    }

    /// Positions of the points of the proximal term under `handles`.
    pub(crate) fn point_images(&self, handles: &[[f64; D]]) -> Vec<[f64; D]> {
        (0..self.terms.proximal.len()).map(|row| self.terms.proximal.image(row, handles)).collect()
    }

    /// The rest grid.
    pub(crate) fn grid(&self) -> &Grid<D> {
        &self.grid
    }

    /// The settings.
    pub(crate) fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The targets in the problem, with their terms.
    pub(crate) fn own_targets(&self) -> TargetTerms<'_, D> {
        let prefactored = self.yielded.as_ref().unwrap_or(&self.prefactored);
        TargetTerms { goal: &self.targets, terms: &self.terms, prefactored }
    }

    /// Combines other targets with their terms and the factored matrix.
    pub(crate) fn targets<'a>(&'a self, goal: &'a Targets<D>, to: &'a Retargeted<D>) -> TargetTerms<'a, D> {
        let prefactored = to.yielded.as_ref().unwrap_or(&self.prefactored);
        TargetTerms { goal, terms: &to.terms, prefactored }
    }

    /// Returns the terms for other targets of the same pins and handles.
    pub(crate) fn retargeted(&self, targets: &Targets<D>, cancel: &Cancel) -> Result<Retargeted<D>, SolveError> {
        let Targets { pins, handles } = targets;
        validate::same_pins(&self.targets.pins, pins)?;
        validate::same_handles(&self.targets.handles, handles)?;
        let mut terms = self.terms.clone();
        pins::retarget(&mut terms.pins, &self.grid, &self.held(pins), &self.settings);
        for (row, handle) in moved_unknowns(self.branching.as_deref(), handles).iter().enumerate() {
            terms.handles.set_target(row, handle.target);
        }
        self.yielding(targets, terms, cancel)
    }

    /// Returns the rigid motion that best fits pins and handles to their targets.
    pub(crate) fn fitted(&self, targets: &TargetTerms<D>) -> RigidMotion<D> {
        RigidMotion::fit(&self.grid, targets.goal)
    }

    /// Returns the minimisation for the given targets.
    pub(crate) fn minimization<'a>(
        &'a self,
        targets: &TargetTerms<'a, D>,
        cancel: &'a Cancel<'a>,
    ) -> Minimization<'a, D> {
        let rest = self.rest();
        let start = match self.settings.start {
            Start::Rest => rest,
            Start::RigidFit => {
                let rigid = self.fitted(targets);
                rest.iter().map(|handle| rigid.image(handle)).collect()
            }
        };
        Minimization {
            distortion: self.distortion.as_ref(),
            normal: &targets.prefactored.normal,
            factor: &targets.prefactored.factor,
            constraints: &targets.prefactored.constraints,
            scales: self.scales,
            terms: targets.terms,
            settings: &self.settings,
            diagonal: self.grid.diagonal(),
            start,
            initial: None,
            final_phase: FinalPhase::Newton,
            barrier: self.barrier.as_ref(),
            cancel,
        }
    }

    /// Returns the folded cells of a lattice over the same grid, and how many of them fold on the model.
    pub(crate) fn folds(&self, lattice: &Lattice<D>) -> Folds<D> {
        self.model_cells.folds(lattice)
    }

    /// Returns the solution of a problem without pins and moved handles: the grid at rest.
    pub(crate) fn unmoved(&self, goal: &Targets<D>) -> Solution<D> {
        let mut warnings = self.warnings.clone();
        warnings.push("no pins and no moved handles: the lattice stays at rest; add a pin".into());
        let result = MinimizationResult::of(self.rest(), 0, true);
        self.report(goal, result, warnings)
    }

    /// Converts the result of a minimisation for `goal` to a solution with its report.
    pub(crate) fn finish(&self, goal: &Targets<D>, result: MinimizationResult<D>) -> Solution<D> {
        let mut warnings = self.warnings.clone();
        warnings.extend(pins::handle_conflicts(&self.grid, &goal.handles));
        if let Some(branching) = &self.branching {
            let is_idle = |handle: &&HandlePin<D>| branching.moved_copies(&[**handle]).is_empty();
            let idle = goal.handles.iter().filter(is_idle).map(|handle| handle.index);
            warnings.extend(
                idle.map(|index| format!("handle {index} acts on no part of the shape; move one nearer to it")),
            );
        }
        if result.is_converged && result.is_minimum == Some(false) {
            warnings
                .push("the solve ended at a saddle: the shape may buckle to either side; move a pin or add one".into());
        }
        if !result.is_converged && self.settings.tolerance > 0.0 {
            let spent = pluralised(result.iterations, "iteration", "iterations");
            warnings.push(format!(
                "not converged after {spent}: the result may still move; move the pins less, or raise the iteration limit"
            ));
        }
        self.report(goal, result, warnings)
    }

    fn report(&self, goal: &Targets<D>, run: MinimizationResult<D>, warnings: Vec<String>) -> Solution<D> {
        let Targets { pins, handles } = goal;
        let metrics = self.distortion.metrics(&run.handles);
        let branches = self.branches(&run.handles);
        let lattice = match &branches {
            Some(branches) => branches.lattice(0),
            None => Lattice { grid: self.grid.clone(), handles: run.handles },
        };
        let held = self.held(pins);
        let pin_errors: Vec<f64> = match (&self.branching, &branches) {
            (Some(branching), Some(branches)) => {
                let image = |k: usize| branches.evaluate_in(branching.branch_of(self.snapped[k].1), held[k].at);
                held.iter().enumerate().map(|(k, pin)| distance(&image(k), &pin.target)).collect()
            }
            _ => pins.iter().map(|pin| self.pin_error(&lattice, pin)).collect(),
        };
        let evidence = Evidence {
            pins,
            settings: &self.settings,
            constraints: &self.prefactored.constraints,
            yielding: &self.yielding_pairs(goal),
            is_held_back: run.has_given_way,
            bounds: [self.grid.lo, self.grid.hi],
            diagonal: self.grid.diagonal(),
        };
        let folds = branches.as_ref().map_or_else(|| self.folds(&lattice), BranchedLattice::folds);
        let report = SolveReport {
            pin_residuals: pin_residuals::residuals(&evidence, &pin_errors),
            pin_errors,
            folded_cells: folds.cells.len(),
            folded_model_cells: folds.active_count,
            min_cell_det: folds.min_det,
            min_det: metrics.min_det(),
            angular: metrics.angular(),
            area: metrics.area(),
            handle_errors: handles.iter().map(|held| self.handle_error(&lattice, branches.as_ref(), held)).collect(),
            is_held_back: run.has_given_way,
            iterations: run.iterations,
            is_converged: run.is_converged,
            stationarity: match run.is_minimum {
                _ if !run.is_converged => Stationarity::Unconverged,
                Some(true) => Stationarity::Minimum,
                Some(false) => Stationarity::Saddle,
                None => Stationarity::Unchecked,
            },
            energy: run.energy,
            conflicts: pins::conflicts(&self.grid, pins),
            warnings,
        };
        Solution { lattice, branches, report }
    }

    /// The copies of handles; `None` if the lattice does not branch.
    pub(crate) fn branching(&self) -> Option<&Branching<D>> {
        self.branching.as_deref()
    }

    /// Whether the lattice branches, so that some handles have copies.
    pub(crate) fn has_branches(&self) -> bool {
        self.branching.is_some()
    }

    /// Whether branches have the same copies of handles over the same shape as this system.
    pub(crate) fn has_pieces_of(&self, branches: &BranchedLattice<D>) -> bool {
        self.branching.as_ref().is_some_and(|own| branches.is_of(own))
    }

    /// Stiffness of the shape at each unknown.
    pub(crate) fn stiffness(&self) -> &[f64] {
        &self.stiffness
    }

    /// Rest positions of the unknowns, which are handles or copies of them.
    pub(crate) fn rest(&self) -> Vec<[f64; D]> {
        self.branching.as_ref().map_or_else(|| self.grid.rest_handles(), |branching| branching.rest())
    }

    /// Returns the pins of the problem, with other targets, at the points that they hold on the shape.
    fn held<'a>(&self, pins: &'a [PointPin<D>]) -> Cow<'a, [PointPin<D>]> {
        match &self.branching {
            Some(_) => pins.iter().zip(&self.snapped).map(|(pin, (at, _))| pin.moved_to(*at)).collect(),
            None => Cow::Borrowed(pins),
        }
    }

    /// Returns the branches of a state; `None` if every handle is one unknown.
    pub(crate) fn branches(&self, unknowns: &[[f64; D]]) -> Option<BranchedLattice<D>> {
        self.branching.as_ref().map(|branching| BranchedLattice::new(branching, unknowns.to_vec()))
    }

    /// Distance of a moved handle from its target, or of the farthest of its copies.
    fn handle_error(&self, lattice: &Lattice<D>, branches: Option<&BranchedLattice<D>>, handle: &HandlePin<D>) -> f64 {
        match branches {
            Some(branches) => {
                let copies = branches.copies_of(handle.index);
                copies.iter().map(|copy| distance(copy, &handle.target)).fold(0.0, f64::max)
            }
            None => distance(&lattice.handles[handle.index], &handle.target),
        }
    }

    fn pin_error(&self, lattice: &Lattice<D>, pin: &PointPin<D>) -> f64 {
        let target = pins::held_target(&self.grid, pin, &self.settings);
        let held = pins::held_point(&self.grid, pin, &self.settings);
        distance(&lattice.evaluate(held), &target)
    }
}

/// Converts moved handles to moved unknowns.
fn moved_unknowns<'a, const D: usize>(
    branching: Option<&Branching<D>>,
    handles: &'a [HandlePin<D>],
) -> Cow<'a, [HandlePin<D>]> {
    branching.map_or(Cow::Borrowed(handles), |branching| Cow::Owned(branching.moved_copies(handles)))
}
