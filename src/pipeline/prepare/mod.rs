//! Prepares a shot: loads its scene, chooses camera and clip, assigns parts to layers, attaches pins.
//!
//! In: a [`Shot`]. Out: a [`PreparedShot`], with notes on choices made on the user's behalf.

pub(super) mod anchors;
pub(super) mod auto_dims;
pub(super) mod box_frames;
pub(super) mod branch_lattices;
pub(super) mod brush_strokes;
pub(super) mod cameras;
mod far_apart;
pub(super) mod known_far_points;
pub(super) mod layer_assignment;
pub(super) mod lighting;
mod loose_parts;
pub(super) mod mattes;
pub(super) mod mesh_resolution;
pub(super) mod mirrored_pins;
pub(super) mod missing_files;
pub(super) mod picture_cuts;
pub(super) mod picture_parts;
mod pin_notes;
pub(super) mod prepared_shot;
pub(super) mod reflection;
pub(super) mod rest_links;
pub(super) mod rest_mesh;
mod screen_cut;
pub(super) mod selection;
pub(super) mod slenderness;
pub(super) mod stiffness;
mod surface_distance;
pub(super) mod symmetry;
pub(super) mod transfer;
pub(super) mod transferred_branches;
pub(super) mod visibility;

use crate::pipeline::evaluate::frame_cache::FrameCache;
use crate::pipeline::evaluate::topology::{self, check_branching};
use crate::pipeline::pictures::Gallery;
use crate::pipeline::{PinAnchor, PipelineError, PreparedShot};
use crate::pose::{ClipChoice, Pose, PosedPart, pose, pose_positions};
use crate::scene::{self, FileAccess, Scene};
use crate::screen::{self, Camera, ScreenMesh};
use crate::shot::{Anchor, CameraRule, ClipName, Layer, LayerSpace, Shot, Source};
use crate::space::{FrameSize, ScreenPoint};
use crate::spelling;
use cameras::{CameraContext, CameraSource};
use glam::DVec2;
use layer_assignment::LayerAssignment;
use mattes::Mattes;
use mesh_resolution::coarse_meshes;
use picture_cuts::PictureCuts;
use prepared_shot::{DrawInputs, LayerInputs};
use rest_links::rest_links;
use rest_mesh::RestMesh;
use std::collections::HashMap;

/// Maximum number of pixels of a frame: 16384 x 16384.
const MAX_PIXELS: u64 = 1 << 28;

/// Number of handles along an axis above which a basis without local support is reported as costly.
const MANY_GLOBAL_HANDLES: usize = 24;

impl PreparedShot {
    /// Loads the scene of a shot and prepares the shot.
    ///
    /// # Errors
    /// [`PipelineError`] if the scene cannot be loaded or does not match the shot.
    pub fn new(shot: Shot) -> Result<Self, PipelineError> {
        check_size(&shot)?;
        missing_files::check(&shot)?;
        let (scene, gallery) = load(&shot)?;
        Ok(Self { gallery, ..Self::with_own_scene(shot, scene)? })
    }

    /// Prepares a shot with its own scene, which is already loaded.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub(in crate::pipeline) fn with_own_scene(shot: Shot, scene: Scene) -> Result<Self, PipelineError> {
        check_size(&shot)?;
        let prepared = Self::with_scene(shot, scene)?;
        check_branching(&prepared.shot, &prepared.assignment)?;
        Ok(prepared)
    }

    /// Prepares a shot with a scene that is already loaded, in place of its own.
    ///
    /// # Errors
    /// [`PipelineError`] if the scene does not match the shot.
    pub(crate) fn with_scene(mut shot: Shot, mut scene: Scene) -> Result<Self, PipelineError> {
        let hidden_nodes = visibility::hide(&shot, &mut scene)?;
        let mut notes = scene.warnings.clone();
        notes.extend(shot.range_notes());
        let clip = choose_clip(&shot, &scene, &mut notes)?;
        let mut first = pose(&scene, clip, shot.frames.seconds(f64::from(shot.reference_frame())));
        check_parts(&shot, &first, &hidden_nodes)?;
        let mut assignment = LayerAssignment::new(&shot, &scene, &first.parts)?;
        let cuts = PictureCuts::find((&shot, &scene), (&first.parts, &assignment.parts_of_layer))?;
        if cuts.divide(&shot, &mut scene) {
            first = pose(&scene, clip, shot.frames.seconds(f64::from(shot.reference_frame())));
            assignment = LayerAssignment::new(&shot, &scene, &first.parts)?;
        }
        let context = CameraContext { shot: &shot, scene: &scene, clip, parts_of_layer: &assignment.parts_of_layer };
        let camera = cameras::choose(&context, &mut notes)?;
        if let CameraSource::Own { camera, .. } = &camera {
            // Shots derived from this one for other scenes keep the resolved camera.
            shot.camera = CameraRule::Own(camera.clone());
        }
        box_frames::check(&shot, &scene)?;
        let loaded = transfer::load(&shot, &mut notes)?;
        notes.extend(topology::choose(&mut shot, &scene, (&assignment, &first.parts), &loaded));
        let cache = FrameCache::default();
        let stiffness = stiffness::paint(&shot, &scene, (&assignment.parts_of_layer, &cache))?;
        notes.extend(stiffness.notes.iter().cloned());
        let view = |frame: i32| {
            let pose = pose_positions(&scene, clip, shot.frames.seconds(f64::from(frame)));
            let camera = camera.at((&shot, &scene), f64::from(frame), &pose);
            (pose, camera)
        };
        let links = rest_links((&shot, &scene), (&assignment.parts_of_layer, &cuts), &view, &mut notes)?;
        let Mattes { submeshes, headers: mattes } = Mattes::new(&shot, &scene, (&first.parts, &assignment));
        let mut prepared = Self {
            shot,
            scene,
            notes,
            assignment,
            layer_inputs: LayerInputs {
                anchors: Vec::new(),
                mirrored: Vec::new(),
                planes: HashMap::new(),
                stiffness,
                links,
                loaded,
            },
            draw_inputs: DrawInputs { rig: Vec::new(), submeshes, mattes, hidden_layers: Vec::new(), hidden_nodes },
            gallery: None,
            camera,
            clip,
            cache,
            trajectory_files: None,
        };
        let frame = f64::from(prepared.shot.reference_frame());
        let camera = prepared.camera.at((&prepared.shot, &prepared.scene), frame, &first);
        prepared.draw_inputs.rig = lighting::neutral_rig(&camera);
        if first.lights.is_empty() && first.parts.iter().any(|part| is_lit(&prepared.scene, part)) {
            prepared.notes.push("the scene has no lights: a neutral three-light rig is used".into());
        }
        attach_pins(&mut prepared, &first)?;
        auto_dims::choose(&mut prepared);
        note_unwarped(&mut prepared);
        box_frames::note_foreshortened(&mut prepared);
        note_costly(&mut prepared);
        let coarse = coarse_meshes(&prepared, &first);
        prepared.notes.extend(coarse);
        Ok(prepared)
    }
}

/// Refuses a scene of which nothing is drawn.
fn check_parts(shot: &Shot, first: &Pose, hidden_nodes: &[usize]) -> Result<(), PipelineError> {
    if !first.parts.is_empty() {
        return Ok(());
    }
    let (key, what, hint) = if hidden_nodes.is_empty() {
        ("scene", "the scene has no triangles and no lines", "export meshes with it")
    } else {
        ("hide", "nothing is left to draw", "hide fewer nodes, or name in `show` what stays")
    };
    Err(PipelineError::mismatch(shot, key, what, hint))
}

/// Resolves every pin's anchor to indices.
pub(in crate::pipeline) fn attach_pins(prepared: &mut PreparedShot, first: &Pose) -> Result<(), PipelineError> {
    let mut casts: HashMap<i32, (Pose, ScreenMesh, Camera)> = HashMap::new();
    for (index, layer) in prepared.shot.layers.iter().enumerate() {
        let mut attached = Vec::new();
        for (number, pin) in layer.pins.iter().enumerate() {
            let pinned = match pin.anchor {
                // Replaced when the pin that it follows is attached.
                _ if pin.mirror.is_some_and(|mirror| mirror.is_anchor_mirrored) => {
                    PinAnchor::Screen(ScreenPoint::default())
                }
                Anchor::Screen { at, frame: None } => PinAnchor::Screen(at),
                Anchor::Screen { at, frame: Some(frame) } => {
                    let (pose, mesh, camera) = casts.entry(frame).or_insert_with(|| {
                        let (pose, camera) = prepared.view(f64::from(frame));
                        let mesh = screen::project(&pose, &camera);
                        (pose, mesh, camera)
                    });
                    let pick = |at| screen::pick(&prepared.scene, pose, mesh, camera.near(), at);
                    let hit = pick(at).or_else(|| pick(inside_border(at, prepared.shot.size)?)).ok_or_else(|| {
                        let what = format!("there is no surface at {}, {} in frame {frame}", at.0.x, at.0.y);
                        anchors::mismatch(
                            &prepared.shot,
                            ([index, number], "anchor"),
                            (what, "move the anchor onto the model".into()),
                        )
                    })?;
                    PinAnchor::on(&prepared.scene, pose, &hit)
                }
                Anchor::Surface { .. } => {
                    let (pinned, note) =
                        anchors::find((&prepared.shot, [index, number]), &prepared.scene, &first.parts)?;
                    prepared.notes.extend(note);
                    pinned
                }
            };
            attached.push(pinned);
        }
        prepared.layer_inputs.anchors.push(attached);
    }
    mirrored_pins::attach(prepared)?;
    divide_links(prepared, first);
    let notes = pin_notes::notes_on_pins(prepared, first);
    prepared.notes.extend(notes);
    Ok(())
}

/// Separates the parts of drawings that have pins.
fn divide_links(prepared: &mut PreparedShot, first: &Pose) {
    for (index, links) in prepared.layer_inputs.links.iter_mut().enumerate() {
        let Some(links) = links.as_mut().filter(|links| links.has_divisions()) else { continue };
        let mesh = RestMesh::of(&prepared.scene, first, &prepared.assignment.parts_of_layer[index]);
        // Pictures are flat: their x and y are screen coordinates.
        let pinned = prepared.layer_inputs.anchors[index].iter().filter_map(|anchor| match anchor {
            PinAnchor::Screen(point) => mesh.triangle_at(point.0),
            PinAnchor::Surface { .. } => mesh.triangle_at(anchor.in_scene(first)?.truncate()),
        });
        links.divide(&pinned.collect::<Vec<_>>());
    }
}

/// Moves a point within half a pixel of the frame's border just inside it: rounding may have put it beyond the edge of a picture.
/// `None` for other points.
fn inside_border(point: ScreenPoint, size: FrameSize) -> Option<ScreenPoint> {
    let pixel = 1.0 / f64::from(size.height);
    let inside = point.0.clamp(DVec2::splat(0.01 * pixel), DVec2::new(size.aspect(), 1.0) - 0.01 * pixel);
    let is_near = inside != point.0 && (inside - point.0).abs().max_element() <= 0.5 * pixel;
    is_near.then_some(ScreenPoint(inside))
}

/// Adds notes on layers that are not moved.
fn note_unwarped(prepared: &mut PreparedShot) {
    let layers = &prepared.shot.layers;
    if !layers.iter().any(Layer::is_moved) {
        prepared.notes.push("no layer has pins or moved handles: nothing is warped".into());
        return;
    }
    let note = |layer: &Layer| {
        let why = match (layer.is_moved(), layer.has_muted_pins_only()) {
            (false, _) => "has no pins and no moved handles",
            (true, _) if layer.is_muted => "is muted",
            (true, true) => "has muted pins only",
            (true, false) => return None,
        };
        Some(format!("layer '{}' {why}: it is not warped", layer.name))
    };
    prepared.notes.extend(layers.iter().filter_map(note));
}

/// Adds notes on costly lattices: every handle of a global basis acts everywhere, so the matrices are full.
fn note_costly(prepared: &mut PreparedShot) {
    let note = |layer: &Layer| {
        let dims = match &layer.space {
            LayerSpace::Screen { dims, .. } => &dims[..],
            LayerSpace::World { dims, .. } => &dims[..],
        };
        let is_costly = !layer.basis.is_local() && dims.iter().any(|&count| count > MANY_GLOBAL_HANDLES);
        is_costly.then(|| {
            let dims: Vec<String> = dims.iter().map(ToString::to_string).collect();
            format!(
                "layer '{}': each of its {} handles acts everywhere, which takes time and memory: twice as many along every axis take up \
                 to {} times as long; basis = \"bspline\" does not, or use {MANY_GLOBAL_HANDLES} handles an axis or less",
                layer.name,
                dims.join(" x "),
                8_u32.pow(dims.len() as u32)
            )
        })
    };
    let notes: Vec<String> = prepared.shot.layers.iter().filter_map(note).collect();
    prepared.notes.extend(notes);
}

/// Whether lighting affects a part.
fn is_lit(scene: &Scene, part: &PosedPart) -> bool {
    !scene.materials[screen::primitive(scene, part).material].unlit
}

/// Loads the source of a shot as a scene, with the pictures that the scene represents.
fn load(shot: &Shot) -> Result<(Scene, Option<Gallery>), PipelineError> {
    match &shot.source {
        Source::Scene(path) => {
            let access = if shot.allow_outside { FileAccess::Anywhere } else { FileAccess::SceneFolder };
            Ok((scene::load_with(path, access)?, None))
        }
        Source::Frame => Ok((scene::frame_card(shot.size.aspect()), None)),
        Source::Images(paths) => {
            let (gallery, scene) = Gallery::load(shot, paths)?;
            Ok((scene, Some(gallery)))
        }
    }
}

/// Refuses frames with too many pixels.
fn check_size(shot: &Shot) -> Result<(), PipelineError> {
    let pixels = u64::from(shot.size.width) * u64::from(shot.size.height);
    if pixels <= MAX_PIXELS {
        return Ok(());
    }
    let what = format!("a frame of {} x {} pixels is too large", shot.size.width, shot.size.height);
    Err(PipelineError::mismatch(shot, "size", what, "stay within 268 million pixels (16384 x 16384)"))
}

/// Returns the clip named by the shot, or else the scene's first, if any.
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
