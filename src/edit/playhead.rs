//! The frame that is seen, and how it moves when the shot plays.
//!
//! In: the clock, what the user asks. Out: frame numbers.

use crate::shot::FrameRange;

/// How frames follow each other while the shot plays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pace {
    /// As fast as the shot's rate; frames that are not ready are left out.
    #[default]
    RealTime,
    /// Every frame, as fast as they are ready.
    EveryFrame,
}

/// Where the shot is, and whether it plays.
#[derive(Clone, Copy, Debug)]
pub struct Playhead {
    frame: i32,
    shot: [i32; 2],
    /// First and last frame that is played, instead of all.
    range: Option<[i32; 2]>,
    rate: f64,
    /// When it began to play, seconds, and from which frame.
    playing: Option<(f64, i32)>,
    /// How it plays.
    pub pace: Pace,
}

impl Playhead {
    /// At the first frame of a shot.
    #[must_use]
    pub fn new(frames: &FrameRange) -> Self {
        let shot = [frames.first, frames.last];
        Self { frame: frames.first, shot, range: None, rate: frames.rate, playing: None, pace: Pace::default() }
    }

    /// The shot has other frames now.
    pub fn follow(&mut self, frames: &FrameRange) {
        self.shot = [frames.first, frames.last];
        self.rate = frames.rate;
        self.range = self.range.filter(|[first, last]| *first >= self.shot[0] && *last <= self.shot[1]);
        self.frame = self.frame.clamp(self.shot[0], self.shot[1].max(self.shot[0]));
    }

    /// The frame that is seen.
    #[must_use]
    pub const fn frame(&self) -> i32 {
        self.frame
    }

    /// First and last frame of the shot.
    #[must_use]
    pub const fn shot_range(&self) -> [i32; 2] {
        self.shot
    }

    /// First and last frame that is played.
    #[must_use]
    pub fn range(&self) -> [i32; 2] {
        self.range.unwrap_or(self.shot)
    }

    /// Whether only a part is played.
    #[must_use]
    pub const fn has_range(&self) -> bool {
        self.range.is_some()
    }

    /// Plays a part alone; `None` and the whole range play all.
    pub fn set_range(&mut self, range: Option<[i32; 2]>) {
        self.range = range.filter(|range| range[0] <= range[1] && *range != self.shot);
    }

    /// Goes to a frame of the shot.
    pub fn go(&mut self, frame: i32) {
        self.frame = frame.clamp(self.shot[0], self.shot[1].max(self.shot[0]));
        self.playing = None;
    }

    /// Goes so many frames on, around the ends of what is played.
    pub fn step(&mut self, by: i32) {
        let [first, last] = self.range();
        let count = (last - first + 1).max(1);
        let frame = first + (self.frame - first + by).rem_euclid(count);
        self.go(frame);
    }

    /// Whether it plays.
    #[must_use]
    pub const fn is_playing(&self) -> bool {
        self.playing.is_some()
    }

    /// Begins to play, or ends.
    pub fn toggle(&mut self, now_secs: f64) {
        self.playing = match self.playing {
            Some(_) => None,
            None => Some((now_secs, self.frame.clamp(self.range()[0], self.range()[1]))),
        };
    }

    /// The clock goes on; `is_ready` tells whether the frame that is asked for is seen already. Gives whether another frame is to be
    /// seen now.
    pub fn tick(&mut self, now_secs: f64, is_ready: bool) -> bool {
        let Some((since, from)) = self.playing else { return false };
        let [first, last] = self.range();
        let count = i64::from(last - first + 1).max(1);
        let frame = match self.pace {
            Pace::RealTime => {
                let passed = ((now_secs - since) * self.rate).floor().max(0.0) as i64;
                first + ((i64::from(from - first) + passed).rem_euclid(count)) as i32
            }
            Pace::EveryFrame if is_ready && (now_secs - since) * self.rate >= 1.0 => {
                let next = if self.frame >= last { first } else { self.frame + 1 };
                self.playing = Some((now_secs, next));
                next
            }
            Pace::EveryFrame => self.frame,
        };
        let is_other = frame != self.frame;
        self.frame = frame;
        is_other
    }

    /// Seconds until the next frame is due; `None`: it does not play.
    #[must_use]
    pub fn due_in(&self, now_secs: f64) -> Option<f64> {
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
}
