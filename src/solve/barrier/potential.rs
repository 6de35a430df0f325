//! The potential of the barrier, a function of det J alone: 0 from [`CLEAR`] on, and without bound at [`POLE`].
//!
//! In: det J. Out: value and derivatives. M. Li et al., "Incremental Potential Contact", 2020, equation 6, of det J instead of a distance:
//! φ = −u² ln((d − d₀)/(d₁ − d₀)), u = (d₁ − d)/d₁. As the logarithm vanishes with u, φ falls to 0 like u³: it is C2 there.

/// d₁: gradients of a greater determinant know nothing of the barrier.
pub(crate) const CLEAR: f64 = 0.2;

/// d₀: no sample is pressed to this. Above 0, so that det J stays positive between samples.
pub(crate) const POLE: f64 = 0.02;

/// φ and its first two derivatives at a determinant above the pole.
pub(crate) fn potential(det: f64) -> [f64; 3] {
    if det >= CLEAR {
        return [0.0; 3];
    }
    if det <= POLE || det.is_nan() {
        return [f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY];
    }
    let (u, left) = ((CLEAR - det) / CLEAR, det - POLE);
    let log = (left / (CLEAR - POLE)).ln();
    let slope = 2.0 * u * log / CLEAR - u * u / left;
    let bend = -2.0 * log / (CLEAR * CLEAR) + 4.0 * u / (CLEAR * left) + u * u / (left * left);
    [-u * u * log, slope, bend]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_are_those_of_the_potential_which_ends_smoothly() {
        for det in [0.021, 0.03, 0.05, 0.1, 0.15, 0.19] {
            let step = 1e-6 * (det - POLE);
            let [below, at, above] = [-step, 0.0, step].map(|by| potential(det + by));
            let slope = (above[0] - below[0]) / (2.0 * step);
            let bend = (above[1] - below[1]) / (2.0 * step);
            assert!((slope / at[1] - 1.0).abs() < 1e-4, "{det}: {slope} {at:?}");
            assert!((bend / at[2] - 1.0).abs() < 1e-4, "{det}: {bend} {at:?}");
        }
        let end = potential(CLEAR - 1e-6);
        assert!(end[0] < 1e-15 && end[1].abs() < 1e-9 && end[2] < 1e-3, "{end:?}");
        assert_eq!(potential(CLEAR), [0.0; 3]);
        assert_eq!(potential(POLE)[0], f64::INFINITY);
    }
}
