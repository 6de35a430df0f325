//! Painted stiffness and the stiffness of regions: what is stiff keeps its shape, whatever measures the distortion.

use super::{grid, sheet};
use pinwarp::lattice::{Basis, Lattice};
use pinwarp::solve::{EdgeWeights, Energy, PointPin, Problem, Region, Settings, Shape, solve};

/// How much the diagonal and the sides of a small square at `at` change, relative to its size.
fn strain(lattice: &Lattice<2>, at: [f64; 2]) -> f64 {
    let gradient = lattice.evaluate_with_gradient(at).gradient;
    let [a, b] = [0, 1].map(|k| gradient[0][k].hypot(gradient[1][k]));
    let shear = gradient[0][0] * gradient[0][1] + gradient[1][0] * gradient[1][1];
    (a - 1.0).abs() + (b - 1.0).abs() + shear.abs()
}

/// A sheet that is pulled apart at its left and right, painted `value` on its left half.
fn pulled(settings: &Settings, value: f64, region: Option<Region>) -> Lattice<2> {
    let shape: Shape<2> = sheet(12);
    let left = |corners: &[u32; 3]| corners.iter().map(|&c| shape.points[c as usize][0]).sum::<f64>() < 1.5;
    let stiffness = shape.triangles.iter().map(|corners| if left(corners) { value } else { 1.0 }).collect();
    let shape = Shape { stiffness, ..shape.clone() };
    let mut pins = [[0.1, 0.2], [0.1, 0.8], [0.9, 0.2], [0.9, 0.8]]
        .map(|at| PointPin::new(at, [if at[0] < 0.5 { at[0] - 0.1 } else { at[0] + 0.1 }, at[1]]));
    pins[2].region = region;
    let grid = grid(10, Basis::Bspline);
    let problem = Problem { grid: &grid, shape: &shape, pins: &pins, handles: &[], settings };
    solve(&problem).expect("a valid problem").lattice
}

#[test]
fn a_stiff_half_stretches_less_in_every_measure() {
    for energy in [Energy::Area, Energy::Edge, Energy::Vertex, Energy::Element, Energy::SpokesAndRims] {
        for weights in [EdgeWeights::Uniform, EdgeWeights::Cot] {
            let settings = Settings { energy, weights, ..Settings::default() };
            let share = |value: f64| {
                let lattice = pulled(&settings, value, None);
                strain(&lattice, [0.3, 0.5]) / strain(&lattice, [0.7, 0.5])
            };
            let (even, stiff) = (share(1.0), share(8.0));
            assert!((even - 1.0).abs() < 0.02 && stiff < 0.4, "{energy:?} {weights:?}: {even} {stiff}");
        }
    }
}

#[test]
fn region_stiffness_acts_around_its_pin() {
    let settings = Settings::default();
    let region = |stiffness: f64| Region { radius: 0.35, rigidity: 0.0, stiffness };
    let near = |stiffness: f64| strain(&pulled(&settings, 1.0, Some(region(stiffness))), [0.8, 0.25]);
    let (plain, soft, stiff) = (near(1.0), near(0.1), near(20.0));
    assert!(stiff < 0.5 * plain && plain < soft, "{stiff} {plain} {soft}");
}

#[test]
fn stiffness_does_not_count_in_the_report() {
    let (grid, shape) = (grid(8, Basis::Bspline), sheet(12));
    let pins = [PointPin::new([0.2, 0.5], [0.2, 0.5]), PointPin::new([0.8, 0.5], [0.9, 0.6])];
    let painted = Shape { stiffness: vec![3.0; shape.triangles.len()], ..shape.clone() };
    let settings = Settings { iteration_limit: 0, ..Settings::default() };
    let report = |shape: &Shape<2>| {
        let problem = Problem { grid: &grid, shape, pins: &pins, handles: &[], settings: &settings };
        let report = solve(&problem).expect("a valid problem").report;
        (report.angular, report.area)
    };
    assert_eq!(report(&shape), report(&painted));
}

#[test]
fn impossible_stiffness_and_regions_are_refused_in_words() {
    let (grid, shape, settings) = (grid(6, Basis::Bspline), sheet(4), Settings::default());
    let refuse = |stiffness: Vec<f64>, region: Option<Region>| -> String {
        let shape = Shape { stiffness, ..shape.clone() };
        let pins = [PointPin { region, ..PointPin::new([0.5, 0.5], [0.5, 0.5]) }];
        let problem = Problem { grid: &grid, shape: &shape, pins: &pins, handles: &[], settings: &settings };
        solve(&problem).map(|_| ()).expect_err("a fault").to_string()
    };
    assert!(refuse(vec![1.0; 3], None).contains("32 triangles and 3 stiffnesses"));
    assert!(refuse([vec![1.0; 31], vec![-1.0]].concat(), None).contains("stiffness of triangle 31 is -1"));
    let region = Region { radius: 0.1, rigidity: 0.5, stiffness: 2.0 };
    for (bad, name) in [
        (Region { radius: 0.0, ..region }, "radius"),
        (Region { rigidity: 1.5, ..region }, "rigidity"),
        (Region { stiffness: f64::NAN, ..region }, "stiffness"),
    ] {
        assert!(refuse(Vec::new(), Some(bad)).contains(&format!("the {name} of the region of pin 0")));
    }
}
