//! The solve of layers whose keys follow the pointer: what does not depend on where pins go is done once a drag.
//!
//! In: a prepared shot and the frame, then keys again and again. Out: the frame's [`TimeSample`], those layers solved.

use crate::pipeline::{LayerMarks, LayerSolver, LayerTask, PipelineError, PreparedShot, TimeSample, resting_marks};
use crate::shot::{Layer, LayerSpace, PinRegion};
use crate::solve::Cancel;

/// A frame with layers under the hand.
pub(super) struct DragSolve {
    frame: i32,
    layers: Vec<usize>,
    sample: TimeSample,
    /// One a layer of `layers`; `None`: it lies in the scene or out of sight.
    solvers: Vec<Option<LayerSolver>>,
    /// Lattices of layers that nothing moves.
    resting: Vec<LayerMarks>,
    /// What a solver holds of the layers.
    held: Vec<HeldPins>,
}

impl DragSolve {
    /// Prepares a drag; the shot's keys are those of its beginning.
    pub(super) fn begin(prepared: &PreparedShot, frame: i32, layers: &[usize]) -> Result<Self, PipelineError> {
        let sample = prepared.provisional(frame)?;
        let mut solvers = Vec::new();
        for &index in layers {
            let Some(layer) = prepared.shot.layers.get(index) else { continue };
            let task = LayerTask { index, layer, anchors: prepared.anchors_of(index), weights: &[] };
            let path = prepared.shot.pin_path(index, prepared.key_frame(layer, sample.frame));
            solvers.push(prepared.layer_solver(&sample, &task, &path, &Cancel::never())?);
        }
        let resting = resting_marks(prepared, &sample);
        Ok(Self { frame, layers: layers.to_vec(), sample, solvers, resting, held: held_of(prepared, layers) })
    }

    /// Whether it goes on with that drag.
    pub(super) fn fits(&self, prepared: &PreparedShot, frame: i32, layers: &[usize]) -> bool {
        self.frame == frame && self.layers == layers && self.held == held_of(prepared, layers)
    }

    /// Solves the frame with the keys that the shot has now.
    pub(super) fn solve(&mut self, prepared: &PreparedShot) -> Result<(), PipelineError> {
        let is_in_scene = |&index: &usize| matches!(prepared.shot.layers[index].space, LayerSpace::World { .. });
        if self.layers.iter().any(is_in_scene) {
            // Lattices of the scene move what all others lie over.
            self.sample = prepared.provisional(self.frame)?;
            return Ok(());
        }
        for (&index, solver) in self.layers.iter().zip(&self.solvers) {
            let Some(solver) = solver else { continue };
            let layer = &prepared.shot.layers[index];
            let path = prepared.shot.pin_path(index, prepared.key_frame(layer, self.sample.frame));
            self.sample.layers[index] = solver.solve(layer, &path)?;
        }
        Ok(())
    }

    /// Marks of layers that rest.
    pub(super) fn resting(&self) -> &[LayerMarks] {
        &self.resting
    }

    /// The frame as it was solved last.
    pub(super) const fn sample(&self) -> &TimeSample {
        &self.sample
    }
}

/// What a factored solver depends on of a layer's pins: what they take along, whether they act; which handles are moved.
#[derive(PartialEq)]
struct HeldPins {
    pins: Vec<(Option<PinRegion>, bool)>,
    handles: usize,
}

fn held_of(prepared: &PreparedShot, layers: &[usize]) -> Vec<HeldPins> {
    let held = |layer: &Layer| HeldPins {
        pins: layer.pins.iter().map(|pin| (pin.region, pin.is_muted)).collect(),
        handles: layer.handles.len(),
    };
    layers.iter().filter_map(|&index| prepared.shot.layers.get(index)).map(held).collect()
}
