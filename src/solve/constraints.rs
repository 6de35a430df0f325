//! Hard constraints: rows of pins and moved handles that are met exactly.
//!
//! In: the factored matrix A; C, the full-weight rows of pins and moved handles; Z, the compliance of pins that give way.
//! Out: after every linear solve P ← P + A⁻¹Cᵀ (C A⁻¹ Cᵀ + Z)⁺ (d − C P), the solution of the KKT system (J. Nocedal and S.
//! Wright, "Numerical Optimization", 2006, section 16.2, the Schur-complement method).

use super::cancel::{Cancel, Cancelled};
use super::least_squares::LeastSquaresRows;
use super::linalg::factorization::Factorization;
use super::linalg::normal_matrix::NormalMatrix;
use super::linalg::pseudo_inverse::PseudoInverse;
use super::overdetermined::{Limits, Overdetermined};
use super::problem::PointPin;
use super::settings::{PinHold, Settings};
use super::terms::Terms;

/// Eigenvectors of C A⁻¹ Cᵀ with eigenvalues below this fraction of the largest fade out; below a tenth of it they are not
/// enforced. A already contains the rows with the weight of the pins, so only directions that cost ten thousand times as much
/// shape energy as pin energy are affected: those of pins closer than about 1e-5 of the box, and of more pins in a cell than it
/// has handles.
const CUTOFF: f64 = 1e-4;

/// Part of a row that must lie in the directions left out for the row to count as in conflict.
const MIN_CONFLICT: f64 = 1e-3;

/// A row that is enforced exactly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ConstraintRow {
    /// A row of the pin terms, and the index of its pin.
    Pin { row: usize, pin: usize },
    /// An entry of the moved handles.
    Handle { row: usize },
}

/// The pin or moved handle that a constraint row belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ConstraintOwner {
    /// A pin, by index.
    Pin(usize),
    /// A moved handle, by its index in the list.
    Handle(usize),
}

/// All rows that are enforced exactly, with the operator that enforces them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Constraints {
    held: Vec<ConstraintRow>,
    correction: Correction,
    /// For each row in conflict the row of another pin or handle on which it depends most; its own index where only rows of the
    /// same pin contradict it.
    rivals: Vec<Option<usize>>,
}

/// Operator that maps residuals of the rows to a correction of the handles.
#[derive(Clone, Debug)]
enum Correction {
    /// A⁻¹Cᵀ(C A⁻¹ Cᵀ)⁺, #rows × #handles.
    ByRow(Vec<f64>),
    /// The factors (C A⁻¹ Cᵀ)⁺ and A⁻¹Cᵀ, for many rows: forming their product would cost more than it saves.
    Factored { inverse: Vec<f64>, responses: Vec<f64> },
    /// A matrix of #handles² that acts on Cᵀ times the residuals, for more rows than handles; see [`Overdetermined`].
    ByHandle(Vec<f64>),
}

impl Default for Correction {
    fn default() -> Self {
        Self::ByRow(Vec::new())
    }
}

/// A matrix and its factorisation.
#[derive(Clone, Copy)]
pub(crate) struct FactoredMatrix<'a> {
    pub(crate) normal: &'a NormalMatrix,
    pub(crate) factor: &'a Factorization,
}

impl Constraints {
    /// Collects the rows of full weight and computes the correction operator.
    pub(crate) fn new<const D: usize>(
        FactoredMatrix { normal, factor }: FactoredMatrix,
        terms: &Terms<D>,
        pins: &[PointPin<D>],
        settings: &Settings,
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        let held = match settings.pin_hold {
            PinHold::Soft => Vec::new(),
            PinHold::Hard => constraint_rows(pins, terms.handles.len()),
        };
        if held.is_empty() {
            return Ok(Self::default());
        }
        if held.len() > normal.size && terms.yielding.is_none() {
            let rows: Vec<&[(usize, f64)]> = held.iter().map(|row| row.entries(terms)).collect();
            let owner = |row: usize| match held[row] {
                ConstraintRow::Pin { pin, .. } => pin,
                ConstraintRow::Handle { row } => pins.len() + row,
            };
            let limits = Limits { cutoff: CUTOFF, conflict: MIN_CONFLICT };
            if let Some(Overdetermined { correction, rivals }) =
                Overdetermined::new(normal, (&rows, &owner), limits, cancel)?
            {
                return Ok(Self { held, correction: Correction::ByHandle(correction), rivals });
            }
        }
        let responses = responses(factor, terms, (&held, normal.size), cancel)?;
        let mut schur: Vec<f64> = responses
            .chunks_exact(normal.size)
            .flat_map(|column| held.iter().map(|row| row.entries(terms).iter().map(|&(h, c)| c * column[h]).sum()))
            .collect();
        add_compliance(terms, &held, &mut schur);
        let PseudoInverse { inverse, dropped } = PseudoInverse::new(&schur, held.len(), CUTOFF, cancel)?;
        let correction = if held.len() > MAX_MULTIPLIED {
            Correction::Factored { inverse, responses }
        } else {
            Correction::ByRow(product(&inverse, &responses, held.len()))
        };
        Ok(Self { rivals: rivals(&dropped, &held), held, correction })
    }

    /// Corrects the handles after a linear solve so that all rows are met. `residuals` is scratch space.
    pub(crate) fn enforce<const D: usize>(
        &self,
        terms: &Terms<D>,
        residuals: &mut Vec<[f64; D]>,
        handles: &mut [[f64; D]],
    ) {
        residuals.clear();
        residuals.extend(self.held.iter().map(|row| row.residual(terms, handles)));
        self.correct(terms, residuals, handles);
    }

    /// Projects a direction onto those that move no row.
    pub(crate) fn project<const D: usize>(
        &self,
        terms: &Terms<D>,
        residuals: &mut Vec<[f64; D]>,
        direction: &mut [[f64; D]],
    ) {
        residuals.clear();
        residuals.extend(self.held.iter().map(|row| row.image(terms, direction)));
        self.correct(terms, residuals, direction);
    }

    fn correct<const D: usize>(&self, terms: &Terms<D>, residuals: &[[f64; D]], handles: &mut [[f64; D]]) {
        match &self.correction {
            Correction::ByRow(rows) => subtract_product(rows, residuals, handles),
            Correction::Factored { inverse, responses } => {
                let mut weights = vec![[0.0; D]; residuals.len()];
                subtract_product(inverse, residuals, &mut weights);
                weights.iter_mut().for_each(|weight| *weight = weight.map(|x| -x));
                subtract_product(responses, &weights, handles);
            }
            Correction::ByHandle(rows) => {
                let mut gathered = vec![[0.0; D]; handles.len()];
                for (row, residual) in self.held.iter().zip(residuals) {
                    for &(handle, coefficient) in row.entries(terms) {
                        (0..D).for_each(|d| gathered[handle][d] += coefficient * residual[d]);
                    }
                }
                subtract_product(rows, &gathered, handles);
            }
        }
    }

    /// The pin or handle that contradicts a pin; the pin itself where its own rows contradict each other.
    pub(crate) fn rival(&self, pin: usize) -> Option<ConstraintOwner> {
        let mut owners = self.rows_of(pin).filter_map(|row| Some(self.held[(*self.rivals.get(row)?)?].owner()));
        let first = owners.next()?;
        Some(std::iter::once(first).chain(owners).find(|owner| *owner != ConstraintOwner::Pin(pin)).unwrap_or(first))
    }

    /// Indices of the rows of a pin, which are contiguous and in the order of the pins.
    fn rows_of(&self, wanted: usize) -> std::ops::Range<usize> {
        let is_before = |row: &ConstraintRow, last: usize| matches!(row, ConstraintRow::Pin { pin, .. } if *pin < last);
        let start = self.held.partition_point(|row| is_before(row, wanted));
        start..self.held.partition_point(|row| is_before(row, wanted + 1))
    }
}

impl ConstraintRow {
    fn owner(self) -> ConstraintOwner {
        match self {
            Self::Pin { pin, .. } => ConstraintOwner::Pin(pin),
            Self::Handle { row } => ConstraintOwner::Handle(row),
        }
    }

    fn entries<const D: usize>(self, terms: &Terms<D>) -> &[(usize, f64)] {
        let (rows, row) = self.place(terms);
        rows.row(row)
    }

    fn image<const D: usize>(self, terms: &Terms<D>, direction: &[[f64; D]]) -> [f64; D] {
        match self {
            Self::Pin { row, .. } => terms.pins.image(row, direction),
            Self::Handle { row } => terms.handles.image(row, direction),
        }
    }

    fn residual<const D: usize>(self, terms: &Terms<D>, handles: &[[f64; D]]) -> [f64; D] {
        let (rows, row) = self.place(terms);
        rows.residual(row, handles)
    }

    /// Returns the set that holds the row, and its index there. A pin that gives way has a row in the set of yielding rows.
    fn place<const D: usize>(self, terms: &Terms<D>) -> (&LeastSquaresRows<D>, usize) {
        match self {
            Self::Pin { row, .. } => {
                let yielding = terms.yielding.as_ref().and_then(|yielding| yielding.held(row));
                yielding.unwrap_or((&terms.pins, row))
            }
            Self::Handle { row } => (&terms.handles, row),
        }
    }
}

/// Lists the rows of pins of full weight and of all moved handles.
fn constraint_rows<const D: usize>(pins: &[PointPin<D>], handles: usize) -> Vec<ConstraintRow> {
    let mut held = Vec::new();
    let mut row = 0;
    for (pin, point) in pins.iter().enumerate() {
        // A pin that prescribes a gradient has one additional row per axis.
        let count = 1 + point.gradient.map_or(0, |_| D);
        if point.weight >= 1.0 {
            held.extend((row..row + count).map(|row| ConstraintRow::Pin { row, pin }));
        }
        row += count;
    }
    held.extend((0..handles).map(|row| ConstraintRow::Handle { row }));
    held
}

/// Adds the compliance of pins that give way to C A⁻¹ Cᵀ, a matrix of #held².
fn add_compliance<const D: usize>(terms: &Terms<D>, held: &[ConstraintRow], schur: &mut [f64]) {
    let entries = terms.yielding.as_ref().map_or(&[][..], |yielding| yielding.compliance());
    let is_row =
        |wanted: usize| move |row: &ConstraintRow| matches!(row, ConstraintRow::Pin { row, .. } if *row == wanted);
    for ([a, b], compliance) in entries {
        let places = (held.iter().position(is_row(*a)), held.iter().position(is_row(*b)));
        if let (Some(a), Some(b)) = places {
            schur[a * held.len() + b] += compliance;
        }
    }
}

/// Number of rows that are solved together.
const BATCH: usize = 8;

/// Returns A⁻¹Cᵀ, column by column, each of length #handles.
fn responses<const D: usize>(
    factor: &Factorization,
    terms: &Terms<D>,
    (held, handle_count): (&[ConstraintRow], usize),
    cancel: &Cancel,
) -> Result<Vec<f64>, Cancelled> {
    let mut responses = vec![0.0; held.len() * handle_count];
    let mut right_side = vec![[0.0; BATCH]; handle_count];
    for (rows, columns) in held.chunks(BATCH).zip(responses.chunks_mut(BATCH * handle_count)) {
        right_side.fill([0.0; BATCH]);
        for (k, row) in rows.iter().enumerate() {
            row.entries(terms).iter().for_each(|&(handle, coefficient)| right_side[handle][k] += coefficient);
        }
        factor.solve(&mut right_side);
        for (k, column) in columns.chunks_exact_mut(handle_count).enumerate() {
            column.iter_mut().zip(&right_side).for_each(|(slot, x)| *slot = x[k]);
        }
        cancel.check()?;
    }
    Ok(responses)
}

/// Maximum number of rows for which the inverse and the responses are multiplied in advance.
const MAX_MULTIPLIED: usize = 128;

/// Product of a square matrix (#rows²) and a matrix of #rows × #columns, both row-major.
fn product(square: &[f64], other: &[f64], rows: usize) -> Vec<f64> {
    let columns = other.len() / rows;
    let mut product = vec![0.0; other.len()];
    for (sums, factors) in product.chunks_exact_mut(columns).zip(square.chunks_exact(rows)) {
        for (factor, row) in factors.iter().zip(other.chunks_exact(columns)) {
            sums.iter_mut().zip(row).for_each(|(slot, x)| *slot += factor * x);
        }
    }
    product
}

/// Subtracts Σ row · value from the handles; each row has #handles entries.
fn subtract_product<const D: usize>(rows: &[f64], values: &[[f64; D]], handles: &mut [[f64; D]]) {
    for (row, value) in rows.chunks_exact(handles.len().max(1)).zip(values) {
        for (handle, factor) in handles.iter_mut().zip(row) {
            (0..D).for_each(|d| handle[d] -= factor * value[d]);
        }
    }
}

/// Returns, for each row with a component in the dropped directions, the row of another pin or handle with the largest common
/// component, or the row itself where no other has one.
fn rivals(dropped: &[f64], held: &[ConstraintRow]) -> Vec<Option<usize>> {
    let of = |(row, shares): (usize, &[f64])| {
        let others = (0..held.len()).filter(|&other| held[other].owner() != held[row].owner());
        let others = others.filter(|&other| shares[other].abs() > MIN_CONFLICT);
        let nearest = others.reduce(|best, other| if shares[other].abs() > shares[best].abs() { other } else { best });
        (shares[row] > MIN_CONFLICT).then(|| nearest.unwrap_or(row))
    };
    dropped.chunks_exact(held.len().max(1)).enumerate().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pin_is_its_own_rival_only_where_nobody_else_is() {
        let row = |row: usize, pin: usize| ConstraintRow::Pin { row, pin };
        // Two pins with one position row and two gradient rows each; `share` sets the common components of two rows.
        let held: Vec<ConstraintRow> = (0..6).map(|k| row(k, k / 3)).collect();
        let mut dropped = vec![0.0; 36];
        let mut share = |a: usize, b: usize, x: f64| [6 * a + b, 6 * b + a].into_iter().for_each(|k| dropped[k] = x);
        [(0, 0, 0.5), (0, 1, 0.4), (0, 4, 0.1), (1, 1, 0.5), (4, 4, 0.1)]
            .into_iter()
            .for_each(|(a, b, x)| share(a, b, x));
        let constraints =
            Constraints { rivals: rivals(&dropped, &held), held: held.clone(), correction: Correction::default() };
        assert_eq!(constraints.rivals, [Some(4), Some(1), None, None, Some(0), None]);
        assert_eq!(
            [0, 1].map(|pin| constraints.rival(pin)),
            [Some(ConstraintOwner::Pin(1)), Some(ConstraintOwner::Pin(0))]
        );
        let alone: Vec<f64> =
            dropped.iter().enumerate().map(|(k, x)| if k % 6 < 3 && k / 6 < 3 { *x } else { 0.0 }).collect();
        let constraints = Constraints { rivals: rivals(&alone, &held), held, correction: Correction::default() };
        assert_eq!([0, 1].map(|pin| constraints.rival(pin)), [Some(ConstraintOwner::Pin(0)), None]);
    }
}
