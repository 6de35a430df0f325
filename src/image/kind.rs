//! File types by extension: a single table for the whole program.
//!
//! In: paths. Out: the file type, or a message that names the alternatives.

use super::ImageError;
use std::path::Path;

/// The type of a file, according to its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FileKind {
    /// A picture.
    Picture(PictureKind),
    /// A glTF file.
    Scene,
    /// A shot.
    Shot,
    /// JSON: lattices, landmarks or a problem.
    Json,
    /// CSV: a table of landmarks.
    Csv,
}

/// Picture formats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PictureKind {
    /// OpenEXR: parts, layers, floats.
    Exr,
    /// PNG: 8 or 16 bits, straight alpha.
    Png,
    /// JPEG: 8 bits, no alpha.
    Jpeg,
}

/// Extensions in lower case, matched case-insensitively.
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
    /// Returns the type by file extension, `None` if the extension is unknown.
    #[must_use]
    pub(crate) fn of(path: &Path) -> Option<Self> {
        let ending = path.extension()?;
        ENDINGS.iter().find(|(known, _)| ending.eq_ignore_ascii_case(known)).map(|(_, kind)| *kind)
    }
}

impl PictureKind {
    /// Advice for files that are not pictures.
    pub(crate) const REMEDY: &str = "give a .png, .jpg or .exr file";

    /// Returns the format by file extension; `None` if it is not a picture.
    #[must_use]
    pub(crate) fn of(path: &Path) -> Option<Self> {
        if let Some(FileKind::Picture(kind)) = FileKind::of(path) { Some(kind) } else { None }
    }

    /// Returns the format by file extension.
    ///
    /// # Errors
    /// [`ImageError::Pattern`] with [`Self::REMEDY`] if it is not a picture.
    pub(crate) fn known(path: &Path) -> Result<Self, ImageError> {
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

    #[test]
    fn the_type_follows_from_the_extension() {
        use crate::image::{FileKind, PictureKind};
        use std::path::Path;
        assert_eq!(FileKind::of(Path::new("girl.####.EXR")), Some(FileKind::Picture(PictureKind::Exr)));
        assert_eq!(FileKind::of(Path::new("girl.psd")), None);
    }
}
