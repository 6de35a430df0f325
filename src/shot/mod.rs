//! Stage 5: parses `shot.toml` into a validated [`Shot`], edits its text, and evaluates keys at a time.
//!
//! In: a file. Out: plain data, with every rule checked that does not require the scene; and [`PinTargets`] at a time. The text
//! becomes a tree with lines, the schema checks its structure, and `check` its values.

mod camera;
mod check;
mod connectivity;
mod document;
mod ease;
pub mod edit;
mod error;
mod hash;
mod hints;
mod keys;
mod lines;
mod model;
#[cfg(feature = "cli")]
mod only_layers;
mod order;
mod range;
mod raw;
mod schema;
mod selection;
mod structure;
#[cfg(any(test, feature = "cli", feature = "editor"))]
pub mod template;

pub(crate) use camera::*;
pub(crate) use connectivity::Connectivity;
pub(crate) use connectivity::{Cut, IdChoice, IdPicture, LineArt};
pub(crate) use connectivity::{CutSurface, Join};
pub use error::ShotError;
pub(crate) use hash::digest;
pub(crate) use lines::KeyLines;
pub use model::*;
pub(crate) use order::OrderKey;
pub(crate) use order::order_at;
pub use schema::schema;
pub(crate) use selection::{ColorChannel, PaintedMask, Selection};

use crate::files::{SHOT_BYTES, read_text};
use crate::image::plate_size;
use crate::space::FrameSize;
use document::Document;
use std::path::Path;

impl Shot {
    /// Reads and checks a shot file.
    ///
    /// # Errors
    /// [`ShotError`] with file, line, key and the nearest valid spelling; [`ShotError::Many`] if there are several.
    pub fn read(path: &Path) -> Result<Self, ShotError> {
        let text = read_text(path, SHOT_BYTES).map_err(|source| ShotError::Io { path: path.to_owned(), source })?;
        Self::parse(&text, path)
    }

    /// Parses and checks the text of a shot file; `path` is used in messages, and relative paths start at its folder.
    ///
    /// ```
    /// use pinwarp::shot::Shot;
    /// use std::path::Path;
    /// let text = "scene = 'pot.glb'\nframes = { first = 1, last = 24 }";
    /// let shot = Shot::parse(text, Path::new("shots/pot.toml"))?;
    /// assert_eq!(shot.scene(), Some(Path::new("shots/pot.glb")));
    ///
    /// let error = Shot::parse(&text.replace("scene", "scnee"), Path::new("pot.toml")).unwrap_err();
    /// assert!(error.to_string().starts_with("pot.toml:1: scnee: is not a key of a shot; did you mean `scene`?"));
    /// # Ok::<(), pinwarp::shot::ShotError>(())
    /// ```
    ///
    /// # Errors
    /// As [`Shot::read`].
    pub fn parse(text: &str, path: &Path) -> Result<Self, ShotError> {
        Self::parse_with(text, path, &plate_size)
    }

    /// As [`Shot::parse`], with a function in place of reading the size of plates: an editor parses at every edit.
    ///
    /// # Errors
    /// As [`Shot::read`].
    pub(crate) fn parse_with(text: &str, path: &Path, plate_size: PlateSize) -> Result<Self, ShotError> {
        let document = Document::parse(text, path)?;
        let shot = check::shot(&document, plate_size)?;
        Ok(Self { lines: document.lines, ..shot })
    }
}

/// Returns the size of a plate in the first of these frames that can be read, from first to last; `None` if there is none.
pub(crate) type PlateSize<'a> = &'a dyn Fn(&Path, [i32; 2]) -> Option<FrameSize>;
