//! Damaged shots give errors with a place, never a panic.

use super::{GOOD, parse};
use pinwarp::shot::{Anchor, ShotError, edit};
use pinwarp::space::ScreenPoint;
use proptest::prelude::*;

/// Words that fit somewhere, put where they do not.
const WORDS: [&str; 24] = [
    "nan",
    "-inf",
    "1e999",
    "-1",
    "0",
    "99999999999999999999",
    "0xffff_ffff_ffff",
    "true",
    "\"\"",
    "''",
    "[]",
    "{}",
    "[[[[]]]]",
    "[[layer]]",
    "[layer.pin]",
    "[[layer.pin]]",
    "layer = 1",
    "keys",
    "screen",
    "\"follow\"",
    "2024-01-01",
    "\u{1F600}",
    "\n",
    "= ",
];

/// Replaces a stretch of the text, snapped to characters, by a word.
fn damaged(text: &str, at: usize, length: usize, word: &str) -> String {
    let floor = |at: usize| (0..=at.min(text.len())).rev().find(|&at| text.is_char_boundary(at)).unwrap_or(0);
    let (start, end) = (floor(at), floor(at + length));
    format!("{}{word}{}", &text[..start], &text[end..])
}

fn assert_places(error: &ShotError, text: &str) {
    let lines = text.lines().count() + 1;
    for fault in error.each() {
        match fault {
            ShotError::Invalid { line, key, what, hint, .. } => {
                assert!((1..=lines).contains(line) && !key.is_empty() && !what.is_empty() && !hint.is_empty());
            }
            ShotError::Syntax { line, column, .. } => assert!((1..=lines).contains(line) && *column >= 1),
            other => panic!("{other}"),
        }
    }
}

proptest! {
    #![proptest_config(super::random::config(2000))]

    #[test]
    fn damaged_shots_never_panic(
        damages in prop::collection::vec((0..GOOD.len(), 0..12_usize, prop::sample::select(&WORDS[..])), 1..4),
        frame in -1e3..1e3_f64,
    ) {
        let text = damages.iter().fold(GOOD.to_owned(), |text, (at, length, word)| damaged(&text, *at, *length, word));
        match parse(&text) {
            Ok(shot) => {
                for pin in (0..shot.layers.len()).flat_map(|layer| shot.pin_targets(layer, frame).pins) {
                    let said = format!("{pin:?}");
                    prop_assert!(!said.contains("NaN"), "{}", said);
                }
            }
            Err(error) => assert_places(&error, &text),
        }
        let anchor = Anchor::Screen { at: ScreenPoint::new(0.5, 0.5), frame: None };
        if let Ok(edited) = edit::add_pin(&text, None, "new", &anchor) {
            let is_toml = edited.parse::<toml_edit::DocumentMut>().is_ok();
            prop_assert!(is_toml, "{}", edited);
        }
    }

    #[test]
    fn a_value_of_another_type_is_a_fault_with_its_line(
        line in 1..34_usize,
        word in prop::sample::select(&["nan", "\"x\"", "[\"x\"]", "{ x = 1 }", "-7", "1.5", "false"][..]),
    ) {
        let mut lines: Vec<String> = GOOD.lines().map(str::to_owned).collect();
        if let Some((key, _)) = lines[line].split_once('=') {
            lines[line] = format!("{key}= {word}");
        }
        let text = lines.join("\n");
        if let Err(error) = parse(&text) {
            assert_places(&error, &text);
        }
    }
}
