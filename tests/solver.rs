//! Properties of the solver on generated shapes.

use pinwarp::lattice::{Basis, Grid};
use pinwarp::solve::{PointPin, Problem, Settings, Shape, solve};

fn bar() -> Shape<2> {
    let points = (0..22).map(|k| [0.1 + 0.8 * f64::from(k / 2) / 10.0, 0.4 + 0.2 * f64::from(k % 2)]).collect();
    let triangles = (0..20).map(|k| [k, k + 1, k + 2]).collect();
    Shape { points, triangles }
}

fn pin(at: [f64; 2], target: [f64; 2]) -> PointPin<2> {
    PointPin { at, target, weight: 1.0, gradient: None }
}

#[test]
fn rigid_pins_move_the_lattice_rigidly() {
    let grid = Grid { dims: [10, 10], basis: Basis::Bspline, lo: [0.0, 0.0], hi: [1.0, 1.0] };
    let (sin, cos) = 1.1_f64.sin_cos();
    let image = |p: [f64; 2]| [cos * p[0] - sin * p[1] + 3.0, sin * p[0] + cos * p[1] - 1.0];
    let pins: Vec<_> = [[0.2, 0.5], [0.8, 0.45], [0.5, 0.6]].map(|p| pin(p, image(p))).to_vec();
    let (shape, settings) = (bar(), Settings::default());
    let solution = solve(&Problem { grid: &grid, shape: &shape, pins: &pins, handles: &[], settings: &settings });
    let solution = solution.expect("a valid problem");
    eprintln!("{:?}", solution.report);
    for (handle, rest) in solution.lattice.handles.iter().zip(grid.rest_handles()) {
        let want = image(rest);
        assert!((handle[0] - want[0]).hypot(handle[1] - want[1]) < 1e-6, "{handle:?} {want:?}");
    }
}

#[test]
fn bent_bar() {
    let grid = Grid { dims: [10, 10], basis: Basis::Bspline, lo: [0.0, 0.0], hi: [1.0, 1.0] };
    let pins = [pin([0.1, 0.5], [0.1, 0.5]), pin([0.5, 0.5], [0.5, 0.6]), pin([0.9, 0.5], [0.8, 0.2])];
    let (shape, settings) = (bar(), Settings::default());
    let solution = solve(&Problem { grid: &grid, shape: &shape, pins: &pins, handles: &[], settings: &settings });
    let solution = solution.expect("a valid problem");
    eprintln!("{:?}", solution.report);
    assert!(solution.report.is_converged);
}
