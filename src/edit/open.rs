//! Opens any supported file: a shot, a scene, a picture, a sequence of plates, or a problem file.
//!
//! In: a path. Out: a [`Document`]. Anything but a shot file gets the text that `pinwarp new` would write, and a shot
//! path next to it. The mesh of a problem file is written beside it as a scene.

use super::{Document, EditError};
use crate::files::{SHOT_BYTES, located, read_text};
use crate::image::{PictureKind, SequencePath, picture_size, replace_bytes};
use crate::pipeline::{NewShot, ProblemShot, new_shot, path_between, problem_shot};
use crate::scene::FileAccess;
use crate::shot::{Shot, Source, template};
use std::path::{Path, PathBuf};

/// Opens a file for editing.
///
/// # Errors
/// [`EditError`] if it cannot be read or its type is not supported.
pub(crate) fn open(path: &Path, access: FileAccess) -> Result<Document, EditError> {
    Ok(document_of(path, access)?.allowing(access))
}

fn document_of(path: &Path, access: FileAccess) -> Result<Document, EditError> {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
    if ending == "toml" {
        return Document::open(path);
    }
    let beside = shot_beside(path);
    if beside.exists() {
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
    Ok(Document::new(&beside, template::write(name, &facts))?.with_scene(scene))
}

/// Creates a shot that warps finished frames of another renderer as whole pictures.
fn plates(pattern: &Path, shot: &Path) -> Result<Document, EditError> {
    let sequence = SequencePath::of_input(pattern)?;
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
    let scene = problem_scene(path);
    let name = scene.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let ProblemShot { glb, text } = problem_shot(path, &name)?;
    replace_bytes(&scene, &glb)?;
    Document::new(shot, text)
}

/// Returns the path at which the shot of a scene or picture is looked up and saved: the first of `hero.toml`, `hero-2.toml`
/// and so on that is its shot, or that is free.
fn shot_beside(path: &Path) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let stem = stem.trim_end_matches(['#', '.', '_', '-']);
    let stem = if stem.is_empty() { "shot" } else { stem };
    let mut beside = path.with_file_name(format!("{stem}.toml"));
    let mut number = 1;
    while beside.exists() && !is_shot_of(&beside, path) {
        number += 1;
        beside.set_file_name(format!("{stem}-{number}.toml"));
    }
    beside
}

/// Returns whether a file is the shot of a scene, picture, sequence or problem. A shot with a fault is if it names it.
fn is_shot_of(shot: &Path, file: &Path) -> bool {
    let Ok(text) = read_text(shot, SHOT_BYTES) else { return false };
    let is_problem = file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("json"));
    let file = if is_problem { problem_scene(file) } else { file.to_owned() };
    let Ok(shot) = Shot::parse(&text, shot) else {
        return file.file_name().is_some_and(|name| text.contains(&*name.to_string_lossy()));
    };
    let files: Vec<PathBuf> = match shot.source {
        Source::Scene(scene) => vec![scene],
        Source::Images(images) => images,
        Source::Frame => Vec::new(),
    };
    files.iter().chain(&shot.plate).any(|other| is_same(other, &file))
}

/// Returns whether two paths lead to one file, or are one sequence: `frame.####.exr` and `frame.%04d.exr`.
fn is_same(one: &Path, other: &Path) -> bool {
    let [one, other] = [one, other].map(|path| {
        let path = SequencePath::of_input(path).map_or_else(|_| path.to_owned(), |sequence| sequence.path_of(0));
        path.canonicalize().unwrap_or_else(|_| located(&path))
    });
    one == other
}

/// Returns the path of the scene that is written for a problem file.
fn problem_scene(problem: &Path) -> PathBuf {
    problem.with_extension("problem.glb")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn the_shot_beside_a_file_is_its_own() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        let shot = |source: &str| {
            format!(
                "version = 1\n{source}\nframes = {{ first = 1, last = 2, rate = 24 }}\nsize = [96, 54]\n[[layer]]\nname = \"a\"\n"
            )
        };
        fs::write(at("hero.toml"), shot("scene = \"hero.glb\"")).expect("written");
        assert_eq!(shot_beside(&at("hero.glb")), at("hero.toml"));
        assert_eq!(shot_beside(&at("hero.png")), at("hero-2.toml"), "it is the shot of the scene");
        fs::write(at("hero-2.toml"), shot("image = \"hero.png\"")).expect("written");
        assert_eq!(shot_beside(&at("hero.png")), at("hero-2.toml"));
        assert_eq!(shot_beside(&at("hero.json")), at("hero-3.toml"));
        // A shot with a fault is still the shot of what it names, and the fault is told when it is opened.
        fs::write(at("hero.toml"), "scene = \"hero.glb").expect("written");
        assert_eq!(shot_beside(&at("hero.glb")), at("hero.toml"));
        // A file that is no shot at all.
        fs::write(at("tool.toml"), "[tool]\nname = 'x'\n").expect("written");
        assert_eq!(shot_beside(&at("tool.glb")), at("tool-2.toml"));
        fs::write(at("beauty.toml"), shot("plate = \"beauty.%04d.exr\"")).expect("written");
        assert_eq!(shot_beside(&at("beauty.####.exr")), at("beauty.toml"));
    }
}
