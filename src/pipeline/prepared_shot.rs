//! A prepared shot: what all frames share. Made once by [`prepare`](super::prepare); frames are
//! [`TimeSample`](super::TimeSample)s of it.

use super::cameras::CameraSource;
use super::frame_cache::FrameCache;
use super::layer_assignment::LayerAssignment;
use super::passes::mid_shutter;
use super::pictures::Gallery;
use super::stiffness::{Painted, PartStiffness};
use super::trajectory_files::TrajectoryFiles;
use super::transfer::Loaded;
use super::{PinAnchor, RestPoint};
use crate::image::cryptomatte::MatteHeader;
use crate::pose::{ClipChoice, Pose, PosedLight, pose};
use crate::raster::geometry::Piece;
use crate::scene::Scene;
use crate::screen::{self, Camera};
use crate::shot::{Layer, Shot};
use crate::solve::Link;
use crate::space::ScreenPoint;
use std::sync::Arc;

/// A shot ready to be rendered: all of it is the same for every frame.
#[derive(Debug)]
pub struct PreparedShot {
    /// The shot.
    pub shot: Shot,
    /// Its scene.
    pub scene: Scene,
    /// What was chosen or ignored, in the user's words.
    pub notes: Vec<String>,
    /// Which layer moves which part.
    pub assignment: LayerAssignment,
    /// What layers are solved with.
    pub(super) layer_inputs: LayerInputs,
    /// How the scene is drawn.
    pub(super) draw_inputs: DrawInputs,
    /// The pictures that the scene stands for.
    pub(super) gallery: Option<Gallery>,
    /// Where it is seen from.
    pub(super) camera: CameraSource,
    /// Which clip moves the scene.
    pub(super) clip: ClipChoice,
    /// What frames leave for their neighbours.
    pub(super) cache: FrameCache,
    /// Where trajectories are kept.
    pub(super) trajectory_files: Option<TrajectoryFiles>,
}

/// What layers are solved with, beside their keys.
#[derive(Debug)]
pub(super) struct LayerInputs {
    /// One a layer and pin.
    pub(super) anchors: Vec<Vec<PinAnchor>>,
    /// Stiffness of their triangles.
    pub(super) stiffness: Painted,
    /// One a layer: which of its triangles hang together, where its lattice branches.
    pub(super) links: Vec<Option<Arc<Vec<Link>>>>,
    /// One a layer: lattices from elsewhere.
    pub(super) loaded: Vec<Option<Loaded>>,
}

/// How the scene is drawn, beside what it says itself.
#[derive(Debug)]
pub(super) struct DrawInputs {
    /// The neutral lights, used where the scene has none.
    pub(super) rig: Vec<PosedLight>,
    /// What the parts are told apart by.
    pub(super) pieces: Vec<Vec<Piece>>,
    /// What files say about Cryptomattes, one each.
    pub(super) mattes: Vec<MatteHeader>,
    /// Layers whose parts are not drawn, though they keep their places, ids and names.
    pub(super) hidden_layers: Vec<usize>,
    /// Nodes whose meshes the shot hides.
    pub(super) hidden_nodes: Vec<usize>,
}

impl PreparedShot {
    /// The pose, not yet moved by any layer, and the camera of a (fractional) frame.
    #[must_use]
    pub fn view(&self, frame: f64) -> (Pose, Camera) {
        let pose = pose(&self.scene, self.clip, self.shot.frames.seconds(frame));
        let camera = self.camera.at((&self.shot, &self.scene), frame, &pose);
        (pose, camera)
    }

    /// The node of the camera, where it is one of the scene's.
    pub(super) const fn camera_node(&self) -> Option<usize> {
        match self.camera {
            CameraSource::Node(node) => Some(node),
            CameraSource::Automatic(_) | CameraSource::Own { .. } => None,
        }
    }

    /// The shot's own camera moves.
    pub(super) fn has_moving_camera(&self) -> bool {
        matches!(&self.camera, CameraSource::Own { camera, .. } if camera.keys.len() > 1)
    }

    /// The time that a whole frame shows: the middle of its exposure.
    #[must_use]
    pub fn mid_exposure_time(&self, frame: f64) -> f64 {
        frame + mid_shutter(self.shot.shutter)
    }

    /// Points of the screen cast onto the front-most unwarped surface of a frame; `None`: there is none.
    #[must_use]
    pub fn cast(&self, frame: i32, points: &[ScreenPoint]) -> Vec<Option<PinAnchor>> {
        let (pose, camera) = self.view(f64::from(frame));
        let mesh = screen::project(&pose, &camera);
        let pick = |&point: &ScreenPoint| screen::pick(&self.scene, &pose, &mesh, camera.near(), point);
        points.iter().map(|point| pick(point).map(|hit| PinAnchor::on(&self.scene, &pose, &hit))).collect()
    }

    /// Where the pinned points of a layer are before any warp at a (fractional) frame, one a pin.
    #[must_use]
    pub fn rests_of(&self, layer: usize, frame: f64) -> Vec<RestPoint> {
        let (pose, camera) = self.view(frame);
        let mesh = screen::project(&pose, &camera);
        self.layer_inputs.anchors[layer].iter().map(|pinned| pinned.rest(&mesh, &camera)).collect()
    }

    /// What the pins of a layer are tied to, one a pin.
    #[must_use]
    pub fn anchors_of(&self, layer: usize) -> &[PinAnchor] {
        &self.layer_inputs.anchors[layer]
    }

    /// Stiffness of a part's triangles in a layer that has the part.
    pub(super) fn stiffness_of(&self, layer: usize, part: usize) -> PartStiffness<'_> {
        PartStiffness {
            painted: self.layer_inputs.stiffness[layer].get(&part).map_or(&[], Vec::as_slice),
            share: self.assignment.share(layer, part),
            is_uneven: !self.shot.layers[layer].stiffness.is_empty() || self.assignment.is_sharing[layer],
        }
    }

    /// The frame whose keys count at a (fractional) frame. A layer on twos shows one drawing all through the exposure
    /// of a frame, so its keys are read at the frame that is exposed, not at the time within the exposure.
    #[must_use]
    pub fn key_frame(&self, layer: &Layer, frame: f64) -> f64 {
        if layer.step > 1 { (frame - mid_shutter(self.shot.shutter)).round() } else { frame }
    }
}
