//! The paper's tables for models of the same vertex counts: `cargo bench --bench paper`.
//!
//! In: `scenes/figures`. Out: Tables 1 and 2 in the paper's layout next to its printed figures, with medians over all poses.
//! With `-- sweep KIND WEIGHTS PADS RADIUS,WEIGHT`, such medians for other regularisers, paddings of the box, and discs of
//! pins.

#[path = "support/stopwatch.rs"]
mod stopwatch;

use pinwarp::compare::{self, Entry};
use pinwarp::lattice::{Basis, Grid};
use pinwarp::solve::methods::{self, Arap, DefaultLpFfd, Deformer, PaperLpFfd, inverse_ffd};
use pinwarp::solve::problem_file::{Figure, Figures, read_figure};
use pinwarp::solve::{Problem, Regularizer, Settings, SmoothingDisc};
use std::path::Path;
use stopwatch::fastest;

/// Model, and the paper's milliseconds: first step of [Sorkine + Noh]; its second step at 5 x 5, 10 x 10 and 15 x 15; the
/// paper's own method at these.
const TABLE_2: [(&str, f64, [f64; 3], [f64; 3]); 6] = [
    ("ginger", 15.6, [3.0, 6.8, 19.2], [3.2, 6.4, 16.4]),
    ("frog", 23.8, [4.0, 8.6, 26.2], [4.4, 8.8, 25.8]),
    ("panda", 31.8, [5.4, 15.0, 34.0], [6.2, 15.0, 32.2]),
    ("unicorn", 34.2, [6.6, 22.6, 42.2], [6.6, 16.4, 34.0]),
    ("girl", 51.6, [8.0, 31.6, 67.0], [11.8, 21.8, 43.0]),
    ("dinosaur", 69.8, [9.4, 36.6, 81.4], [15.6, 26.8, 44.2]),
];
const DIMS: [usize; 3] = [5, 10, 15];

/// The paper's Table 1: angular and area distortion, by key of the method.
const TABLE_1: [(&str, [f64; 2]); 4] = [
    ("hsu", [0.21808, 0.14608]),
    ("mls", [0.21793, 0.15529]),
    ("arap", [0.20432, 0.24516]),
    ("paper", [0.14694, 0.11644]),
];

fn figure(name: &str) -> Figure<2> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/figures").join(format!("{name}.json"));
    match read_figure(&path) {
        Ok(Figures::Plane(figure)) => figure,
        Ok(Figures::Space(_)) => unreachable!("figures are flat"),
        Err(error) => {
            eprintln!("{error}");
            std::process::exit(2)
        }
    }
}

fn figures() -> Vec<Figure<2>> {
    TABLE_2.iter().map(|row| figure(row.0)).collect()
}

fn entry(method: &dyn Deformer<2>, problem: &Problem<2>) -> Entry<2> {
    compare::run(method, problem).unwrap_or_else(|error| {
        eprintln!("{}: {error}", method.name());
        std::process::exit(2)
    })
}

/// The median; of an even number of values, the mean of the two middle ones.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    0.5 * (values[(values.len() - 1) / 2] + values[values.len() / 2])
}

fn table_1(figures: &[Figure<2>]) {
    println!("Table 1. Angular and area distortion on the ginger man (10 x 10), pose '{}'", figures[0].poses[0].name);
    println!("printed: the paper's own model, pose and formulas (after Wang et al. 2016; not public in full).");
    println!("ours: mean change of a triangle corner in rad; mean |s1 s2 - 1| by area.\n");
    println!("{:24}|  printed            |  ours, first pose   |  ours, median of all poses of all models", "Method");
    println!("{:24}|  Angular   Area     |  Angular   Area     |  Angular   Area   pin error  folded cells (mean)", "");
    for method in methods::all::<2>() {
        let printed = TABLE_1.iter().find(|row| row.0 == method.key());
        let printed = printed.map_or_else(|| "     -         -   ".into(), |(_, [a, b])| format!("  {a:.5}   {b:.5} "));
        let all = all_poses(method.as_ref(), figures);
        let first = all[0].metrics;
        let pick = |pick: fn(&Entry<2>) -> f64| median(all.iter().map(pick).collect());
        let folded = all.iter().map(|entry| entry.metrics.folded_cells as f64).sum::<f64>() / all.len() as f64;
        println!(
            "{:24}|{printed} |   {:.4}    {:.4}   |   {:.4}    {:.4}  {:9.1e}  {folded:5.1}",
            method.name(),
            first.angle,
            first.area,
            pick(|entry| entry.metrics.angle),
            pick(|entry| entry.metrics.area),
            pick(|entry| entry.metrics.pin_error),
        );
    }
}

fn all_poses(method: &dyn Deformer<2>, figures: &[Figure<2>]) -> Vec<Entry<2>> {
    let poses = figures.iter().flat_map(|figure| figure.poses.iter().map(move |pose| figure.problem(pose)));
    poses.map(|problem| entry(method, &problem)).collect()
}

fn table_2(figures: &[Figure<2>]) {
    println!(
        "\nTable 2. Computation time, one thread, nothing precomputed [ms]; ours, and in brackets the paper's (1.5 GHz)"
    );
    println!(
        "ARAP and the preset run ten iterations, since the paper tells no number; 'default' runs to a step of 1e-6.\n"
    );
    println!("Model      #V   #P       | Sorkine 2007     + Noh 2021       | paper preset            | default, ratio");
    let ten = Arap { iteration_limit: 10, tolerance: -1.0 };
    let preset = PaperLpFfd { settings: Settings { iteration_limit: 10, tolerance: -1.0, ..Settings::paper() } };
    for (figure, (name, first, second, ours)) in figures.iter().zip(TABLE_2) {
        let pose = &figure.poses[0];
        let arap = fastest(|| ten.deform(&figure.shape, &pose.pins)).0;
        let moved = ten.deform(&figure.shape, &pose.pins).map(|moved| moved.0).unwrap_or_default();
        for (k, dims) in DIMS.into_iter().enumerate() {
            let own = Grid { dims: [dims; 2], ..figure.grid.clone() };
            let theirs = Grid { basis: Basis::Bernstein, ..own.clone() };
            let inverse = fastest(|| inverse_ffd(&theirs, &figure.shape.points, &moved, 1e-2)).0;
            let problem = figure.problem(pose);
            let paper = fastest(|| preset.deform(&Problem { grid: &theirs, ..problem })).0;
            let house = fastest(|| DefaultLpFfd.deform(&Problem { grid: &own, ..problem })).0;
            let (model, count) =
                if k == 0 { (name, figure.shape.points.len().to_string()) } else { ("", String::new()) };
            let cell = if k == 0 { format!("{arap:6.2} ({first:4.1})") } else { " ".repeat(13) };
            println!(
                "{model:9} {count:>4}  {:7}  | {cell}    {inverse:6.2} ({:4.1})   | {paper:6.2} ({:4.1}) {:5.1}x  | {house:6.2} {:5.1}x",
                format!("{dims} x {dims}"),
                second[k],
                ours[k],
                ours[k] / paper,
                ours[k] / house
            );
        }
    }
}

/// The default settings with other regularisers, weights and boxes: medians over all poses, folds, and how far handles
/// stray.
fn sweep(figures: &[Figure<2>], (kind, disc): (Regularizer, SmoothingDisc), weights: &[f64], pads: &[f64]) {
    println!(
        "regulariser    weight    pad | angle   area   | folded cells  stray | iterations  flips | worst angle  area"
    );
    for &pad in pads {
        let figures: Vec<_> = figures.iter().map(|figure| padded(figure, pad)).collect();
        for &weight in weights {
            let mut settings = Settings::default().with_regularizer(kind);
            settings.lambdas.regularizer = weight;
            settings.disc = disc;
            let figures: Vec<_> =
                figures.iter().map(|figure| Figure { settings: settings.clone(), ..figure.clone() }).collect();
            let all = all_poses(&DefaultLpFfd, &figures);
            let list = |pick: fn(&Entry<2>) -> f64| all.iter().map(pick).collect::<Vec<f64>>();
            let mean = |pick: fn(&Entry<2>) -> f64| list(pick).iter().sum::<f64>() / all.len() as f64;
            let most = |pick: fn(&Entry<2>) -> f64| list(pick).into_iter().fold(0.0, f64::max);
            println!(
                "{:11} {weight:9.1e}  {pad:5.2} | {:.4} {:.4} | {:8.1}      {:5.2} | {:6.0}      {:4.0}  | {:.4}       {:.4}",
                format!("{kind:?}"),
                median(list(|entry| entry.metrics.angle)),
                median(list(|entry| entry.metrics.area)),
                mean(|entry| entry.metrics.folded_cells as f64),
                median(list(|entry| entry.metrics.stray)),
                median(list(|entry| entry.metrics.iterations as f64)),
                most(|entry| entry.metrics.flips as f64),
                most(|entry| entry.metrics.angle),
                most(|entry| entry.metrics.area),
            );
        }
    }
}

/// The figure with its box padded by a fraction of its size. The stored box is the bounding box of the model.
fn padded(figure: &Figure<2>, pad: f64) -> Figure<2> {
    let mut figure = figure.clone();
    let grid = &mut figure.grid;
    for d in 0..2 {
        let bare = grid.size(d);
        let middle = 0.5 * (grid.lo[d] + grid.hi[d]);
        (grid.lo[d], grid.hi[d]) = (middle - (0.5 + pad) * bare, middle + (0.5 + pad) * bare);
    }
    figure
}

fn numbers(text: &str) -> Vec<f64> {
    text.split(',').filter_map(|number| number.parse().ok()).collect()
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    let figures = figures();
    if let [task, kind, weights, pads, disc @ ..] = words.as_slice()
        && task == "sweep"
    {
        let kind = match kind.as_str() {
            "rest" => Regularizer::Rest,
            "noh" => Regularizer::Noh,
            "affine" => Regularizer::Affine,
            _ => Regularizer::Bend,
        };
        let disc = disc.first().and_then(|text| <[f64; 2]>::try_from(numbers(text)).ok());
        let disc = disc.map_or(Settings::default().disc, |[radius, weight]| SmoothingDisc { radius, weight });
        return sweep(&figures, (kind, disc), &numbers(weights), &numbers(pads));
    }
    table_1(&figures);
    table_2(&figures);
}
