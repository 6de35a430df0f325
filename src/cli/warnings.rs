//! Condenses warnings of many frames: similar warnings of consecutive frames become one line.
//!
//! In: warnings, frame by frame. Out: lines, in order of first occurrence.

use std::collections::HashMap;

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

/// Returns a warning with every number outside quotes masked, as numbers vary from frame to frame. Quoted names, which
/// may contain digits, are kept, since they distinguish warnings.
pub(super) fn kind_of(warning: &str) -> String {
    let unquoted = |(index, piece): (usize, &str)| {
        if index % 2 == 1 {
            piece.to_owned()
        } else {
            piece.split(is_of_number).filter(|s| !s.is_empty()).collect::<Vec<_>>().join("…")
        }
    };
    warning.split('\'').enumerate().map(unquoted).collect::<Vec<_>>().join("'")
}

/// Returns the numbers outside quotes.
fn numbers_of(warning: &str) -> Vec<f64> {
    let unquoted = warning.split('\'').step_by(2);
    unquoted
        .flat_map(|piece| piece.split(|letter| !is_of_number(letter)).filter_map(|word| word.parse().ok()))
        .collect()
}

fn is_of_number(letter: char) -> bool {
    letter.is_ascii_digit() || letter == '.'
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn warnings_that_differ_in_numbers_are_of_one_kind() {
        let one = kind_of("layer 'layer1': pin 'a' is 0.12 px off its target");
        assert_eq!(one, kind_of("layer 'layer1': pin 'a' is 7.5 px off its target"));
        assert_ne!(one, kind_of("layer 'layer2': pin 'a' is 0.12 px off its target"));
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
