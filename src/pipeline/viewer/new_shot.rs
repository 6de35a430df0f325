//! Collects the facts for a new shot of a scene or picture.
//!
//! In: a path. Out: the input of [`template`](crate::shot::template).

use crate::image::{PictureKind, SequencePath, picture_size};
use crate::pipeline::PipelineError;
use crate::pipeline::evaluate::topology::branches_over;
use crate::scene::{self, FileAccess, Scene};
use crate::shot::template::{ClipFact, Subject, TemplateFacts};
use crate::space::FrameSize;
use glam::Vec3;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Frames per second of a new shot.
const RATE: f64 = 24.0;

/// Last frame of the longest clip; shot files allow frames up to a million.
const MAX_FRAME: f32 = 999_999.0;

/// Number of frames of a new shot whose scene is not animated.
const DEFAULT_FRAMES: i32 = 24;

/// The inputs of a new shot.
#[derive(Debug)]
pub(crate) struct NewShot {
    /// Facts for the template.
    pub facts: TemplateFacts,
    /// Warnings from reading the file.
    #[cfg_attr(not(any(test, feature = "cli")), expect(dead_code, reason = "only commands read it"))]
    pub warnings: Vec<String>,
    /// Files to which the scene refers.
    #[cfg_attr(not(any(test, feature = "cli")), expect(dead_code, reason = "only commands read it"))]
    pub files_beside: Vec<PathBuf>,
    /// The scene, unless the file is a picture.
    #[cfg_attr(not(any(test, feature = "editor")), expect(dead_code, reason = "only the editor reads it"))]
    pub scene: Option<Scene>,
}

/// Inspects a scene, or a picture if the file name has a picture's extension.
///
/// # Errors
/// [`PipelineError`] if the file cannot be read or is a sequence.
pub(crate) fn new_shot(path: &Path, access: FileAccess) -> Result<NewShot, PipelineError> {
    // Files without a picture's extension are read as scenes, whose reader reports unsupported types.
    if PictureKind::of(path).is_some() {
        return Ok(NewShot {
            facts: picture_facts(path)?,
            warnings: Vec::new(),
            files_beside: Vec::new(),
            scene: None,
        });
    }
    let scene = scene::load_with(path, access)?;
    let (warnings, files_beside) = (scene.warnings.clone(), scene.files_beside.clone());
    Ok(NewShot { facts: scene_facts(&scene), warnings, files_beside, scene: Some(scene) })
}

/// Collects the facts about a picture.
fn picture_facts(path: &Path) -> Result<TemplateFacts, PipelineError> {
    if SequencePath::of_input(path)?.has_counter() {
        return Err(PipelineError::Unusable {
            what: format!("{}: pictures of a shot are single images, but this is a sequence", path.display()),
            hint: format!(
                "write a shot with `plate = \"{}\"`, give its layer `matte = \"alpha\"`, and run `pinwarp warp`",
                path.display()
            ),
        });
    }
    let name = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    Ok(TemplateFacts {
        subject: Subject::Image,
        can_branch: true,
        cameras: Vec::new(),
        has_camera: true,
        clips: Vec::new(),
        mesh_nodes: vec![name],
        spare_nodes: Vec::new(),
        frames: [1, DEFAULT_FRAMES],
        rate: RATE,
        size: picture_size(path)?,
    })
}

/// Collects the facts about a scene.
fn scene_facts(scene: &Scene) -> TemplateFacts {
    let names = |of: fn(&scene::Node) -> bool| {
        scene.nodes.iter().filter(|node| of(node)).map(|node| node.name.clone()).collect::<Vec<_>>()
    };
    let cameras = names(|node| node.camera.is_some());
    let frames = scene
        .clips
        .first()
        .map_or(DEFAULT_FRAMES, |clip| (clip.end_secs * RATE as f32).round().min(MAX_FRAME) as i32 + 1);
    TemplateFacts {
        subject: Subject::Scene,
        can_branch: branches_over(scene),
        has_camera: !cameras.is_empty(),
        cameras,
        clips: scene
            .clips
            .iter()
            .map(|clip| ClipFact { name: clip.name.clone(), secs: clip.end_secs.into() })
            .collect(),
        mesh_nodes: names(|node| node.mesh.is_some()),
        spare_nodes: spare_nodes(scene),
        frames: [1, frames.max(1)],
        rate: RATE,
        size: FrameSize::new(1920, 1080),
    }
}

/// Returns the names of rigid meshes that hang from one joint in the same place, such as the weapons of a character pack. Meshes
/// beside each other, such as eyes, are no alternatives.
fn spare_nodes(scene: &Scene) -> Vec<String> {
    let joints: BTreeSet<usize> = scene.skins.iter().flat_map(|skin| &skin.joints).copied().collect();
    let hung: Vec<Hung> = scene.nodes.iter().filter_map(|node| Hung::of(scene, node)).collect();
    let hung: Vec<&Hung> = hung.iter().filter(|hung| joints.contains(&hung.parent)).collect();
    let is_spare = |one: &&&Hung| hung.iter().any(|other| one.is_in_place_of(other));
    hung.iter().filter(is_spare).map(|hung| hung.node.name.clone()).collect()
}

/// A rigid mesh below another node.
struct Hung<'a> {
    node: &'a scene::Node,
    parent: usize,
    /// Bounding box at rest, lowest and highest corner in the space of the parent.
    corners: [Vec3; 2],
}

impl<'a> Hung<'a> {
    fn of(scene: &Scene, node: &'a scene::Node) -> Option<Self> {
        let parent = node.parent?;
        let mesh = node.mesh.filter(|_| node.skin.is_none())?;
        let matrix = node.rest.matrix();
        let positions = scene.meshes[mesh].primitives.iter().flat_map(|primitive| &primitive.positions);
        let points = positions.map(|&position| [matrix.transform_point3(position); 2]);
        let corners = points.reduce(|[low, high], [point, _]| [low.min(point), high.max(point)])?;
        Some(Self { node, parent, corners })
    }

    /// Whether two different meshes hang from one node and their boxes overlap.
    fn is_in_place_of(&self, other: &Self) -> bool {
        let ([low, high], [other_low, other_high]) = (self.corners, other.corners);
        !std::ptr::eq(self.node, other.node)
            && self.parent == other.parent
            && low.cmple(other_high).all()
            && other_low.cmple(high).all()
    }
}

/// Returns the path of a file relative to a folder if the file lies below it, and the absolute path otherwise.
///
/// # Errors
/// [`PipelineError`] if the folder or the file does not exist.
pub(crate) fn path_between(folder: &Path, file: &Path) -> Result<PathBuf, PipelineError> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let folder = folder.canonicalize().map_err(|_| PipelineError::Unusable {
        what: format!("the folder {} of the shot file is not there", folder.display()),
        hint: "make it first".into(),
    })?;
    let file = file.canonicalize().map_err(|error| PipelineError::Unusable {
        what: format!("{}: {error}", file.display()),
        hint: "name a file that is there".into(),
    })?;
    Ok(file.strip_prefix(&folder).map(Path::to_owned).unwrap_or(file))
}
