//! Rigid moving least squares (MLS), applied to the handles of the grid. In: grid and pins. Out: handles.
//!
//! S. Schaefer, T. McPhail, J. Warren, "Image deformation using moving least squares", SIGGRAPH 2006,
//! <https://doi.org/10.1145/1179352.1141920>; in 3D: Y. Zhu, S. J. Gortler, "3D deformation using moving least squares", 2007. As
//! in the comparison of lp-FFD, MLS moves each handle as a point; the shape is not used.

use super::{Deformed, Deformer};
use crate::lattice::Lattice;
use crate::solve::error::SolveError;
use crate::solve::linalg::small_matrix::{apply, best_rotation, dot, minus};
use crate::solve::problem::Problem;
use crate::solve::validate;

/// Rigid MLS, f(v) = R (v − p*) + q*, with R the best rotation under the weights 1/|p − v|^2α.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mls {
    /// α, which is 1 in the pictures of the authors.
    pub alpha: f64,
}

impl Default for Mls {
    fn default() -> Self {
        Self { alpha: 1.0 }
    }
}

/// Rest position and target of a pin or moved handle.
type Control<const D: usize> = ([f64; D], [f64; D]);

impl<const D: usize> Deformer<D> for Mls {
    fn key(&self) -> &'static str {
        "mls"
    }

    fn name(&self) -> &'static str {
        "Rigid MLS on the grid"
    }

    fn deform(&self, problem: &Problem<D>) -> Result<Deformed<D>, SolveError> {
        validate::problem(problem)?;
        let grid = problem.grid;
        let moved = problem.handles.iter().map(|handle| (grid.rest_handle(handle.index), handle.target));
        let controls: Vec<Control<D>> = problem.pins.iter().map(|pin| (pin.at, pin.target)).chain(moved).collect();
        let handles = grid.rest_handles().iter().map(|handle| self.image(handle, &controls)).collect();
        Ok(Deformed { lattice: Lattice { grid: grid.clone(), handles }, iterations: 1 })
    }
}

impl Mls {
    /// Returns the image of a point (equations 5 to 8 of Schaefer et al.; R is the polar factor, which is equivalent in 2D).
    fn image<const D: usize>(&self, point: &[f64; D], controls: &[Control<D>]) -> [f64; D] {
        let mut weights = Vec::with_capacity(controls.len());
        for (rest, target) in controls {
            let gap = minus(rest, point);
            let square = dot(&gap, &gap);
            if square == 0.0 {
                return *target;
            }
            weights.push(square.powf(-self.alpha));
        }
        let total: f64 = weights.iter().sum();
        if total <= 0.0 {
            return *point;
        }
        let mean = |pick: fn(&Control<D>) -> &[f64; D]| -> [f64; D] {
            let weighted =
                |d: usize| weights.iter().zip(controls).map(|(w, control)| w * pick(control)[d]).sum::<f64>();
            std::array::from_fn(|d| weighted(d) / total)
        };
        let (from, to) = (mean(|control| &control.0), mean(|control| &control.1));
        let mut s = [[0.0; D]; D];
        for (weight, (rest, target)) in weights.iter().zip(controls) {
            let (rest, target) = (minus(rest, &from), minus(target, &to));
            for a in 0..D {
                (0..D).for_each(|b| s[a][b] += weight / total * rest[a] * target[b]);
            }
        }
        let turned = apply(&best_rotation(&s), &minus(point, &from));
        std::array::from_fn(|d| turned[d] + to[d])
    }
}
