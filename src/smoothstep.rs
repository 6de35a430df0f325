//! The cubic step from 0 to 1 that begins and ends without slope.

/// 3 t² − 2 t³, with `t` clamped to 0 to 1.
pub(crate) fn smoothstep(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
