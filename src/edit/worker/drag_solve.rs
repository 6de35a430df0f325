//! The solve of layers being dragged: everything independent of the pins' targets is computed once per frame.
//!
//! In: a prepared shot and the frame, then changed keys again and again. Out: the frame's [`TimeSample`] with those
//! layers solved.

use crate::image::Frame;
use crate::lattice::Basis;
use crate::pipeline::{
    Device, LayerMarks, LayerSolver, LayerTask, PipelineError, PreparedShot, TimeSample, WarpedStill, resting_marks,
};
use crate::raster::geometry::KeptParts;
use crate::shot::{BoxOrientation, Layer, LayerSpace, OffsetUnit, PinRegion};
use crate::solve::{Cancel, Settings};
use crate::space::FrameSize;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A frame whose layers are dragged, or will be.
pub(super) struct DragSolve {
    frame: i32,
    sample: Arc<TimeSample>,
    /// By layer; `None` if it lies in the scene or is not visible.
    solvers: BTreeMap<usize, Option<LayerSolver>>,
    /// The inputs that the solvers were factored with, one per layer of the shot.
    held: Vec<HeldLayer>,
    /// The layers that are dragged; none before a drag.
    dragged: Vec<usize>,
    /// Whether the layers that are not dragged are solved as in the shot.
    is_current: bool,
    /// Marks of layers without displacement.
    resting: Vec<LayerMarks>,
    /// The parts of all layers that are not dragged.
    at_rest: KeptParts,
    /// The frame as pictures of its layers, drawn when it is first needed; `None` inside if that is not possible.
    still: Option<Option<WarpedStill>>,
}

impl DragSolve {
    /// Prepares drags of these layers, and solves the frame as the shot's keys are.
    pub(super) fn begin(prepared: &PreparedShot, frame: i32, layers: &[usize]) -> Result<Self, PipelineError> {
        let is_in_scene = are_in_scene(prepared, layers);
        // Layers of the screen are solved below, with solvers that are kept.
        let sample = prepared.provisional_without(frame, if is_in_scene { &[] } else { layers })?;
        let mut solvers = BTreeMap::new();
        for &index in layers {
            let Some(layer) = prepared.shot.layers.get(index) else { continue };
            let task = LayerTask { index, layer, anchors: prepared.anchors_of(index), weights: &[] };
            let path = prepared.shot.pin_path(index, prepared.key_frame(layer, sample.frame));
            solvers.insert(index, prepared.layer_solver(&sample, &task, &path, &Cancel::never())?);
        }
        let mut drag = Self {
            frame,
            sample: Arc::new(sample),
            solvers,
            held: held_of(prepared),
            dragged: Vec::new(),
            is_current: true,
            resting: Vec::new(),
            at_rest: KeptParts::default(),
            still: None,
        };
        if !is_in_scene {
            drag.solve_layers(prepared, layers)?;
        }
        drag.resting = resting_marks(prepared, &drag.sample);
        Ok(drag)
    }

    /// Prepares drags of all layers that are solved for this frame alone.
    pub(super) fn look(prepared: &PreparedShot, frame: i32) -> Result<Self, PipelineError> {
        let is_own = |&index: &usize| {
            let layer = &prepared.shot.layers[index];
            let is_moved = !layer.pins.is_empty() || !layer.handles.is_empty();
            is_moved && !are_in_scene(prepared, &[index]) && prepared.is_solved_alone(index)
        };
        let layers: Vec<usize> = (0..prepared.shot.layers.len()).filter(is_own).collect();
        Self::begin(prepared, frame, &layers)
    }

    /// Returns whether the solvers are those that `look` or `begin` would prepare, whatever the keys are.
    pub(super) fn is_of(&self, prepared: &PreparedShot, frame: i32) -> bool {
        let time = prepared.mid_exposure_time(f64::from(frame));
        self.frame == frame && self.sample.frame == time && self.held == held_of(prepared)
    }

    /// Returns whether these layers can be dragged on.
    pub(super) fn fits(&self, prepared: &PreparedShot, frame: i32, layers: &[usize]) -> bool {
        let is_current = self.is_current || !has_layers_in_scene(prepared);
        is_current && self.is_of(prepared, frame) && layers.iter().all(|layer| self.solvers.contains_key(layer))
    }

    /// Keeps what the next drag of the frame needs; other layers may change until then. `None` if they may move the meshes.
    pub(super) fn set_aside(mut self, prepared: &PreparedShot, frame: i32) -> Option<Self> {
        (self.is_current, self.dragged) = (false, Vec::new());
        (self.at_rest, self.still) = (KeptParts::default(), None);
        (!has_layers_in_scene(prepared) && self.is_of(prepared, frame)).then_some(self)
    }

    /// Solves the frame with the shot's current keys, of which only those of the dragged layers change from one call to the next.
    pub(super) fn solve(&mut self, prepared: &PreparedShot, dragged: &[usize]) -> Result<(), PipelineError> {
        self.take_up(prepared, dragged);
        if are_in_scene(prepared, dragged) {
            // World-space lattices displace what all other layers lie over.
            self.sample = Arc::new(prepared.provisional(self.frame)?);
            return Ok(());
        }
        if !self.is_current {
            self.solve_all(prepared)?;
        }
        self.solve_layers(prepared, dragged)
    }

    /// Begins to drag layers, unless they are dragged already.
    pub(super) fn take_up(&mut self, prepared: &PreparedShot, dragged: &[usize]) {
        if self.dragged != dragged {
            (self.dragged, self.still) = (dragged.to_vec(), None);
            self.at_rest = prepared.parts_at_rest(dragged);
        }
    }

    /// Solves all layers with the shot's current keys.
    pub(super) fn solve_all(&mut self, prepared: &PreparedShot) -> Result<(), PipelineError> {
        let is_own = |index: &usize| self.solvers.contains_key(index) && prepared.is_solved_alone(*index);
        let (own, others): (Vec<usize>, Vec<usize>) = (0..prepared.shot.layers.len()).partition(is_own);
        self.solve_layers(prepared, &own)?;
        for index in others.into_iter().filter(|&index| !are_in_scene(prepared, &[index])) {
            let state = prepared.provisional_layer(&self.sample, index)?;
            Arc::make_mut(&mut self.sample).layers[index] = state;
        }
        self.resting = resting_marks(prepared, &self.sample);
        self.is_current = true;
        Ok(())
    }

    /// Solves layers with their solvers.
    fn solve_layers(&mut self, prepared: &PreparedShot, layers: &[usize]) -> Result<(), PipelineError> {
        let sample = Arc::make_mut(&mut self.sample);
        for &index in layers {
            let Some(Some(solver)) = self.solvers.get(&index) else { continue };
            let layer = &prepared.shot.layers[index];
            let path = prepared.shot.pin_path(index, prepared.key_frame(layer, sample.frame));
            sample.layers[index] = solver.solve(layer, &path)?;
        }
        Ok(())
    }

    /// Returns the marks of undisplaced layers.
    pub(super) fn resting(&self) -> &[LayerMarks] {
        &self.resting
    }

    /// Returns the frame as solved last.
    pub(super) const fn sample(&self) -> &Arc<TimeSample> {
        &self.sample
    }

    /// Returns a frame as solved last; `None` if another frame is dragged, or other layers may have changed.
    pub(super) fn sample_of(&self, frame: i32) -> Option<&Arc<TimeSample>> {
        (self.frame == frame && self.is_current).then_some(&self.sample)
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
            None => prepared.warped_still(device, (Arc::make_mut(&mut self.sample), &self.dragged), size)?,
        };
        Ok(self.still.insert(still).as_ref().and_then(|still| still.warped(&self.sample)))
    }

    /// Returns the parts of all layers that are not dragged.
    pub(super) const fn at_rest(&self) -> &KeptParts {
        &self.at_rest
    }
}

/// The properties of a layer, beside its anchors, that a factored solver depends on.
#[derive(PartialEq)]
struct HeldLayer {
    space: LayerSpace,
    basis: Basis,
    orientation: BoxOrientation,
    settings: Settings,
    pins: Vec<(Option<PinRegion>, bool, f64, OffsetUnit)>,
    handles: Vec<[usize; 3]>,
}

impl HeldLayer {
    fn of(layer: &Layer) -> Self {
        Self {
            space: layer.space,
            basis: layer.basis,
            orientation: layer.orientation.clone(),
            settings: layer.settings.clone(),
            pins: layer.pins.iter().map(|pin| (pin.region, pin.is_muted, pin.weight, pin.unit)).collect(),
            handles: layer.handles.iter().map(|handle| handle.index).collect(),
        }
    }
}

fn held_of(prepared: &PreparedShot) -> Vec<HeldLayer> {
    prepared.shot.layers.iter().map(HeldLayer::of).collect()
}

/// Whether any of the layers lies in the scene.
fn are_in_scene(prepared: &PreparedShot, layers: &[usize]) -> bool {
    let mut own = layers.iter().filter_map(|&index| prepared.shot.layers.get(index));
    own.any(|layer| matches!(layer.space, LayerSpace::World { .. }))
}

fn has_layers_in_scene(prepared: &PreparedShot) -> bool {
    prepared.shot.layers.iter().any(|layer| matches!(layer.space, LayerSpace::World { .. }))
}
