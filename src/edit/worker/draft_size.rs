//! How large a quick picture may be to be there in time.
//!
//! In: how long pictures took. Out: the next one's size, a whole part of the frame's.

use crate::space::FrameSize;

/// The smallest picture has this part of the frame's lines.
const MOST_PARTS: u32 = 4;

/// Part of the time that does not depend on pixels, of a picture in full size.
const FIXED: f64 = 0.25;

/// Learns how long pictures take.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct DraftSize {
    /// Of a picture in full size, as the last one lets expect; `None`: none was drawn yet.
    full_ms: Option<f64>,
}

impl DraftSize {
    /// The largest size that is there in time.
    pub(super) fn within(self, frame: FrameSize, longest_ms: f64) -> FrameSize {
        let parts = match self.full_ms {
            None => 2,
            Some(full) => (1..MOST_PARTS).find(|parts| full * share(*parts) <= longest_ms).unwrap_or(MOST_PARTS),
        };
        let part = |side: u32| side.div_ceil(parts).max(1);
        FrameSize { width: part(frame.width), height: part(frame.height), ..frame }
    }

    /// A picture of that size took so long.
    pub(super) fn learn(&mut self, frame: FrameSize, size: FrameSize, took_ms: f64) {
        let parts = (f64::from(frame.height) / f64::from(size.height)).round().max(1.0) as u32;
        let full = took_ms / share(parts);
        self.full_ms = Some(self.full_ms.map_or(full, |known| 0.5 * (known + full)));
    }
}

/// The share of a full picture's time that a smaller one takes.
fn share(parts: u32) -> f64 {
    FIXED + (1.0 - FIXED) / f64::from(parts * parts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slow_pictures_become_smaller_and_fast_ones_larger() {
        let frame = FrameSize::new(1920, 1081);
        let mut size = DraftSize::default();
        assert_eq!(size.within(frame, 25.0).height, 541);
        for _ in 0..8 {
            size.learn(frame, frame, 400.0);
        }
        assert_eq!(size.within(frame, 25.0).height, 271);
        for _ in 0..8 {
            size.learn(frame, size.within(frame, 25.0), 4.0);
        }
        assert_eq!(size.within(frame, 25.0).height, 1081);
    }
}
