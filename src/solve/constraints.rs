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
    /// The row that a row depends on most, where they cannot all hold.
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
        Self { partners: partners(&dropped, held.len()), held, answers }
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

    /// The other pin or handle that keeps a pin from its target.
    pub(crate) fn rival(&self, pin: usize) -> Option<Holder> {
        let partner = self.rows_of(pin).find_map(|row| self.partners[row])?;
        Some(match self.held[partner] {
            Held::Pin { pin, .. } => Holder::Pin(pin),
            Held::Handle { row } => Holder::Handle(row),
        })
    }

    fn rows_of(&self, wanted: usize) -> impl Iterator<Item = usize> + '_ {
        let is_of = move |held: &Held| matches!(held, Held::Pin { pin, .. } if *pin == wanted);
        (0..self.held.len()).filter(move |&row| is_of(&self.held[row]))
    }
}

impl Held {
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

/// For each row that has a share in the directions left out, the row it shares most with.
fn partners(dropped: &[f64], count: usize) -> Vec<Option<usize>> {
    let of = |(row, shares): (usize, &[f64])| {
        let others = (0..count).filter(|&other| other != row);
        let nearest = others.reduce(|best, other| if shares[other].abs() > shares[best].abs() { other } else { best });
        nearest.filter(|_| shares[row] > SHARE)
    };
    dropped.chunks_exact(count.max(1)).enumerate().map(of).collect()
}
