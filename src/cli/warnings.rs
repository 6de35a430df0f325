//! Condenses warnings of many frames: similar warnings of consecutive frames become one line.
//!
//! In: warnings, frame by frame. Out: lines, in order of first occurrence.

use std::collections::HashMap;
use std::ops::Range;

/// Maximum gap in frames within one event: a single kink in a motion affects four frames.
const GAP: i32 = 3;

/// Collects warnings.
#[derive(Debug, Default)]
pub(super) struct Warnings {
    events: Vec<Event>,
    /// Index of the last event of each kind.
    last: HashMap<String, usize>,
}

/// Consecutive frames with the same kind of warning.
#[derive(Debug)]
struct Event {
    first: i32,
    last: i32,
    /// The warning with the largest numbers.
    text: String,
}

impl Warnings {
    /// Adds a warning; frames must be in increasing order.
    pub(super) fn add(&mut self, frame: i32, warning: &str) {
        let kind = kind_of(warning);
        if let Some(event) = self.last.get(&kind).and_then(|&event| self.events.get_mut(event))
            && (frame - GAP..=frame).contains(&event.last)
        {
            event.last = frame;
            if numbers_of(&event.text).partial_cmp(&numbers_of(warning)).is_some_and(std::cmp::Ordering::is_lt) {
                warning.clone_into(&mut event.text);
            }
            return;
        }
        self.last.insert(kind, self.events.len());
        self.events.push(Event { first: frame, last: frame, text: warning.to_owned() });
    }

    /// Returns one line per event.
    pub(super) fn lines(&self) -> impl Iterator<Item = String> {
        self.events.iter().map(|Event { first, last, text }| {
            if first == last {
                format!("warning: frame {first}: {text}")
            } else {
                format!("warning: frames {first} to {last}: {text}")
            }
        })
    }
}

/// Returns a warning with its numbers masked, as they vary from frame to frame. Names, which may contain digits, are kept, since
/// they distinguish warnings: all that is quoted, and words with letters.
pub(super) fn kind_of(warning: &str) -> String {
    let mut kind = String::new();
    let mut kept = 0;
    for number in numbers(warning) {
        kind.push_str(&warning[kept..number.start]);
        kind.push('…');
        kept = number.end;
    }
    kind + &warning[kept..]
}

/// Returns the numbers of a warning.
fn numbers_of(warning: &str) -> Vec<f64> {
    numbers(warning).into_iter().filter_map(|number| warning[number].parse().ok()).collect()
}

/// Returns where the numbers of a warning are: words without letters that are not quoted.
fn numbers(warning: &str) -> Vec<Range<usize>> {
    let mut numbers = Vec::new();
    let mut start = 0;
    for (index, piece) in warning.split('\'').enumerate() {
        let mut at = start;
        for word in piece.split(|letter| !is_of_word(letter)) {
            let bare = word.trim_end_matches('.');
            if index % 2 == 0 && bare.parse::<f64>().is_ok_and(f64::is_finite) {
                numbers.push(at..at + bare.len());
            }
            at += word.len();
            at += warning[at..].chars().next().map_or(0, char::len_utf8);
        }
        start += piece.len() + 1;
    }
    numbers
}

fn is_of_word(letter: char) -> bool {
    letter.is_alphanumeric() || matches!(letter, '.' | '_' | '-')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn warnings_that_differ_in_numbers_are_of_one_kind() {
        let one = kind_of("layer 'layer1': pin 'a' is 0.12 px off its target");
        assert_eq!(one, kind_of("layer 'layer1': pin 'a' is 7.5 px off its target"));
        assert_ne!(one, kind_of("layer 'layer2': pin 'a' is 0.12 px off its target"));
        assert_eq!(one, "layer 'layer1': pin 'a' is … px off its target");
    }

    #[test]
    fn names_with_digits_are_no_numbers() {
        let kind = kind_of("2 of 3 channels of light_2.R, Z2 and é5.crypto00 are 10.5 % darker than -0.5.");
        assert_eq!(kind, "… of … channels of light_2.R, Z2 and é5.crypto00 are … % darker than ….");
    }

    #[test]
    fn frames_in_a_row_are_one_line_with_the_greatest_numbers() {
        let mut warnings = Warnings::default();
        for (frame, px) in [(3, 4.0), (4, 11.5), (5, 9.0), (7, 2.5), (20, 3.0)] {
            warnings.add(frame, &format!("layer 'arm2': the warp jerks by {px:.1} px"));
            warnings.add(frame, "layer 'leg': nothing of it is in sight");
        }
        let lines: Vec<String> = warnings.lines().collect();
        assert_eq!(
            lines,
            [
                "warning: frames 3 to 7: layer 'arm2': the warp jerks by 11.5 px",
                "warning: frames 3 to 7: layer 'leg': nothing of it is in sight",
                "warning: frame 20: layer 'arm2': the warp jerks by 3.0 px",
                "warning: frame 20: layer 'leg': nothing of it is in sight",
            ]
        );
    }
}
