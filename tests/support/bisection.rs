//! Bisection in time: how far something moves in the shortest time.

/// Time at which bisection ends, frames.
const SHORTEST: f64 = 1e-6;

/// The distance of two states at neighbouring times: the half in which it is greater is halved again, until it is less than `least` or
/// the times are next to each other.
pub(crate) fn jump<S>(
    [mut low, mut high]: [(f64, S); 2],
    least: f64,
    state: impl Fn(f64) -> S,
    distance: impl Fn(&S, &S) -> f64,
) -> f64 {
    while distance(&low.1, &high.1) >= least && high.0 - low.0 > SHORTEST {
        let time = f64::midpoint(low.0, high.0);
        let middle = (time, state(time));
        if distance(&low.1, &middle.1) > distance(&middle.1, &high.1) {
            high = middle;
        } else {
            low = middle;
        }
    }
    distance(&low.1, &high.1)
}
