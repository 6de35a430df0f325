//! The solve of layers being dragged: everything independent of the pins' targets is computed once per drag.
//!
//! In: a prepared shot and the frame, then changed keys again and again. Out: the frame's [`TimeSample`] with those
//! layers solved.

use crate::image::Frame;
use crate::pipeline::{
    Device, LayerMarks, LayerSolver, LayerTask, PipelineError, PreparedShot, TimeSample, WarpedStill, resting_marks,
};
use crate::raster::geometry::KeptParts;
use crate::shot::{Layer, LayerSpace, PinRegion};
use crate::solve::Cancel;
use crate::space::FrameSize;

/// A frame with layers being dragged.
pub(super) struct DragSolve {
    frame: i32,
    layers: Vec<usize>,
    sample: TimeSample,
    /// One per layer of `layers`; `None` if it lies in the scene or is not visible.
    solvers: Vec<Option<LayerSolver>>,
    /// Marks of layers without displacement.
    resting: Vec<LayerMarks>,
    /// The inputs that the solvers were factored with.
    held: Vec<HeldPins>,
    /// The parts of all other layers.
    at_rest: KeptParts,
    /// The frame as pictures of its layers, drawn when it is first needed; `None` inside if that is not possible.
    still: Option<Option<WarpedStill>>,
}

impl DragSolve {
    /// Prepares a drag from the shot's keys at its start, and solves the frame.
    pub(super) fn begin(prepared: &PreparedShot, frame: i32, layers: &[usize]) -> Result<Self, PipelineError> {
        let is_in_scene = are_in_scene(prepared, layers);
        // Layers of the screen are solved below, with solvers that are kept.
        let sample = prepared.provisional_without(frame, if is_in_scene { &[] } else { layers })?;
        let mut solvers = Vec::new();
        for &index in layers {
            let Some(layer) = prepared.shot.layers.get(index) else { continue };
            let task = LayerTask { index, layer, anchors: prepared.anchors_of(index), weights: &[] };
            let path = prepared.shot.pin_path(index, prepared.key_frame(layer, sample.frame));
            solvers.push(prepared.layer_solver(&sample, &task, &path, &Cancel::never())?);
        }
        let (held, at_rest) = (held_of(prepared, layers), prepared.parts_at_rest(layers));
        let mut drag =
            Self { frame, layers: layers.to_vec(), sample, solvers, resting: Vec::new(), held, at_rest, still: None };
        if !is_in_scene {
            drag.solve(prepared)?;
        }
        drag.resting = resting_marks(prepared, &drag.sample);
        Ok(drag)
    }

    /// Returns whether this drag can be continued with these inputs.
    pub(super) fn fits(&self, prepared: &PreparedShot, frame: i32, layers: &[usize]) -> bool {
        self.frame == frame && self.layers == layers && self.held == held_of(prepared, layers)
    }

    /// Solves the frame with the shot's current keys.
    pub(super) fn solve(&mut self, prepared: &PreparedShot) -> Result<(), PipelineError> {
        if are_in_scene(prepared, &self.layers) {
            // World-space lattices displace what all other layers lie over.
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

    /// Returns the marks of undisplaced layers.
    pub(super) fn resting(&self) -> &[LayerMarks] {
        &self.resting
    }

    /// Returns the frame as solved last.
    pub(super) const fn sample(&self) -> &TimeSample {
        &self.sample
    }

    /// Returns a frame as solved last; `None` if another frame is dragged.
    pub(super) fn sample_of(&self, frame: i32) -> Option<&TimeSample> {
        (self.frame == frame).then_some(&self.sample)
    }

    /// Whether the pictures of the layers have been drawn.
    pub(super) const fn has_still(&self) -> bool {
        self.still.is_some()
    }

    /// Returns the frame with the dragged layers warped as pictures, in place of drawing it; `None` if that is not possible.
    pub(super) fn warped(
        &mut self,
        prepared: &PreparedShot,
        device: &mut Device,
        size: FrameSize,
    ) -> Result<Option<Frame>, PipelineError> {
        let still = match self.still.take() {
            Some(still) => still,
            None => prepared.warped_still(device, (&mut self.sample, &self.layers), size)?,
        };
        Ok(self.still.insert(still).as_ref().and_then(|still| still.warped(&self.sample)))
    }

    /// Returns the parts of all layers that are not dragged.
    pub(super) const fn at_rest(&self) -> &KeptParts {
        &self.at_rest
    }
}

/// The pin properties that a factored solver depends on: regions and mute states; and the number of moved handles.
#[derive(PartialEq)]
struct HeldPins {
    pins: Vec<(Option<PinRegion>, bool)>,
    handles: usize,
}

/// Whether any of the layers lies in the scene.
fn are_in_scene(prepared: &PreparedShot, layers: &[usize]) -> bool {
    let mut own = layers.iter().filter_map(|&index| prepared.shot.layers.get(index));
    own.any(|layer| matches!(layer.space, LayerSpace::World { .. }))
}

fn held_of(prepared: &PreparedShot, layers: &[usize]) -> Vec<HeldPins> {
    let held = |layer: &Layer| HeldPins {
        pins: layer.pins.iter().map(|pin| (pin.region, pin.is_muted)).collect(),
        handles: layer.handles.len(),
    };
    layers.iter().filter_map(|&index| prepared.shot.layers.get(index)).map(held).collect()
}
