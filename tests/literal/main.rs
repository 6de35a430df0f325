//! The solver against a second, literal reading of its formulas: dense, loop by loop, with numeric derivatives.
//!
//! For every energy, basis and dimension: the stated energies are those of the formulas, and after a global step the
//! derivative of their sum, rotations held, vanishes.

mod formulas;
mod problem;

use formulas::{Terms, rotations_at, terms};
use pinwarp::solve::problem_file::{ResultFile, run_text};
use problem::{Problem, points};
use serde_json::{Value, json};

const BASES: [&str; 4] = ["bernstein", "bspline", "bilinear", "barytri"];
const FORMS: [(&str, &str); 8] = [
    ("edge", "uniform"),
    ("edge", "cot"),
    ("vrd", "uniform"),
    ("vrd", "cot"),
    ("elem", "tri"),
    ("rims", "tri"),
    ("quad", "area"),
    ("stroke", "uniform"),
];
const REGULARISERS: [&str; 4] = ["gr", "noh", "affproj", "bend"];

fn run(problem: &Value, iterations: usize) -> ResultFile {
    let mut problem = problem.clone();
    problem["iterations"] = json!(iterations);
    run_text(&problem.to_string()).unwrap_or_else(|error| panic!("{error}: {problem}"))
}

/// A bent strip with obtuse triangles (negative cotangents), a vertex without edges and an empty triangle.
fn plane(form: (&str, &str), basis: &str, regulariser: &str) -> Value {
    let triangles =
        json!([[0, 1, 2], [1, 3, 2], [2, 3, 4], [3, 5, 4], [4, 5, 6], [5, 7, 6], [6, 7, 8], [1, 9, 3], [5, 5, 7]]);
    json!({
        "dims": [5, 4], "bbox": [[-0.1, 0.0], [1.9, 1.2]], "basis": basis,
        "form": form.0, "weights": form.1, "regulariser": regulariser,
        "lambdas": { "ml": 1.5, "mp": 80.0, "gp": 60.0, "gr": 0.02 },
        "vertices": [[0.1, 0.3], [0.2, 0.7], [0.45, 0.35], [0.62, 0.82], [0.8, 0.41], [1.1, 0.85], [1.2, 0.3],
            [1.45, 0.7], [1.75, 0.22], [0.3, 0.75], [1.0, 1.1]],
        "triangles": triangles,
        "strokes": [[0, 2, 4, 6, 8], [1, 3, 5, 7], [0, 1, 3, 2, 4, 0], [9, 9]],
        "pins": [{ "vertex": 0, "target": [0.1, 0.2] }, { "triangle": 6, "bary": [0.2, 0.3, 0.5], "target": [1.3, 0.9] },
            { "point": [2.1, 0.3], "target": [2.0, 0.9] }, { "point": [0.6, 0.6], "target": [0.55, 0.7] }],
        "handles": [{ "index": 7, "target": [0.9, 0.4] }, { "index": 19, "target": [1.9, 1.3] }],
    })
}

/// The surface of a skew octahedron with a loose fin.
fn space(form: (&str, &str), basis: &str, regulariser: &str) -> Value {
    let dims = if basis == "bspline" { [4, 5, 4] } else { [3, 4, 3] };
    json!({
        "dims": dims, "bbox": [[-1.2, -1.1, -1.0], [1.3, 1.2, 1.4]], "basis": basis,
        "form": form.0, "weights": form.1, "regulariser": regulariser,
        "lambdas": { "ml": 0.7, "mp": 100.0, "gp": 100.0, "gr": 0.01 },
        "vertices": [[0.9, 0.1, 0.0], [-0.8, 0.0, 0.2], [0.1, 0.95, 0.1], [0.0, -0.9, -0.1], [0.1, 0.0, 1.1],
            [-0.1, 0.2, -0.85], [1.1, 0.9, 0.8]],
        "triangles": [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5], [0, 2, 6]],
        "strokes": [[0, 2, 1, 3, 0], [4, 0, 5], [6, 4]],
        "pins": [{ "vertex": 4, "target": [0.5, 0.2, 1.2] }, { "vertex": 3, "target": [0.1, -0.9, 0.1] },
            { "triangle": 5, "bary": [0.3, 0.3, 0.4], "target": [-0.3, 0.5, -0.3] },
            { "point": [1.5, 0.2, 0.1], "target": [1.4, 0.4, 0.3] }],
        "handles": [{ "index": 1, "target": [-0.2, -1.0, -0.9] }],
    })
}

/// Largest difference of two sums, as a part of their sizes.
fn is_near(found: f64, wanted: f64, total: f64, slack: f64) -> bool {
    (found - wanted).abs() <= slack * (wanted.abs() + 1e-3 * total.abs()) + 1e-18
}

/// Compares three iterations of a problem with the formulas.
fn check<const D: usize>(text: &Value) {
    let problem = Problem::<D>::read(text);
    // The gradient of the lattice is a numeric one here.
    let slack = if problem.form == "quad" { 1e-6 } else { 1e-9 };
    for iterations in 1..=3 {
        let result = run(text, iterations);
        let before = if iterations == 1 { problem.rest_handles() } else { points(&run(text, iterations - 1).handles) };
        let (after, rotations): (Vec<[f64; D]>, _) = (points(&result.handles), rotations_at(&problem, &before));
        let wanted = terms(&problem, &after, &rotations);
        let found = result.energies[iterations - 1];
        let total = problem.total(&wanted);
        let found_terms = Terms { ml: found.ml, mp: found.mp, gp: found.gp, gr: found.gr };
        for (name, found, wanted) in found_terms.pairs(&wanted) {
            assert!(is_near(found, wanted, total, slack), "{name} is {found:e}, not {wanted:e}, in {text}");
        }
        assert!(is_near(found.total, total, total, slack), "the total is {:e}, not {total:e}, in {text}", found.total);
        let slope = largest_slope(&problem, &after, &rotations);
        assert!(slope <= slack, "the derivative is {slope:e} at the minimum, in {text}");
    }
}

/// Largest derivative by a coordinate of a handle, as a part of the second derivative there times the diagonal; both by
/// central differences, which are exact for squares.
fn largest_slope<const D: usize>(problem: &Problem<D>, handles: &[[f64; D]], rotations: &[formulas::Square<D>]) -> f64 {
    let energy = |handles: &[[f64; D]]| problem.total(&terms(problem, handles, rotations));
    let (here, step) = (energy(handles), 0.1 * problem.diagonal());
    let mut worst: f64 = 0.0;
    for (index, d) in (0..handles.len()).flat_map(|index| (0..D).map(move |d| (index, d))) {
        let mut moved = handles.to_vec();
        moved[index][d] += step;
        let up = energy(&moved);
        moved[index][d] -= 2.0 * step;
        let down = energy(&moved);
        let curvature = up - 2.0 * here + down;
        // Where handles are nearly free, rounding of the sum is all there is to see.
        worst = worst.max((0.5 * (up - down)).abs() / (curvature.abs() + 1e-3 * here.abs() + 1e-20));
    }
    worst
}

macro_rules! forms {
    ($($test:ident $number:literal)*) => { $(
        #[test]
        fn $test() {
            for (number, basis) in BASES.into_iter().enumerate() {
                // All regularisers for one basis, another one for each of the others.
                let regularisers = if number == $number % 4 { &REGULARISERS[..] } else { &REGULARISERS[number..=number] };
                for regulariser in regularisers {
                    check::<2>(&plane(FORMS[$number], basis, regulariser));
                    check::<3>(&space(FORMS[$number], basis, regulariser));
                }
            }
        }
    )* };
}

forms! {
    edges_of_weight_one 0
    edges_of_cotangents 1
    vertices_of_weight_one 2
    vertices_of_cotangents 3
    elements 4
    spokes_and_rims 5
    gradients_at_centroids 6
    strokes 7
}

#[test]
fn samples_given_in_the_file() {
    let mut problem = plane(FORMS[6], "barytri", "affproj");
    problem["samples"] = json!([[0.31, 0.43, 0.2], [0.93, 0.63, 0.3], [1.41, 0.37, 0.1], [0.52, 0.71, 0.25]]);
    check::<2>(&problem);
}

#[test]
fn regularisers_of_little_weight() {
    for (form, regulariser) in FORMS.into_iter().zip(REGULARISERS.into_iter().cycle()) {
        let mut problem = plane(form, "bernstein", regulariser);
        problem["dims"] = json!([3, 3]);
        problem["handles"] = json!([]);
        problem["lambdas"]["gr"] = json!(1e-7);
        check::<2>(&problem);
    }
}

#[test]
fn single_pins() {
    for (form, regulariser) in FORMS.into_iter().zip(REGULARISERS.into_iter().cycle()) {
        let mut problem = plane(form, "bernstein", regulariser);
        problem["handles"] = json!([]);
        problem["pins"] = json!([{ "vertex": 3, "target": [0.9, 1.1] }]);
        check::<2>(&problem);
    }
}

/// On a banded matrix the projector of `affproj` is a correction of low rank.
#[test]
fn affine_images_on_many_handles() {
    let mut problem = plane(FORMS[6], "bspline", "affproj");
    problem["dims"] = json!([12, 9]);
    check::<2>(&problem);
}

/// The comparison can fail.
#[test]
#[should_panic(expected = "ml is")]
fn another_energy_is_noticed() {
    let text = plane(FORMS[4], "bernstein", "gr");
    let mut problem = Problem::<2>::read(&text);
    problem.form = "rims".into();
    let result = run(&text, 1);
    let rotations = rotations_at(&problem, &problem.rest_handles());
    let wanted = terms(&problem, &points(&result.handles), &rotations).ml;
    let found = result.energies[0].ml;
    // At rest all rotations are the identity, in both energies; one step later they are not.
    assert!(is_near(found, wanted, 1.0, 1e-9), "rest differs");
    let (first, second): (Vec<[f64; 2]>, _) = (points(&result.handles), run(&text, 2));
    let wanted = terms(&problem, &points(&second.handles), &rotations_at(&problem, &first)).ml;
    let found = second.energies[1].ml;
    assert!(is_near(found, wanted, 1.0, 1e-9), "ml is {found:e}, not {wanted:e}");
}
