//! Solves that are cancelled, and how many polls a solve makes: polls follow its work, so they measure it, too.

use super::{distance, grid, sheet};
use pinwarp::lattice::{Basis, Grid};
use pinwarp::solve::{
    Cancel, Guard, HandlePin, PointPin, Problem, ResidualReason, Settings, Shape, SolveError, Solver, Targets,
};
use std::cell::Cell;

/// Pins spread over the box, each moved its own way.
fn spread(count: usize, by: f64) -> Vec<PointPin<2>> {
    let pin = |k: usize| {
        let t = k as f64;
        let at = [(0.618_033_988_7 * t).fract(), (0.5 + 0.754_877_666 * t).fract()].map(|x| 0.05 + 0.9 * x);
        PointPin::new(at, [at[0] + by * (3.3 * t).sin(), at[1] + by * (5.1 * t).cos()])
    };
    (0..count).map(pin).collect()
}

/// Two pairs of pins, the upper of which turns by so many degrees against the lower.
fn wound(degrees: f64) -> Targets<2> {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let low = [0.2, 0.8].map(|x| PointPin::new([x, 0.1], [x, 0.1]));
    let high = [0.2, -0.2].map(|x| PointPin::new([0.5 + x, 0.9], [0.5 + x * cos, 0.9 + x * sin]));
    Targets { pins: low.into_iter().chain(high).collect(), handles: Vec::new() }
}

/// The handles at the border, held where they rest.
fn border(grid: &Grid<2>) -> Vec<HandlePin<2>> {
    let is_outer = |handle: usize| {
        let place = grid.handle_coords(handle);
        (0..2).any(|axis| place[axis] == 0 || place[axis] + 1 == grid.dims[axis])
    };
    let outer = (0..grid.handle_count()).filter(|&handle| is_outer(handle));
    outer.map(|index| HandlePin { index, target: grid.rest_handle(index) }).collect()
}

/// A problem, and what is done with its solver.
struct Case {
    name: &'static str,
    grid: Grid<2>,
    pins: Vec<PointPin<2>>,
    handles: Vec<HandlePin<2>>,
    settings: Settings,
    /// Fewest polls of all that is done.
    least_polls: usize,
}

fn cases() -> Vec<Case> {
    let case = |name, grid: Grid<2>, count| Case {
        name,
        pins: spread(count, 0.03),
        handles: Vec::new(),
        settings: Settings::default(),
        least_polls: 8,
        grid,
    };
    let paper = Settings { acceleration: 5, ..Settings::paper() };
    let held = grid::<2>(40, Basis::Bspline);
    vec![
        case("local", grid(12, Basis::Bspline), 9),
        Case { least_polls: 100, ..case("global", grid(18, Basis::Bernstein), 32) },
        Case { least_polls: 40, handles: border(&held), ..case("many held handles", held.clone(), 6) },
        Case { least_polls: 15, ..case("more pins than handles", grid(6, Basis::Bspline), 300) },
        Case { settings: paper, ..case("edges", grid(9, Basis::Bernstein), 5) },
        Case {
            settings: Settings { guard: Guard::Limit, ..Settings::default() },
            pins: wound(170.0).pins,
            least_polls: 60,
            ..case("guard", grid(8, Basis::Bspline), 4)
        },
    ]
}

/// Builds, solves, follows a path and drags.
fn work(case: &Case, shape: &Shape<2>, cancel: &Cancel) -> Result<Vec<[f64; 2]>, SolveError> {
    let Case { grid, pins, handles, settings, .. } = case;
    let solver = Solver::build(&Problem { grid, shape, pins, handles, settings }, cancel)?;
    let solver = solver.with_cancel(cancel);
    let solved = solver.solve()?;
    let mut found = solver.update(pins, handles)?.lattice.handles;
    assert!(found == solved.lattice.handles);
    let half =
        |pin: &PointPin<2>| PointPin { target: std::array::from_fn(|d| 0.5 * (pin.at[d] + pin.target[d])), ..*pin };
    let path = [pins.iter().map(half).collect(), pins.clone()];
    let path = path.map(|pins: Vec<_>| Targets { pins, handles: handles.clone() });
    found.extend(solver.follow(&path)?.lattice.handles);
    let mut drag = solver.drag(&solved.lattice)?;
    found.extend(drag.follow(&path[0].pins, handles)?.handles);
    found.extend(drag.settle(&path[0].pins, handles)?.lattice.handles);
    Ok(found)
}

#[test]
fn a_cancelled_solve_ends_at_the_next_poll() {
    let shape = sheet::<2>(6);
    for case in cases() {
        let polls = Cell::new(0);
        let count = || {
            polls.set(polls.get() + 1);
            false
        };
        let whole = work(&case, &shape, &Cancel::when(&count)).expect(case.name);
        assert!(polls.get() >= case.least_polls, "{}: {} polls", case.name, polls.get());
        assert!(whole == work(&case, &shape, &Cancel::never()).expect(case.name), "{}: polls change bits", case.name);
        // Wherever it is cancelled it ends at once, without a panic, and is not asked again.
        let last = polls.get();
        for at in (0..4).chain((1..5).map(|k| k * last / 5)).chain([last - 1]) {
            let polls = Cell::new(0);
            let stop = || {
                polls.set(polls.get() + 1);
                polls.get() > at
            };
            let ended = work(&case, &shape, &Cancel::when(&stop));
            assert!(matches!(ended, Err(SolveError::Cancelled)), "{}: cancelled at poll {at} of {last}", case.name);
            assert_eq!(polls.get(), at + 1, "{}", case.name);
        }
    }
}

#[test]
fn wound_paths_are_cancelled_on_the_way() {
    let (grid, shape) = (grid(8, Basis::Bspline), sheet::<2>(6));
    let path: Vec<Targets<2>> = [0.0, 100.0, 200.0, 300.0].map(wound).to_vec();
    let settings = Settings::default();
    let problem = Problem { grid: &grid, shape: &shape, pins: &path[0].pins, handles: &[], settings: &settings };
    let solver = Solver::new(&problem).expect("a valid problem");
    let polls = Cell::new(0);
    let stop = || {
        polls.set(polls.get() + 1);
        polls.get() > 30
    };
    let ended = solver.with_cancel(&Cancel::when(&stop)).follow(&path);
    assert!(matches!(ended, Err(SolveError::Cancelled)) && polls.get() == 31, "{} polls", polls.get());
    assert!(solver.follow(&path).expect("not cancelled").report.is_converged);
}

#[test]
fn a_cancelled_move_leaves_the_drag_where_it_was() {
    let (grid, shape, settings) = (grid(12, Basis::Bspline), sheet::<2>(6), Settings::default());
    let pins = spread(5, 0.05);
    let problem = Problem { grid: &grid, shape: &shape, pins: &pins, handles: &[], settings: &settings };
    let solver = Solver::new(&problem).expect("a valid problem");
    let start = solver.solve().lattice;
    let moved: Vec<_> = pins.iter().map(|pin| PointPin { target: pin.at, ..*pin }).collect();
    let (is_wanted, stop) = (Cell::new(false), Cell::new(true));
    let hook = || !is_wanted.get() && stop.get();
    let cancel = Cancel::when(&hook);
    let mut cancelled = solver.with_cancel(&cancel).drag(&start).expect("a lattice of the solver");
    assert!(matches!(cancelled.follow(&moved, &[]), Err(SolveError::Cancelled)));
    // A hook that has asked to stop once is not asked again.
    is_wanted.set(true);
    assert!(matches!(cancelled.follow(&moved, &[]), Err(SolveError::Cancelled)));
}

/// Polls of a build and solve: they measure its work.
fn polls(count: usize, basis: Basis) -> usize {
    let (grid, shape, settings) = (grid::<2>(10, basis), sheet::<2>(6), Settings::default());
    let pins = spread(count, 0.01);
    let problem = Problem { grid: &grid, shape: &shape, pins: &pins, handles: &[], settings: &settings };
    let polls = Cell::new(0);
    let hook = || {
        polls.set(polls.get() + 1);
        false
    };
    let cancel = Cancel::when(&hook);
    let solution = Solver::build(&problem, &cancel).expect("solvable").with_cancel(&cancel).solve().expect("solved");
    assert_eq!(solution.report.pin_errors.len(), count);
    polls.get()
}

#[test]
fn work_grows_with_the_number_of_pins_and_no_faster() {
    for basis in [Basis::Bspline, Basis::Bilinear] {
        let [some, many] = [500, 2000].map(|count| polls(count, basis));
        assert!(many <= 4 * some + 16, "{basis:?}: {some} and {many} polls");
    }
}

#[test]
fn more_pins_than_handles_hold_what_they_agree_on() {
    let (grid, shape) = (grid::<2>(6, Basis::Bspline), sheet::<2>(6));
    let affine = |[x, y]: [f64; 2]| [1.1 * x + 0.2 * y + 0.05, 0.9 * y - 0.1 * x];
    let mut pins: Vec<PointPin<2>> = spread(200, 0.0).iter().map(|pin| PointPin::new(pin.at, affine(pin.at))).collect();
    let settings = Settings::default();
    let solve = |pins: &[PointPin<2>]| {
        let problem = Problem { grid: &grid, shape: &shape, pins, handles: &[], settings: &settings };
        Solver::new(&problem).expect("solvable").solve()
    };
    let agreed = solve(&pins);
    assert!(agreed.report.pin_errors.iter().all(|error| *error < 1e-6), "{:?}", agreed.report.pin_residuals);
    // One that contradicts the others is named, and so is what stands against it.
    pins[7].target[0] += 0.1;
    let torn = solve(&pins);
    let residual = torn.report.pin_residuals.iter().max_by(|a, b| a.distance.total_cmp(&b.distance)).expect("torn");
    assert_eq!(residual.pin, 7);
    let ResidualReason::Conflict(pinwarp::solve::ConstraintOwner::Pin(rival)) = residual.reason else {
        panic!("{:?}", residual.reason)
    };
    assert!(rival != 7 && distance(pins[rival].at, pins[7].at) < 0.5, "{rival}");
}
