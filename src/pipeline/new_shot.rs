//! The shot that a scene or picture begins with.
//!
//! In: a path. Out: what [`template`](crate::shot::template) says about it.

use super::PipelineError;
use crate::image::{PictureKind, SequencePath, picture_size};
use crate::scene::{self, FileAccess, Scene};
use crate::shot::template::{ClipFact, Subject, TemplateFacts};
use crate::space::FrameSize;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Frames a second of a new shot.
const RATE: f64 = 24.0;

/// Longer clips are cut: shot files take frames up to a million.
const MAX_FRAME: f32 = 999_999.0;

/// Length of a new shot whose scene does not move.
const DEFAULT_FRAMES: i32 = 24;

/// What a new shot is made of.
#[derive(Clone, Debug)]
pub struct NewShot {
    /// For the template.
    pub facts: TemplateFacts,
    /// What reading it found, in words.
    pub warnings: Vec<String>,
    /// Files that it refers to.
    pub files_beside: Vec<PathBuf>,
}

/// Looks at a scene, or at a picture by its name.
///
/// # Errors
/// [`PipelineError`] where it cannot be read, or is a sequence.
pub fn new_shot(path: &Path, access: FileAccess) -> Result<NewShot, PipelineError> {
    // Everything that is no picture by its name is a scene, or none of the two, and the scene's reader says so.
    if PictureKind::of(path).is_some() {
        return Ok(NewShot { facts: picture_facts(path)?, warnings: Vec::new(), files_beside: Vec::new() });
    }
    let scene = scene::load_with(path, access)?;
    Ok(NewShot { facts: scene_facts(&scene), warnings: scene.warnings, files_beside: scene.files_beside })
}

/// What the template says about a picture.
fn picture_facts(path: &Path) -> Result<TemplateFacts, PipelineError> {
    if !path.is_file() && SequencePath::parse(path)?.has_counter() {
        return Err(PipelineError::Unusable {
            what: format!("{}: pictures of a shot stand still, this is a sequence", path.display()),
            hint: format!(
                "write a shot with `plate = \"{}\"`, give its layer `matte = \"alpha\"`, and run `pinwarp warp`",
                path.display()
            ),
        });
    }
    let name = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    Ok(TemplateFacts {
        subject: Subject::Image,
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

/// What the template says about a scene.
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

/// Rigid meshes that hang on a joint beside others: the weapons of a character pack, all in one hand.
fn spare_nodes(scene: &Scene) -> Vec<String> {
    let joints: BTreeSet<usize> = scene.skins.iter().flat_map(|skin| &skin.joints).copied().collect();
    let is_rigid = |node: &&scene::Node| node.mesh.is_some() && node.skin.is_none();
    let place = |node: &scene::Node| node.parent.filter(|parent| joints.contains(parent));
    let hung = || scene.nodes.iter().filter(is_rigid).filter_map(|node| Some((place(node)?, node)));
    let is_spare = |parent: usize| hung().filter(|(other, _)| *other == parent).count() > 1;
    hung().filter(|(parent, _)| is_spare(*parent)).map(|(_, node)| node.name.clone()).collect()
}

/// A file's path as seen from a folder: relative where it lies below it, else absolute.
///
/// # Errors
/// [`PipelineError`] where folder or file are not there.
pub fn path_between(folder: &Path, file: &Path) -> Result<PathBuf, PipelineError> {
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
