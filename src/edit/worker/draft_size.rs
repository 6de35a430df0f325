//! Adapts the resolution of draft pictures to a time budget.
//!
//! In: the drawing times of pictures. Out: the next size, an integer fraction of the frame's.

use crate::space::FrameSize;

/// Largest divisor of the frame's size.
const MAX_PARTS: u32 = 4;

/// Fraction of a full-size picture's time that does not depend on its pixels.
const FIXED: f64 = 0.25;

/// Estimates how long pictures take.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct DraftSize {
    /// Estimated milliseconds of a full-size picture; `None` until one was drawn.
    full_ms: Option<f64>,
}

impl DraftSize {
    /// Returns the largest size that meets the budget.
    pub(super) fn within(self, frame: FrameSize, longest_ms: f64) -> FrameSize {
        let parts = match self.full_ms {
            None => 2,
            Some(full) => (1..MAX_PARTS).find(|parts| full * share(*parts) <= longest_ms).unwrap_or(MAX_PARTS),
        };
        divided(frame, parts)
    }

    /// Returns the smallest size.
    pub(super) fn least(frame: FrameSize) -> FrameSize {
        divided(frame, MAX_PARTS)
    }

    /// Returns the estimated milliseconds of the smallest size; `None` until a picture was drawn.
    pub(super) fn least_ms(self) -> Option<f64> {
        Some(self.full_ms? * share(MAX_PARTS))
    }

    /// Updates the estimate with a measured time.
    pub(super) fn learn(&mut self, frame: FrameSize, size: FrameSize, took_ms: f64) {
        let parts = (f64::from(frame.height) / f64::from(size.height)).round().max(1.0) as u32;
        let full = took_ms / share(parts);
        self.full_ms = Some(self.full_ms.map_or(full, |known| 0.5 * (known + full)));
    }
}

fn divided(frame: FrameSize, parts: u32) -> FrameSize {
    let part = |side: u32| side.div_ceil(parts).max(1);
    FrameSize { width: part(frame.width), height: part(frame.height), ..frame }
}

/// Returns the fraction of a full-size picture's time that a smaller one takes.
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
        assert!(size.least_ms().is_some_and(|least| (100.0..200.0).contains(&least)));
        for _ in 0..8 {
            size.learn(frame, size.within(frame, 25.0), 4.0);
        }
        assert_eq!(size.within(frame, 25.0).height, 1081);
    }
}
