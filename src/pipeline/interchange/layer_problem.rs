//! Extracts a layer at one frame as a bare problem, for comparison with other methods.
//!
//! In: a [`PreparedShot`], a layer, a frame. Out: a [`LayerProblem`]: grid, shape and pins on the screen.

use crate::lattice::Grid;
use crate::pipeline::evaluate::layer_pins::moved_handles;
use crate::pipeline::evaluate::screen_shape::screen_shape;
use crate::pipeline::{PipelineError, PreparedShot};
use crate::solve::{HandlePin, PointPin, Problem, Settings, Shape, Topology, Upright};

/// The inputs of a layer's solve.
#[derive(Clone, Debug)]
pub(crate) struct LayerProblem {
    grid: Grid<2>,
    shape: Shape<2>,
    pins: Vec<PointPin<2>>,
    handles: Vec<HandlePin<2>>,
    settings: Settings,
}

impl LayerProblem {
    /// Returns the problem, borrowing its data.
    #[must_use]
    pub(crate) fn problem(&self) -> Problem<'_, 2> {
        let Self { grid, shape, pins, handles, settings } = self;
        Problem { grid, shape, pins, handles, settings }
    }
}

/// Returns a layer's shape, pins and moved handles on the screen at a frame, rotated back if the box is rotated; `None` if
/// nothing is solved there or the layer is a world layer. Only points and targets of the pins are included, and the
/// lattice is plain, because no other method supports rotations or branches.
///
/// # Errors
/// [`PipelineError::Solve`] if a layer cannot be solved.
pub(crate) fn layer_problem(
    prepared: &PreparedShot,
    index: usize,
    frame: f64,
) -> Result<Option<LayerProblem>, PipelineError> {
    let sample = prepared.evaluate(frame)?;
    let (Some(layer), Some(state)) = (prepared.shot.layers.get(index), sample.layers.get(index)) else {
        return Ok(None);
    };
    let Some(rotated) = state.solution.as_ref().map(|solution| &solution.lattice.grid) else {
        return Ok(None);
    };
    let pins: Vec<_> =
        state.pins.iter().map(|pin| PointPin::new(pin.rest.0.to_array(), pin.target.0.to_array())).collect();
    let targets = prepared.shot.pin_targets(index, prepared.key_frame(layer, frame));
    let (grid, upright) = (rotated.upright(), Upright::of(rotated));
    let pins = upright.pins(&pins).into_owned();
    let handles = moved_handles(layer, &grid, &targets);
    let is_empty = pins.is_empty() && handles.is_empty();
    let shape = Shape { links: None, ..upright.shape(&screen_shape(prepared, &sample, index)).into_owned() };
    let settings = Settings { topology: Topology::Plain, ..layer.settings.clone() };
    Ok((!is_empty).then_some(LayerProblem { grid, shape, pins, handles, settings }))
}
