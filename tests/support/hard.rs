//! Hard random problems: shapes whose pins go far, in any direction.
//!
//! In: the number of a problem, which is its seed. Out: the problem, in a box of about 2 x 2 units.

use super::figure::figure;
use crate::internal::numbers::{Random, SplitMix};
use pinwarp::lattice::{Basis, Grid};
use pinwarp::solve::{PointPin, Shape};

/// Number of problems.
pub(crate) const HARD: u64 = 280;

/// A problem.
pub(crate) struct Hard {
    pub(crate) grid: Grid<2>,
    pub(crate) shape: Shape<2>,
    pub(crate) pins: Vec<PointPin<2>>,
}

/// Triangles of a fine grid all of whose corners lie inside.
fn cut_out(is_inside: impl Fn([f64; 2]) -> bool) -> Shape<2> {
    const SIDE: usize = 41;
    let place = |k: usize| [-1.0 + 0.05 * (k % SIDE) as f64, -1.0 + 0.05 * (k / SIDE) as f64];
    let mut used: Vec<Option<u32>> = vec![None; SIDE * SIDE];
    let mut shape = Shape::default();
    for k in (0..SIDE * (SIDE - 1)).filter(|k| k % SIDE + 1 < SIDE) {
        for corners in [[k, k + 1, k + SIDE], [k + 1, k + SIDE + 1, k + SIDE]] {
            if corners.iter().all(|&corner| is_inside(place(corner))) {
                shape.triangles.push(corners.map(|corner| {
                    *used[corner].get_or_insert_with(|| {
                        shape.points.push(place(corner));
                        shape.points.len() as u32 - 1
                    })
                }));
            }
        }
    }
    shape
}

/// One of four shapes: the figure, a disc, a bar, a ring; 4 to 16 handles a side; 2 to 9 pins on vertices, which go up to 0.7 units far.
pub(crate) fn hard(number: u64) -> Hard {
    let mut numbers = SplitMix(1 + number);
    let shape = match number % 4 {
        0 => figure(0.08),
        1 => cut_out(|[x, y]| x.hypot(y) < 0.9),
        2 => cut_out(|[x, y]| x.abs() < 0.95 && y.abs() < 0.22),
        _ => cut_out(|[x, y]| (0.45..0.95).contains(&x.hypot(y))),
    };
    let bounds = |d: usize| {
        let of = shape.points.iter().map(|point| point[d]);
        of.fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], x| [lo.min(x), hi.max(x)])
    };
    let padded = [bounds(0), bounds(1)].map(|[lo, hi]| [lo - 0.1 * (hi - lo), hi + 0.1 * (hi - lo)]);
    let side = 6 + (10.0 * numbers.unit()) as usize;
    let count = 2 + (8.0 * numbers.unit()) as usize;
    let far = 0.1 + 0.6 * numbers.unit();
    let pins = (0..count).map(|_| {
        let at = shape.points[(shape.points.len() as f64 * numbers.unit()) as usize];
        let (angle, length) = (std::f64::consts::TAU * numbers.unit(), far * numbers.unit().sqrt());
        PointPin::new(at, [at[0] + length * angle.cos(), at[1] + length * angle.sin()])
    });
    let pins = pins.collect();
    let grid = Grid {
        dims: [side, side],
        basis: Basis::Bspline,
        lo: padded.map(|[lo, _]| lo),
        hi: padded.map(|[_, hi]| hi),
        angle: 0.0,
    };
    Hard { grid, shape, pins }
}
