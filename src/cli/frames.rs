//! Parsing of frame lists and scale factors on the command line.

use crate::space::FrameSize;
use std::str::FromStr;

/// Frames in the given order, without duplicates: `1-48x2,60`; steps may also be written as in OpenJD, `1-48:2`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct FrameList(pub(super) Vec<i32>);

/// Largest frame number, as in shot files.
const MAX_FRAME: i32 = 1_000_000;

impl FromStr for FrameList {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut frames = Vec::new();
        let mut seen = std::collections::HashSet::new();
        for item in text.split(',') {
            let (first, last, step) = range(item.trim())
                .ok_or_else(|| format!("'{}' is not a frame or a range; write for example 1-48x2,60", item.trim()))?;
            if last < first || step < 1 {
                return Err(format!("'{}' holds no frame; ranges go up and steps are at least 1", item.trim()));
            }
            if first < -MAX_FRAME || last > MAX_FRAME {
                return Err(format!("'{}' leaves the range of frames, {} to {MAX_FRAME}", item.trim(), -MAX_FRAME));
            }
            frames.extend((first..=last).step_by(step as usize).filter(|&frame| seen.insert(frame)));
        }
        Ok(Self(frames))
    }
}

/// Parses first frame, last frame and step of `7`, `1-48`, `1-48x2`, `1-48:2`, `-5--1`.
fn range(item: &str) -> Option<(i32, i32, i32)> {
    let (span, step) = match item.split_once(['x', ':']) {
        Some((span, step)) => (span, step.parse().ok()?),
        None => (item, 1),
    };
    // The first character may be the sign of the first number.
    let dash = span.char_indices().skip(1).find(|&(_, letter)| letter == '-').map(|(at, _)| at);
    match dash {
        Some(at) => Some((span[..at].parse().ok()?, span[at + 1..].parse().ok()?, step)),
        None => {
            let frame = span.parse().ok()?;
            Some((frame, frame, step))
        }
    }
}

/// Resolution relative to the shot's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scale(f64);

impl FromStr for Scale {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| text.trim().parse::<f64>().ok();
        let factor = match (text.split_once('/'), text.strip_suffix('%')) {
            (Some((above, below)), _) => number(above).zip(number(below)).map(|(above, below)| above / below),
            (None, Some(percent)) => number(percent).map(|percent| percent / 100.0),
            (None, None) => number(text),
        };
        factor
            .filter(|factor| factor.is_finite() && *factor > 0.0 && *factor <= 16.0)
            .map(Self)
            .ok_or_else(|| "a factor above 0 and up to 16 is needed, e.g. 1/2, 0.5 or 50%".to_owned())
    }
}

impl Scale {
    /// Returns the scaled frame size, at least one pixel on each side.
    pub(super) fn of(self, size: FrameSize) -> FrameSize {
        size.scaled(self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_of_frames() {
        let list = |text: &str| text.parse::<FrameList>().map(|list| list.0);
        assert_eq!(list("1-7x2, 60,3"), Ok(vec![1, 3, 5, 7, 60]));
        assert_eq!(list("1001-1003,1-5:2"), Ok(vec![1001, 1002, 1003, 1, 3, 5]));
        assert_eq!(list("-2-1"), Ok(vec![-2, -1, 0, 1]));
        assert_eq!(list("-3--2"), Ok(vec![-3, -2]));
        for wrong in ["", "a", "5-1", "1-5x0", "1-", "1,,2", "1-5x-1", "0-99999999", "2147483647", "-2147483648"] {
            assert!(list(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn scales() {
        let scaled = |text: &str| text.parse::<Scale>().map(|scale| scale.of(FrameSize::new(1920, 1080)).height);
        assert_eq!((scaled("1/2"), scaled("50%"), scaled("0.25")), (Ok(540), Ok(540), Ok(270)));
        assert!(scaled("0").is_err() && scaled("1/0").is_err() && scaled("-1").is_err() && scaled("x").is_err());
    }
}
