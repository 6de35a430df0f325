//! The scene at one time: posed, seen by its camera, every layer solved.
//!
//! Plain data: what [`evaluate`](super::evaluate) computes for a (fractional) frame.

use super::LayerAssignment;
use super::part_starts::PartStarts;
use super::selection::SharedPart;
use crate::lattice::{SceneLattice, ScreenLattice};
use crate::plate::{Field, WholeWarp};
use crate::pose::Pose;
use crate::raster::geometry::{BranchWarp, PartWarp, WarpBlend};
use crate::screen::{Camera, ScreenMesh, project};
use crate::solve::{Solution, SolveReport};
use crate::space::ScreenPoint;
use glam::DVec3;
use std::borrow::Cow;

/// The scene at one time.
#[derive(Clone, Debug)]
pub struct TimeSample {
    /// The (fractional) frame.
    pub frame: f64,
    /// The pose, moved by the world layers.
    pub pose: Pose,
    /// The camera.
    pub camera: Camera,
    /// The pose on the screen, while layers are solved: samples that are kept are lean.
    pub(super) mesh: Option<ScreenMesh>,
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
    /// Where its parts lie in the shape of a lattice with branches; empty without branches.
    pub(super) starts: Vec<PartStarts>,
}

/// The solved lattice of a world layer.
#[derive(Clone, Debug)]
pub struct WorldSolution {
    /// The lattice.
    pub lattice: SceneLattice,
    /// How good it is; pin errors in metres.
    pub report: SolveReport,
    /// One a pin that acts.
    pub pins: Vec<ScenePin>,
}

/// A pin of a world layer, scene space, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScenePin {
    /// Where its point is before the warp.
    pub rest: DVec3,
    /// Where it has to go.
    pub target: DVec3,
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
    /// What warps a part of the layer on the screen.
    fn part_warp(&self, part: usize) -> PartWarp<'_> {
        let Some(solution) = &self.solution else { return PartWarp::Rest };
        let own = self.starts.iter().find(|own| own.part == part);
        match solution.branches.as_ref().zip(own) {
            Some((branches, own)) => PartWarp::Branches(BranchWarp { branches, starts: &own.starts }),
            None => PartWarp::Lattice(&solution.lattice),
        }
    }

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

impl TimeSample {
    /// The pose on the screen, before the layers of the screen warp it. Solved samples project it again.
    #[must_use]
    pub fn mesh(&self) -> Cow<'_, ScreenMesh> {
        self.mesh.as_ref().map_or_else(|| Cow::Owned(project(&self.pose, &self.camera)), Cow::Borrowed)
    }

    /// What warps a part on the screen, one a part; layers that `counts` leaves out rest.
    pub(super) fn warps<'a>(
        &'a self,
        assignment: &'a LayerAssignment,
        counts: impl Fn(usize) -> bool,
    ) -> Vec<PartWarp<'a>> {
        let of_layer = |layer: usize, part: usize| {
            if counts(layer) { self.layers[layer].part_warp(part) } else { PartWarp::Rest }
        };
        let warp = |(part, (owner, shared)): (usize, (&Option<usize>, &'a Option<SharedPart>))| match shared {
            Some(shared) => PartWarp::Blend(WarpBlend {
                layers: shared.layers.iter().map(|&layer| of_layer(layer, part)).collect(),
                weights: &shared.weights,
            }),
            None => owner.map_or(PartWarp::Rest, |layer| of_layer(layer, part)),
        };
        assignment.layer_of_part.iter().zip(&assignment.shared_parts).enumerate().map(warp).collect()
    }
}
