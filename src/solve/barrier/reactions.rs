//! Pins under the barrier: each holds with a limited force, and gives way where the barrier would need more.
//!
//! In: rows of pins and moved handles, with multipliers λ. Out: an energy that replaces w‖C P − d‖², and its derivatives, which are
//! halved, as in the matrices.

use crate::solve::least_squares::LeastSquaresRows;
use crate::solve::linalg::normal_matrix::NormalMatrix;
use crate::solve::minimization::Minimization;

/// Maximum force of a row, in units of the stiffness of the shape divided by the box diagonal.
const FORCE: f64 = 10.0;

/// A row with its multiplier and force limit.
///
/// It acts as w‖s‖², s = C P − d + λ/w, up to the force w‖s‖ = L, and as 2 L‖s‖ − L²/w beyond (P. Huber, "Robust Estimation of a
/// Location Parameter", 1964). If λ is then set to the force, limited to L, this is the method of multipliers for L‖C P − d‖ (R.
/// T. Rockafellar, "Augmented Lagrangians and Applications of the Proximal Point Algorithm in Convex Programming", 1976), under
/// which a row is met exactly with any force below L.
#[derive(Clone, Debug)]
struct Reaction<const D: usize> {
    /// Index among the rows of the pins, followed by those of the moved handles.
    row: usize,
    /// Weight w of the row.
    weight: f64,
    multiplier: [f64; D],
    /// Maximum force L.
    limit: f64,
}

/// All rows of pins and moved handles that have a weight.
#[derive(Clone)]
pub(super) struct Reactions<'a, const D: usize> {
    rows: [&'a LeastSquaresRows<D>; 2],
    list: Vec<Reaction<D>>,
}

impl<'a, const D: usize> Reactions<'a, D> {
    pub(super) fn new(problem: &'a Minimization<D>) -> Self {
        let rows = [problem.terms.acting_pins(), &problem.terms.handles];
        let most = FORCE * problem.stiffness() / problem.diagonal;
        let scales = [problem.scales.pins, problem.scales.handles];
        let list = (0..rows[0].len() + rows[1].len()).map(|row| {
            let (set, place) = place(rows, row);
            let share = set.weight(place);
            let weight = share * scales[usize::from(row >= rows[0].len())];
            Reaction { row, weight, multiplier: [0.0; D], limit: most * share.min(1.0) }
        });
        let list = list.filter(|reaction| reaction.weight > 0.0).collect();
        Self { rows, list }
    }

    /// Sets the multipliers to the forces at a state that was solved without multipliers; they are close to those at the minimum
    /// without the barrier. Adds the fraction `share` of each force to the limit of its row.
    pub(super) fn initialise_multipliers(&mut self, handles: &[[f64; D]], share: f64) {
        let rows = self.rows;
        for reaction in &mut self.list {
            reaction.multiplier = [0.0; D];
            reaction.limit += share * norm(&reaction.force(rows, handles));
        }
        self.update_multipliers(handles);
    }

    /// The multipliers, coordinate by coordinate.
    pub(super) fn multipliers(&self) -> Vec<f64> {
        self.list.iter().flat_map(|reaction| reaction.multiplier).collect()
    }

    /// Sets the multipliers to those of a similar problem, limited to L, if there are as many.
    pub(super) fn set_multipliers(&mut self, multipliers: &[f64]) {
        let (found, _) = multipliers.as_chunks::<D>();
        if found.len() == self.list.len() {
            self.list
                .iter_mut()
                .zip(found)
                .for_each(|(reaction, found)| reaction.multiplier = reaction.limited(*found));
        }
    }

    /// Sets the multipliers to the forces at a state, limited to L. Returns the largest residual of the rows that do not give way.
    pub(super) fn update_multipliers(&mut self, handles: &[[f64; D]]) -> f64 {
        let (rows, mut farthest) = (self.rows, 0.0_f64);
        for reaction in &mut self.list {
            let force = reaction.force(rows, handles);
            let size = norm(&force);
            if size <= reaction.limit {
                let (set, place) = place(rows, reaction.row);
                farthest = farthest.max(norm(&set.residual(place, handles)));
            }
            reaction.multiplier = reaction.limited(force);
        }
        farthest
    }

    /// Whether the force of a row exceeds its limit.
    pub(super) fn any_yields(&self, handles: &[[f64; D]]) -> bool {
        self.list.iter().any(|reaction| norm(&reaction.force(self.rows, handles)) > reaction.limit)
    }

    /// Replaces w‖C P − d‖² by the energy of the reactions: returns the difference of the energies, and subtracts half its
    /// derivative from `right_side`.
    pub(super) fn correct(&self, handles: &[[f64; D]], right_side: &mut [[f64; D]]) -> f64 {
        let mut energy = 0.0;
        for reaction in &self.list {
            let (set, place) = place(self.rows, reaction.row);
            let residual = set.residual(place, handles);
            let force = reaction.force(self.rows, handles);
            let size = norm(&force);
            let is_held = size <= reaction.limit;
            let acting = if is_held { force } else { force.map(|x| x * reaction.limit / size) };
            energy -= reaction.weight * residual.iter().map(|x| x * x).sum::<f64>();
            energy += if is_held {
                size * size / reaction.weight
            } else {
                (2.0 * size - reaction.limit) * reaction.limit / reaction.weight
            };
            let excess: [f64; D] = std::array::from_fn(|d| acting[d] - reaction.weight * residual[d]);
            for &(handle, coefficient) in set.row(place) {
                (0..D).for_each(|d| right_side[handle][d] -= coefficient * excess[d]);
            }
        }
        energy
    }

    /// Makes the same replacement in the matrix of all coordinates. A row that gives way has no stiffness along its force; the
    /// convex matrix still gives it the stiffness that it has across.
    pub(super) fn correct_curvature(&self, handles: &[[f64; D]], is_convex: bool, normal: &mut NormalMatrix) {
        for reaction in &self.list {
            let force = reaction.force(self.rows, handles);
            let size = norm(&force);
            if size <= reaction.limit {
                continue;
            }
            let (set, place) = place(self.rows, reaction.row);
            let row = set.row(place);
            let across = reaction.weight * reaction.limit / size;
            for d in 0..D {
                let entries: Vec<(usize, f64)> = row.iter().map(|&(handle, c)| (D * handle + d, c)).collect();
                normal.add_row(across - reaction.weight, &entries);
            }
            if !is_convex {
                let entries =
                    row.iter().flat_map(|&(handle, c)| (0..D).map(move |d| (D * handle + d, c * force[d] / size)));
                normal.add_row(-across, &entries.collect::<Vec<_>>());
            }
        }
    }
}

impl<const D: usize> Reaction<D> {
    /// Force of the row: w s = w (C P − d) + λ.
    fn force(&self, rows: [&LeastSquaresRows<D>; 2], handles: &[[f64; D]]) -> [f64; D] {
        let (set, place) = place(rows, self.row);
        let residual = set.residual(place, handles);
        std::array::from_fn(|d| self.weight * residual[d] + self.multiplier[d])
    }

    /// A force, shortened to L.
    fn limited(&self, force: [f64; D]) -> [f64; D] {
        let size = norm(&force);
        let share = if size > self.limit { self.limit / size } else { 1.0 };
        force.map(|x| share * x)
    }
}

/// Returns the set that a row belongs to, and its index in the set.
fn place<const D: usize>([pins, handles]: [&LeastSquaresRows<D>; 2], row: usize) -> (&LeastSquaresRows<D>, usize) {
    if row < pins.len() { (pins, row) } else { (handles, row - pins.len()) }
}

fn norm<const D: usize>(x: &[f64; D]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}
