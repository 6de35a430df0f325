//! Pins that come close: they give way where they ask for more than the lattice can do between them, smoothly, and hold elsewhere.

#[path = "support/figure.rs"]
mod figure;

use crate::internal::numbers::distance;
use crate::internal::solving::run;
use figure::{Pose, around, figure, posed};
use pinwarp::lattice::{Basis, Lattice};
use pinwarp::solve::{PointPin, Problem, ResidualReason, Settings, Shape, Solution, Solver};

/// A pixel of a frame of 1080 lines that the box of the figure fills.
const PIXEL: f64 = 2.4 / 1080.0;

/// A miss that nobody sees, pixels.
const EXACT: f64 = 0.05;

/// Farthest that a vertex goes from one lattice to another, pixels.
fn apart(a: &Lattice<2>, b: &Lattice<2>, shape: &Shape<2>) -> f64 {
    shape.points.iter().map(|&point| distance(a.evaluate(point), b.evaluate(point))).fold(0.0, f64::max) / PIXEL
}

/// The figure's pins at rest and a pair `gap` pixels apart about a place, of which the second goes `by` pixels more than the first.
fn with_pair(place: [f64; 2], gap: f64, by: [f64; 2]) -> Vec<PointPin<2>> {
    let mut pins = posed(Pose::default());
    for side in [-0.5, 0.5] {
        let at = [place[0] + side * gap * PIXEL, place[1]];
        pins.push(PointPin::new(at, [at[0] + side * by[0] * PIXEL, at[1] + side * by[1] * PIXEL]));
    }
    pins
}

/// Triangles of another orientation than at rest.
fn flips(lattice: &Lattice<2>, shape: &Shape<2>) -> usize {
    let area = |[p, q, r]: [[f64; 2]; 3]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    let is_flipped = |corners: &&[u32; 3]| {
        let rest = corners.map(|corner| shape.points[corner as usize]);
        area(rest) * area(rest.map(|point| lattice.evaluate(point))) <= 0.0
    };
    shape.triangles.iter().filter(is_flipped).count()
}

#[test]
fn close_pins_move_the_model_no_more_than_twice_as_far_as_the_papers() {
    let (grid, shape) = (around(10, Basis::Bspline), figure(0.08));
    let rest = grid.at_rest();
    for (gap, by) in [(1.0, 2.0), (10.0, 40.0)] {
        for place in [[0.0, 0.1], [0.5, 0.33], [-0.3, -0.7]] {
            for towards in [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.6, -0.8]] {
                let mut pins = with_pair(place, gap, towards.map(|x| x * by));
                // One stays, the other goes all the way.
                let (first, last) = (pins.len() - 2, pins.len() - 1);
                pins[first].target = pins[first].at;
                pins[last].target = std::array::from_fn(|d| pins[last].at[d] + by * PIXEL * towards[d]);
                let [ours, paper] =
                    [Settings::default(), Settings::paper()].map(|settings| run(&grid, &shape, &pins, &settings));
                let [moved, most] = [&ours, &paper].map(|solution| apart(&solution.lattice, &rest, &shape));
                eprintln!("{gap} px apart, {by} px, {place:?} {towards:?}: {moved:.2} px, paper {most:.2} px");
                assert!(moved <= 2.0 * most, "{gap} {by} {place:?} {towards:?}: {moved} px, paper {most} px");
                assert_eq!(flips(&ours.lattice, &shape), 0);
                // What is given up is told.
                let told = &ours.report.pin_residuals;
                assert!(
                    told.iter().any(|miss| miss.pin == last && matches!(miss.reason, ResidualReason::Yielding(_))),
                    "{told:?}"
                );
                assert!(
                    ours.report.pin_errors[..first].iter().all(|&error| error < EXACT * PIXEL),
                    "{:?}",
                    ours.report
                );
            }
        }
    }
}

#[test]
fn pins_below_the_limit_hold_exactly() {
    let (grid, shape) = (around(10, Basis::Bspline), figure(0.08));
    let span = grid.spacing(0) / PIXEL;
    for share in [0.05, 0.2, 0.5, 0.9, 1.1] {
        // Almost as much as max_stretch allows at this distance.
        let gap = share * span;
        let t = f64::min(share / 0.44, 1.0);
        let by = 0.95 * 3.0 * t * t * (3.0 - 2.0 * t) * gap;
        for towards in [[1.0, 0.0], [0.0, 1.0]] {
            let pins = with_pair([0.0, 0.1], gap, towards.map(|x| x * by));
            let report = run(&grid, &shape, &pins, &Settings::default()).report;
            assert!(report.pin_errors.iter().all(|&error| error < EXACT * PIXEL), "{share} {towards:?} {report:?}");
        }
    }
}

/// Movements from each solution to the next, pixels.
fn steps(solutions: &[Solution<2>], shape: &Shape<2>) -> Vec<f64> {
    solutions.windows(2).map(|pair| apart(&pair[0].lattice, &pair[1].lattice, shape)).collect()
}

#[test]
fn pins_that_cross_break_and_jerk_nothing() {
    let (grid, shape, settings) = (around(10, Basis::Bspline), figure(0.08), Settings::default());
    let rest = grid.at_rest();
    // A pin passes another one, which is pulled up by 43 px: 20 px below it, through it, and 1 px away; then in finer steps.
    for (height, range, step) in [(-20.0, 150.0, 1.0), (0.0, 150.0, 1.0), (1.0, 150.0, 1.0), (0.0, 4.0, 0.02)] {
        let count = (2.0 * range / step) as usize;
        let at = |k: usize| -range + step * k as f64;
        let solutions: Vec<_> = (0..=count)
            .map(|k| {
                let mut pins = posed(Pose::default());
                pins.push(PointPin::new([0.0, 0.1], [0.0, 0.1 + 43.0 * PIXEL]));
                let place = [at(k) * PIXEL, 0.1 + height * PIXEL];
                pins.push(PointPin::new(place, place));
                run(&grid, &shape, &pins, &settings)
            })
            .collect();
        let steps = steps(&solutions, &shape);
        let (worst, at_step) =
            steps.iter().zip(0..).fold((0.0, 0), |most, (&step, k)| if step > most.0 { (step, k) } else { most });
        let moved = solutions.iter().map(|solution| apart(&solution.lattice, &rest, &shape)).fold(0.0, f64::max);
        let flipped = solutions.iter().map(|solution| flips(&solution.lattice, &shape)).max();
        eprintln!(
            "{height} px away in steps of {step} px: moved {moved:.1} px, at most {worst:.2} px a step, at {:.2}, flips {flipped:?}",
            at(at_step)
        );
        assert!(moved < 160.0, "{moved} px");
        assert!(worst < 20.0 * step + 0.2, "{worst} px at {}", at(at_step));
        assert_eq!(flipped, Some(0));
    }
}

#[test]
fn a_pin_that_fades_in_among_others_jerks_nothing() {
    let (grid, shape, settings) = (around(10, Basis::Bspline), figure(0.08), Settings::default());
    let faded = |weight: f64| {
        let mut pins = with_pair([0.05, 0.05], 12.0, [30.0, 10.0]);
        pins.push(PointPin { weight, ..PointPin::new([0.05, 0.07], [0.1, 0.03]) });
        run(&grid, &shape, &pins, &settings).lattice
    };
    let without = run(&grid, &shape, &with_pair([0.05, 0.05], 12.0, [30.0, 10.0]), &settings).lattice;
    let weights: Vec<f64> = (-80..=0).map(|k| 10_f64.powf(0.1 * f64::from(k))).collect();
    let lattices: Vec<_> = weights.iter().map(|&weight| faded(weight)).collect();
    let steps: Vec<f64> = lattices.windows(2).map(|pair| apart(&pair[0], &pair[1], &shape)).collect();
    eprintln!("{steps:.3?}");
    assert!(apart(&without, &lattices[0], &shape) < 0.5);
    assert!(steps.iter().all(|&step| step < 10.0), "{steps:?}");
    // From soft to hard.
    assert!(apart(&faded(1.0 - 1e-9), &faded(1.0), &shape) < 0.05);
}

#[test]
fn a_cluster_of_pins_that_disagree_stays_where_it_is_on_average() {
    let (grid, shape, settings) = (around(10, Basis::Bspline), figure(0.08), Settings::default());
    let mut pins = posed(Pose::default());
    let first = pins.len();
    for k in 0..5 {
        let (sin, cos) = (f64::from(k) * 72_f64.to_radians()).sin_cos();
        pins.push(PointPin::new([0.002 * f64::from(k), 0.1], [0.05 * cos, 0.1 + 0.05 * sin]));
    }
    let solution = run(&grid, &shape, &pins, &settings);
    let (mut mean, mut wanted) = ([0.0; 2], [0.0; 2]);
    for pin in &pins[first..] {
        let image = solution.lattice.evaluate(pin.at);
        (0..2).for_each(|d| (mean[d], wanted[d]) = (mean[d] + image[d] / 5.0, wanted[d] + pin.target[d] / 5.0));
    }
    assert!(distance(mean, wanted) < EXACT * PIXEL, "{mean:?} {wanted:?}");
    assert_eq!(flips(&solution.lattice, &shape), 0);
    assert!(apart(&solution.lattice, &grid.at_rest(), &shape) < 60.0);
}

#[test]
fn updates_and_drags_yield_like_solves() {
    let (grid, shape, settings) = (around(10, Basis::Bspline), figure(0.08), Settings::default());
    let rest = with_pair([0.3, 0.3], 10.0, [0.0, 0.0]);
    let problem = Problem { grid: &grid, shape: &shape, pins: &rest, handles: &[], settings: &settings };
    let solver = Solver::new(&problem).expect("a valid problem");
    let mut drag = solver.drag(&solver.solve().lattice).expect("a lattice of the solver");
    for by in [5.0, 20.0, 40.0, 80.0, 20.0, 0.0] {
        let pins = with_pair([0.3, 0.3], 10.0, [0.6 * by, 0.8 * by]);
        let alone = run(&grid, &shape, &pins, &settings);
        let updated = solver.update(&pins, &[]).expect("the same pins");
        let settled = drag.settle(&pins, &[]).expect("the same pins");
        assert!(alone.report.is_converged && updated.report.is_converged && settled.report.is_converged);
        assert!(apart(&alone.lattice, &updated.lattice, &shape) < 0.01, "{by}");
        assert!(apart(&alone.lattice, &settled.lattice, &shape) < 0.01, "{by}");
        assert!(apart(&alone.lattice, &drag.follow(&pins, &[]).expect("the same pins"), &shape) < 0.1, "{by}");
    }
}
