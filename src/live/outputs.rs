//! Protects input files from being overwritten: the rule of the command line, worded for hosts.
//!
//! In: the shape, and an output path. Out: permission, or [`ImageError::Refused`].

use super::{LiveError, ShapeSource, solve};
use crate::image::{ImageError, Inputs};
use crate::pipeline::input_files;
use crate::space::FrameSize;
use std::path::Path;

/// Refuses to overwrite the inputs of a shape, and anything but regular files.
#[derive(Clone, Debug, Default)]
pub(crate) struct OutputGuard {
    inputs: Inputs,
}

impl OutputGuard {
    /// Guards the inputs of a shape: for a shot, its file, scene, pictures, plates and lattices. Hosts do not tell the
    /// files of their pictures.
    ///
    /// # Errors
    /// [`LiveError`] if a shot cannot be loaded.
    pub(crate) fn of(shape: &ShapeSource, frame: FrameSize) -> Result<Self, LiveError> {
        let ShapeSource::Shot(_) = shape else { return Ok(Self::default()) };
        let base = solve::base(shape, frame)?;
        let inputs = base.prepared.as_ref().map(input_files).transpose()?;
        Ok(Self { inputs: inputs.unwrap_or_default() })
    }

    /// Refuses inputs, under any name, and anything but regular files.
    ///
    /// # Errors
    /// [`ImageError::Refused`].
    pub(crate) fn check(&self, path: &Path) -> Result<(), ImageError> {
        self.inputs.refuse(path).map_err(|error| match error {
            ImageError::Refused { path, what, .. } => {
                ImageError::Refused { path, what, hint: "name another file".to_owned() }
            }
            error => error,
        })
    }
}
