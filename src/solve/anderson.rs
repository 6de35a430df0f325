//! Anderson acceleration of a fixed-point iteration (Y. Peng et al., "Anderson Acceleration for Geometry Optimization
//! and Physics Simulation", 2018).
//!
//! In: a state and its plain successor (one step of the iteration). Out: an accelerated successor, extrapolated from the last few
//! steps.

/// Maximum number of stored steps.
const MAX_WINDOW: usize = 12;

/// History of the last steps; all vectors are flat and as long as the state.
#[derive(Clone, Debug)]
pub(crate) struct Anderson {
    window: usize,
    /// Per stored step the differences ΔF of successive residuals and ΔG of successive plain successors, newest last.
    differences: Vec<[Vec<f64>; 2]>,
    /// Residual and plain successor of the previous step.
    last: Option<[Vec<f64>; 2]>,
}

impl Anderson {
    /// Creates a history of up to `window` steps (at most twelve); 0 disables acceleration.
    pub(crate) fn new(window: usize) -> Self {
        Self { window: window.min(MAX_WINDOW), differences: Vec::new(), last: None }
    }

    /// Whether the next step is accelerated; the first one after a reset is plain.
    pub(crate) fn has_history(&self) -> bool {
        self.window > 0 && self.last.is_some()
    }

    /// Clears the history.
    pub(crate) fn reset(&mut self) {
        self.differences.clear();
        self.last = None;
    }

    /// Replaces the plain `successor` of `state` by the accelerated one.
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
        let coefficients = self.coefficients(&residual);
        for ([_, step], share) in self.differences.iter().zip(coefficients) {
            successor.as_flattened_mut().iter_mut().zip(step).for_each(|(x, dx)| *x -= share * dx);
        }
        self.last = Some([residual, plain]);
    }

    /// Returns the θ that minimises ‖F − Σ θ_k ΔF_k‖, from the normal equations of the normalised columns ΔF_k. Cholesky starts
    /// at the newest column; a column that depends linearly on newer ones gets the coefficient 0.
    fn coefficients(&self, residual: &[f64]) -> [f64; MAX_WINDOW] {
        let count = self.differences.len();
        let column = |k: usize| &self.differences[count - 1 - k][0];
        let mut lower = [[0.0; MAX_WINDOW]; MAX_WINDOW];
        let (mut units, mut shares) = ([0.0; MAX_WINDOW], [0.0; MAX_WINDOW]);
        for k in 0..count {
            let length = dot(column(k), column(k)).sqrt();
            units[k] = if length > 0.0 { 1.0 / length } else { 0.0 };
            for j in 0..=k {
                let known: f64 = (0..j).map(|m| lower[k][m] * lower[j][m]).sum();
                let left = dot(column(k), column(j)) * units[k] * units[j] - known;
                lower[k][j] = if j < k { left * lower[j][j] } else { inverse_root(left) };
            }
            let known: f64 = (0..k).map(|m| lower[k][m] * shares[m]).sum();
            shares[k] = (dot(column(k), residual) * units[k] - known) * lower[k][k];
        }
        for k in (0..count).rev() {
            let known: f64 = (k + 1..count).map(|m| lower[m][k] * shares[m]).sum();
            shares[k] = (shares[k] - known) * lower[k][k];
        }
        std::array::from_fn(|k| if k < count { shares[count - 1 - k] * units[count - 1 - k] } else { 0.0 })
    }
}

/// Returns 1/√x, or 0 where the pivot x shows that the unit column is linearly dependent.
fn inverse_root(x: f64) -> f64 {
    if x > 1e-10 { 1.0 / x.sqrt() } else { 0.0 }
}

/// Dot product with eight partial sums.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    let mut sums = [0.0; 8];
    for (a, b) in a.iter().zip(b) {
        (0..8).for_each(|lane| sums[lane] += a[lane] * b[lane]);
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(x, y)| x * y).sum();
    sums.iter().sum::<f64>() + rest
}
