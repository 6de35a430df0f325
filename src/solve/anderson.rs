//! Anderson acceleration of a fixed-point iteration (Y. Peng et al., "Anderson Acceleration for Geometry Optimization
//! and Physics Simulation", 2018).
//!
//! In: a state and its plain successor. Out: a better successor, from the last few steps.

use super::small::symmetric_eigen;

/// Most steps remembered.
const MOST: usize = 5;

/// Remembers steps; all vectors are flat and as long as the state.
#[derive(Clone, Debug)]
pub(crate) struct Anderson {
    window: usize,
    /// Differences of successive residuals and of successive plain successors; newest last.
    differences: Vec<[Vec<f64>; 2]>,
    last: Option<[Vec<f64>; 2]>,
}

impl Anderson {
    /// Remembers up to `window` steps (at most five); 0 accelerates nothing.
    pub(crate) fn new(window: usize) -> Self {
        Self { window: window.min(MOST), differences: Vec::new(), last: None }
    }

    /// Forgets all steps.
    pub(crate) fn reset(&mut self) {
        self.differences.clear();
        self.last = None;
    }

    /// Overwrites `successor`, the plain one of `state`, by the accelerated one.
    pub(crate) fn step<const D: usize>(&mut self, state: &[[f64; D]], successor: &mut [[f64; D]]) {
        if self.window == 0 {
            return;
        }
        let plain: Vec<f64> = successor.as_flattened().to_vec();
        let residual: Vec<f64> = plain.iter().zip(state.as_flattened()).map(|(g, x)| g - x).collect();
        if let Some([last_residual, last_plain]) = self.last.take() {
            if self.differences.len() == self.window {
                self.differences.remove(0);
            }
            let difference = |now: &[f64], before: &[f64]| now.iter().zip(before).map(|(a, b)| a - b).collect();
            self.differences.push([difference(&residual, &last_residual), difference(&plain, &last_plain)]);
        }
        let shares = self.shares(&residual);
        for ([_, step], share) in self.differences.iter().zip(shares) {
            successor.as_flattened_mut().iter_mut().zip(step).for_each(|(x, dx)| *x -= share * dx);
        }
        self.last = Some([residual, plain]);
    }

    /// θ that minimises ‖F − Σ θ_k ΔF_k‖, by the normal equations with small eigenvalues left out.
    fn shares(&self, residual: &[f64]) -> [f64; MOST] {
        let count = self.differences.len();
        let lengths: [f64; MOST] = std::array::from_fn(|k| {
            if k < count { product(&self.differences[k][0], &self.differences[k][0]).sqrt() } else { 0.0 }
        });
        let unit = |k: usize| if lengths[k] > 0.0 { 1.0 / lengths[k] } else { 0.0 };
        let mut gram = [[0.0; MOST]; MOST];
        for a in 0..count {
            for b in 0..=a {
                let value = product(&self.differences[a][0], &self.differences[b][0]) * unit(a) * unit(b);
                (gram[a][b], gram[b][a]) = (value, value);
            }
        }
        let right: [f64; MOST] =
            std::array::from_fn(|k| if k < count { product(&self.differences[k][0], residual) * unit(k) } else { 0.0 });
        let (values, vectors) = symmetric_eigen(&gram);
        let mut shares = [0.0; MOST];
        for k in (0..MOST).filter(|&k| values[k] > 1e-10) {
            let part: f64 = (0..MOST).map(|a| vectors[a][k] * right[a]).sum::<f64>() / values[k];
            (0..MOST).for_each(|a| shares[a] += part * vectors[a][k]);
        }
        std::array::from_fn(|k| shares[k] * unit(k))
    }
}

fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
