//! The comparison as a text table.
//!
//! In: entries. Out: an aligned table, one line per entry.

use super::Entry;
use std::fmt::Write as _;

/// Column headings, as wide as the columns.
const HEAD: &str =
    "method                  basis        angle    area  pin error  flips  folded  stray  iterations        ms";

/// Formats a table of all entries; the smallest distortion of each kind is marked with a star.
///
/// angle: mean change of a triangle corner, radians; area: mean |σ1σ2 − 1| by area; pin error and stray handles in
/// diagonals of the rest box.
#[must_use]
pub(crate) fn table<const D: usize>(entries: &[Entry<D>]) -> String {
    let least = |pick: fn(&Entry<D>) -> f64| entries.iter().map(pick).fold(f64::INFINITY, f64::min);
    let (angle, area) = (least(|entry| entry.metrics.angle), least(|entry| entry.metrics.area));
    let star = |is_least: bool| if is_least { '*' } else { ' ' };
    let mut text = format!("{HEAD}\n");
    for Entry { method, basis, metrics, .. } in entries {
        let (a, b) = (star(metrics.angle <= angle), star(metrics.area <= area));
        let _ = writeln!(
            text,
            "{method:22}  {:9} {:.4}{a} {:.4}{b}  {:9.1e}  {:5}  {:6}  {:5.2}  {:10}  {:8.3}",
            basis.label(),
            metrics.angle,
            metrics.area,
            metrics.pin_error,
            metrics.flips,
            metrics.folded_cells,
            metrics.stray,
            metrics.iterations,
            metrics.ms
        );
    }
    text
}
