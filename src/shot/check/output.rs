//! Rules of `[output]`: a name that tells frames apart, channels once each.
//!
//! In: the raw table and the frame range. Out: [`Output`].

use super::Check;
use crate::image::Compression;
use crate::raster::ChannelGroup;
use crate::shot::raw::{RawChannel, RawCompression, RawOutput};
use crate::shot::{FrameRange, Output};
use std::path::Path;

/// All groups, in the order in which they are written.
const ALL_CHANNELS: [ChannelGroup; 5] =
    [ChannelGroup::Beauty, ChannelGroup::Depth, ChannelGroup::Motion, ChannelGroup::Normal, ChannelGroup::Id];

impl Check<'_> {
    pub(super) fn output(&mut self, raw: &RawOutput, frames: &FrameRange) -> Output {
        let shot_path = self.document.path;
        let folder = shot_path.parent().unwrap_or(Path::new(""));
        if let Some(path) = &raw.path {
            self.output_path(path, frames);
        }
        let path = raw.path.clone().unwrap_or_else(|| {
            let stem = shot_path.file_stem().map_or("shot".into(), |stem| stem.to_string_lossy());
            format!("out/{stem}.####.exr")
        });
        Output {
            path: folder.join(path),
            channels: raw.channels.as_ref().map_or(ALL_CHANNELS.to_vec(), |channels| self.channels(channels)),
            compression: raw.compression.map_or_else(Compression::default, Compression::from),
        }
    }

    fn output_path(&mut self, path: &str, frames: &FrameRange) {
        let key = "output.path";
        let name = path.rsplit('/').next().unwrap_or(path);
        if !name.to_ascii_lowercase().ends_with(".exr") {
            self.fault(key, format!("{name:?} is not the name of an EXR file"), "let it end in .exr");
        }
        let places = frame_places(name);
        if frame_places(path) != places {
            self.fault(key, "a folder has a place for the frame", "put #### into the name of the file only");
        } else if places > 1 {
            self.fault(key, format!("{name:?} has {places} places for the frame"), "keep one #### or %04d");
        } else if places == 0 && frames.first < frames.last {
            let what = format!("all frames {} to {} would be written to {name:?}", frames.first, frames.last);
            self.fault(key, what, "put #### or %04d where the frame goes, as in \"shot.####.exr\"");
        }
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

/// Runs of `#`, and `%d`, `%4d`, `%04d`.
fn frame_places(text: &str) -> usize {
    let after_percent = text.split('%').skip(1);
    let counted = after_percent.filter(|rest| rest.trim_start_matches(|c: char| c.is_ascii_digit()).starts_with('d'));
    let runs = text.split('#').collect::<Vec<_>>();
    // Between two runs of # stands text; inside a run the pieces are empty.
    let hashes = runs.windows(2).enumerate().filter(|(index, pair)| *index == 0 || !pair[0].is_empty()).count();
    counted.count() + hashes
}

impl From<RawChannel> for ChannelGroup {
    fn from(raw: RawChannel) -> Self {
        match raw {
            RawChannel::Beauty => Self::Beauty,
            RawChannel::Depth => Self::Depth,
            RawChannel::Motion => Self::Motion,
            RawChannel::Normal => Self::Normal,
            RawChannel::Id => Self::Id,
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

#[cfg(test)]
mod tests {
    use super::frame_places;

    #[test]
    fn frame_places_are_runs() {
        for (text, places) in [
            ("a.exr", 0),
            ("a.####.exr", 1),
            ("#", 1),
            ("##.##", 2),
            ("a#", 1),
            ("%04d", 1),
            ("%d.#", 2),
            ("100%.exr", 0),
            ("%%", 0),
        ] {
            assert_eq!(frame_places(text), places, "{text}");
        }
    }
}
