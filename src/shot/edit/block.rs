//! A pin as TOML, as a table or an inline table.
//!
//! In: a name and an [`Anchor`]. Out: `[[layer.pin]]` with one key that holds the point at rest.

use crate::shot::Anchor;
use crate::spelling::escaped;
use toml_edit::{Array, InlineTable, Item, Table, Value};

/// Decimals of the numbers in anchors: far below a pixel, without binary noise.
const DECIMALS: i32 = 7;

/// Formats a pin as in a shot file, held at rest by a key in the given frame, ending with a newline: for printing, or pasting
/// below a layer.
///
/// ```
/// use pinwarp::shot::{Anchor, edit};
/// use pinwarp::space::ScreenPoint;
/// let block = edit::pin_block("nose", &Anchor::Screen { at: ScreenPoint::new(0.5, 0.25), frame: None }, 1001);
/// assert_eq!(block, "  [[layer.pin]]\n  name   = \"nose\"\n  anchor = { screen = [0.5, 0.25] }
///   keys   = [ { frame = 1001, offset = [0.0, 0.0] } ]\n");
/// ```
#[must_use]
pub fn pin_block(name: &str, anchor: &Anchor, frame: i32) -> String {
    let pin = NewPin::anchored(name, anchor_table(anchor, Digits::Few), resting(i64::from(frame)));
    format!("  [[layer.pin]]\n{}", pin.table("  "))
}

/// A pin to be written.
pub(super) struct NewPin<'a> {
    pub(super) name: &'a str,
    /// Its keys after `name`, with their values.
    entries: Vec<(&'static str, Value)>,
}

/// The precision of written numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Digits {
    /// Readable: far below a pixel, without binary noise.
    Few,
    /// Lossless: they are read back bit for bit.
    #[cfg_attr(
        not(any(test, feature = "editor", feature = "ofx")),
        expect(dead_code, reason = "only the OpenFX plugin and the editor write all digits")
    )]
    All,
}

/// Returns keys that hold the rest position: a single one without offset.
pub(super) fn resting(frame: i64) -> Array {
    let mut key = InlineTable::new();
    key.insert("frame", frame.into());
    key.insert("offset", numbers(&[0.0, 0.0], Digits::Few));
    let mut keys = Array::new();
    keys.push_formatted(Value::InlineTable(key).decorated(" ", " "));
    keys
}

impl<'a> NewPin<'a> {
    /// Creates a pin with an anchor and keys.
    pub(super) fn anchored(name: &'a str, anchor: InlineTable, keys: Array) -> Self {
        Self { name, entries: vec![("anchor", Value::InlineTable(anchor)), ("keys", Value::Array(keys))] }
    }

    /// Creates a pin that follows another one, mirrored.
    #[cfg(any(test, feature = "editor"))]
    pub(super) fn mirrored(name: &'a str, of: &str) -> Self {
        Self { name, entries: vec![("mirror", of.into())] }
    }

    /// Returns its anchor, if it has one of its own.
    pub(super) fn anchor(&self) -> Option<&InlineTable> {
        self.entries.iter().find(|(key, _)| *key == "anchor").and_then(|(_, value)| value.as_inline_table())
    }

    /// Returns the pin for `[[layer.pin]]`, with every line indented.
    pub(super) fn table(&self, indent: &str) -> Table {
        let mut table = Table::new();
        table.decor_mut().set_prefix(format!("\n{indent}"));
        for (key, value) in self.entries() {
            table.insert(key, Item::Value(value));
            if let Some(mut key) = table.key_mut(key) {
                let width = "anchor ".len() - key.get().len();
                key.leaf_decor_mut().set_prefix(indent);
                key.leaf_decor_mut().set_suffix(" ".repeat(width));
            }
        }
        table
    }

    /// Returns the pin for `pin = [ {..}, {..} ]`.
    pub(super) fn inline(&self) -> InlineTable {
        self.entries().collect()
    }

    fn entries(&self) -> impl Iterator<Item = (&'static str, Value)> {
        std::iter::once(("name", self.name.into())).chain(self.entries.iter().cloned())
    }
}

/// Returns a string on one line: control characters, which could affect a terminal, are escaped.
fn one_line(text: &str) -> Value {
    if escaped(text) == text {
        return text.into();
    }
    let escape = |letter: char| match letter {
        '"' | '\\' => format!("\\{letter}"),
        _ if escaped(letter.encode_utf8(&mut [0; 4])) != letter.to_string() => format!("\\u{:04X}", u32::from(letter)),
        _ => letter.to_string(),
    };
    let quoted = format!("\"{}\"", text.chars().map(escape).collect::<String>());
    quoted.parse().unwrap_or_else(|_| text.into())
}

/// Returns `{ node = .., primitive = .., triangle = .., barycentric = [..], rest = [..] }` or `{ screen = [..], frame =
/// .. }`.
pub(super) fn anchor_table(anchor: &Anchor, digits: Digits) -> InlineTable {
    let mut table = InlineTable::new();
    match anchor {
        Anchor::Surface { node, primitive, triangle, barycentric, rest } => {
            table.insert("node", one_line(node));
            table.insert("primitive", integer(*primitive));
            table.insert("triangle", integer(*triangle));
            table.insert("barycentric", numbers(barycentric, digits));
            if let Some(rest) = rest {
                table.insert("rest", numbers(rest, digits));
            }
        }
        Anchor::Screen { at, frame } => {
            table.insert("screen", numbers(&at.0.to_array(), digits));
            if let Some(frame) = frame {
                table.insert("frame", i64::from(*frame).into());
            }
        }
    }
    table
}

fn integer(index: usize) -> Value {
    i64::try_from(index).unwrap_or(i64::MAX).into()
}

pub(super) fn numbers(values: &[f64], digits: Digits) -> Value {
    let scale = 10_f64.powi(DECIMALS);
    let rounded = |value: f64| match digits {
        Digits::Few => (value * scale).round() / scale,
        Digits::All => value,
    };
    // Adding zero turns -0 into 0.
    values.iter().map(|value| rounded(*value) + 0.0).collect()
}
