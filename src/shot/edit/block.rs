//! A pin as TOML text, table and inline table.
//!
//! In: a name and an [`Anchor`]. Out: `[[layer.pin]]` with one key that leaves the point where it is.

use crate::shot::Anchor;
use toml_edit::{Array, InlineTable, Item, Table, Value};

/// Numbers of anchors are written with this many decimals: far below a pixel, free of binary noise.
const DECIMALS: i32 = 7;

/// A pin as it stands in a shot file, ending with a newline: to print, or to paste below a layer.
///
/// ```
/// use pinwarp::shot::{Anchor, edit};
/// use pinwarp::space::ScreenPoint;
/// let block = edit::pin_block("nose", &Anchor::Screen { at: ScreenPoint::new(0.5, 0.25), frame: None });
/// assert_eq!(block, "  [[layer.pin]]\n  name   = \"nose\"\n  anchor = { screen = [0.5, 0.25] }
///   keys   = [ { frame = 1, offset = [0.0, 0.0] } ]\n");
/// ```
#[must_use]
pub fn pin_block(name: &str, anchor: &Anchor) -> String {
    format!("  [[layer.pin]]\n{}", NewPin { name, anchor, first_frame: 1 }.table("  "))
}

/// A pin about to be written.
pub(super) struct NewPin<'a> {
    pub(super) name: &'a str,
    pub(super) anchor: &'a Anchor,
    pub(super) first_frame: i64,
}

impl NewPin<'_> {
    /// For `[[layer.pin]]`, each line indented.
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

    /// For `pin = [ {..}, {..} ]`.
    pub(super) fn inline(&self) -> InlineTable {
        self.entries().into_iter().collect()
    }

    fn entries(&self) -> [(&'static str, Value); 3] {
        let mut key = InlineTable::new();
        key.insert("frame", self.first_frame.into());
        key.insert("offset", numbers(&[0.0, 0.0]));
        let mut keys = Array::new();
        keys.push_formatted(Value::InlineTable(key).decorated(" ", " "));
        [
            ("name", self.name.into()),
            ("anchor", Value::InlineTable(anchor_table(self.anchor))),
            ("keys", Value::Array(keys)),
        ]
    }
}

/// `{ node = .., primitive = .., triangle = .., barycentric = [..], rest = [..] }` or `{ screen = [..], frame = .. }`.
pub(super) fn anchor_table(anchor: &Anchor) -> InlineTable {
    let mut table = InlineTable::new();
    match anchor {
        Anchor::Surface { node, primitive, triangle, barycentric, rest } => {
            table.insert("node", node.as_str().into());
            table.insert("primitive", integer(*primitive));
            table.insert("triangle", integer(*triangle));
            table.insert("barycentric", numbers(barycentric));
            if let Some(rest) = rest {
                table.insert("rest", numbers(rest));
            }
        }
        Anchor::Screen { at, frame } => {
            table.insert("screen", numbers(&at.0.to_array()));
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

fn numbers(values: &[f64]) -> Value {
    let scale = 10_f64.powi(DECIMALS);
    // Adding zero turns -0 into 0.
    values.iter().map(|value| (value * scale).round() / scale + 0.0).collect()
}
