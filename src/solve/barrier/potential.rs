//! Barrier potential, a function of det J alone: 0 from [`ACTIVATION_DET`] upwards, growing without bound towards [`MIN_DET`].
//!
//! In: d = det J. Out: the value and its first two derivatives. M. Li et al., "Incremental Potential Contact", 2020, equation 6,
//! with det J in place of a distance: φ = −u² ln((d − d₀)/(d₁ − d₀)), u = (d₁ − d)/d₁. At d₁ the logarithm vanishes together with
//! u, so φ falls to 0 like u³ and is C2.

/// d₁: from this determinant upwards the potential is 0.
pub(crate) const ACTIVATION_DET: f64 = 0.2;

/// d₀: the determinant at which the potential is infinite. It is above 0 so that det J stays positive between the samples.
pub(crate) const MIN_DET: f64 = 0.02;

/// Strength of the barrier, in units of the stiffness of the shape.
pub(super) const STRENGTH: f64 = 1.0;

/// Returns φ, φ' and φ''; infinite at and below the pole.
pub(crate) fn potential(det: f64) -> [f64; 3] {
    if det >= ACTIVATION_DET {
        return [0.0; 3];
    }
    if det <= MIN_DET || det.is_nan() {
        return [f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY];
    }
    let (u, left) = ((ACTIVATION_DET - det) / ACTIVATION_DET, det - MIN_DET);
    let log = (left / (ACTIVATION_DET - MIN_DET)).ln();
    let slope = 2.0 * u * log / ACTIVATION_DET - u * u / left;
    let bend =
        -2.0 * log / (ACTIVATION_DET * ACTIVATION_DET) + 4.0 * u / (ACTIVATION_DET * left) + u * u / (left * left);
    [-u * u * log, slope, bend]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_are_those_of_the_potential_which_ends_smoothly() {
        for det in [0.021, 0.03, 0.05, 0.1, 0.15, 0.19] {
            let step = 1e-6 * (det - MIN_DET);
            let [below, at, above] = [-step, 0.0, step].map(|by| potential(det + by));
            let slope = (above[0] - below[0]) / (2.0 * step);
            let bend = (above[1] - below[1]) / (2.0 * step);
            assert!((slope / at[1] - 1.0).abs() < 1e-4, "{det}: {slope} {at:?}");
            assert!((bend / at[2] - 1.0).abs() < 1e-4, "{det}: {bend} {at:?}");
        }
        let end = potential(ACTIVATION_DET - 1e-6);
        assert!(end[0] < 1e-15 && end[1].abs() < 1e-9 && end[2] < 1e-3, "{end:?}");
        assert_eq!(potential(ACTIVATION_DET), [0.0; 3]);
        assert_eq!(potential(MIN_DET)[0], f64::INFINITY);
    }
}
