//! Screen layers: lattices solved on the screen, over the projected scene.
//!
//! In: a projected [`TimeSample`] and a layer. Out: the layer's lattice and pins.

use super::lattice_box::screen_box;
use super::layer_pins::{faded_weight, held_border, moved_handles, region};
use super::layer_solve::{factor, solve_layer};
use super::part_triangle_ranges::{PartTriangleRanges, held_triangle};
use super::screen_shape::{ScreenShape, screen_shape, screen_shape_with_starts};
use super::whole_layer;
use crate::lattice::Grid;
use crate::pipeline::prepare::reflection::{MirroredPin, ScreenReflection};
use crate::pipeline::{LayerState, PinAnchor, PinState, PipelineError, PreparedShot, RestPoint, TimeSample};
use crate::shot::{BoxRule, Goal, Layer, LayerSpace, OffsetUnit, PinTargets, Rotation, Source};
use crate::solve::{Cancel, PointPin, SolveError, Solver, Targets, Topology};
use crate::space::{ScreenPoint, ScreenVector};
use std::borrow::Cow;

/// A screen layer and the anchors of its pins: the shot's own, or a layer controlled by a host program.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LayerTask<'a> {
    /// Index of the layer in the shot, whose nodes are the shape.
    pub(crate) index: usize,
    /// The layer: lattice, settings, pins and handles.
    pub(crate) layer: &'a Layer,
    /// One per pin of the layer.
    pub(crate) anchors: &'a [PinAnchor],
    /// Weights of the pins, 0..=1, in order; missing ones count as 1.
    pub(crate) weights: &'a [f64],
}

/// A screen layer at one time: everything that does not depend on the targets of pins and handles.
#[derive(Debug)]
pub(crate) struct LayerSolver {
    frame: f64,
    grid: Grid<2>,
    /// One per pin of the layer.
    rests: Vec<RestPoint>,
    /// One per pin of the shot's layer: set if the pin is mirrored.
    mirrored: Vec<Option<ScreenMirror>>,
    /// Weights of the layer's first pins; those of the others are 1.
    weights: Vec<f64>,
    border: Border,
    /// One per pin: the triangle of the shape to which it is attached.
    triangles: Vec<Option<u32>>,
    /// Positions of the layer's parts in the shape, if the lattice branches.
    starts: Vec<PartTriangleRanges>,
    /// `None` if there are neither pins nor handles.
    solver: Option<Solver<2>>,
}

/// A mirrored pin at one time.
#[derive(Clone, Copy, Debug)]
struct ScreenMirror {
    /// Position of the pin that it follows.
    source: ScreenPoint,
    reflection: ScreenReflection,
}

/// The treatment of the edge of a layer's box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Border {
    /// The edge moves with the lattice.
    Free,
    /// The border handles that are not moved by keys are held at rest.
    Held,
    /// The edge rests, enforced after the solve instead of by handles (see `whole_layer`).
    Rests,
}

/// Returns the state of a screen layer: solved, or taken from a lattice file.
pub(in crate::pipeline) fn solve(
    prepared: &PreparedShot,
    sample: &TimeSample,
    index: usize,
    bounds: BoxRule,
) -> Result<LayerState, PipelineError> {
    let layer = &prepared.shot.layers[index];
    if let Some(loaded) = &prepared.layer_inputs.loaded[index] {
        let key_frame = prepared.key_frame(layer, sample.frame);
        let rest_box = || screen_box(prepared, sample, index, bounds);
        let shape = || {
            let ScreenShape { shape, starts } = screen_shape_with_starts(prepared, sample, index);
            (shape, starts)
        };
        return Ok(loaded.state(layer, key_frame, (rest_box, shape)));
    }
    if layer.pins.is_empty() && layer.handles.is_empty() {
        return Ok(LayerState::default());
    }
    // The whole path of the pins, at this frame's anchors, determines the winding.
    let path = prepared.shot.pin_path(index, prepared.key_frame(layer, sample.frame));
    let task = LayerTask { index, layer, anchors: prepared.anchors_of(index), weights: &[] };
    match prepared.layer_solver(sample, &task, &path, &Cancel::never())? {
        Some(solver) => solver.solve(layer, &path),
        None => Ok(LayerState::default()),
    }
}

impl PreparedShot {
    /// Prepares everything of a screen layer's solve that does not depend on the targets of its pins. `path` lists what
    /// the pins prescribe, as returned by [`Shot::pin_path`](crate::shot::Shot::pin_path). `None` if nothing of the
    /// layer is in or near the frame, and for world layers.
    ///
    /// # Errors
    /// [`PipelineError::Solve`] if the problem is malformed, or the solve is cancelled.
    pub(crate) fn layer_solver(
        &self,
        sample: &TimeSample,
        task: &LayerTask,
        path: &[PinTargets],
        cancel: &Cancel,
    ) -> Result<Option<LayerSolver>, PipelineError> {
        let LayerTask { index, layer, anchors, .. } = *task;
        let Some(mut solver) = unfactored(self, sample, task) else { return Ok(None) };
        let branching = is_branching(layer).then(|| screen_shape_with_starts(self, sample, index));
        if let Some(ScreenShape { starts, .. }) = &branching {
            solver.hold_triangles(anchors, starts);
        }
        if let Some((_, goal)) = path.last().map(|targets| solver.targets(layer, targets)) {
            let shape = || branching.map_or_else(|| screen_shape(self, sample, index), |branching| branching.shape);
            let settings = match solver.border {
                Border::Rests => Cow::Owned(whole_layer::compliant(&layer.settings)),
                Border::Free | Border::Held => Cow::Borrowed(&layer.settings),
            };
            let factored = factor(&solver.grid, shape, &goal, &settings, cancel);
            solver.solver = factored.map_err(|source| solver.fault(layer, source))?;
        }
        Ok(Some(solver))
    }
}

impl PreparedShot {
    /// Returns width and height of the rest box of a screen layer's lattice at a (fractional) frame, in frame heights; `None` if nothing
    /// of the layer is in or near the frame, and for world layers.
    ///
    /// # Errors
    /// [`PipelineError::Solve`] if a world layer cannot be solved.
    #[cfg(any(test, feature = "ofx"))]
    pub(crate) fn box_size(&self, index: usize, frame: f64) -> Result<Option<[f64; 2]>, PipelineError> {
        let Layer { space: LayerSpace::Screen { dims, bounds }, basis, .. } = self.shot.layers[index] else {
            return Ok(None);
        };
        let rest_box = screen_box(self, &self.unsolved_at(frame)?, index, bounds);
        let grid = rest_box.map(|rest_box| Grid::over(rest_box, dims, basis));
        Ok(grid.map(|grid| [0, 1].map(|axis| grid.size(axis))))
    }
}

/// Returns box, grid and pins of a screen layer, without a factored matrix.
pub(in crate::pipeline) fn unfactored(
    prepared: &PreparedShot,
    sample: &TimeSample,
    task: &LayerTask,
) -> Option<LayerSolver> {
    let LayerTask { index, layer, anchors, weights } = *task;
    let LayerSpace::Screen { dims, bounds } = layer.space else { return None };
    let rest_box = screen_box(prepared, sample, index, bounds)?;
    let mesh = sample.mesh();
    Some(LayerSolver {
        frame: sample.frame,
        grid: Grid::over(rest_box, dims, layer.basis),
        rests: anchors.iter().map(|anchor| anchor.rest(&mesh, &sample.camera)).collect(),
        mirrored: screen_mirrors(prepared, sample, task),
        weights: weights.to_vec(),
        border: border(&prepared.shot.source, layer, bounds),
        triangles: Vec::new(),
        starts: Vec::new(),
        solver: None,
    })
}

/// Returns how the pins of a task follow others. The pins of a host program follow none.
fn screen_mirrors(prepared: &PreparedShot, sample: &TimeSample, task: &LayerTask) -> Vec<Option<ScreenMirror>> {
    if task.layer.pins.iter().all(|pin| pin.mirror.is_none()) {
        return Vec::new();
    }
    let mesh = sample.mesh();
    let mirror = |mirrored: &MirroredPin| ScreenMirror {
        source: mirrored.source.rest(&mesh, &sample.camera).point,
        reflection: mirrored.reflection(&sample.pose).seen_by(&sample.camera),
    };
    prepared.mirrored_pins_of(task.index).iter().map(|pin| pin.as_ref().map(mirror)).collect()
}

/// Whether the layer's lattice may branch.
pub(in crate::pipeline) fn is_branching(layer: &Layer) -> bool {
    layer.settings.topology == Topology::Branching
}

/// Returns the treatment of the edge. A layer that moves a whole plate has no data beyond the edge, and a background
/// must not slide, so the edge is fixed; in a shot with a scene, the plate follows the geometry instead.
fn border(source: &Source, layer: &Layer, bounds: BoxRule) -> Border {
    match (source, bounds, &layer.matte) {
        (Source::Frame, BoxRule::Frame, None) if layer.handles.is_empty() => Border::Rests,
        (Source::Frame, BoxRule::Frame, None) => Border::Held,
        _ => Border::Free,
    }
}

/// Whether a layer moves a whole picture whose border rests.
pub(in crate::pipeline) fn border_rests(source: &Source, layer: &Layer) -> bool {
    match layer.space {
        LayerSpace::Screen { bounds, .. } => border(source, layer, bounds) == Border::Rests,
        LayerSpace::World { .. } => false,
    }
}

impl LayerSolver {
    /// Attaches the pins to triangles of the shape.
    pub(in crate::pipeline) fn hold_triangles(&mut self, anchors: &[PinAnchor], starts: &[PartTriangleRanges]) {
        self.triangles = anchors.iter().map(|anchor| held_triangle(anchor, starts)).collect();
        self.starts = starts.to_vec();
    }

    /// Returns the positions of the layer's parts in the shape; empty if the lattice does not branch.
    pub(in crate::pipeline) fn starts(&self) -> &[PartTriangleRanges] {
        &self.starts
    }

    /// Returns the grid of the lattice at rest.
    #[must_use]
    pub(crate) fn grid(&self) -> &Grid<2> {
        &self.grid
    }

    /// Returns the positions of the layer's pins before the warp, one per pin.
    #[must_use]
    pub(crate) fn rests(&self) -> &[RestPoint] {
        &self.rests
    }

    /// Solves for the targets at the end of a path, for the prepared pins and handles. The same path gives the same
    /// bits, whatever was solved before.
    ///
    /// # Errors
    /// [`PipelineError::Solve`] if pins or handles differ from the prepared ones, or numbers are not finite.
    pub(crate) fn solve(&self, layer: &Layer, path: &[PinTargets]) -> Result<LayerState, PipelineError> {
        self.solve_cancellable(layer, path, &Cancel::never())
    }

    /// Solves as [`Self::solve`] does, unless it is cancelled.
    ///
    /// # Errors
    /// As [`Self::solve`], and [`SolveError::Cancelled`] as the source.
    pub(crate) fn solve_cancellable(
        &self,
        layer: &Layer,
        path: &[PinTargets],
        cancel: &Cancel,
    ) -> Result<LayerState, PipelineError> {
        let Some(solver) = &self.solver else { return Ok(LayerState::default()) };
        let (mut states, way): (Vec<_>, Vec<_>) = path.iter().map(|targets| self.targets(layer, targets)).unzip();
        let (Some(pins), Some(goal)) = (states.pop(), way.last()) else { return Ok(LayerState::default()) };
        let presence = pins.iter().map(|pin| pin.presence);
        let mut solution =
            solve_layer(solver, &way, goal, presence, cancel).map_err(|source| self.fault(layer, source))?;
        if self.border == Border::Rests {
            let whole_pins = path.last().map(|targets| {
                let weights: Vec<f64> =
                    pins.iter().map(|state| state.presence * self.weight(layer, state.pin)).collect();
                whole_layer::whole_pins(&pins, &self.turned(targets), &weights)
            });
            let whole = whole_pins.map(|pins| whole_layer::finish(&mut solution, &pins));
            return Ok(LayerState { solution: Some(solution), pins, whole, ..LayerState::default() });
        }
        Ok(LayerState { solution: Some(solution), pins, starts: self.starts.clone(), ..LayerState::default() })
    }

    /// Returns the active pins, and the solver's targets, for one point of the path.
    pub(in crate::pipeline) fn targets(&self, layer: &Layer, targets: &PinTargets) -> (Vec<PinState>, Targets<2>) {
        let (states, pins) = self.point_pins(layer, targets);
        let mut handles = moved_handles(layer, &self.grid, targets);
        if self.border != Border::Free {
            handles.extend(held_border(&self.grid, &handles));
        }
        (states, Targets { pins, handles })
    }

    /// Returns the weight of a pin: its own times the one given in the task.
    fn weight(&self, layer: &Layer, pin: usize) -> f64 {
        layer.pins[pin].weight * self.weights.get(pin).copied().unwrap_or(1.0)
    }

    /// Returns targets in which the rotations of mirrored pins are those seen on their side.
    fn turned<'t>(&self, targets: &'t PinTargets) -> Cow<'t, PinTargets> {
        let mut turned = Cow::Borrowed(targets);
        for (pin, mirror) in self.mirrored.iter().enumerate() {
            let (Some(mirror), Some(Rotation::InView(angle))) = (mirror, targets.pins[pin].rotation) else { continue };
            let angle = angle * mirror.reflection.turn();
            turned.to_mut().pins[pin].rotation = Some(Rotation::InView(angle));
        }
        turned
    }

    fn fault(&self, layer: &Layer, source: SolveError) -> PipelineError {
        PipelineError::Solve { layer: layer.name.clone(), frame: self.frame, source }
    }

    /// Returns the active pins for the overlay and for the solver.
    fn point_pins(&self, layer: &Layer, targets: &PinTargets) -> (Vec<PinState>, Vec<PointPin<2>>) {
        let targets = self.turned(targets);
        let mut states = Vec::new();
        let mut points = Vec::new();
        for (pin, (rest, target)) in self.rests.iter().zip(&targets.pins).enumerate() {
            if rest.presence <= 0.0 || layer.pins[pin].is_muted {
                continue;
            }
            let mirror = self.mirrored.get(pin).copied().flatten();
            let offset = match target.goal {
                Goal::Offset(offset) => match layer.pins[pin].unit {
                    OffsetUnit::Frame => offset,
                    OffsetUnit::Box => ScreenVector(self.grid.scaled_to_box(offset.0.to_array()).into()),
                },
                Goal::Target(place) => {
                    let from = mirror.map_or(rest.point, |mirror| mirror.source);
                    ScreenVector((place - from).0 * layer.strength)
                }
                // Goals of world layers, which the shot checks refuse for screen layers.
                Goal::SceneOffset(_) | Goal::SceneTarget(_) => ScreenVector::default(),
            };
            let goal = rest.point + mirror.map_or(offset, |mirror| mirror.reflection.direction(offset));
            let is_turned = target.rotation.is_some() || target.log_scale.is_some();
            // If the border rests, the discs of the flow rotate and scale instead.
            let gradient = (is_turned && self.border != Border::Rests).then(|| {
                let angle = match target.rotation {
                    Some(Rotation::InView(angle)) => angle,
                    _ => 0.0,
                };
                let (sin, cos) = angle.sin_cos();
                let scale = target.log_scale.unwrap_or(0.0).exp();
                [[scale * cos, scale * sin], [-scale * sin, scale * cos]]
            });
            states.push(PinState { pin, rest: rest.point, target: goal, presence: rest.presence, is_in_view: true });
            points.push(PointPin {
                at: rest.point.0.to_array(),
                target: goal.0.to_array(),
                weight: faded_weight(rest.presence * self.weight(layer, pin)),
                gradient,
                region: region(&layer.pins[pin], self.grid.diagonal()),
                triangle: self.triangles.get(pin).copied().flatten(),
            });
        }
        (states, points)
    }
}
