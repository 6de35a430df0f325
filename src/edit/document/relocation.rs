//! Saves a shot to another folder.
//!
//! In: the text, the paths of the shot file before and after. Out: the text whose relative paths name the same files.
//! Frames are still written relative to the shot file, so that a copy does not overwrite those of its original.

use crate::edit::EditError;
use crate::files::located;
use crate::shot::edit::put_paths;
use std::path::Path;

/// Returns the text of a shot for another folder.
///
/// # Errors
/// [`EditError`] if one of the folders cannot be used.
pub(super) fn relocated(text: &str, [from, to]: [&Path; 2]) -> Result<String, EditError> {
    let [old, new] = [from, to].map(|path| path.parent().unwrap_or(Path::new("")));
    if old == new {
        return Ok(text.to_owned());
    }
    let new = new.canonicalize().map_err(|source| EditError::Io { path: new.to_owned(), source })?;
    if old.to_str().is_none() {
        return Err(EditError::Unusable {
            what: format!(
                "{}: the name of the folder is not valid Unicode, and a shot elsewhere has to name it",
                old.display()
            ),
            hint: "rename the folder, or save in it".into(),
        });
    }
    let moved = |file: &str| {
        if Path::new(file).is_absolute() {
            return None;
        }
        let file = located(&old.join(file));
        let file = file.strip_prefix(&new).unwrap_or(&file).to_string_lossy().into_owned();
        Some(if cfg!(windows) { file.replace('\\', "/") } else { file })
    };
    Ok(put_paths(text, &moved)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn files_are_named_from_the_other_folder() {
        let folder = tempfile::tempdir().expect("a folder");
        let root = folder.path().canonicalize().expect("there");
        for name in ["a/art", "b"] {
            fs::create_dir_all(root.join(name)).expect("made");
        }
        let [from, to] = ["a/shot.toml", "shot.toml"].map(|name| root.join(name));
        let text = "scene = \"x.glb\" # mine\nplate = \"art/p.####.exr\"\n[output]\npath = \"out/f.####.exr\"\n";
        let up = relocated(text, [&from, &to]).expect("it is TOML");
        assert_eq!(up, text.replace("\"x.glb", "\"a/x.glb").replace("\"art", "\"a/art"));
        assert_eq!(relocated(&up, [&to, &from]).expect("it is TOML"), text);
        let aside = relocated(text, [&from, &root.join("b/shot.toml")]).expect("it is TOML");
        assert!(aside.contains(&format!("scene = \"{}/a/x.glb\" # mine", root.display())), "{aside}");
        assert_eq!(relocated(text, [&from, &from.with_file_name("other.toml")]).expect("the same folder"), text);
        assert!(relocated(text, [&from, &root.join("none/shot.toml")]).is_err());
    }
}
