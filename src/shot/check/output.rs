//! Validates `[output]`: a file name that distinguishes frames, no duplicate channels.
//!
//! In: the raw table and the frame range. Out: [`Output`].

use super::Check;
use crate::image::{Compression, ImageError, PictureKind, SequencePath, without_counter};
use crate::raster::ChannelGroup;
use crate::shot::raw::{RawChannel, RawCompression, RawOutput};
use crate::shot::{FrameRange, Output, Source};
use std::path::Path;

impl Check<'_> {
    pub(super) fn output(&mut self, raw: &RawOutput, frames: &FrameRange, source: &Source) -> Output {
        let shot_path = self.document.path;
        let folder = shot_path.parent().unwrap_or(Path::new(""));
        if let Some(path) = &raw.path {
            // Warped PNG plates may be written as PNG files.
            let kinds =
                if *source == Source::Frame { &[PictureKind::Exr, PictureKind::Png][..] } else { &[PictureKind::Exr] };
            self.output_path(path, frames, kinds);
        }
        let path = raw.path.clone().unwrap_or_else(|| {
            let stem = without_counter(Path::new(shot_path.file_stem().unwrap_or("shot".as_ref())));
            format!("out/{}.####.exr", stem.to_string_lossy())
        });
        Output {
            path: folder.join(path),
            channels: raw
                .channels
                .as_ref()
                .map_or_else(|| default_channels(source), |channels| self.channels(channels)),
            compression: raw.compression.map_or_else(Compression::default, Compression::from),
        }
    }

    fn output_path(&mut self, path: &str, frames: &FrameRange, kinds: &[PictureKind]) {
        let key = "output.path";
        if !PictureKind::of(Path::new(path)).is_some_and(|kind| kinds.contains(&kind)) {
            self.fault(key, format!("{path:?} is not the name of an EXR file"), "let it end in .exr");
        }
        let count = frames.count();
        let fault = SequencePath::parse(Path::new(path)).and_then(|sequence| sequence.check_frame_count(count)).err();
        let what = match fault {
            Some(ImageError::Pattern { what, .. }) => what,
            Some(other) => other.to_string(),
            None => return,
        };
        let (what, hint) = what.split_once("; ").unwrap_or((&what, "write for example out/shot.####.exr"));
        self.fault(key, format!("{path:?} {what}"), hint);
    }

    fn channels(&mut self, raw: &[RawChannel]) -> Vec<ChannelGroup> {
        for (index, channel) in raw.iter().enumerate() {
            if raw[..index].contains(channel) {
                self.fault(&format!("output.channels[{index}]"), "is listed twice", "remove one of them");
            }
        }
        raw.iter().map(|&channel| channel.into()).collect()
    }
}

/// Returns the default channels: all but mattes, whose 36 channels are larger than all others together. Pictures have
/// colour and ids only.
fn default_channels(source: &Source) -> Vec<ChannelGroup> {
    if let Source::Images(_) = source {
        vec![ChannelGroup::Beauty, ChannelGroup::Id]
    } else {
        ChannelGroup::PLANAR.to_vec()
    }
}

impl From<RawChannel> for ChannelGroup {
    fn from(raw: RawChannel) -> Self {
        match raw {
            RawChannel::Beauty => Self::Beauty,
            RawChannel::Depth => Self::Depth,
            RawChannel::Motion => Self::Motion,
            RawChannel::Normal => Self::Normal,
            RawChannel::Id => Self::Id,
            RawChannel::Cryptomatte => Self::Cryptomatte,
        }
    }
}

impl From<RawCompression> for Compression {
    fn from(raw: RawCompression) -> Self {
        match raw {
            RawCompression::None => Self::None,
            RawCompression::Rle => Self::Rle,
            RawCompression::Zips => Self::Zips,
            RawCompression::Zip => Self::Zip,
            RawCompression::Piz => Self::Piz,
            RawCompression::Dwaa => Self::Dwaa,
            RawCompression::Dwab => Self::Dwab,
        }
    }
}
