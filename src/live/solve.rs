//! Solves warps from parameters, through the caches of the process: scenes, prefactored solvers, solved warps.
//!
//! In: [`Controls`], a [`ShapeSource`], the frame. Out: a [`Warp`]. Solvers are always prepared from pins at rest, so
//! that a warp is bit-identical whatever was solved before.

#[cfg(any(test, feature = "ofx"))]
use super::base_scene::BaseScene;
use super::driven_layer::{Goals, check_controls, driven_layer};
use super::key::{Key, KeyWriter};
use super::load_scene::load_scene;
use super::prepared_solver::PreparedSolver;
use super::process_cache::CACHE;
use super::warp::{ActingPin, PinPlace, Warning};
use super::{Controls, LiveError, Moved, NEVER, OwnPins, ShapeSource, ShotShape, Stop, Warp, shape_source};
use crate::lattice::Support;
use crate::memory;
use crate::pipeline::{
    BranchView, Exposure, LayerState, LayerTask, PinAnchor, PipelineError, PreparedShot, SampleInMotion, TimeSample,
    fields_of,
};
use crate::plate::SharedParts;
use crate::shot::{FrameRange, Layer};
use crate::solve::{Cancel, SolveError};
use crate::space::{FrameSize, ScreenPoint};
use std::sync::Arc;

/// Peak bytes of a solve per entry of the matrix's band: counted from the sizes of the matrices of one coordinate and
/// of both, and of their factors, not measured.
const BAND_ENTRY_BYTES: u128 = 120;

/// Returns the warp of a picture of size `frame`; results are cached by content.
///
/// # Errors
/// [`LiveError`] if a parameter is out of range, the shot file is invalid or has another aspect ratio, or the problem
/// cannot be solved (more handles than a lattice may have).
pub fn warp(controls: &Controls, shape: &ShapeSource, frame: FrameSize) -> Result<Arc<Warp>, LiveError> {
    warp_until(controls, shape, frame, NEVER)
}

/// Like [`warp`]; during a solve, `stop` is called every few milliseconds on the calling thread. Cancelled solves are not cached.
///
/// # Errors
/// As [`warp`]; [`LiveError::Aborted`].
pub(crate) fn warp_until(
    controls: &Controls,
    shape: &ShapeSource,
    frame: FrameSize,
    stop: &Stop,
) -> Result<Arc<Warp>, LiveError> {
    controls.check()?;
    let given_up = || stop().then_some(LiveError::Aborted);
    let hook = || stop();
    let cancel = Cancel::when(&hook);
    if let ShapeSource::Shot(shot) = shape {
        check_aspect(shot, frame)?;
    }
    let base_key = shape.key(frame)?;
    let solver_key = solver_key(base_key, controls, shape);
    let key = warp_key(solver_key, controls);
    let warp = CACHE.warps.get_until(key, &given_up, || {
        let base = CACHE.scenes.get_until(base_key, &given_up, || load_scene(shape, frame))?;
        let Some(prepared) = &base.prepared else {
            return Ok(Warp::identity("the picture's alpha is 0 everywhere: nothing is warped", key));
        };
        let task = Task { prepared, index: base.layer, controls, shape, size: frame };
        let ready = CACHE.solvers.get_until(solver_key, &given_up, || task.prepare(base_key, &cancel))?;
        given_up().map_or(Ok(()), Err)?;
        task.solve(&ready, key, &cancel)
    })?;
    if matches!(shape, ShapeSource::Coverage(_)) {
        CACHE.shown_warps.put(shown_key(controls), Arc::clone(&warp));
    }
    Ok(warp)
}

/// Converts a cancelled solve to an abort.
fn aborted(error: PipelineError) -> LiveError {
    match error {
        PipelineError::Solve { source: SolveError::Cancelled, .. } => LiveError::Aborted,
        error => error.into(),
    }
}

/// Returns the latest [`warp`] of these controls over a picture's alpha, of any size, for hosts that have no pixels
/// while they draw handles; `None` if there was none recently.
#[cfg(any(test, feature = "ofx"))]
#[must_use]
pub(crate) fn last_of_alpha(controls: &Controls) -> Option<Arc<Warp>> {
    CACHE.shown_warps.peek(shown_key(controls))
}

fn shown_key(controls: &Controls) -> Key {
    warp_key(solver_key(KeyWriter::new().finish(), controls, &ShapeSource::Frame), controls)
}

/// Returns the scene of a shape, loaded or cached.
///
/// # Errors
/// [`LiveError`] if it cannot be loaded, or has another aspect ratio.
#[cfg(any(test, feature = "ofx"))]
pub(super) fn base(shape: &ShapeSource, frame: FrameSize) -> Result<Arc<BaseScene>, LiveError> {
    if let ShapeSource::Shot(shot) = shape {
        check_aspect(shot, frame)?;
    }
    CACHE.scenes.get(shape.key(frame)?, || load_scene(shape, frame))
}

/// Hashes everything that determines the factored matrix.
fn solver_key(base: Key, controls: &Controls, shape: &ShapeSource) -> Key {
    let mut key = KeyWriter::after(base);
    key.words(&controls.dims.map(|count| count as u64)).word(controls.basis as u64).float(controls.smoothness);
    key.word(controls.moved as u64).word(controls.guard as u64);
    for pin in &controls.pins {
        key.float(pin.rest.0.x).float(pin.rest.0.y).word(pin.rotation.is_some().into());
        key.word(pin.scale.is_some().into()).float(pin.weight);
        let region = pin.region.map_or([0.0; 3], |region| [region.radius, region.rigidity, region.stiffness]);
        region.iter().for_each(|value| _ = key.float(*value));
    }
    if let ShapeSource::Shot(shot) = shape {
        key.float(shot.frame).word(shot.pin_frame as u64).word(shot.own_pins as u64);
    }
    key.finish()
}

/// Adds everything that determines the targets.
fn warp_key(solver: Key, controls: &Controls) -> Key {
    let mut key = KeyWriter::after(solver);
    key.float(controls.strength);
    for pin in &controls.pins {
        key.float(pin.target.0.x).float(pin.target.0.y).option(pin.rotation).option(pin.scale);
    }
    key.finish()
}

/// Checks the aspect ratio. Proxies have that of the shot; another ratio needs another shot.
fn check_aspect(shape: &ShotShape, frame: FrameSize) -> Result<(), LiveError> {
    let wanted = shape_source::read(&shape.path)?.size.aspect();
    if frame.is_as_wide_as(wanted) {
        return Ok(());
    }
    let hint = "correct `size` and `pixel_aspect` of the shot, or the format of the picture";
    Err(LiveError::Aspect { path: shape.path.clone(), wanted, found: frame.aspect(), hint })
}

/// One layer, driven by controls.
struct Task<'a> {
    prepared: &'a PreparedShot,
    index: usize,
    controls: &'a Controls,
    shape: &'a ShapeSource<'a>,
    /// Size of the picture.
    size: FrameSize,
}

impl Task<'_> {
    /// Returns the current frame.
    fn frame(&self) -> f64 {
        if let ShapeSource::Shot(shot) = self.shape { shot.frame } else { 0.0 }
    }

    fn own_pins(&self) -> OwnPins {
        if let ShapeSource::Shot(shot) = self.shape { shot.own_pins } else { OwnPins::Act }
    }

    fn layer(&self, goals: Goals) -> Layer {
        let key_frame = self.key_frame();
        driven_layer(&self.prepared.shot.layers[self.index], self.controls, (self.own_pins(), key_frame), goals)
    }

    fn key_frame(&self) -> f64 {
        let sample = self.prepared.mid_exposure_time(self.frame());
        self.prepared.key_frame(&self.prepared.shot.layers[self.index], sample)
    }

    fn frames(&self) -> &FrameRange {
        &self.prepared.shot.frames
    }

    fn prepare(&self, base: Key, cancel: &Cancel) -> Result<PreparedSolver, LiveError> {
        let layer = self.layer(Goals::AtRest);
        check_controls(&self.prepared.shot.layers[self.index], &self.prepared.shot.path, self.controls)?;
        self.check_memory()?;
        let (pinned, warnings) = self.pinned(base)?;
        let own = layer.pins.len() - pinned.len();
        let anchors: Vec<PinAnchor> =
            self.prepared.anchors_of(self.index)[..own].iter().copied().chain(pinned).collect();
        let sample = self.unsolved()?;
        let weights: Vec<f64> =
            std::iter::repeat_n(1.0, own).chain(self.controls.pins.iter().map(|pin| pin.weight)).collect();
        let task = LayerTask { index: self.index, layer: &layer, anchors: &anchors, weights: &weights };
        let path = layer.pin_path(self.frames(), self.key_frame());
        let layer_solver = self.prepared.layer_solver(&sample, &task, &path, cancel).map_err(aborted)?;
        Ok(PreparedSolver { solver: layer_solver, warnings })
    }

    /// Checks that the matrices of the lattice fit into the memory budget.
    fn check_memory(&self) -> Result<(), LiveError> {
        let Controls { dims, basis, .. } = *self.controls;
        let handles = dims[0] * dims[1];
        let band = match basis.support() {
            Support::Global => handles,
            Support::Tensor { width } => handles.min(width * dims[0]),
            Support::Simplex => handles.min(2 * dims[0]),
        };
        memory::check((handles * band) as u128 * BAND_ENTRY_BYTES).map_err(|source| LiveError::Memory { dims, source })
    }

    /// Returns the anchors of the pins of the controls.
    fn pinned(&self, base: Key) -> Result<(Vec<PinAnchor>, Vec<Warning>), LiveError> {
        let rests: Vec<ScreenPoint> = self.controls.pins.iter().map(|pin| pin.rest).collect();
        let ShapeSource::Shot(shot) = self.shape else {
            return Ok((rests.into_iter().map(PinAnchor::Screen).collect(), Vec::new()));
        };
        let mut key = KeyWriter::after(base);
        key.word(shot.pin_frame as u64);
        rests.iter().for_each(|rest| _ = key.float(rest.0.x).float(rest.0.y));
        let casts = CACHE.casts.get(key.finish(), || Ok::<_, LiveError>(self.prepared.cast(shot.pin_frame, &rests)))?;
        let missed = casts.iter().enumerate().filter(|(_, cast)| cast.is_none());
        let warnings =
            missed.map(|(index, _)| Warning::OffModel { pin: index, at: rests[index], frame: shot.pin_frame });
        let warnings = warnings.collect();
        let pinned = casts.iter().zip(rests).map(|(cast, rest)| cast.unwrap_or(PinAnchor::Screen(rest)));
        Ok((pinned.collect(), warnings))
    }

    fn solve(&self, ready: &PreparedSolver, key: Key, cancel: &Cancel) -> Result<Warp, LiveError> {
        let Some(layer_solver) = &ready.solver else {
            return Ok(Warp::identity("no part of the model is visible in the frame: nothing is warped", key));
        };
        let layer = self.layer(Goals::Reached);
        let path = layer.pin_path(self.frames(), self.key_frame());
        let state = layer_solver.solve_cancellable(&layer, &path, cancel).map_err(aborted)?;
        let is_whole = matches!(
            (self.controls.moved, self.shape, &layer.matte),
            (Moved::Picture, ShapeSource::Frame | ShapeSource::Shot(_), None)
        );
        let field = state.field(is_whole).unwrap_or_default();
        let (parts, state) = self.parts(state)?;
        let (parts, covered) = parts.map_or_else(Default::default, |(parts, covered)| (parts, Some(covered)));
        let folds = self.folds(&state)?;
        let given_way = state.whole.iter().flat_map(|whole| whole.given_way.iter().copied()).collect::<Vec<_>>();
        let (lattice, report) = match state.solution {
            Some(solution) => (solution.lattice, Some(solution.report)),
            None => (layer_solver.grid().at_rest(), None),
        };
        let own = layer.pins.len() - self.controls.pins.len();
        let rests = &layer_solver.rests()[own..];
        let warp = Warp { field, parts, covered, lattice: Some(lattice), folds, report, ..Warp::identity("", key) };
        let pins = rests.iter().zip(&self.controls.pins).map(|(rest, pin)| PinPlace {
            rest: rest.point,
            target: crate::space::ScreenPoint(rest.point.0 + (pin.target - pin.rest).0 * layer.strength),
            moved: warp.carry(rest.point, self.size),
            presence: rest.presence,
        });
        let mut warnings = ready.warnings.clone();
        warnings.extend(warp.report.iter().flat_map(|report| report.warnings.iter().cloned().map(Warning::Text)));
        warnings.extend(given_way.into_iter().map(|(pin, by)| Warning::BorderGivesWay { pin, by }));
        let acting = state.pins.iter().map(|pin| match pin.pin.checked_sub(own) {
            Some(index) => ActingPin::OfControls(index),
            None => ActingPin::OfShot(layer.pins[pin.pin].name.clone()),
        });
        let acting = acting.collect();
        let pins = pins.collect();
        Ok(Warp { pins, warnings, acting, ..warp })
    }

    /// Returns the scene at the current frame, with its screen layers unsolved.
    fn unsolved(&self) -> Result<TimeSample, LiveError> {
        Ok(self.prepared.unsolved_at(self.prepared.mid_exposure_time(self.frame()))?)
    }

    /// Returns the outlines of the cells in which the shape folds.
    fn folds(&self, state: &LayerState) -> Result<Vec<Vec<ScreenPoint>>, LiveError> {
        match &state.solution {
            Some(solution) if solution.report.folded_model_cells > 0 => {
                Ok(self.prepared.folded_outlines((&self.unsolved()?, self.index), solution))
            }
            _ => Ok(Vec::new()),
        }
    }

    /// Returns the parts of the picture if the lattice branches, and hands back the state.
    fn parts(&self, state: LayerState) -> Result<(Option<SharedParts>, LayerState), LiveError> {
        if state.solution.as_ref().is_none_or(|solution| solution.branches.is_none()) {
            return Ok((None, state));
        }
        let mut sample = self.unsolved()?;
        sample.layers[self.index] = state;
        let view = BranchView { size: self.size, exposure: Exposure::Shutter };
        let parts = self.prepared.branch_parts(self.index, SampleInMotion { now: &sample, around: None }, view);
        Ok((parts.and_then(fields_of), std::mem::take(&mut sample.layers[self.index])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Basis;
    use crate::live::Pin;
    use crate::live::process_cache::SOLVER_BYTES;

    #[test]
    fn large_solvers_weigh_more_and_few_of_them_are_kept() {
        let frame = FrameSize::new(160, 90);
        let pin = Pin::new(ScreenPoint::new(0.5, 0.5), ScreenPoint::new(0.6, 0.5));
        let weight = |dims, basis| {
            let controls = Controls { dims, basis, pins: vec![pin], ..Controls::default() };
            let base = load_scene(&ShapeSource::Frame, frame).expect("a card");
            let prepared = base.prepared.as_ref().expect("a card");
            let task = Task { prepared, index: 0, controls: &controls, shape: &ShapeSource::Frame, size: frame };
            task.prepare(KeyWriter::new().finish(), &Cancel::never()).expect("fits").bytes()
        };
        let small = weight([10, 10], Basis::Bspline);
        assert_eq!((small, SOLVER_BYTES / small), (2_000_000, 67));
        assert_eq!(weight([20, 30], Basis::Bspline), 6 * small);
        assert!(weight([10, 10], Basis::Bernstein) > 6 * small);
    }
}
