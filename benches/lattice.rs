//! Time of the forward deformation of a million points: `cargo bench --bench lattice`.
//!
//! In: bent 15 x 15 lattices. Out: milliseconds in single precision on all threads and on one, and in double precision on
//! one.

#[path = "support/stopwatch.rs"]
mod stopwatch;

use pinwarp::lattice::{Basis, DisplayWarp, Grid, Lattice};
use pinwarp::space::ScreenPoint;
use std::hint::black_box;
use stopwatch::fastest;

const POINTS: usize = 1_000_000;

fn bent(basis: Basis) -> Lattice<2> {
    let mut lattice = Grid { dims: [15, 15], basis, lo: [0.0, 0.0], hi: [1.0, 1.0], angle: 0.0 }.at_rest();
    for (k, handle) in lattice.handles.iter_mut().enumerate() {
        *handle = [handle[0] + 0.02 * (k as f64).sin(), handle[1] + 0.02 * (1.3 * k as f64).cos()];
    }
    lattice
}

fn main() {
    let place = |k: usize| [(k % 1000) as f32 / 1000.0, (k / 1000) as f32 / 1000.0];
    let points: Vec<[f32; 2]> = (0..POINTS).map(place).collect();
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    println!("{POINTS} points, 15 x 15, ms: f32 on {} threads | f32 on one | f64 on one", rayon::current_num_threads());
    for basis in [Basis::Bspline, Basis::Bernstein, Basis::Bilinear, Basis::Barytri] {
        let lattice = bent(basis);
        let display = DisplayWarp::new(&lattice);
        let mut moved = points.clone();
        let mut run = || {
            moved.copy_from_slice(&points);
            display.warp(black_box(&mut moved));
        };
        let (all, one) = (fastest(&mut run).0, alone.install(|| fastest(&mut run)).0);
        let double = fastest(|| {
            for &[x, y] in &points {
                black_box(lattice.warp(ScreenPoint::new(x.into(), y.into())));
            }
        })
        .0;
        println!("{basis:?}: {all:.1} | {one:.1} | {double:.1}");
    }
}
