//! Opens any supported file: a shot, a scene, a picture, a sequence of plates, or a problem file.
//!
//! In: a path. Out: a [`Document`]. Anything but a shot file gets the text that `pinwarp new` would write, and a shot
//! path next to it. The mesh of a problem file is written beside it as a scene.

use super::{Document, EditError};
use crate::image::{PictureKind, SequencePath, picture_size, replace_bytes};
use crate::pipeline::{NewShot, ProblemShot, new_shot, path_between, problem_shot};
use crate::scene::FileAccess;
use crate::shot::template;
use std::path::{Path, PathBuf};

/// Opens a file for editing.
///
/// # Errors
/// [`EditError`] if it cannot be read or its type is not supported.
pub fn open(path: &Path, access: FileAccess) -> Result<Document, EditError> {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
    if ending == "toml" {
        return Document::open(path);
    }
    let beside = shot_beside(path);
    if beside.is_file() {
        // Opening a scene again continues its existing shot.
        return Document::open(&beside);
    }
    if ending == "json" {
        return problem(path, &beside);
    }
    if PictureKind::of(path).is_some() && !path.is_file() {
        return plates(path, &beside);
    }
    let NewShot { facts, scene, .. } = new_shot(path, access)?;
    let seen = path_between(path.parent().unwrap_or(Path::new("")), path)?;
    let name = seen.to_str().ok_or_else(|| EditError::Unusable {
        what: format!("{}: the name is not valid Unicode", path.display()),
        hint: "rename it".into(),
    })?;
    let document = Document::new(&beside, template::write(name, &facts))?;
    // A shot allows other files than those of the scene's folder only if it says so.
    let is_as_allowed = access == FileAccess::SceneFolder || document.shot().allow_outside;
    Ok(document.with_scene(scene.filter(|_| is_as_allowed)))
}

/// Creates a shot that warps finished frames of another renderer as whole pictures.
fn plates(pattern: &Path, shot: &Path) -> Result<Document, EditError> {
    let sequence = SequencePath::parse(pattern)?;
    let frames = sequence.frames_on_disk()?.unwrap_or_default();
    let (Some(first), Some(last)) = (frames.first(), frames.last()) else {
        return Err(EditError::Unusable {
            what: format!("{}: there is no such file or sequence", pattern.display()),
            hint: "open a shot (.toml), a scene (.glb, .gltf), a picture, a problem (.json), or frames named like frame.####.exr".into(),
        });
    };
    let size = picture_size(&sequence.path_of(*first))?;
    let name = pattern.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let text = format!(
        "version = 1\nplate   = {name:?}\nframes  = {{ first = {first}, last = {last}, rate = 24 }}\n\
         size    = [{}, {}]\n\n[[layer]]\nname    = \"all\"\n",
        size.width, size.height
    );
    Document::new(shot, text)
}

/// Creates a scene and a shot of a problem file.
fn problem(path: &Path, shot: &Path) -> Result<Document, EditError> {
    let scene = path.with_extension("problem.glb");
    let name = scene.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let ProblemShot { glb, text } = problem_shot(path, &name)?;
    replace_bytes(&scene, &glb)?;
    Document::new(shot, text)
}

/// Returns the path at which the shot of a scene or picture is looked up and saved.
fn shot_beside(path: &Path) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let stem = stem.trim_end_matches(['#', '.', '_', '-']);
    path.with_file_name(format!("{}.toml", if stem.is_empty() { "shot" } else { stem }))
}
