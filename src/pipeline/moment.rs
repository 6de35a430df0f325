//! The scene at one time: posed, projected, and every layer solved.
//!
//! In: a [`Setup`] and a (fractional) frame. Out: a [`Moment`]: world layers first, because they move what is projected.

use super::passes::mid_shutter;
use super::{PipelineError, Setup, WorldSolution};
use crate::lattice::ScreenLattice;
use crate::plate::{Field, WholeWarp};
use crate::pose::Pose;
use crate::screen::{Camera, ScreenMesh, project};
use crate::shot::{Layer, LayerSpace};
use crate::solve::{Solution, SolveReport};
use crate::space::ScreenPoint;
use std::borrow::Cow;

/// The scene at one time.
#[derive(Clone, Debug)]
pub struct Moment {
    /// The (fractional) frame.
    pub frame: f64,
    /// The pose, moved by the world layers.
    pub pose: Pose,
    /// The camera.
    pub camera: Camera,
    /// The pose on the screen, while layers are solved: moments that are kept are lean.
    mesh: Option<ScreenMesh>,
    /// One a layer of the shot.
    pub layers: Vec<LayerState>,
}

/// A layer at one time.
#[derive(Clone, Debug, Default)]
pub struct LayerState {
    /// The solved lattice of a screen layer; `None` where it is out of sight or has neither handles nor pins that act.
    pub solution: Option<Solution<2>>,
    /// The warp of a whole picture whose border rests: its lattice is that of `solution`.
    pub whole: Option<WholeWarp>,
    /// The solved lattice of a world layer; `None` where it has neither handles nor pins that act.
    pub world: Option<WorldSolution>,
    /// One a pin that acts.
    pub pins: Vec<PinState>,
}

/// A pin at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PinState {
    /// Index in the layer.
    pub pin: usize,
    /// Where its point is before the warp.
    pub rest: ScreenPoint,
    /// Where it has to go.
    pub target: ScreenPoint,
    /// 1, or less where it fades near the camera.
    pub presence: f64,
    /// The camera sees both places; where it does not, they say nothing (pins of world layers act there, too).
    pub is_in_view: bool,
}

impl LayerState {
    /// How good its solve is; `None` where the layer is not warped.
    #[must_use]
    pub fn report(&self) -> Option<&SolveReport> {
        let world = self.world.as_ref().map(|world| &world.report);
        self.solution.as_ref().map(|solution| &solution.report).or(world)
    }
}

impl LayerState {
    /// Where the points of a plate go; `None` where the layer is not warped. `is_whole`: no matte cuts it out.
    #[must_use]
    pub fn field(&self, is_whole: bool) -> Option<Field> {
        Some(self.screen_warp()?.field(is_whole))
    }

    /// What moves the layer on the screen; `None` where it is not warped.
    pub(super) fn screen_warp(&self) -> Option<ScreenWarp> {
        let whole = self.whole.clone().map(ScreenWarp::Whole);
        whole.or_else(|| Some(ScreenWarp::Lattice(self.solution.as_ref()?.lattice.clone())))
    }
}

/// What moves a layer on the screen.
#[derive(Clone, Debug)]
pub(super) enum ScreenWarp {
    /// Its lattice.
    Lattice(ScreenLattice),
    /// A whole picture whose border rests: a lattice and more.
    Whole(WholeWarp),
}

impl ScreenWarp {
    /// Where the points of a plate go; `is_whole`: no matte cuts the layer out.
    pub(super) fn field(self, is_whole: bool) -> Field {
        match self {
            Self::Whole(whole) if is_whole => Field::of_whole(&whole),
            Self::Lattice(lattice) if is_whole => Field::of_picture(lattice),
            Self::Lattice(lattice) | Self::Whole(WholeWarp { lattice, .. }) => Field::of_layer(lattice),
        }
    }
}

impl Moment {
    /// The pose on the screen, before the layers of the screen warp it. Solved moments project it anew.
    #[must_use]
    pub fn mesh(&self) -> Cow<'_, ScreenMesh> {
        self.mesh.as_ref().map_or_else(|| Cow::Owned(project(&self.pose, &self.camera)), Cow::Borrowed)
    }

    /// The lattice that warps a part, one a part.
    pub(super) fn lattices(&self, owners: &[Option<usize>]) -> Vec<Option<&ScreenLattice>> {
        let lattice = |layer: usize| self.layers[layer].solution.as_ref().map(|solution| &solution.lattice);
        owners.iter().map(|owner| owner.and_then(lattice)).collect()
    }
}

impl Setup {
    /// Poses, projects and solves a (fractional) frame.
    ///
    /// # Errors
    /// [`PipelineError::Solve`] where a layer cannot be solved.
    pub(super) fn compute(&self, frame: f64) -> Result<Moment, PipelineError> {
        let mut moment = self.unsolved(frame)?;
        for (index, layer) in self.shot.layers.iter().enumerate() {
            if let LayerSpace::Screen { bounds, .. } = layer.space {
                moment.layers[index] = self.solve_layer(&moment, index, bounds)?;
            }
        }
        moment.mesh = None;
        Ok(moment)
    }

    /// Poses and projects a (fractional) frame: the layers of the scene are solved, those of the screen are not.
    ///
    /// # Errors
    /// [`PipelineError::Solve`] where a layer of the scene cannot be solved.
    pub fn unsolved(&self, frame: f64) -> Result<Moment, PipelineError> {
        let (mut pose, camera) = self.view(frame);
        let layers = self.solve_worlds(frame, &pose, &camera)?;
        self.move_meshes(&mut pose, &layers);
        let mesh = Some(project(&pose, &camera));
        Ok(Moment { frame, pose, camera, mesh, layers })
    }

    /// The frame whose keys count at a (fractional) frame. A layer on twos shows one drawing all through the exposure
    /// of a frame, so its keys are read at the frame that is exposed, not at the moment within the exposure.
    #[must_use]
    pub fn key_frame(&self, layer: &Layer, frame: f64) -> f64 {
        if layer.step > 1 { (frame - mid_shutter(self.shot.shutter)).round() } else { frame }
    }
}
