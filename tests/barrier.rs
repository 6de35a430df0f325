//! The barrier: hard random pins fold nothing, pins that can hold do, and what is clear is left alone to the bit.

#[path = "support/figure.rs"]
#[expect(dead_code, reason = "poses are for other tests")]
mod figure;
#[path = "support/hard.rs"]
mod hard;

use hard::{HARD, Hard, hard};
use pinwarp::lattice::{Folds, Lattice};
use pinwarp::solve::{
    Energy, Guard, PointPin, Problem, ResidualReason, Settings, Shape, Solution, Solver, active_cells, solve,
};
use rayon::prelude::*;
use std::sync::OnceLock;

fn with(guard: Guard) -> Settings {
    Settings { guard, ..Settings::default() }
}

/// Parts of a side of a triangle between the points that are looked at.
const PARTS: usize = 6;

/// Points of the model, many a triangle, around which the warp turns it over. Chords of long triangles may cross where the warp is curved.
fn flips(lattice: &Lattice<2>, shape: &Shape<2>) -> usize {
    let is_turned_over = |at: [f64; 2]| {
        let [[a, b], [c, d]] = lattice.evaluate_with_gradient(at).gradient;
        a * d - b * c <= 0.0
    };
    let flipped = |corners: &[u32; 3]| {
        let [p, q, r] = corners.map(|corner| shape.points[corner as usize]);
        let at = |(i, j): (usize, usize)| {
            let [u, v] = [i, j].map(|k| k as f64 / PARTS as f64);
            [0, 1].map(|d| p[d] + u * (q[d] - p[d]) + v * (r[d] - p[d]))
        };
        let places = (0..=PARTS).flat_map(|i| (0..=PARTS - i).map(move |j| (i, j)));
        places.map(at).filter(|&at| is_turned_over(at)).count()
    };
    shape.triangles.iter().map(flipped).sum()
}

/// Folds in all of the cells that hold some of the model, which the barrier covers. Reports count those on the model alone.
fn folds(lattice: &Lattice<2>, shape: &Shape<2>) -> Folds<2> {
    lattice.folds(&active_cells(&lattice.grid, shape))
}

fn run(Hard { grid, shape, pins }: &Hard, guard: Guard) -> Solution<2> {
    solve(&Problem { grid, shape, pins, handles: &[], settings: &with(guard) }).expect("a valid problem")
}

/// The solutions of all problems without the barrier and with it.
fn solutions() -> &'static [[Solution<2>; 2]] {
    static SOLUTIONS: OnceLock<Vec<[Solution<2>; 2]>> = OnceLock::new();
    let of = |number| {
        let problem = hard(number);
        [Guard::Report, Guard::Limit].map(|guard| run(&problem, guard))
    };
    SOLUTIONS.get_or_init(|| (0..HARD).into_par_iter().map(of).collect())
}

#[test]
fn hard_random_pins_fold_nothing() {
    let (mut folded, mut unconverged, mut given_way, mut iterations) = ([[0; 3]; 2], 0, 0, Vec::new());
    for (number, solutions) in (0..).zip(solutions()) {
        let Hard { shape, .. } = hard(number);
        for ((guard, sums), solution) in [Guard::Report, Guard::Limit].into_iter().zip(&mut folded).zip(solutions) {
            let Solution { lattice, report, .. } = solution;
            let in_cells = folds(lattice, &shape);
            let (flips, cells) = (flips(lattice, &shape), in_cells.active_count);
            assert!(
                report.folded_model_cells <= cells && report.min_cell_det >= in_cells.min_det,
                "{number}: {report:?}"
            );
            let found = [usize::from(flips + cells > 0), flips, cells];
            sums.iter_mut().zip(found).for_each(|(sum, found)| *sum += found);
            if guard == Guard::Limit {
                unconverged += usize::from(!report.is_converged);
                given_way += usize::from(report.is_held_back);
                iterations.push(report.iterations);
                assert!(found == [0; 3] && in_cells.min_det > 0.0, "{number}: {found:?} {report:?}");
                // Either all pins hold, or it is said which do not.
                let missed = report.pin_errors.iter().filter(|error| **error > 1e-4).count();
                assert!(missed <= report.pin_residuals.len(), "{number}: {report:?}");
                let gave_way = report.pin_residuals.iter().any(|miss| miss.reason == ResidualReason::Guard);
                assert!(report.is_held_back || !gave_way, "{number}: {report:?}");
            }
        }
    }
    iterations.sort_unstable();
    let [free, held] = folded;
    eprintln!(
        "{} of {HARD} problems fold without the barrier ({} points of triangles, {} cells), {} with it; in {given_way} pins give way; \
         {unconverged} unconverged; {} solves in the median, {} at most",
        free[0],
        free[1],
        free[2],
        held[0],
        iterations[iterations.len() / 2],
        iterations[iterations.len() - 1]
    );
    // The problems are hard, and the comparison can fail.
    assert!(free[0] > 150 && free[1] > 1000, "{free:?}");
    assert!(unconverged <= 2, "{unconverged}");
}

#[test]
fn clear_problems_keep_their_bits() {
    let mut clear = 0;
    for (number, [free, held]) in (0..).zip(solutions()) {
        let clear_by = folds(&free.lattice, &hard(number).shape).min_det;
        if clear_by >= 0.2 {
            assert_eq!(held, free, "{number}");
            clear += 1;
        }
    }
    assert!(clear > 20, "{clear}");
}

#[test]
fn drags_and_other_energies_fold_nothing_either() {
    for number in 0..12 {
        let Hard { grid, shape, pins } = hard(number);
        let rest: Vec<PointPin<2>> = pins.iter().map(|pin| PointPin::new(pin.at, pin.at)).collect();
        for energy in [Energy::Area, Energy::Element] {
            let settings = Settings { energy, ..with(Guard::Limit) };
            let problem = Problem { grid: &grid, shape: &shape, pins: &rest, handles: &[], settings: &settings };
            let solver = Solver::new(&problem).expect("a valid problem");
            let mut drag = solver.drag(&grid.at_rest()).expect("a lattice of the solver");
            for step in 1..=5 {
                let share = f64::from(step) / 5.0;
                let moved = pins.iter().map(|pin| PointPin {
                    target: std::array::from_fn(|d| pin.at[d] + share * (pin.target[d] - pin.at[d])),
                    ..*pin
                });
                let moved: Vec<PointPin<2>> = moved.collect();
                let lattice = drag.follow(&moved, &[]).expect("the same pins");
                let settled = drag.settle(&moved, &[]).expect("the same pins");
                for lattice in [&lattice, &settled.lattice] {
                    let folds = folds(lattice, &shape);
                    assert_eq!(folds.active_count, 0, "{number} {energy:?} {share}: {folds:?} {:?}", settled.report);
                }
            }
        }
    }
}
