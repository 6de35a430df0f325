//! A layer at one frame as a bare problem, for comparisons with other methods.
//!
//! In: a [`Setup`], a layer, a frame. Out: [`PosedLayer`]: grid, shape and pins on the screen.

use super::layer_pins::moved_handles;
use super::{PipelineError, Setup};
use crate::lattice::Grid;
use crate::solve::{HandlePin, PointPin, Problem, Settings, Shape};

/// What a layer's solve was made of.
#[derive(Clone, Debug)]
pub struct PosedLayer {
    grid: Grid<2>,
    shape: Shape<2>,
    pins: Vec<PointPin<2>>,
    handles: Vec<HandlePin<2>>,
    settings: Settings,
}

impl PosedLayer {
    /// The problem.
    #[must_use]
    pub fn problem(&self) -> Problem<'_, 2> {
        let Self { grid, shape, pins, handles, settings } = self;
        Problem { grid, shape, pins, handles, settings }
    }
}

impl Setup {
    /// A layer's shape, pins and moved handles on the screen at a frame; `None` where nothing is solved there, or in the world. Of the pins
    /// only points and targets are taken: no other method holds rotations.
    ///
    /// # Errors
    /// [`PipelineError::Solve`] where a layer cannot be solved.
    pub fn layer_problem(&self, index: usize, frame: f64) -> Result<Option<PosedLayer>, PipelineError> {
        let moment = self.compute(frame)?;
        let (Some(layer), Some(state)) = (self.shot.layers.get(index), moment.layers.get(index)) else {
            return Ok(None);
        };
        let Some(grid) = state.solution.as_ref().map(|solution| solution.lattice.grid.clone()) else {
            return Ok(None);
        };
        let pins: Vec<_> =
            state.pins.iter().map(|pin| PointPin::new(pin.rest.0.to_array(), pin.target.0.to_array())).collect();
        let targets = self.shot.pin_targets(index, self.key_frame(layer, frame));
        let handles = moved_handles(layer, &grid, &targets);
        let is_empty = pins.is_empty() && handles.is_empty();
        let shape = self.shape(&moment, index);
        let settings = layer.settings.clone();
        Ok((!is_empty).then_some(PosedLayer { grid, shape, pins, handles, settings }))
    }
}
