//! Which files the buttons of hosts may write: the rule of the command line, worded for hosts.
//!
//! In: the shape, and a path that is to be written. Out: leave, or [`ImageError::Refused`].

use super::{LiveError, ShapeSource, solve};
use crate::image::{ImageError, Inputs};
use crate::pipeline::input_files;
use crate::space::FrameSize;
use std::path::Path;

/// Refuses to write over what a shape is read from, and over what is no regular file.
#[derive(Clone, Debug, Default)]
pub struct OutputGuard {
    inputs: Inputs,
}

impl OutputGuard {
    /// Guards everything that a shape is read from: of a shot its file, scene, pictures, plates and lattices. Hosts do not
    /// tell the files of their pictures.
    ///
    /// # Errors
    /// [`LiveError`] where a shot cannot be loaded.
    pub fn of(shape: &ShapeSource, frame: FrameSize) -> Result<Self, LiveError> {
        let ShapeSource::Shot(_) = shape else { return Ok(Self::default()) };
        let base = solve::base(shape, frame)?;
        let inputs = base.prepared.as_ref().map(input_files).transpose()?;
        Ok(Self { inputs: inputs.unwrap_or_default() })
    }

    /// Refuses an input, by whatever name, and what is no regular file.
    ///
    /// # Errors
    /// [`ImageError::Refused`].
    pub fn check(&self, path: &Path) -> Result<(), ImageError> {
        self.inputs.refuse(path).map_err(|error| match error {
            ImageError::Refused { path, what, .. } => {
                ImageError::Refused { path, what, hint: "name another file".to_owned() }
            }
            error => error,
        })
    }
}
