//! The easing of a segment between two keys.
//!
//! In: an [`Ease`] and the elapsed fraction of the segment's time. Out: the fraction of the change.

use super::Ease;
use crate::smoothstep::smoothstep;

/// Returns the fraction of the change at the fraction `time` (0..=1) of the segment.
pub(super) fn eased(ease: Ease, time: f64) -> f64 {
    match ease {
        Ease::Hold => 0.0,
        Ease::Linear => time,
        Ease::Smooth => smoothstep(time),
        Ease::Bezier([x1, y1, x2, y2]) => cubic(y1, y2, parameter_at(x1, x2, time)),
    }
}

/// Evaluates one coordinate of the cubic Bézier curve with end points 0 and 1 and inner control points `a`, `b`.
fn cubic(a: f64, b: f64, s: f64) -> f64 {
    let r = 1.0 - s;
    3.0 * r * r * s * a + 3.0 * r * s * s * b + s * s * s
}

fn cubic_slope(a: f64, b: f64, s: f64) -> f64 {
    let r = 1.0 - s;
    3.0 * r * r * a + 6.0 * r * s * (b - a) + 3.0 * s * s * (1.0 - b)
}

/// Returns the curve parameter at which x = `time`. With x1, x2 in 0..=1, x is monotonic, so the root stays bracketed:
/// Newton's method, with bisection where a step leaves the bracket (the slope vanishes at flat ends).
fn parameter_at(x1: f64, x2: f64, time: f64) -> f64 {
    let (mut low, mut high, mut s) = (0.0, 1.0, time);
    for _ in 0..64 {
        let error = cubic(x1, x2, s) - time;
        if error.abs() < 1e-14 || high - low < 1e-15 {
            break;
        }
        if error > 0.0 {
            high = s;
        } else {
            low = s;
        }
        let newton = s - error / cubic_slope(x1, x2, s);
        s = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
    }
    s
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eases_meet_values_worked_out_by_hand() {
        assert_eq!(eased(Ease::Hold, 0.99), 0.0);
        assert_eq!(eased(Ease::Linear, 0.3), 0.3);
        // 3·0.0625 − 2·0.015625
        assert_eq!(eased(Ease::Smooth, 0.25), 0.15625);
        // Control points at thirds give a straight line.
        let line = Ease::Bezier([1.0 / 3.0, 1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0]);
        assert!((eased(line, 0.37) - 0.37).abs() < 1e-12);
        // x = s³ + 3s²(1−s)·1 + 0: x1 = 0, x2 = 1 is x = 3s² − 2s³; at s = ¼: x = 0.15625, y with (0, 0): s³.
        assert!((eased(Ease::Bezier([0.0, 0.0, 1.0, 0.0]), 0.15625) - 0.015625).abs() < 1e-12);
        // The symmetric CSS ease-in-out passes through its midpoint.
        assert!((eased(Ease::Bezier([0.42, 0.0, 0.58, 1.0]), 0.5) - 0.5).abs() < 1e-12);
        // Overshoot: s = ½ is x = ½, y = 3/8·2 + 3/8·2 + 1/8 = 1.625.
        assert!((eased(Ease::Bezier([0.5, 2.0, 0.5, 2.0]), 0.5) - 1.625).abs() < 1e-12);
    }

    #[test]
    fn bezier_with_vertical_and_flat_parts_is_solved_everywhere() {
        for [x1, x2] in [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0], [0.5, 0.5]] {
            for i in 0..=1000 {
                let time = f64::from(i) / 1000.0;
                let s = parameter_at(x1, x2, time);
                assert!((0.0..=1.0).contains(&s), "{x1} {x2} {time}: {s}");
                assert!((cubic(x1, x2, s) - time).abs() < 1e-12, "{x1} {x2} {time}: {s}");
            }
        }
    }
}
