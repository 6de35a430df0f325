//! The frame size of a shot that does not set it.
//!
//! In: the raw shot, its source and plate. Out: the size.

use super::Check;
use crate::image::picture_size;
use crate::shot::raw::RawShot;
use crate::shot::{FrameRange, Source};
use crate::space::FrameSize;
use std::path::Path;

/// Default frame size.
const DEFAULT_SIZE: [u32; 2] = [1920, 1080];

impl Check<'_> {
    /// Returns the frame size: the shot's, else that of its first picture, else that of the first frame of its plate that
    /// can be read, as for `pinwarp warp`. If none can, that is no fault: they may not exist yet, and the command line may give others.
    pub(super) fn size(
        &mut self,
        raw: &RawShot,
        source: &Source,
        (plate, frames): (Option<&Path>, &FrameRange),
    ) -> FrameSize {
        let [width, height] = raw.size.unwrap_or(DEFAULT_SIZE);
        let default = FrameSize { width, height, pixel_aspect: raw.pixel_aspect.unwrap_or(1.0) };
        if raw.size.is_some() {
            return default;
        }
        let shown = match source {
            Source::Images(images) => images.first().map(|image| picture_size(image)),
            Source::Frame => plate.and_then(|plate| (self.plate_size)(plate, [frames.first, frames.last])).map(Ok),
            Source::Scene(_) => None,
        };
        match shown {
            Some(Ok(size)) => FrameSize { pixel_aspect: raw.pixel_aspect.unwrap_or(size.pixel_aspect), ..size },
            Some(Err(error)) if matches!(source, Source::Images(_)) => {
                let hint = "the size of the frame is that of the first picture; mend its path, or give `size`";
                self.fault("image", error.to_string(), hint);
                default
            }
            _ => default,
        }
    }
}
