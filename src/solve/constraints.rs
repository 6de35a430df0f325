//! Hard pins: rows that hold exactly, whatever the rest of the energy says.
//!
//! In: the factored matrix A, and C, the rows of full weight of pins and moved handles.
//! Out: after every linear solve P ← P + A⁻¹Cᵀ (C A⁻¹ Cᵀ)⁺ (d − C P), the solution of the KKT system
//! (J. Nocedal and S. Wright, "Numerical Optimization", 2006, section 16.2, the Schur-complement method).

use super::matrix::{Factor, pseudo_inverse};
use super::solver::Terms;
use super::{PinHold, PointPin, Settings};

/// Directions of C A⁻¹ Cᵀ below this part of its largest are not forced. A holds the rows at the weight of the pins
/// already, so only what would cost the shape ten thousand times as much as a pin pays falls below: pins closer than
/// about 1e-5 of the box, and more pins in a cell than it has handles.
const CUTOFF: f64 = 1e-4;

/// Part of a row's direction that must be left out before the row is told to be in conflict.
const SHARE: f64 = 1e-3;

/// A row that holds exactly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Held {
    /// Row of the pins' terms, and the pin it belongs to.
    Pin { row: usize, pin: usize },
    /// Entry of the moved handles.
    Handle { row: usize },
}

/// Who holds a row that another row contradicts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Holder {
    /// A pin, by index.
    Pin(usize),
    /// An entry of the moved handles.
    Handle(usize),
}

/// All rows that hold exactly, with what enforces them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Constraints {
    held: Vec<Held>,
    /// A⁻¹Cᵀ(C A⁻¹ Cᵀ)⁺, #rows times #handles: how the handles answer to a miss of 1.
    answers: Vec<f64>,
    /// The row of another pin or handle that a row depends on most, where they cannot all hold; its own number where only
    /// rows of its own pin stand against it.
    partners: Vec<Option<usize>>,
}

impl Constraints {
    /// The rows of full weight, eliminated once.
    pub(crate) fn new<const D: usize>(
        factor: &Factor,
        (terms, handle_count): (&Terms<D>, usize),
        pins: &[PointPin<D>],
        settings: &Settings,
    ) -> Self {
        let held = match settings.pin_hold {
            PinHold::Soft => Vec::new(),
            PinHold::Hard => held_rows(pins, terms.handles.len()),
        };
        if held.is_empty() {
            return Self::default();
        }
        let mut responses = vec![0.0; held.len() * handle_count];
        for (rows, columns) in held.chunks(D).zip(responses.chunks_mut(D * handle_count)) {
            respond(factor, terms, rows, columns);
        }
        let schur: Vec<f64> = responses
            .chunks_exact(handle_count)
            .flat_map(|column| held.iter().map(|row| row.entries(terms).iter().map(|&(h, c)| c * column[h]).sum()))
            .collect();
        let (inverse, dropped) = pseudo_inverse(&schur, held.len(), CUTOFF);
        let mut answers = vec![0.0; responses.len()];
        for (answer, factors) in answers.chunks_exact_mut(handle_count).zip(inverse.chunks_exact(held.len())) {
            for (factor, response) in factors.iter().zip(responses.chunks_exact(handle_count)) {
                answer.iter_mut().zip(response).for_each(|(slot, x)| *slot += factor * x);
            }
        }
        Self { partners: partners(&dropped, &held), held, answers }
    }

    /// Brings the handles of a linear solve onto all rows. `misses` is scratch space.
    pub(crate) fn enforce<const D: usize>(
        &self,
        terms: &Terms<D>,
        misses: &mut Vec<[f64; D]>,
        handles: &mut [[f64; D]],
    ) {
        misses.clear();
        misses.extend(self.held.iter().map(|row| row.miss(terms, handles)));
        for (answer, miss) in self.answers.chunks_exact(handles.len().max(1)).zip(misses) {
            for (handle, factor) in handles.iter_mut().zip(answer) {
                (0..D).for_each(|d| handle[d] -= factor * miss[d]);
            }
        }
    }

    /// The other pin or handle that keeps a pin from its target; the pin itself where its own rows do.
    pub(crate) fn rival(&self, pin: usize) -> Option<Holder> {
        let mut rivals = self.rows_of(pin).filter_map(|row| Some(self.held[self.partners[row]?].holder()));
        let first = rivals.next()?;
        Some(std::iter::once(first).chain(rivals).find(|rival| *rival != Holder::Pin(pin)).unwrap_or(first))
    }

    fn rows_of(&self, wanted: usize) -> impl Iterator<Item = usize> + '_ {
        let is_of = move |held: &Held| matches!(held, Held::Pin { pin, .. } if *pin == wanted);
        (0..self.held.len()).filter(move |&row| is_of(&self.held[row]))
    }
}

impl Held {
    fn holder(self) -> Holder {
        match self {
            Self::Pin { pin, .. } => Holder::Pin(pin),
            Self::Handle { row } => Holder::Handle(row),
        }
    }

    fn entries<const D: usize>(self, terms: &Terms<D>) -> &[(usize, f64)] {
        match self {
            Self::Pin { row, .. } => terms.pins.row(row),
            Self::Handle { row } => terms.handles.row(row),
        }
    }

    fn miss<const D: usize>(self, terms: &Terms<D>, handles: &[[f64; D]]) -> [f64; D] {
        match self {
            Self::Pin { row, .. } => terms.pins.miss(row, handles),
            Self::Handle { row } => terms.handles.miss(row, handles),
        }
    }
}

/// Rows of the pins that have not begun to fade, and of all moved handles.
fn held_rows<const D: usize>(pins: &[PointPin<D>], handles: usize) -> Vec<Held> {
    let mut held = Vec::new();
    let mut row = 0;
    for (pin, point) in pins.iter().enumerate() {
        // A pin that wants a gradient has one row an axis after its own.
        let count = 1 + point.gradient.map_or(0, |_| D);
        if point.weight >= 1.0 {
            held.extend((row..row + count).map(|row| Held::Pin { row, pin }));
        }
        row += count;
    }
    held.extend((0..handles).map(|row| Held::Handle { row }));
    held
}

/// A⁻¹ times up to D rows at once; `columns`: one after the other, #handles each.
fn respond<const D: usize>(factor: &Factor, terms: &Terms<D>, rows: &[Held], columns: &mut [f64]) {
    let handle_count = columns.len() / rows.len();
    let mut right_side = vec![[0.0; D]; handle_count];
    for (d, row) in rows.iter().enumerate() {
        row.entries(terms).iter().for_each(|&(handle, coefficient)| right_side[handle][d] += coefficient);
    }
    factor.solve(&mut right_side);
    for (d, column) in columns.chunks_exact_mut(handle_count).enumerate() {
        column.iter_mut().zip(&right_side).for_each(|(slot, x)| *slot = x[d]);
    }
}

/// For each row that has a share in the directions left out, the row of another pin or handle it shares most with, or
/// itself where there is none.
fn partners(dropped: &[f64], held: &[Held]) -> Vec<Option<usize>> {
    let of = |(row, shares): (usize, &[f64])| {
        let others = (0..held.len()).filter(|&other| held[other].holder() != held[row].holder());
        let others = others.filter(|&other| shares[other].abs() > SHARE);
        let nearest = others.reduce(|best, other| if shares[other].abs() > shares[best].abs() { other } else { best });
        (shares[row] > SHARE).then(|| nearest.unwrap_or(row))
    };
    dropped.chunks_exact(held.len().max(1)).enumerate().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pin_is_its_own_rival_only_where_nobody_else_is() {
        let row = |row: usize, pin: usize| Held::Pin { row, pin };
        // Two pins with a place and two axes each; rows along the diagonal share with those named.
        let held: Vec<Held> = (0..6).map(|k| row(k, k / 3)).collect();
        let mut dropped = vec![0.0; 36];
        let mut share = |a: usize, b: usize, x: f64| [6 * a + b, 6 * b + a].into_iter().for_each(|k| dropped[k] = x);
        [(0, 0, 0.5), (0, 1, 0.4), (0, 4, 0.1), (1, 1, 0.5), (4, 4, 0.1)]
            .into_iter()
            .for_each(|(a, b, x)| share(a, b, x));
        let constraints = Constraints { partners: partners(&dropped, &held), held: held.clone(), answers: Vec::new() };
        assert_eq!(constraints.partners, [Some(4), Some(1), None, None, Some(0), None]);
        assert_eq!([0, 1].map(|pin| constraints.rival(pin)), [Some(Holder::Pin(1)), Some(Holder::Pin(0))]);
        let alone: Vec<f64> =
            dropped.iter().enumerate().map(|(k, x)| if k % 6 < 3 && k / 6 < 3 { *x } else { 0.0 }).collect();
        let constraints = Constraints { partners: partners(&alone, &held), held, answers: Vec::new() };
        assert_eq!([0, 1].map(|pin| constraints.rival(pin)), [Some(Holder::Pin(0)), None]);
    }
}
