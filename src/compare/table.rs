//! The comparison in words.
//!
//! In: entries. Out: an aligned table, a line each.

use super::Entry;
use std::fmt::Write as _;

/// Column heads, as wide as the columns.
const HEAD: &str = "method                   angle    area  pin error  flips  folded  stray  iterations        ms";

/// A table of all entries; the least distortion of each kind carries a star.
///
/// angle: mean change of a triangle corner, radians; area: mean |σ1σ2 − 1| by area; pin error and stray handles in
/// diagonals of the rest box.
#[must_use]
pub fn table<const D: usize>(entries: &[Entry<D>]) -> String {
    let least = |pick: fn(&Entry<D>) -> f64| entries.iter().map(pick).fold(f64::INFINITY, f64::min);
    let (angle, area) = (least(|entry| entry.figures.angle), least(|entry| entry.figures.area));
    let star = |is_least: bool| if is_least { '*' } else { ' ' };
    let mut text = format!("{HEAD}\n");
    for Entry { method, figures, .. } in entries {
        let (a, b) = (star(figures.angle <= angle), star(figures.area <= area));
        let _ = writeln!(
            text,
            "{method:22} {:.4}{a} {:.4}{b}  {:9.1e}  {:5}  {:6}  {:5.2}  {:10}  {:8.3}",
            figures.angle,
            figures.area,
            figures.pin_error,
            figures.flips,
            figures.folded_cells,
            figures.stray,
            figures.iterations,
            figures.ms
        );
    }
    text
}
