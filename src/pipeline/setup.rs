//! A shot made ready: scene loaded, camera and clip chosen, layers claimed, pins tied.
//!
//! In: a [`Shot`]. Out: a [`Setup`] that gives the [`Moment`] of any frame; notes on what was chosen for the user.

use super::cameras::{self, CameraContext, CameraSource};
use super::claims::Claims;
use super::follow::{Bounds, KeptBounds};
use super::mattes::Mattes;
use super::passes::mid_shutter;
use super::pictures::Gallery;
use super::screen_layer::corners;
use super::trajectories::KeptTrajectories;
use super::transfer::{self, Loaded};
use super::{Moment, Pinned, PipelineError, Rest, anchors, claims, lighting, missing, stiffness, visibility};
use crate::pose::{ClipChoice, Pose, PosedLight, PosedPart, pose};
use crate::scene::{self, FileAccess, Scene};
use crate::screen::{self, Camera, ScreenMesh};
use crate::shot::{Anchor, CameraRule, ClipName, Layer, LayerSpace, Shot, Source};
use crate::space::ScreenPoint;
use crate::spelling;
use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Mutex, PoisonError};

/// Moments kept: a frame, its two neighbours, and the one before.
const KEPT_MOMENTS: usize = 4;

/// The greatest number of pixels of a frame: 16384 x 16384.
const MAX_PIXELS: u64 = 1 << 28;

/// A shot ready to be rendered.
#[derive(Debug)]
pub struct Setup {
    /// The shot.
    pub shot: Shot,
    /// Its scene.
    pub scene: Scene,
    /// What was chosen or ignored, in the user's words.
    pub notes: Vec<String>,
    /// One a part of every pose: the layer that claims it.
    pub owners: Vec<Option<usize>>,
    /// One a part: the node that carries it.
    pub(super) part_nodes: Vec<usize>,
    /// One a layer: the parts it claims.
    pub(super) parts_of_layer: Vec<Vec<usize>>,
    /// One a part: stiffness of its triangles; empty: 1 everywhere.
    pub(super) stiffness: Vec<Vec<f64>>,
    /// One a layer: the node that carries all of it.
    pub(super) carriers: Vec<Option<usize>>,
    /// One a layer and pin.
    pub(super) anchors: Vec<Vec<Pinned>>,
    /// The neutral lights, used where the scene has none.
    pub(super) rig: Vec<PosedLight>,
    /// One a layer: lattices from elsewhere.
    pub(super) loaded: Vec<Option<Loaded>>,
    /// Names and ids for Cryptomattes.
    pub(super) mattes: Mattes,
    /// Layers whose parts are not drawn, though they keep their places, ids and names.
    pub(super) hidden: Vec<usize>,
    /// Nodes whose meshes the shot hides.
    pub(super) hidden_nodes: Vec<usize>,
    /// The pictures that the scene stands for.
    pub(super) gallery: Option<Gallery>,
    camera: CameraSource,
    /// Which clip moves the scene.
    pub(super) clip: ClipChoice,
    moments: Mutex<VecDeque<Arc<Moment>>>,
    screen_bounds: KeptBounds<2>,
    world_bounds: KeptBounds<3>,
    /// Of the layers whose frames are solved together.
    pub(super) trajectories: KeptTrajectories,
}

impl Setup {
    /// Loads the scene and ties the shot to it.
    ///
    /// # Errors
    /// [`PipelineError`] where the scene cannot be loaded or does not fit the shot.
    pub fn new(shot: Shot) -> Result<Self, PipelineError> {
        check_size(&shot)?;
        missing::check(&shot)?;
        let (scene, gallery) = load(&shot)?;
        let setup = Self::with_scene(shot, scene)?;
        Ok(Self { gallery, ..setup })
    }

    /// Ties a shot to a scene that is loaded already, instead of its own.
    ///
    /// # Errors
    /// [`PipelineError`] where the scene does not fit the shot.
    pub fn with_scene(mut shot: Shot, mut scene: Scene) -> Result<Self, PipelineError> {
        let hidden_nodes = visibility::hide(&shot, &mut scene)?;
        let mut notes = scene.warnings.clone();
        notes.extend(shot.range_notes());
        let clip = choose_clip(&shot, &scene, &mut notes)?;
        let first = pose(&scene, clip, shot.frames.seconds(f64::from(shot.frames.first)));
        if first.parts.is_empty() && !hidden_nodes.is_empty() {
            let hint = "hide fewer nodes, or name in `show` what stays";
            return Err(PipelineError::mismatch(&shot, "hide", "nothing is left to draw", hint));
        }
        if first.parts.is_empty() {
            let what = "the scene has no triangles and no lines";
            return Err(PipelineError::mismatch(&shot, "scene", what, "export meshes with it"));
        }
        let Claims { owners, parts_of_layer } = claims::claim(&shot, &scene, &first.parts)?;
        let context = CameraContext { shot: &shot, scene: &scene, clip, parts_of_layer: &parts_of_layer };
        let camera = cameras::choose(&context, &mut notes)?;
        if let CameraSource::Own { camera, .. } = &camera {
            // Shots that are made of this one for other scenes see them from the same place.
            shot.camera = CameraRule::Own(camera.clone());
        }
        let loaded = transfer::load(&shot, &mut notes)?;
        let stiffness = stiffness::paint(&shot, &scene, (&first.parts, &parts_of_layer))?;
        let carriers = parts_of_layer.iter().map(|parts| claims::carrier(&scene, &first.parts, parts)).collect();
        let mattes = Mattes::new(&shot, &scene, (&first.parts, &owners));
        let mut setup = Self {
            shot,
            scene,
            notes,
            owners,
            part_nodes: first.parts.iter().map(|part| part.node).collect(),
            parts_of_layer,
            stiffness,
            carriers,
            anchors: Vec::new(),
            rig: Vec::new(),
            loaded,
            mattes,
            hidden: Vec::new(),
            hidden_nodes,
            gallery: None,
            camera,
            clip,
            moments: Mutex::default(),
            screen_bounds: KeptBounds::new(),
            world_bounds: KeptBounds::new(),
            trajectories: KeptTrajectories::default(),
        };
        setup.rig = lighting::neutral_rig(&setup.view(f64::from(setup.shot.frames.first)).1);
        if first.lights.is_empty() && first.parts.iter().any(|part| is_lit(&setup.scene, part)) {
            setup.notes.push("the scene has no lights: a neutral three-light rig is used".into());
        }
        setup.tie_pins(&first)?;
        setup.note_unwarped();
        setup.note_coarse(&first);
        Ok(setup)
    }

    /// Says which layers nothing moves.
    fn note_unwarped(&mut self) {
        let is_moved = |layer: &&Layer| !layer.pins.is_empty() || !layer.handles.is_empty() || layer.transfer.is_some();
        let (moved, still): (Vec<_>, Vec<_>) = self.shot.layers.iter().partition(is_moved);
        if moved.is_empty() {
            self.notes.push("no layer has pins or moved handles: nothing is warped".into());
            return;
        }
        let names = still.iter().map(|layer| &layer.name);
        self.notes
            .extend(names.map(|name| format!("layer '{name}' has no pins and no moved handles: it is not warped")));
    }

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

    /// The solved scene in the middle of a frame's exposure: what its data channels show.
    ///
    /// # Errors
    /// [`PipelineError::Solve`] where a layer cannot be solved.
    pub fn exposed(&self, frame: i32) -> Result<Arc<Moment>, PipelineError> {
        self.moment(f64::from(frame) + mid_shutter(self.shot.shutter))
    }

    /// The solved scene at a (fractional) frame; the last ones that other frames need, too, are kept.
    ///
    /// # Errors
    /// [`PipelineError::Solve`] where a layer cannot be solved.
    pub fn moment(&self, frame: f64) -> Result<Arc<Moment>, PipelineError> {
        let kept = || self.moments.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(moment) = kept().iter().find(|moment| moment.frame == frame) {
            return Ok(Arc::clone(moment));
        }
        let moment = Arc::new(self.compute(frame)?);
        // Neighbouring frames ask for the middle of an exposure again, never for another moment of it.
        let exposed = frame - mid_shutter(self.shot.shutter);
        if (exposed - exposed.round()).abs() > 1e-9 {
            return Ok(moment);
        }
        let mut moments = kept();
        moments.push_back(Arc::clone(&moment));
        if moments.len() > KEPT_MOMENTS {
            moments.pop_front();
        }
        Ok(moment)
    }

    /// Bounds of a screen layer at a whole frame.
    pub(super) fn bounds_at(&self, layer: usize, frame: i32) -> Option<Bounds<2>> {
        self.screen_bounds.at(layer, frame, || {
            let (pose, camera) = self.view(f64::from(frame));
            let mesh = screen::project(&pose, &camera);
            let of_layer = |layer: usize| self.bounds_of(layer, &pose, &mesh, &camera).map(corners);
            (0..self.shot.layers.len()).map(of_layer).collect()
        })
    }

    /// Bounds of a world layer at a whole frame, in the frame of its box.
    pub(super) fn world_bounds_at(&self, layer: usize, frame: i32) -> Option<Bounds<3>> {
        self.world_bounds.at(layer, frame, || {
            let (pose, _) = self.view(f64::from(frame));
            let is_world = |layer: usize| matches!(self.shot.layers[layer].space, LayerSpace::World { .. });
            let of_layer = |layer: usize| is_world(layer).then(|| self.world_bounds_of(layer, &pose)).flatten();
            (0..self.shot.layers.len()).map(of_layer).collect()
        })
    }

    /// The moment that a whole frame shows: the middle of its exposure.
    #[must_use]
    pub fn exposed_at(&self, frame: f64) -> f64 {
        frame + mid_shutter(self.shot.shutter)
    }

    /// Points of the screen cast onto the front-most unwarped surface of a frame; `None`: there is none.
    #[must_use]
    pub fn cast(&self, frame: i32, points: &[ScreenPoint]) -> Vec<Option<Pinned>> {
        let (pose, camera) = self.view(f64::from(frame));
        let mesh = screen::project(&pose, &camera);
        let pick = |&point: &ScreenPoint| screen::pick(&self.scene, &pose, &mesh, camera.near(), point);
        points.iter().map(|point| pick(point).map(|hit| Pinned::on(&self.scene, &pose, &hit))).collect()
    }

    /// Where the pinned points of a layer are before any warp at a (fractional) frame, one a pin.
    #[must_use]
    pub fn rests_of(&self, layer: usize, frame: f64) -> Vec<Rest> {
        let (pose, camera) = self.view(frame);
        let mesh = screen::project(&pose, &camera);
        self.anchors[layer].iter().map(|pinned| pinned.rest(&mesh, &camera)).collect()
    }

    /// What the pins of a layer are tied to, one a pin.
    #[must_use]
    pub fn anchors_of(&self, layer: usize) -> &[Pinned] {
        &self.anchors[layer]
    }

    /// Turns every pin's anchor into indices.
    fn tie_pins(&mut self, first: &Pose) -> Result<(), PipelineError> {
        let mut casts: HashMap<i32, (Pose, ScreenMesh, Camera)> = HashMap::new();
        for (index, layer) in self.shot.layers.iter().enumerate() {
            let mut tied = Vec::new();
            for (number, pin) in layer.pins.iter().enumerate() {
                let pinned = match pin.anchor {
                    Anchor::Screen { at, frame: None } => Pinned::Screen(at),
                    Anchor::Screen { at, frame: Some(frame) } => {
                        let (pose, mesh, camera) = casts.entry(frame).or_insert_with(|| {
                            let (pose, camera) = self.view(f64::from(frame));
                            let mesh = screen::project(&pose, &camera);
                            (pose, mesh, camera)
                        });
                        let hit = screen::pick(&self.scene, pose, mesh, camera.near(), at).ok_or_else(|| {
                            let what = format!("there is no surface at {}, {} in frame {frame}", at.0.x, at.0.y);
                            anchors::mismatch(
                                &self.shot,
                                [index, number],
                                (what, "move the anchor onto the model".into()),
                            )
                        })?;
                        Pinned::on(&self.scene, pose, &hit)
                    }
                    Anchor::Surface { .. } => {
                        let (pinned, note) = anchors::find((&self.shot, [index, number]), &self.scene, &first.parts)?;
                        self.notes.extend(note);
                        pinned
                    }
                };
                if let Pinned::Surface { part, .. } = pinned
                    && !self.parts_of_layer[index].contains(&part)
                {
                    let node = &self.scene.nodes[first.parts[part].node].name;
                    let text = "which the layer does not claim: the pin follows it all the same";
                    self.notes.push(format!("layer '{}': pin '{}' sits on '{node}', {text}", layer.name, pin.name));
                }
                tied.push(pinned);
            }
            self.anchors.push(tied);
        }
        Ok(())
    }
}

/// Whether light makes a difference to a part.
fn is_lit(scene: &Scene, part: &PosedPart) -> bool {
    !scene.materials[screen::primitive(scene, part).material].unlit
}

/// What the shot is about, as a scene; and the pictures that it stands for.
fn load(shot: &Shot) -> Result<(Scene, Option<Gallery>), PipelineError> {
    match &shot.source {
        Source::Scene(path) => {
            let access = if shot.allow_outside { FileAccess::Anywhere } else { FileAccess::SceneFolder };
            Ok((scene::load_with(path, access)?, None))
        }
        Source::Frame => Ok((scene::frame_card(shot.size.aspect()), None)),
        Source::Images(paths) => {
            let (gallery, scene) = Gallery::hang(shot, paths)?;
            Ok((scene, Some(gallery)))
        }
    }
}

/// Refuses frames that no memory holds.
fn check_size(shot: &Shot) -> Result<(), PipelineError> {
    let pixels = u64::from(shot.size.width) * u64::from(shot.size.height);
    if pixels <= MAX_PIXELS {
        return Ok(());
    }
    let what = format!("a frame of {} x {} pixels is too large", shot.size.width, shot.size.height);
    Err(PipelineError::mismatch(shot, "size", what, "stay within 268 million pixels (16384 x 16384)"))
}

/// The clip the shot names, else the scene's first, if any.
fn choose_clip(shot: &Shot, scene: &Scene, notes: &mut Vec<String>) -> Result<ClipChoice, PipelineError> {
    let (name, index) = match &shot.clip {
        None => (None, None),
        Some(ClipName::Name(name)) => (Some(name.as_str()), None),
        Some(ClipName::Index(index)) => (None, Some(*index)),
    };
    let found = scene.find_clip(name, index);
    let clip = found.map_err(|source| PipelineError::find(shot, "frames.clip", source))?;
    if shot.clip.is_none() && scene.clips.len() > 1 {
        let names = scene.clips.iter().map(|clip| clip.name.as_str());
        notes.push(format!("no clip is named: '{}' is used; {}", scene.clips[0].name, spelling::list(names)));
    }
    Ok(ClipChoice { clip, is_looped: shot.is_looped })
}
