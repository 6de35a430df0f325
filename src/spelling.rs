//! Handles names and counts as people write them: patterns with `*` and `?`, suggestions for misspelt names, plurals, ranges.
//!
//! In: names and numbers. Out: whether they match; phrases for messages.

use std::borrow::Cow;
use std::fmt::Display;

/// Maximum number of names listed in a hint.
const LISTED: usize = 12;

/// Pairs of words that name the sides, anywhere in a name.
const WORDS: [[&str; 2]; 4] = [["left", "right"], ["Left", "Right"], ["LEFT", "RIGHT"], ["near", "far"]];

/// Separators before a single-letter side suffix.
const SEPARATORS: [char; 4] = ['.', '_', '-', ' '];

/// Returns the valid spelling nearest to a wrong one (Jaro-Winkler similarity, ignoring case), if it is near enough.
pub(crate) fn nearest<'a>(wrong: &str, right: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let closeness = |name: &str| strsim::jaro_winkler(&wrong.to_lowercase(), &name.to_lowercase());
    let best = right.map(|name| (closeness(name), name)).max_by(|a, b| a.0.total_cmp(&b.0))?;
    (best.0 > 0.75).then_some(best.1)
}

/// Suggests how to correct a wrong name: the nearest valid one, or a list of all.
pub(crate) fn hint<'a>(wrong: &str, right: impl Iterator<Item = &'a str> + Clone) -> String {
    if let Some(name) = nearest(wrong, right.clone()) {
        return format!("did you mean \"{name}\"?");
    }
    list(right)
}

/// Lists names for a message, at most [`LISTED`] of them.
pub(crate) fn list<'a>(names: impl Iterator<Item = &'a str> + Clone) -> String {
    let shown: Vec<&str> = names.clone().take(LISTED).collect();
    let more = names.count().saturating_sub(shown.len());
    match (shown.is_empty(), more) {
        (true, _) => "there are none".into(),
        (false, 0) => format!("there are: {}", shown.join(", ")),
        (false, more) => format!("there are: {} and {more} more", shown.join(", ")),
    }
}

/// Escapes text from a file for messages: control characters, which could drive a terminal, line breaks, and invisible
/// marks that change the direction of writing.
pub(crate) fn escaped(text: &str) -> Cow<'_, str> {
    let is_harmful = |letter: char| {
        letter.is_control()
            || matches!(letter, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    if !text.contains(is_harmful) {
        return Cow::Borrowed(text);
    }
    let escape = |letter: char| match is_harmful(letter) {
        true => letter.escape_default().to_string(),
        false => letter.to_string(),
    };
    Cow::Owned(text.chars().map(escape).collect())
}

/// Formats a count with its noun: `1 frame`, `2 frames`. The noun may be followed by a verb.
pub(crate) fn pluralised<N: Display + PartialEq + From<u8>>(count: N, one: &str, many: &str) -> String {
    let words = if count == N::from(1) { one } else { many };
    format!("{count} {words}")
}

/// Formats a number: from 10^9 on in scientific notation, as hundreds of digits tell nothing.
pub(crate) fn number(value: f64) -> String {
    if value.abs() < 1e9 { value.to_string() } else { format!("{value:e}") }
}

/// Maximum number of ranges in a message.
const SHOWN_RANGES: usize = 8;

/// Formats frame numbers as ranges: `1 to 4, 7`.
pub(crate) fn ranges(frames: &[i32]) -> String {
    let mut sorted = frames.to_vec();
    sorted.sort_unstable();
    let chunks = sorted.chunk_by(|a, b| a + 1 == *b);
    let words = chunks.map(|chunk| match chunk {
        [only] => only.to_string(),
        [first, .., last] => format!("{first} to {last}"),
        [] => String::new(),
    });
    let mut words: Vec<String> = words.collect();
    if words.len() > SHOWN_RANGES {
        words.truncate(SHOWN_RANGES);
        words.push("...".to_owned());
    }
    words.join(", ")
}

/// Whether a name matches a pattern in which `*` stands for any characters and `?` for one.
///
/// On a mismatch, the last star takes one more character, so the search needs no recursion.
pub(crate) fn matches_pattern(pattern: &str, name: &str) -> bool {
    let (pattern, name): (Vec<char>, Vec<char>) = (pattern.chars().collect(), name.chars().collect());
    let (mut p, mut n) = (0, 0);
    let mut star = None;
    while n < name.len() {
        match pattern.get(p) {
            Some('*') => {
                star = Some((p, n));
                p += 1;
            }
            Some(&c) if c == '?' || c == name[n] => {
                p += 1;
                n += 1;
            }
            _ => {
                let Some((at, taken)) = star else { return false };
                star = Some((at, taken + 1));
                p = at + 1;
                n = taken + 1;
            }
        }
    }
    pattern[p..].iter().all(|c| *c == '*')
}

/// Returns the name of the other side, such as "right hand" for "left hand" and "Hand.R" for "Hand.L"; `None` if the
/// name denotes no side.
#[must_use]
pub(crate) fn other_side(name: &str) -> Option<String> {
    let both = WORDS.iter().flat_map(|[one, other]| [(one, other), (other, one)]);
    if let Some((side, other)) = { both }.find(|(side, _)| name.contains(**side)) {
        return Some(name.replacen(side, other, 1));
    }
    let (start, last) = name.split_at(name.char_indices().last()?.0);
    let other = match last {
        "l" => "r",
        "r" => "l",
        "L" => "R",
        "R" => "L",
        _ => return None,
    };
    start.ends_with(SEPARATORS).then(|| format!("{start}{other}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_in_words() {
        assert_eq!(ranges(&[4, 1, 2, 3, 7, -1]), "-1, 1 to 4, 7");
        assert!(ranges(&(0..100).map(|k| 2 * k).collect::<Vec<_>>()).ends_with("14, ..."));
    }

    #[test]
    fn large_numbers_are_short() {
        let numbers = [0.0, -0.25, 120.0, 999_999_999.0, 1e9, -1e300, f64::MAX].map(number);
        assert_eq!(numbers, ["0", "-0.25", "120", "999999999", "1e9", "-1e300", "1.7976931348623157e308"]);
        assert_eq!(number(f64::INFINITY), "inf");
    }

    #[test]
    fn one_thing_is_not_told_as_many() {
        let pins = |count: usize| pluralised(count, "pin is", "pins are");
        assert_eq!([0, 1, 2, 11].map(pins), ["0 pins are", "1 pin is", "2 pins are", "11 pins are"]);
    }

    #[test]
    fn nothing_in_a_name_drives_a_terminal() {
        assert_eq!(escaped("Möbius \"1\" 日本"), "Möbius \"1\" 日本");
        assert_eq!(escaped("a\u{1b}[31m\n\tb\r\u{7f}\u{9b}"), r"a\u{1b}[31m\n\tb\r\u{7f}\u{9b}");
        assert_eq!(escaped("a\u{202e}gpj.exe"), r"a\u{202e}gpj.exe");
    }

    #[test]
    fn patterns_match_as_people_expect() {
        for (pattern, name) in
            [("*", ""), ("Tea*", "Teapot"), ("*pot", "Teapot"), ("T?a*t", "Teapot"), ("a*b*c", "axbxbc")]
        {
            assert!(matches_pattern(pattern, name), "{pattern} matches {name}");
        }
        for (pattern, name) in [("", "x"), ("Tea", "Teapot"), ("?", ""), ("a*b*c", "axbxb"), ("tea*", "Teapot")] {
            assert!(!matches_pattern(pattern, name), "{pattern} does not match {name}");
        }
    }

    #[test]
    fn a_near_name_is_suggested_and_a_far_one_lists_all() {
        let names = ["Teapot", "Ground"];
        assert_eq!(hint("Taepot", names.into_iter()), "did you mean \"Teapot\"?");
        assert_eq!(hint("xyz", names.into_iter()), "there are: Teapot, Ground");
        assert_eq!(hint("xyz", std::iter::empty()), "there are none");
    }

    #[test]
    fn sides_go_there_and_back() {
        for (left, right) in [
            ("left hand", "right hand"),
            ("HandLeft", "HandRight"),
            ("Hand.L", "Hand.R"),
            ("ear_l", "ear_r"),
            ("near toe", "far toe"),
        ] {
            assert_eq!(other_side(left).as_deref(), Some(right));
            assert_eq!(other_side(right).as_deref(), Some(left));
        }
        for name in ["belly", "tail", "", "l", "ä"] {
            assert_eq!(other_side(name), None, "{name}");
        }
    }
}
