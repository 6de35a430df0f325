//! A prepared shot: the data that all frames share, created once by [`prepare`](crate::pipeline::prepare); frames are
//! [`TimeSample`](crate::pipeline::TimeSample)s of it.

use super::cameras::CameraSource;
use super::layer_assignment::LayerAssignment;
use super::reflection::MirroredPin;
use super::rest_links::RestLinks;
use super::stiffness::{PartStiffness, Stiffness};
use super::symmetry::Symmetry;
use super::transfer::Loaded;
use crate::image::cryptomatte::MatteHeader;
use crate::pipeline::draw::passes::mid_shutter;
use crate::pipeline::evaluate::frame_cache::FrameCache;
use crate::pipeline::pictures::Gallery;
use crate::pipeline::trajectories::trajectory_files::TrajectoryFiles;
use crate::pipeline::{PinAnchor, RestPoint};
use crate::pose::{ClipChoice, Pose, PosedLight, is_still, pose, pose_positions};
use crate::raster::geometry::Submesh;
use crate::scene::Scene;
use crate::screen::{self, Camera};
use crate::shot::{Layer, Shot};
use crate::solve::Link;
use crate::space::ScreenPoint;
use std::collections::HashMap;
use std::sync::Arc;

/// A shot ready to be rendered; everything in it is the same for every frame.
#[derive(Debug)]
pub struct PreparedShot {
    /// The shot.
    pub shot: Shot,
    /// Its scene.
    pub scene: Scene,
    /// Notes for the user on what was chosen or ignored.
    pub notes: Vec<String>,
    /// The mapping from parts to layers.
    pub assignment: LayerAssignment,
    /// Inputs of the layers' solves.
    pub(in crate::pipeline) layer_inputs: LayerInputs,
    /// Inputs of drawing.
    pub(in crate::pipeline) draw_inputs: DrawInputs,
    /// The pictures that the scene represents.
    pub(in crate::pipeline) gallery: Option<Gallery>,
    /// The camera.
    pub(in crate::pipeline) camera: CameraSource,
    /// The clip that animates the scene.
    pub(in crate::pipeline) clip: ClipChoice,
    /// Values cached between frames.
    pub(in crate::pipeline) cache: FrameCache,
    /// Where trajectories are stored.
    pub(in crate::pipeline) trajectory_files: Option<TrajectoryFiles>,
}

/// Inputs of the layers' solves, except their keys.
#[derive(Debug)]
pub(in crate::pipeline) struct LayerInputs {
    /// One per layer and pin.
    pub(in crate::pipeline) anchors: Vec<Vec<PinAnchor>>,
    /// One per layer and pin: set if the pin takes the keys of another one, mirrored.
    pub(in crate::pipeline) mirrored: Vec<Vec<Option<MirroredPin>>>,
    /// Planes of symmetry that were found, by the layers of a mirrored pin and of the pin that it follows.
    pub(in crate::pipeline) planes: HashMap<[usize; 2], Symmetry>,
    /// Stiffness of the layers' triangles.
    pub(in crate::pipeline) stiffness: Stiffness,
    /// #layers: links between the layer's connected triangles; `None` if its lattice does not branch.
    pub(in crate::pipeline) links: Vec<Option<RestLinks>>,
    /// #layers: lattices transferred from other shots.
    pub(in crate::pipeline) loaded: Vec<Option<Loaded>>,
}

/// Inputs of drawing that are not part of the scene.
#[derive(Debug)]
pub(in crate::pipeline) struct DrawInputs {
    /// The neutral lights, used if the scene has none.
    pub(in crate::pipeline) rig: Vec<PosedLight>,
    /// Pieces of every part, with layer ids and Cryptomatte ids.
    pub(in crate::pipeline) submeshes: Vec<Vec<Submesh>>,
    /// One header per Cryptomatte.
    pub(in crate::pipeline) mattes: Vec<MatteHeader>,
    /// Layers whose parts are not drawn but keep their indices, ids and names.
    pub(in crate::pipeline) hidden_layers: Vec<usize>,
    /// Nodes whose meshes the shot hides.
    #[cfg_attr(
        not(any(test, feature = "cli", feature = "editor")),
        expect(dead_code, reason = "only exports and the editor read it")
    )]
    pub(in crate::pipeline) hidden_nodes: Vec<usize>,
}

impl PreparedShot {
    /// Returns the pose, before any layer moves it, and the camera at a (fractional) frame.
    #[must_use]
    pub fn view(&self, frame: f64) -> (Pose, Camera) {
        let pose = pose(&self.scene, self.clip, self.shot.frames.seconds(frame));
        let camera = self.camera.at((&self.shot, &self.scene), frame, &pose);
        (pose, camera)
    }

    /// Returns the same as [`Self::view`], without normals and tangents.
    pub(in crate::pipeline) fn view_of_positions(&self, frame: f64) -> (Pose, Camera) {
        let pose = pose_positions(&self.scene, self.clip, self.shot.frames.seconds(frame));
        let camera = self.camera.at((&self.shot, &self.scene), frame, &pose);
        (pose, camera)
    }

    /// Returns a frame that shows the scene, before any layer moves it, exactly as the given one does: the first frame if neither
    /// scene nor camera move.
    pub(in crate::pipeline) fn same_view(&self, frame: i32) -> i32 {
        let is_still = is_still(&self.scene, self.clip) && !self.has_moving_camera();
        if is_still { self.shot.frames.first } else { frame }
    }

    /// Returns the camera's node, if the camera is one of the scene's.
    #[cfg(any(test, feature = "cli"))]
    pub(in crate::pipeline) const fn camera_node(&self) -> Option<usize> {
        match self.camera {
            CameraSource::Node(node) => Some(node),
            CameraSource::Automatic(_) | CameraSource::Own { .. } => None,
        }
    }

    /// Whether the shot's own camera moves.
    pub(in crate::pipeline) fn has_moving_camera(&self) -> bool {
        matches!(&self.camera, CameraSource::Own { camera, .. } if camera.keys.len() > 1)
    }

    /// Returns the time shown by a whole frame: the middle of its exposure.
    #[must_use]
    pub(crate) fn mid_exposure_time(&self, frame: f64) -> f64 {
        frame + mid_shutter(self.shot.shutter)
    }

    /// Casts points of the screen onto the front-most unwarped surface of a frame; `None` where there is no surface.
    #[must_use]
    pub(crate) fn cast(&self, frame: i32, points: &[ScreenPoint]) -> Vec<Option<PinAnchor>> {
        let (pose, camera) = self.view(f64::from(frame));
        let mesh = screen::project(&pose, &camera);
        let pick = |&point: &ScreenPoint| screen::pick(&self.scene, &pose, &mesh, camera.near(), point);
        points.iter().map(|point| pick(point).map(|hit| PinAnchor::on(&self.scene, &pose, &hit))).collect()
    }

    /// Returns the positions of a layer's pinned points before any warp at a (fractional) frame, one per pin.
    #[must_use]
    pub(crate) fn rests_of(&self, layer: usize, frame: f64) -> Vec<RestPoint> {
        let (pose, camera) = self.view(frame);
        let mesh = screen::project(&pose, &camera);
        self.layer_inputs.anchors[layer].iter().map(|pinned| pinned.rest(&mesh, &camera)).collect()
    }

    /// Returns the anchors of a layer's pins.
    #[must_use]
    pub(crate) fn anchors_of(&self, layer: usize) -> &[PinAnchor] {
        &self.layer_inputs.anchors[layer]
    }

    /// Returns how the pins of a layer follow others; `None` for pins that do not. Empty for layers that a host program drives.
    pub(in crate::pipeline) fn mirrored_pins_of(&self, layer: usize) -> &[Option<MirroredPin>] {
        &self.layer_inputs.mirrored[layer]
    }

    /// Returns the parts of a layer's picture that have an order in depth, as [`RestLinks::ordered_parts`] does.
    pub(in crate::pipeline) fn ordered_parts_of(&self, layer: usize) -> &[(usize, Vec<bool>)] {
        self.layer_inputs.links[layer].as_ref().map_or(&[], RestLinks::ordered_parts)
    }

    /// Returns the links between the triangles of a layer; `None` if its lattice does not branch.
    pub(in crate::pipeline) fn links_of(&self, layer: usize) -> Option<&Arc<Vec<Link>>> {
        let Layer { space, basis, .. } = &self.shot.layers[layer];
        let spans = space.dims().into_iter().filter(|count| *count > 1).map(|count| basis.spans(count)).max();
        Some(self.layer_inputs.links[layer].as_ref()?.for_spans(spans.unwrap_or(1)))
    }

    /// Returns the stiffness of a part's triangles; the part must belong to the layer.
    pub(in crate::pipeline) fn stiffness_of(&self, layer: usize, part: usize) -> PartStiffness<'_> {
        PartStiffness {
            painted: self.layer_inputs.stiffness.painted[layer].get(&part).map_or(&[], Vec::as_slice),
            share: self.assignment.share(layer, part),
            is_uneven: !self.layer_inputs.stiffness.painted[layer].is_empty() || self.assignment.is_sharing[layer],
        }
    }

    /// Returns the frame at which the layer's keys are evaluated for a (fractional) frame. A layer on twos shows one
    /// drawing throughout the exposure of a frame, so its keys are evaluated at the exposed frame instead of at the
    /// time of the sample.
    #[must_use]
    pub(crate) fn key_frame(&self, layer: &Layer, frame: f64) -> f64 {
        if layer.step > 1 { (frame - mid_shutter(self.shot.shutter)).round() } else { frame }
    }
}
