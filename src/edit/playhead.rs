//! The current frame, and its advance during playback.
//!
//! In: the clock and user commands. Out: frame numbers.

use crate::shot::FrameRange;

/// Playback mode.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Pace {
    /// At the shot's frame rate; frames that are not ready are skipped.
    #[default]
    RealTime,
    /// Every frame, as fast as they become ready.
    EveryFrame,
}

/// The current frame and the playback state.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Playhead {
    frame: i32,
    shot: [i32; 2],
    /// First and last frame of the playback range, if it is not the whole shot.
    range: Option<[i32; 2]>,
    rate: f64,
    /// Time in seconds and frame at which playback started.
    playing: Option<(f64, i32)>,
    /// The playback mode.
    pub(crate) pace: Pace,
}

impl Playhead {
    /// Creates a playhead at the first frame of a shot.
    #[must_use]
    pub(crate) fn new(frames: &FrameRange) -> Self {
        let shot = [frames.first, frames.last];
        Self { frame: frames.first, shot, range: None, rate: frames.rate, playing: None, pace: Pace::default() }
    }

    /// Adapts to a changed frame range of the shot.
    pub(crate) fn follow(&mut self, frames: &FrameRange) {
        self.shot = [frames.first, frames.last];
        self.rate = frames.rate;
        self.range = self.range.filter(|[first, last]| *first >= self.shot[0] && *last <= self.shot[1]);
        self.frame = self.frame.clamp(self.shot[0], self.shot[1].max(self.shot[0]));
    }

    /// Returns the current frame.
    #[must_use]
    pub(crate) const fn frame(&self) -> i32 {
        self.frame
    }

    /// Returns the first and last frame of the shot.
    #[must_use]
    pub(crate) const fn shot_range(&self) -> [i32; 2] {
        self.shot
    }

    /// Returns the first and last frame of the playback range.
    #[must_use]
    pub(crate) fn range(&self) -> [i32; 2] {
        self.range.unwrap_or(self.shot)
    }

    /// Returns whether playback is restricted to a part of the shot.
    #[must_use]
    pub(crate) const fn has_range(&self) -> bool {
        self.range.is_some()
    }

    /// Restricts playback to a range; `None`, or the whole range, plays all.
    pub(crate) fn set_range(&mut self, range: Option<[i32; 2]>) {
        self.range = range.filter(|range| range[0] <= range[1] && *range != self.shot);
    }

    /// Goes to a frame, clamped to the shot, and stops playback.
    pub(crate) fn go(&mut self, frame: i32) {
        self.frame = frame.clamp(self.shot[0], self.shot[1].max(self.shot[0]));
        self.playing = None;
    }

    /// Moves by a number of frames, wrapping around within the playback range, and stops playback. From outside the range it goes to
    /// the first frame of it, or backwards to the last.
    pub(crate) fn step(&mut self, by: i32) {
        let [first, last] = self.range();
        let count = (last - first + 1).max(1);
        let frame = match (first..=last).contains(&self.frame) {
            true => first + (self.frame - first + by).rem_euclid(count),
            false if by > 0 => first,
            false => last,
        };
        self.go(frame);
    }

    /// Returns whether the shot is playing.
    #[must_use]
    pub(crate) const fn is_playing(&self) -> bool {
        self.playing.is_some()
    }

    /// Starts or stops playback.
    pub(crate) fn toggle(&mut self, now_secs: f64) {
        self.playing = match self.playing {
            Some(_) => None,
            None => Some((now_secs, self.frame.clamp(self.range()[0], self.range()[1]))),
        };
    }

    /// Advances playback to the time `now_secs`; `is_ready`: whether the current frame is displayed already. Returns
    /// whether the current frame changed.
    pub(crate) fn tick(&mut self, now_secs: f64, is_ready: bool) -> bool {
        let Some((since, from)) = self.playing else { return false };
        let [first, last] = self.range();
        let count = i64::from(last - first + 1).max(1);
        let frame = match self.pace {
            Pace::RealTime => {
                let passed = ((now_secs - since) * self.rate).floor().max(0.0) as i64;
                first + ((i64::from(from - first) + passed).rem_euclid(count)) as i32
            }
            Pace::EveryFrame if is_ready && (now_secs - since) * self.rate >= 1.0 => {
                let next = if (first..last).contains(&self.frame) { self.frame + 1 } else { first };
                self.playing = Some((now_secs, next));
                next
            }
            Pace::EveryFrame => self.frame,
        };
        let is_other = frame != self.frame;
        self.frame = frame;
        is_other
    }

    /// Returns the seconds until the next frame is due; `None` if playback is stopped.
    #[must_use]
    pub(crate) fn due_in(&self, now_secs: f64) -> Option<f64> {
        let (since, _) = self.playing?;
        let passed = (now_secs - since) * self.rate;
        Some(((passed.floor() + 1.0 - passed) / self.rate).max(0.001))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn playhead() -> Playhead {
        Playhead::new(&FrameRange { first: 1, last: 48, rate: 24.0, clip_start: 1 })
    }

    #[test]
    fn real_time_drops_frames_and_begins_again() {
        let mut playhead = playhead();
        playhead.toggle(10.0);
        assert!(!playhead.tick(10.02, false) && playhead.frame() == 1);
        assert!(playhead.tick(10.5, false) && playhead.frame() == 13);
        assert!(playhead.tick(12.0, false) && playhead.frame() == 1);
        assert!(playhead.due_in(12.0).is_some_and(|secs| (secs - 1.0 / 24.0).abs() < 1e-9));
        playhead.toggle(12.5);
        assert!(!playhead.tick(20.0, true) && playhead.due_in(20.0).is_none());
    }

    #[test]
    fn every_frame_waits_for_each() {
        let mut playhead = playhead();
        playhead.pace = Pace::EveryFrame;
        playhead.set_range(Some([10, 12]));
        playhead.go(12);
        playhead.toggle(0.0);
        assert!(!playhead.tick(5.0, false));
        assert!(playhead.tick(5.0, true) && playhead.frame() == 10);
        assert!(!playhead.tick(5.01, true), "no faster than the shot");
        playhead.step(-1);
        assert_eq!((playhead.frame(), playhead.is_playing()), (12, false));
    }

    #[test]
    fn playback_from_outside_the_range_stays_within_it() {
        for (pace, outside) in [Pace::RealTime, Pace::EveryFrame].into_iter().flat_map(|pace| [(pace, 1), (pace, 48)]) {
            let mut playhead = playhead();
            playhead.pace = pace;
            playhead.set_range(Some([10, 12]));
            playhead.go(outside);
            playhead.toggle(0.0);
            for passed in 1..8 {
                assert!(playhead.tick(0.05 * f64::from(passed), true));
                assert!((10..=12).contains(&playhead.frame()), "{pace:?} from {outside}: {}", playhead.frame());
            }
        }
    }

    #[test]
    fn steps_from_outside_the_range_enter_it_at_an_end() {
        for (outside, by, end) in [(1, 1, 10), (1, -1, 12), (48, 1, 10), (48, -1, 12)] {
            let mut playhead = playhead();
            playhead.set_range(Some([10, 12]));
            playhead.go(outside);
            playhead.step(by);
            assert_eq!(playhead.frame(), end, "from {outside} by {by}");
        }
    }

    #[test]
    fn a_shot_that_becomes_shorter_keeps_the_playhead_and_the_range_within_it() {
        let mut playhead = playhead();
        playhead.set_range(Some([30, 40]));
        playhead.go(48);
        playhead.follow(&FrameRange { first: 5, last: 20, rate: 24.0, clip_start: 1 });
        assert_eq!((playhead.frame(), playhead.range(), playhead.has_range()), (20, [5, 20], false));
        playhead.follow(&FrameRange { first: 30, last: 60, rate: 24.0, clip_start: 1 });
        assert_eq!(playhead.frame(), 30);
    }
}
