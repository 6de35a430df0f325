//! Kinds of files by the endings of their names: one table for the whole program.
//!
//! In: paths. Out: what a file holds, or a message that names what can be used instead.

use super::ImageError;
use std::path::Path;

/// What a file holds, as its name says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// Pixels.
    Picture(PictureKind),
    /// A glTF file.
    Scene,
    /// A shot.
    Shot,
    /// Lattices, landmarks or a problem.
    Json,
    /// Landmarks as a table.
    Csv,
}

/// Formats of pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureKind {
    /// Parts, layers, floats.
    Exr,
    /// 8 or 16 bits, straight alpha.
    Png,
    /// 8 bits, no alpha.
    Jpeg,
}

/// Endings in lower case. Names may be written in any.
const ENDINGS: [(&str, FileKind); 9] = [
    ("exr", FileKind::Picture(PictureKind::Exr)),
    ("png", FileKind::Picture(PictureKind::Png)),
    ("jpg", FileKind::Picture(PictureKind::Jpeg)),
    ("jpeg", FileKind::Picture(PictureKind::Jpeg)),
    ("glb", FileKind::Scene),
    ("gltf", FileKind::Scene),
    ("toml", FileKind::Shot),
    ("json", FileKind::Json),
    ("csv", FileKind::Csv),
];

impl FileKind {
    /// By the ending of the name, `None` where the program knows no such files.
    ///
    /// ```
    /// use pinwarp::image::{FileKind, PictureKind};
    /// use std::path::Path;
    /// assert_eq!(FileKind::of(Path::new("girl.####.EXR")), Some(FileKind::Picture(PictureKind::Exr)));
    /// assert_eq!(FileKind::of(Path::new("girl.psd")), None);
    /// ```
    #[must_use]
    pub fn of(path: &Path) -> Option<Self> {
        let ending = path.extension()?;
        ENDINGS.iter().find(|(known, _)| ending.eq_ignore_ascii_case(known)).map(|(_, kind)| *kind)
    }
}

impl PictureKind {
    /// What to do about a file that is no picture.
    pub const REMEDY: &str = "give a .png, .jpg or .exr file";

    /// By the ending of the name; `None` where it is no picture.
    #[must_use]
    pub fn of(path: &Path) -> Option<Self> {
        if let Some(FileKind::Picture(kind)) = FileKind::of(path) { Some(kind) } else { None }
    }

    /// By the ending of the name.
    ///
    /// # Errors
    /// [`ImageError::Pattern`] with [`Self::REMEDY`] where it is no picture.
    pub fn known(path: &Path) -> Result<Self, ImageError> {
        Self::of(path).ok_or_else(|| {
            let what = format!("is not the name of a picture; {}", Self::REMEDY);
            ImageError::Pattern { pattern: path.to_owned(), what }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_ending_stands_once_and_counts_in_any_case() {
        for (index, (ending, kind)) in ENDINGS.into_iter().enumerate() {
            assert!(ENDINGS[..index].iter().all(|(other, _)| *other != ending), "{ending}");
            assert_eq!(FileKind::of(Path::new(&format!("a.b.{}", ending.to_uppercase()))), Some(kind), "{ending}");
        }
        assert_eq!(FileKind::of(Path::new("exr")), None);
        assert_eq!(PictureKind::of(Path::new("a.glb")), None);
    }

    #[test]
    fn what_is_no_picture_is_told_what_to_give() {
        let error = PictureKind::known(Path::new("drawn.psd")).expect_err("no picture").to_string();
        assert_eq!(error, "the path drawn.psd is not the name of a picture; give a .png, .jpg or .exr file");
    }
}
