//! `pinwarp new`: writes a shot file that renders as it stands.
//!
//! In: a scene or a picture. Out: commented TOML with its clips, cameras, nodes and size.

use super::args::NewArgs;
use super::outcome::Outcome;
use super::outputs;
use crate::image::{PictureKind, SequencePath, picture_size, replace_text};
use crate::scene::{self, Scene};
use crate::shot::template::{self, ClipFact, Subject, TemplateFacts};
use crate::space::FrameSize;
use anyhow::{Context, bail};
use std::collections::BTreeSet;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Frames a second of a new shot.
const RATE: f64 = 24.0;

/// Longer clips are cut: shot files take frames up to a million.
const MAX_FRAME: f32 = 999_999.0;

/// Length of a new shot whose scene does not move.
const DEFAULT_FRAMES: i32 = 24;

pub(super) fn run(args: &NewArgs) -> anyhow::Result<Outcome> {
    let mut inputs = outputs::inputs_of([&args.scene]);
    let (facts, warnings) = if is_model(&args.scene) {
        let scene = scene::load_with(&args.scene, args.outside.access())?;
        scene.files_beside.iter().for_each(|file| inputs.add(file));
        (facts(&scene), scene.warnings)
    } else {
        (image_facts(&args.scene)?, Vec::new())
    };
    outputs::allow(&inputs, &args.output, args.overwrite)?;
    let path = path_between(args.output.parent().unwrap_or(Path::new("")), &args.scene)?;
    let text = template::write(outputs::as_text(&path)?, &facts);
    replace_text(&args.output, &text)?;
    for warning in &warnings {
        writeln!(std::io::stderr(), "warning: {warning}")?;
    }
    writeln!(std::io::stdout(), "wrote {0}; next: pinwarp render {0} --frames 1 --preview", args.output.display())?;
    Ok(Outcome::Complete)
}

/// Everything that is no picture by its name is a scene, or none of the two, and the scene's reader says so.
fn is_model(path: &Path) -> bool {
    PictureKind::of(path).is_none()
}

/// What the template says about a picture.
fn image_facts(path: &Path) -> anyhow::Result<TemplateFacts> {
    if !path.is_file() && SequencePath::parse(path)?.has_counter() {
        bail!(
            "{0}: pictures of a shot stand still, this is a sequence; write a shot with `plate = \"{0}\"`, give its \
             layer `matte = \"alpha\"`, and run `pinwarp warp`",
            path.display()
        );
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

/// What the template says about the scene.
fn facts(scene: &Scene) -> TemplateFacts {
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

/// The scene's path as seen from the shot file's folder: relative where it lies below it, else absolute.
pub(super) fn path_between(folder: &Path, scene: &Path) -> anyhow::Result<PathBuf> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let folder = folder
        .canonicalize()
        .with_context(|| format!("the folder {} of the shot file is not there; make it first", folder.display()))?;
    let scene = scene.canonicalize()?;
    Ok(scene.strip_prefix(&folder).map(Path::to_owned).unwrap_or(scene))
}
