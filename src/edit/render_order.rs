//! What to render, how, and where to.
//!
//! In: the user's choices, a shot. Out: the shot as it is rendered, and its frames. The document does not change.

use super::playhead::Playhead;
use crate::shot::{Shot, Shutter};
use crate::space::FrameSize;
use std::path::Path;

/// The shutter where the shot has none: open for half a frame, around it.
const HALF_OPEN: Shutter = Shutter { angle: 180.0, phase: -90.0 };

/// Which frames are rendered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum RenderRange {
    /// Those that are played: from in to out, else all.
    #[default]
    Played,
    /// All of the shot.
    All,
    /// That which is shown.
    Shown,
}

/// What to render.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RenderOrder {
    pub(crate) range: RenderRange,
    /// Whether a PNG preview is written beside each EXR frame.
    pub(crate) has_previews: bool,
    /// Size in per cent of the shot's.
    pub(crate) percent: u32,
    /// Whether motion is blurred; `None`: as the shot says.
    pub(crate) is_blurred: Option<bool>,
    /// Samples of a pixel; `None`: as many as the shot says.
    pub(crate) samples: Option<u32>,
    /// The folder, relative to that of the shot file; empty: that of the shot's output path.
    pub(crate) folder: String,
}

impl Default for RenderOrder {
    fn default() -> Self {
        let (is_blurred, samples, folder) = (None, None, String::new());
        Self { range: RenderRange::Played, has_previews: true, percent: 100, is_blurred, samples, folder }
    }
}

impl RenderOrder {
    /// Returns the frames to render; none: all of the shot.
    pub(crate) fn frames(&self, playhead: &Playhead) -> Vec<i32> {
        let [first, last] = playhead.range();
        match self.range {
            RenderRange::Played if playhead.has_range() => (first..=last).collect(),
            RenderRange::Played | RenderRange::All => Vec::new(),
            RenderRange::Shown => vec![playhead.frame()],
        }
    }

    /// Returns a shot as it is rendered.
    pub(crate) fn shot(&self, shot: &Shot) -> Shot {
        let mut shot = shot.clone();
        let pixels =
            |side: u32| ((u64::from(side) * u64::from(self.percent) + 50) / 100).clamp(1, u64::from(u32::MAX)) as u32;
        let FrameSize { width, height, .. } = shot.size;
        shot.size = FrameSize { width: pixels(width), height: pixels(height), ..shot.size };
        shot.samples = self.samples.unwrap_or(shot.samples);
        shot.shutter = match (self.is_blurred, shot.shutter.angle > 0.0) {
            (Some(false), _) => Shutter::CLOSED,
            (Some(true), false) => HALF_OPEN,
            (Some(true), true) | (None, _) => shot.shutter,
        };
        let folder = self.folder.trim();
        if let Some(name) = shot.output.path.file_name().filter(|_| !folder.is_empty()) {
            let beside = shot.path.parent().unwrap_or(Path::new(""));
            shot.output.path = beside.join(folder).join(name);
        }
        shot
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::edit::Document;
    use std::path::PathBuf;

    const SHOT: &str = "scene = 'a.glb'\nsize = [1920, 1081]\nsamples = 16\nframes = { first = 1, last = 24 }\n\
                        shutter = { angle = 180 }\n[output]\npath = 'out/a.####.exr'\n";

    #[test]
    fn an_order_changes_what_is_rendered_and_nothing_else() {
        let document = Document::new(Path::new("/shots/a.toml"), SHOT.to_owned()).expect("a shot");
        let usual = RenderOrder::default();
        assert_eq!(usual.shot(document.shot()), *document.shot());
        let (is_blurred, samples, folder) = (Some(false), Some(4), " small".to_owned());
        let order = RenderOrder { percent: 50, is_blurred, samples, folder, ..usual };
        let shot = order.shot(document.shot());
        assert_eq!([shot.size.width, shot.size.height], [960, 541]);
        assert_eq!((shot.samples, shot.shutter), (4, Shutter::CLOSED));
        assert_eq!(shot.output.path, PathBuf::from("/shots/small/a.####.exr"));
        let still = SHOT.replace("180", "0");
        let document = Document::new(Path::new("/shots/a.toml"), still).expect("a shot");
        let order = RenderOrder { is_blurred: Some(true), ..RenderOrder::default() };
        assert_eq!(order.shot(document.shot()).shutter, HALF_OPEN);
    }

    #[test]
    fn the_frames_are_those_played_all_or_the_shown_one() {
        let document = Document::new(Path::new("a.toml"), SHOT.to_owned()).expect("a shot");
        let mut playhead = Playhead::new(&document.shot().frames);
        let frames = |playhead: &Playhead, range| RenderOrder { range, ..RenderOrder::default() }.frames(playhead);
        assert!(frames(&playhead, RenderRange::Played).is_empty(), "all of them");
        playhead.set_range(Some([3, 5]));
        playhead.go(4);
        assert_eq!(frames(&playhead, RenderRange::Played), [3, 4, 5]);
        assert!(frames(&playhead, RenderRange::All).is_empty());
        assert_eq!(frames(&playhead, RenderRange::Shown), [4]);
    }
}
