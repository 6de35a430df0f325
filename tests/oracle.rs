//! The solver against reference cases of an independent program: handles, vertices, energies, measures.
//!
//! The cases are not part of the package; without them every test here says so, and fails with `PINWARP_REQUIRE_SHARED=1`.

#[path = "support/shared.rs"]
mod shared;

use pinwarp::lattice::{AxisTerms, Basis};
use pinwarp::solve::problem_file::{ResultFile, run_text};
use serde_json::Value;

/// Text of a case, or nothing where the cases are absent.
fn case(name: &str) -> Option<String> {
    let path = shared::shared(&format!("oracle/{name}"))?;
    Some(std::fs::read_to_string(path).expect("a case is text"))
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).expect("cases are JSON")
}

fn points(value: &Value) -> Vec<Vec<f64>> {
    serde_json::from_value(value.clone()).expect("a list of points")
}

fn largest_gap(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    assert_eq!(a.len(), b.len());
    let gaps = a.iter().flatten().zip(b.iter().flatten()).map(|(x, y)| (x - y).abs());
    gaps.fold(0.0, |most: f64, gap| if gap <= most { most } else { gap })
}

fn diagonal(problem: &Value) -> f64 {
    let bbox = points(&problem["bbox"]);
    bbox[0].iter().zip(&bbox[1]).map(|(lo, hi)| (hi - lo).powi(2)).sum::<f64>().sqrt()
}

/// The case with another number of iterations.
fn run_for(problem: &Value, iterations: &Value) -> ResultFile {
    let mut problem = problem.clone();
    problem["iterations"] = iterations.clone();
    run_text(&problem.to_string()).expect("a valid problem")
}

/// Solves a case and compares all that it states.
fn compare(name: &str) {
    let Some(text) = case(name) else { return };
    let problem = json(&text);
    let (expected, diagonal) = (&problem["expected"], diagonal(&problem));
    let result = run_text(&text).expect("a valid problem");
    let gap = largest_gap(&result.vertices, &points(&expected["V"]));
    assert!(gap <= 1e-9 * diagonal, "{name}: V is {gap:e} off");
    let gap = largest_gap(&result.handles, &points(&expected["P"]));
    assert!(gap <= 1e-8 * diagonal, "{name}: P is {gap:e} off");
    assert_eq!(Some(result.iterations as u64), problem["iterations"].as_u64());
    compare_energies(name, &result, &expected["energies"]);
    compare_measures(name, &result, &expected["measures"]);
    for (count, key) in [(Value::from(1), "P_after_1"), (expected["converged_iterations"].clone(), "P_converged")] {
        let gap = largest_gap(&run_for(&problem, &count).handles, &points(&expected[key]));
        assert!(gap <= 1e-8 * diagonal, "{name}: {key} is {gap:e} off");
    }
}

fn compare_energies(name: &str, result: &ResultFile, expected: &Value) {
    let expected = expected.as_array().expect("a list");
    assert_eq!(result.energies.len(), expected.len());
    for (found, wanted) in result.energies.iter().zip(expected) {
        for (key, value) in
            [("ml", found.ml), ("mp", found.mp), ("gp", found.gp), ("gr", found.gr), ("total", found.total)]
        {
            let wanted = wanted[key].as_f64().expect("a number");
            // Terms a thousandth of the total and less are differences of larger numbers.
            let slack = 1e-7 * wanted.abs() + 1e-12 * found.total;
            assert!((value - wanted).abs() <= slack, "{name}: {key} is {value:e}, not {wanted:e}");
        }
    }
}

/// Measures; in case 17 the reference counts three slivers of rounding size as triangles, which decide some, and
/// whose inverse areas shake the others in the sixth digit.
fn compare_measures(name: &str, result: &ResultFile, expected: &Value) {
    let found = serde_json::to_value(result.measures).expect("numbers");
    let rounding = ["ang_rad", "area_abs_u", "flips", "min_det", "min_s", "max_s"];
    for (key, wanted) in expected.as_object().expect("keys").iter() {
        if name.starts_with("17_") && rounding.contains(&key.as_str()) {
            continue;
        }
        let (wanted, found) = (wanted.as_f64().expect("a number"), found[key].as_f64().expect("the same keys"));
        let slack = if name.starts_with("17_") { 1e-5 } else { 1e-7 };
        assert!((found - wanted).abs() <= slack * (1.0 + wanted.abs()), "{name}: {key} is {found}, not {wanted}");
    }
}

macro_rules! cases {
    ($($test:ident $file:literal)*) => { $(#[test] fn $test() { compare($file); })* };
}

cases! {
    unit_square "01_unit_square_3x3.json"
    uniform_edges "02_ginger_10x10_edge_uniform_gr.json"
    cotangent_edges "03_ginger_10x10_edge_cot_gr.json"
    pins_of_all_kinds_and_handles "05_ginger_5x7_mixed_pins_handles.json"
    bspline_and_bend "08_ginger_9x8_bspline_bend.json"
    single_pin "10_bird_single_pin_gr_stretch.json"
    area_at_centroids "14_frog_8x8_quad.json"
    space_cotangent "15_blob502_5x5x5_edge_cot.json"
    screen_teapot "17_teapot_screen_10x10_uniform.json"
    spokes_and_rims "12_frog_8x8_rims.json"
    space_affine "22_blob502_4x4x4_affproj.json"
    isolated_vertex_and_empty_triangle "19_degenerate_isolated_vertex_zero_triangle.json"
}

#[test]
fn a_wrong_case_is_noticed() {
    let Some(text) = case("01_unit_square_3x3.json") else { return };
    let mut problem = json(&text);
    problem["expected"]["P"][3][0] = Value::from(1e-6);
    let result = run_text(&text).expect("a valid problem");
    assert!(largest_gap(&result.handles, &points(&problem["expected"]["P"])) > 1e-8 * diagonal(&problem));
}

#[test]
fn basis_values() {
    let Some(text) = case("units.json") else { return };
    let units = json(&text);
    for (key, basis) in [("bernstein", Basis::Bernstein), ("bspline", Basis::Bspline), ("bilinear", Basis::Bilinear)] {
        for unit in units[key].as_array().expect("a list") {
            let count = unit["n"].as_u64().expect("a number") as usize;
            let terms: AxisTerms = AxisTerms::at(basis, count, unit["t"].as_f64().expect("a number"));
            let lists = [("B", terms.values()), ("dB", terms.slopes())];
            for (name, found) in lists.into_iter().filter(|(name, _)| unit.get(name).is_some()) {
                let wanted: Vec<f64> = serde_json::from_value(unit[name].clone()).expect("numbers");
                let mut all = vec![0.0; count];
                all[terms.first..terms.first + found.len()].copy_from_slice(found);
                let gap = all.iter().zip(&wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(gap < 1e-12, "{basis:?} {name} of {count} handles: {gap:e}");
            }
        }
    }
}

#[test]
fn measures_of_two_triangles() {
    let Some(text) = case("units.json") else { return };
    let unit = &json(&text)["measures"];
    let target = unit["Vd"].as_array().expect("a list").iter();
    let handles: Vec<Value> =
        target.enumerate().map(|(index, target)| serde_json::json!({ "index": index, "target": target })).collect();
    // Handles of bilinear cells are the corners of the square: moving all four moves the mesh.
    let problem = serde_json::json!({
        "dims": [2, 2], "bbox": [[0, 0], [1, 1]], "basis": "bilinear", "form": "edge", "regulariser": "gr", "iterations": 1,
        "lambdas": { "ml": 0, "gp": 1 }, "vertices": unit["V"], "triangles": unit["F"], "handles": handles,
    });
    let result = run_text(&problem.to_string()).expect("a valid problem");
    let found = serde_json::to_value(result.measures).expect("numbers");
    let known: Vec<(&String, &Value)> = found.as_object().expect("keys").iter().collect();
    assert_eq!(known.iter().filter(|(key, _)| unit.get(key.as_str()).is_some()).count(), 14);
    for (key, found) in known {
        let (found, wanted) = (found.as_f64().expect("a number"), unit[key].as_f64().expect("the same keys"));
        assert!((found - wanted).abs() < 1e-12, "{key} is {found}, not {wanted}");
    }
}
