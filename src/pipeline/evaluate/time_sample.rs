//! The scene at one time: posed, projected by its camera, with every layer solved.
//!
//! Plain data, computed by [`evaluate`](crate::pipeline::evaluate) for a (fractional) frame.

use super::ordered_parts::OrderedParts;
use super::part_triangle_ranges::PartTriangleRanges;
use crate::lattice::{SceneLattice, ScreenLattice};
use crate::pipeline::LayerAssignment;
use crate::pipeline::prepare::selection::SharedPart;
use crate::plate::{Field, WholeWarp};
use crate::pose::Pose;
use crate::raster::geometry::{BranchWarp, PartWarp, WarpBlend};
use crate::screen::{Camera, ScreenMesh, project};
use crate::solve::{BranchedLattice, Solution, SolveReport};
use crate::space::ScreenPoint;
use glam::DVec3;
use std::borrow::Cow;
use std::sync::OnceLock;

/// The scene at one time.
#[derive(Clone, Debug)]
pub struct TimeSample {
    /// The (fractional) frame.
    pub frame: f64,
    /// The pose, deformed by the world layers.
    pub pose: Pose,
    /// The camera.
    pub camera: Camera,
    /// The projected pose, present only while layers are solved, so that cached samples stay small.
    pub(in crate::pipeline) mesh: Option<ScreenMesh>,
    /// One per layer of the shot.
    pub layers: Vec<LayerState>,
}

/// The state of a layer at one time.
#[derive(Clone, Debug, Default)]
pub struct LayerState {
    /// The solved lattice of a screen layer; `None` if the layer is out of sight or has neither handles nor active pins.
    pub solution: Option<Solution<2>>,
    /// The warp of a whole picture whose border rests; its lattice is that of `solution`.
    pub whole: Option<WholeWarp>,
    /// The solved lattice of a world layer; `None` if the layer has neither handles nor active pins.
    pub world: Option<WorldSolution>,
    /// One per active pin.
    pub(crate) pins: Vec<PinState>,
    /// Positions of the layer's parts in the shape of a branching lattice; empty for layers that cannot branch.
    pub(in crate::pipeline) starts: Vec<PartTriangleRanges>,
    /// Whether the layer is solved over time, and not this time alone.
    pub(in crate::pipeline) is_on_trajectory: bool,
    /// Its parts, once something asked for them.
    pub(in crate::pipeline) parts: OnceLock<OrderedParts>,
}

/// The solved lattice of a world layer.
#[derive(Clone, Debug)]
pub struct WorldSolution {
    /// The lattice; that of its largest branch if it has several.
    pub lattice: SceneLattice,
    /// The branches, in the frame of `lattice`; `None` if no handle has several copies.
    pub(crate) branches: Option<BranchedLattice<3>>,
    /// The solver's report; pin errors in metres.
    pub report: SolveReport,
    /// One per active pin.
    pub(crate) pins: Vec<ScenePin>,
}

/// A pin of a world layer in scene space, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ScenePin {
    /// Position of the pinned point before the warp.
    pub rest: DVec3,
    /// Target position.
    pub target: DVec3,
}

/// A pin at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PinState {
    /// Index in the layer.
    pub pin: usize,
    /// Position of the pinned point before the warp.
    pub rest: ScreenPoint,
    /// Target position.
    pub target: ScreenPoint,
    /// 1, falling to 0 where the pin fades near the camera.
    pub presence: f64,
    /// Whether the camera sees both positions; otherwise they are undefined (pins of world layers act even then).
    pub is_in_view: bool,
}

impl LayerState {
    /// Returns the report of the layer's solve; `None` if the layer is not warped.
    #[must_use]
    pub(crate) fn report(&self) -> Option<&SolveReport> {
        let world = self.world.as_ref().map(|world| &world.report);
        self.solution.as_ref().map(|solution| &solution.report).or(world)
    }
}

impl LayerState {
    /// Returns the warp of a part of the layer on the screen.
    pub(in crate::pipeline) fn part_warp(&self, part: usize) -> PartWarp<'_> {
        let Some(solution) = &self.solution else { return PartWarp::Rest };
        let own = self.starts.iter().find(|own| own.part == part);
        match solution.branches.as_ref().zip(own) {
            Some((branches, own)) => PartWarp::Branches(BranchWarp { branches, starts: &own.starts }),
            None => PartWarp::Lattice(&solution.lattice),
        }
    }

    /// Returns the field by which the layer moves a plate; `None` if the layer is not warped. `is_whole`: no matte cuts
    /// the layer out.
    #[must_use]
    pub(crate) fn field(&self, is_whole: bool) -> Option<Field> {
        Some(self.screen_warp()?.field(is_whole))
    }

    /// Returns the warp of the layer on the screen; `None` if the layer is not warped.
    pub(in crate::pipeline) fn screen_warp(&self) -> Option<ScreenWarp> {
        let whole = self.whole.clone().map(ScreenWarp::Whole);
        whole.or_else(|| Some(ScreenWarp::Lattice(self.solution.as_ref()?.lattice.clone())))
    }
}

/// The warp of a layer on the screen.
#[derive(Clone, Debug)]
pub(in crate::pipeline) enum ScreenWarp {
    /// A lattice.
    Lattice(ScreenLattice),
    /// The warp of a whole picture whose border rests: a lattice followed by a flow.
    Whole(WholeWarp),
}

impl ScreenWarp {
    /// Returns the field by which the layer moves a plate; `is_whole`: no matte cuts the layer out.
    pub(in crate::pipeline) fn field(self, is_whole: bool) -> Field {
        match self {
            Self::Whole(whole) if is_whole => Field::of_whole(&whole),
            Self::Lattice(lattice) if is_whole => Field::of_picture(lattice),
            Self::Lattice(lattice) | Self::Whole(WholeWarp { lattice, .. }) => Field::of_layer(lattice),
        }
    }
}

impl TimeSample {
    /// Returns the projected pose before screen layers warp it; cached samples project it again.
    #[must_use]
    pub fn mesh(&self) -> Cow<'_, ScreenMesh> {
        self.mesh.as_ref().map_or_else(|| Cow::Owned(project(&self.pose, &self.camera)), Cow::Borrowed)
    }

    /// Returns the warp of every part on the screen; layers excluded by `counts` are at rest.
    pub(in crate::pipeline) fn warps<'a>(
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
