//! Branching lattices against plain ones and against as-rigid-as-possible deformation of the mesh itself.

#[path = "support/puppet.rs"]
mod puppet;

use crate::internal::numbers::{Random, SplitMix, distance};
use pinwarp::lattice::{Basis, Grid};
use pinwarp::solve::methods::Arap;
use pinwarp::solve::{
    BranchedLattice, Energy, HandlePin, PointPin, Problem, Region, Settings, Shape, Solution, Solver, Topology,
    far_points, solve,
};
use puppet::Puppet;

/// Edges of the meshes: about 2,000 triangles.
const SPACING: f64 = 0.0145;

fn grid_over(shape: &Shape<2>, dims: [usize; 2]) -> Grid<2> {
    let range = |axis: usize| {
        let values = shape.points.iter().map(|point| point[axis]);
        let (low, high) = (values.clone().fold(f64::INFINITY, f64::min), values.fold(f64::NEG_INFINITY, f64::max));
        let pad = 0.1 * (high - low);
        [low - pad, high + pad]
    };
    let [x, y] = [range(0), range(1)];
    Grid { dims, basis: Basis::Bspline, lo: [x[0], y[0]], hi: [x[1], y[1]], angle: 0.0 }
}

/// Mean angular and area distortion over the triangles of a mesh.
fn distortion(shape: &Shape<2>, moved: impl Fn(usize, u32) -> [f64; 2]) -> [f64; 2] {
    let (mut sums, mut total) = ([0.0; 2], 0.0);
    for (number, corners) in shape.triangles.iter().enumerate() {
        let [a, b, c] = corners.map(|corner| shape.points[corner as usize]);
        let [p, q, r] = corners.map(|corner| moved(number, corner));
        let sides = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| [b[0] - a[0], c[0] - a[0], b[1] - a[1], c[1] - a[1]];
        let ([e, f, g, h], [k, l, m, n]) = (sides(a, b, c), sides(p, q, r));
        let doubled = e * h - f * g;
        let j = [
            (k * h - l * g) / doubled,
            (l * e - k * f) / doubled,
            (m * h - n * g) / doubled,
            (n * e - m * f) / doubled,
        ];
        let det = j[0] * j[3] - j[1] * j[2];
        let volume = det.abs().max(1e-12);
        let area = 0.5 * doubled.abs();
        total += area;
        sums[0] += area * (j.iter().map(|x| x * x).sum::<f64>() / volume - 2.0).max(0.0);
        sums[1] += area * (volume + 1.0 / volume - 2.0);
    }
    sums.map(|sum| sum / total)
}

fn solved(shape: &Shape<2>, pins: &[PointPin<2>], dims: [usize; 2], topology: Topology) -> Solution<2> {
    let (grid, settings) = (grid_over(shape, dims), Settings { topology, ..Settings::default() });
    let problem = Problem { grid: &grid, shape, pins, handles: &[], settings: &settings };
    solve(&problem).expect("a right problem")
}

/// Where a corner of a triangle goes.
fn image(solution: &Solution<2>, shape: &Shape<2>, triangle: usize, corner: u32) -> [f64; 2] {
    let point = shape.points[corner as usize];
    match &solution.branches {
        Some(branches) => branches.evaluate(triangle, point),
        None => solution.lattice.evaluate(point),
    }
}

fn of_lattice(shape: &Shape<2>, solution: &Solution<2>) -> [f64; 2] {
    distortion(shape, |triangle, corner| image(solution, shape, triangle, corner))
}

fn of_mesh(shape: &Shape<2>, pins: &[PointPin<2>]) -> [f64; 2] {
    let (moved, _) = Arap::default().deform(shape, pins).expect("solvable");
    distortion(shape, |_, corner| moved[corner as usize])
}

/// The same pins, turned and shifted together.
fn moved_together(pins: &[PointPin<2>]) -> Vec<PointPin<2>> {
    pins.iter().map(|pin| PointPin { target: motion(pin.at), ..*pin }).collect()
}

fn motion([x, y]: [f64; 2]) -> [f64; 2] {
    [0.6 * x - 0.8 * y + 0.3, 0.8 * x + 0.6 * y - 0.1]
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    0.5 * (values[(values.len() - 1) / 2] + values[values.len() / 2])
}

#[test]
fn a_rigid_motion_of_all_pins_is_one_of_all_branches() {
    let girl = Puppet::girl();
    let shape = girl.mesh(SPACING);
    let solution = solved(&shape, &moved_together(&girl.pins()), [16, 20], Topology::Branching);
    assert!(solution.branches.as_ref().is_some_and(|branches| branches.branch_count() > 4));
    for (triangle, corner) in shape.triangles.iter().enumerate().flat_map(|(k, corners)| corners.map(|c| (k, c))) {
        let (found, wanted) = (image(&solution, &shape, triangle, corner), motion(shape.points[corner as usize]));
        assert!(distance(found, wanted) < 1e-6, "triangle {triangle}: {found:?} instead of {wanted:?}");
    }
}

/// As where a model reaches through the near plane: its projection extends far beyond the box.
#[test]
fn points_far_outside_the_box_move_with_the_nearest_of_their_own_piece() {
    let girl = Puppet::girl();
    let near = girl.mesh(SPACING);
    let mut grid = grid_over(&near, [24, 24]);
    grid.lo[1] = f64::midpoint(grid.lo[1], grid.hi[1]);
    let middle = f64::midpoint(grid.lo[0], grid.hi[0]);
    let far = |&[x, y]: &[f64; 2]| {
        let factor = if y < grid.lo[1] { 1.0 + 1e4 * (grid.lo[1] - y) } else { 1.0 };
        [middle + factor * (x - middle), grid.lo[1] + factor * (y - grid.lo[1])]
    };
    let shape = Shape { points: near.points.iter().map(far).collect(), ..near };
    let settings = Settings { topology: Topology::Branching, ..Settings::default() };
    let by = [0.03, -0.02];
    let pins = girl.pins().into_iter().filter(|pin| pin.at[1] > grid.lo[1]);
    let pins: Vec<_> = pins.map(|pin| PointPin { target: [pin.at[0] + by[0], pin.at[1] + by[1]], ..pin }).collect();
    let problem = Problem { grid: &grid, shape: &shape, pins: &pins, handles: &[], settings: &settings };
    let solution = solve(&problem).expect("a right problem");
    assert!(solution.branches.as_ref().is_some_and(|branches| branches.branch_count() > 2));
    for (triangle, corner) in shape.triangles.iter().enumerate().flat_map(|(k, corners)| corners.map(|c| (k, c))) {
        let (found, [x, y]) = (image(&solution, &shape, triangle, corner), shape.points[corner as usize]);
        assert!(distance(found, [x + by[0], y + by[1]]) < 1e-6, "triangle {triangle}: {found:?} instead of {x}, {y}");
    }
}

#[test]
fn without_parts_that_are_apart_the_lattice_is_the_plain_one_to_the_bit() {
    let side = 12_u32;
    let points = (0..side * side).map(|k| [f64::from(k % side), f64::from(k / side)]).collect();
    let cells = (0..side - 1).flat_map(|j| (0..side - 1).map(move |i| i + side * j));
    let triangles = cells.flat_map(|k| [[k, k + 1, k + side], [k + 1, k + side + 1, k + side]]).collect();
    let shape = Shape::of_triangles(points, triangles);
    let pins = [PointPin::new([1.0, 1.0], [1.0, 1.0]), PointPin::new([10.0, 10.0], [12.0, 9.0])];
    let [plain, branching] = [Topology::Plain, Topology::Branching].map(|kind| solved(&shape, &pins, [9, 9], kind));
    assert!(branching.branches.is_none() && plain == branching);
}

#[test]
fn the_warp_is_smooth_along_the_shape_where_branches_meet() {
    let girl = Puppet::girl();
    let shape = girl.mesh(SPACING);
    let solution = solved(&shape, &girl.raised(), [24, 32], Topology::Branching);
    let branches = solution.branches.as_ref().expect("parts are apart");
    let mut met = 0;
    for (triangle, corners) in shape.triangles.iter().enumerate() {
        let ends = [corners[0], corners[1]].map(|corner| shape.points[corner as usize]);
        let [from, to] = ends.map(|end| branches.branch_at(triangle, end));
        if from == to {
            continue;
        }
        // Where the side of the triangle leaves the first branch.
        let along = |t: f64| [0, 1].map(|d| ends[0][d] + t * (ends[1][d] - ends[0][d]));
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..50 {
            let middle = f64::midpoint(low, high);
            if branches.branch_at(triangle, along(middle)) == from { low = middle } else { high = middle }
        }
        let other = branches.branch_at(triangle, along(high));
        let [one, other] = [from, other].map(|branch| branches.lattice(branch).evaluate_with_gradient(along(low)));
        assert!(distance(one.point, other.point) < 1e-9, "triangle {triangle}: {one:?} {other:?}");
        let slopes = one.gradient.as_flattened().iter().zip(other.gradient.as_flattened());
        assert!(
            slopes.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 1e-6,
            "triangle {triangle}: {one:?} {other:?}"
        );
        met += 1;
    }
    assert!(met > 3, "branches meet in {met} triangles");
}

/// Ratios to as-rigid-as-possible deformation of the mesh with the same pins, by dims.
#[test]
fn a_raised_arm_leaves_the_body_alone() {
    let girl = Puppet::girl();
    let shape = girl.mesh(SPACING);
    let pins = girl.raised();
    let arap = of_mesh(&shape, &pins);
    println!("{} triangles, ARAP {:.5} {:.5}", shape.triangles.len(), arap[0], arap[1]);
    let ratios = |dims: [usize; 2]| {
        [Topology::Plain, Topology::Branching].map(|topology| {
            let solution = solved(&shape, &pins, dims, topology);
            assert!(solution.report.pin_errors.iter().all(|&error| error < 1e-9), "{:?}", solution.report.pin_errors);
            let found = of_lattice(&shape, &solution);
            let [angle, area] = [found[0] / arap[0], found[1] / arap[1]];
            println!("{dims:?} {topology:?}: angle {angle:.2}, area {area:.2}");
            [angle, area]
        })
    };
    for (dims, most) in
        [([10, 10], f64::INFINITY), ([16, 20], 12.0), ([24, 32], 2.7), ([32, 42], 1.35), ([48, 62], 1.2)]
    {
        let [plain, branching] = ratios(dims);
        assert!(
            branching[0] < plain[0].min(most) && branching[1] < plain[1].min(most),
            "{dims:?}: {plain:?} {branching:?}"
        );
    }
}

#[test]
fn poses_of_other_figures_are_better_than_on_a_plain_lattice() {
    let figure = |seed| {
        let puppet = Puppet::random(seed);
        let (shape, pins) = (puppet.mesh(SPACING), puppet.posed(&mut SplitMix(100 + seed)));
        let arap = of_mesh(&shape, &pins);
        (seed, shape, pins, arap)
    };
    let figures: Vec<_> = (1..=10).map(figure).collect();
    for (dims, most) in [([10, 10], f64::INFINITY), ([24, 32], 1.8), ([21, 50], 1.3), ([41, 64], 1.05)] {
        let mut ratios = [Vec::new(), Vec::new()];
        for (seed, shape, pins, arap) in &figures {
            let [plain, branching] = [Topology::Plain, Topology::Branching]
                .map(|topology| of_lattice(shape, &solved(shape, pins, dims, topology)));
            println!("{dims:?} seed {seed}: plain {plain:.4?}, branching {branching:.4?}, ARAP {arap:.4?}");
            assert!(branching[0] < plain[0] && branching[1] < plain[1], "seed {seed}: {plain:?} {branching:?}");
            (0..2).for_each(|k| ratios[k].push(branching[k] / arap[k]));
        }
        let medians = ratios.map(median);
        println!("{dims:?}: median ratios {medians:.2?}");
        assert!(medians.iter().all(|&ratio| ratio < most), "{medians:?}");
    }
}

/// Limbs without a moving pin move about as far as those of the mesh itself.
#[test]
fn limbs_whose_pins_rest_stay_where_they_are() {
    /// A pixel of a figure that is 1080 pixels high.
    const PIXEL: f64 = 1.0 / 1080.0;
    let mut excess = Vec::new();
    for seed in 1..=4 {
        let puppet = Puppet::random(seed);
        let (shape, posed) = (puppet.mesh(SPACING), puppet.posed(&mut SplitMix(100 + seed)));
        for moved in 0..puppet.limbs.len() {
            let mut pins = puppet.pins();
            pins[3 + moved].target = posed[3 + moved].target;
            let (arap, _) = Arap::default().deform(&shape, &pins).expect("solvable");
            let solution = solved(&shape, &pins, [41, 64], Topology::Branching);
            let mut farthest = vec![[0.0_f64; 2]; puppet.limbs.len()];
            for (triangle, corner) in
                shape.triangles.iter().enumerate().flat_map(|(k, all)| all.map(|corner| (k, corner)))
            {
                let rest = shape.points[corner as usize];
                if let Some([lattice, mesh]) = puppet.limb_at(rest).map(|limb| &mut farthest[limb]) {
                    *lattice = lattice.max(distance(image(&solution, &shape, triangle, corner), rest));
                    *mesh = mesh.max(distance(arap[corner as usize], rest));
                }
            }
            let others = farthest.iter().enumerate().filter(|(limb, _)| *limb != moved);
            excess.extend(others.map(|(_, [lattice, mesh])| (lattice - mesh) / PIXEL));
        }
    }
    let above = excess.iter().filter(|&&excess| excess > 0.5).count();
    let most = excess.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    println!(
        "{above} of {} limbs move more than 0.5 px farther than those of the mesh, at most {most:.2}",
        excess.len()
    );
    assert!(above <= 2 && most < 1.5, "{above} limbs, {most} px");
}

/// The region of a pin is that of its part: a hand that hangs beside the skirt does not stiffen it.
#[test]
fn regions_of_pins_end_where_their_part_does() {
    let girl = Puppet::girl();
    let shape = girl.mesh(SPACING);
    let plain_pins = girl.raised();
    let hand = plain_pins[3].at;
    let middles: Vec<[f64; 2]> = (shape.triangles.iter())
        .map(|corners| [0, 1].map(|d| corners.iter().map(|&k| shape.points[k as usize][d]).sum::<f64>() / 3.0))
        .collect();
    // The arm is to the right of a line beside the skirt.
    let near = |k: usize| distance(middles[k], hand) < 0.09;
    let part = |is_arm: bool| -> Vec<usize> {
        let is_of_arm = |[x, y]: [f64; 2]| x > 0.091 + 0.25 * (0.5 - y).max(0.0) && y > 0.36;
        (0..middles.len()).filter(|&k| near(k) && is_of_arm(middles[k]) == is_arm).collect()
    };
    let (arm, skirt) = (part(true), part(false));
    assert!(arm.len() > 30 && skirt.len() > 30, "{} {}", arm.len(), skirt.len());
    let of = |triangles: &[usize]| Shape {
        triangles: triangles.iter().map(|&k| shape.triangles[k]).collect(),
        ..shape.clone()
    };
    let measured = |solution: &Solution<2>, triangles: &[usize]| {
        distortion(&of(triangles), |k, corner| image(solution, &shape, triangles[k], corner))
    };
    let before = solved(&shape, &plain_pins, [32, 42], Topology::Branching);
    for (rigidity, stiffness, least) in [(1.0, 1.0, 8.0), (0.0, 30.0, 2.0)] {
        let mut pins = plain_pins.clone();
        pins[3].region = Some(Region { radius: 0.1, rigidity, stiffness });
        let after = solved(&shape, &pins, [32, 42], Topology::Branching);
        let [was, is] = [&before, &after].map(|solution| measured(solution, &arm));
        println!("rigidity {rigidity}, stiffness {stiffness}: arm {was:.6?} to {is:.6?}");
        assert!(is[0] * least < was[0], "{was:?} {is:?}");
        let moved = skirt.iter().flat_map(|&k| shape.triangles[k].map(|corner| (k, corner)));
        let gaps =
            moved.map(|(k, corner)| distance(image(&before, &shape, k, corner), image(&after, &shape, k, corner)));
        let farthest = gaps.fold(0.0, f64::max);
        println!("the skirt beside it moves by {farthest:.5}");
        assert!(farthest < 2e-3, "{farthest}");
        let plain = [&plain_pins, &pins].map(|pins| solved(&shape, pins, [32, 42], Topology::Plain));
        let gaps = skirt.iter().flat_map(|&k| shape.triangles[k].map(|corner| (k, corner)));
        let gaps =
            gaps.map(|(k, corner)| distance(image(&plain[0], &shape, k, corner), image(&plain[1], &shape, k, corner)));
        let of_plain = gaps.fold(0.0, f64::max);
        println!("on a plain lattice by {of_plain:.5}");
        assert!(of_plain > 3.0 * farthest, "a plain lattice would pass: {of_plain}");
    }
}

/// A handle that is moved by hand moves all its copies.
#[test]
fn moved_handles_move_all_their_copies() {
    let girl = Puppet::girl();
    let shape = girl.mesh(SPACING);
    let pins = girl.pins();
    let (grid, settings) =
        (grid_over(&shape, [16, 20]), Settings { topology: Topology::Branching, ..Settings::default() });
    let rest = solved(&shape, &pins, [16, 20], Topology::Branching);
    let branches = rest.branches.expect("parts are apart");
    let index = (0..grid.handle_count()).find(|&handle| branches.copies_of(handle).len() > 1).expect("copies");
    let idle = (0..grid.handle_count()).find(|&handle| branches.copies_of(handle).is_empty()).expect("an empty corner");
    let [x, y] = grid.rest_handle(index);
    let handles = [index, idle].map(|index| HandlePin { index, target: [x + 0.02, y - 0.01] });
    let problem = Problem { grid: &grid, shape: &shape, pins: &pins, handles: &handles, settings: &settings };
    let solver = Solver::new(&problem).expect("a right problem");
    let solution = solver.solve();
    let places = |solution: &Solution<2>| solution.branches.as_ref().expect("branches").copies_of(index).to_vec();
    assert!(
        places(&solution).iter().all(|place| distance(*place, handles[0].target) < 1e-9),
        "{:?}",
        places(&solution)
    );
    assert!(solution.report.handle_errors.iter().all(|&error| error < 1e-9), "{:?}", solution.report.handle_errors);
    assert!(solution.report.pin_errors.iter().all(|&error| error < 1e-9));
    let warned = |text: &&String| text.contains(&format!("handle {idle} acts on no part"));
    assert_eq!(solution.report.warnings.iter().filter(warned).count(), 1, "{:?}", solution.report.warnings);
    let back = handles.map(|handle| HandlePin { target: [x - 0.01, y], ..handle });
    let solution = solver.update(&pins, &back).expect("the same handles");
    assert!(places(&solution).iter().all(|place| distance(*place, [x - 0.01, y]) < 1e-9), "{:?}", places(&solution));
}

#[test]
fn drags_follow_all_branches() {
    let girl = Puppet::girl();
    let shape = girl.mesh(2.0 * SPACING);
    let (grid, settings) =
        (grid_over(&shape, [15, 15]), Settings { topology: Topology::Branching, ..Settings::default() });
    let (rest, raised) = (girl.pins(), girl.raised());
    let problem = Problem { grid: &grid, shape: &shape, pins: &rest, handles: &[], settings: &settings };
    let solver = Solver::new(&problem).expect("a right problem");
    let start = solver.solve();
    let mut drag = solver.drag_from(&start).expect("a solution of the solver");
    let moved = |share: f64| -> Vec<PointPin<2>> {
        let towards = |(from, to): (&PointPin<2>, &PointPin<2>)| {
            let target = [0, 1].map(|d| from.target[d] + share * (to.target[d] - from.target[d]));
            PointPin { target, ..*from }
        };
        rest.iter().zip(&raised).map(towards).collect()
    };
    let farthest = |a: &BranchedLattice<2>, b: &BranchedLattice<2>| {
        let corners = shape.triangles.iter().enumerate();
        let gaps = corners.map(|(k, corners)| {
            let point = shape.points[corners[0] as usize];
            distance(a.evaluate(k, point), b.evaluate(k, point))
        });
        gaps.fold(0.0, f64::max)
    };
    for step in 1..=30 {
        let pins = moved(f64::from(step) / 30.0);
        let lattice = drag.follow(&pins, &[]).expect("the same pins");
        let branches = drag.branches().expect("it branches");
        assert_eq!(lattice, branches.lattice(0));
        for pin in &pins {
            assert!(distance(branches.pin_image(pin), pin.target) < 1e-9, "step {step}");
        }
        if step % 10 == 0 {
            let solved = solver.update(&pins, &[]).expect("the same pins").branches.expect("it branches");
            let lag = farthest(&branches, &solved);
            println!("step {step}: {lag:.1e} heights behind");
            assert!(lag < 1e-3, "step {step}: {lag}");
        }
    }
    let settled = drag.settle(&raised, &[]).expect("the same pins");
    let solved = solver.update(&raised, &[]).expect("the same pins");
    assert!(settled.report.is_converged && settled.report.pin_residuals.is_empty());
    let [settled, solved] = [settled, solved].map(|solution| solution.branches.expect("it branches"));
    assert!(farthest(&settled, &solved) < 1e-5, "{}", farthest(&settled, &solved));
    // From a solution of another solver, or a lattice alone, there is no way.
    let plain = solve(&Problem { settings: &Settings::default(), ..problem }).expect("a right problem");
    assert!(solver.drag_from(&plain).is_err() && solver.drag(&start.lattice).is_err());
}

#[test]
fn features_without_support_for_branches_are_refused() {
    let girl = Puppet::girl();
    let (shape, pins) = (girl.mesh(0.04), girl.pins());
    let settings = Settings { topology: Topology::Branching, ..Settings::default() };
    let fault = |basis: Basis, pins: &[PointPin<2>], settings: &Settings| {
        let grid = Grid { basis, ..grid_over(&shape, [10, 10]) };
        let problem = Problem { grid: &grid, shape: &shape, pins, handles: &[], settings };
        solve(&problem).expect_err("a fault").to_string()
    };
    let edge = Settings { energy: Energy::Edge, ..settings.clone() };
    let told = [fault(Basis::Bernstein, &pins, &settings), fault(Basis::Bspline, &pins, &edge)];
    for (text, word) in told.iter().zip(["Bernstein", "`area`"]) {
        assert!(text.contains(word) && text.contains("topology = \"plain\""), "{text}");
    }
}

/// Eyes lie apart from the head, and go along with it.
#[test]
fn islands_move_with_the_nearest_part() {
    let girl = Puppet::girl();
    let mut shape = girl.mesh(SPACING);
    // A button beside the chest, farther from the arm.
    let button = shape.points.len() as u32;
    shape.points.extend([[0.0, 0.605], [0.006, 0.605], [0.003, 0.61]]);
    shape.triangles.push([button, button + 1, button + 2]);
    let solution = solved(&shape, &moved_together(&girl.pins()), [24, 32], Topology::Branching);
    let last = shape.triangles.len() - 1;
    let found = image(&solution, &shape, last, button);
    let wanted = motion(shape.points[button as usize]);
    assert!(distance(found, wanted) < 1e-6, "{found:?} instead of {wanted:?}");
    let raised = solved(&shape, &girl.raised(), [24, 32], Topology::Branching);
    let (found, rest) = (image(&raised, &shape, last, button), shape.points[button as usize]);
    assert!(distance(found, rest) < 0.02, "{found:?}, at rest {rest:?}");
}

/// Blades of grass: triangles that touch nothing, at random places.
fn grass(count: usize) -> Shape<2> {
    let mut random = SplitMix(7);
    let mut number = || random.unit();
    let blade = |_| {
        let [x, y] = [number(), number()];
        let [lean, height] = [0.04 * (number() - 0.5), 0.02 + 0.05 * number()];
        [[x, y], [x + 0.002, y], [x + lean, y + height]]
    };
    let points: Vec<[f64; 2]> = (0..count).flat_map(blade).collect();
    let triangles = (0..count as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
    Shape::of_triangles(points, triangles)
}

/// Triangles on one common edge, spread like the pages of a book.
fn pages(count: usize) -> Shape<2> {
    let tip = |k: usize| {
        [0.5 + 0.5 * (std::f64::consts::PI * k as f64 / count as f64).cos(), 0.2 + 0.8 * k as f64 / count as f64]
    };
    let points: Vec<[f64; 2]> = [[0.5, 0.0], [0.5, 0.1]].into_iter().chain((0..count).map(tip)).collect();
    Shape::of_triangles(points, (0..count as u32).map(|k| [0, 1, k + 2]).collect())
}

#[test]
fn loose_triangles_and_pages_on_one_edge_share_copies_beyond_a_number() {
    for (shape, radius) in [(grass(3000), 0.0), (grass(3000), 0.1), (pages(500), 0.1)] {
        let shape = shape.linked(radius);
        let pins: Vec<PointPin<2>> = [(0, [0.0; 2]), (100, [0.05, 0.02])]
            .map(|(triangle, [dx, dy]): (usize, [f64; 2])| {
                let [x, y] = shape.points[shape.triangles[triangle][2] as usize];
                PointPin::new([x, y], [x + dx, y + dy])
            })
            .into();
        let solution = solved(&shape, &pins, [10, 10], Topology::Branching);
        let branches = solution.branches.as_ref().expect("it branches");
        let most = (0..100).map(|handle| branches.copies_of(handle).len()).max();
        assert_eq!(
            most,
            Some(48),
            "the supports hold hundreds of pieces, of which only the largest have copies of their own"
        );
        let corners =
            shape.triangles.iter().enumerate().flat_map(|(number, corners)| corners.map(|corner| (number, corner)));
        for (number, corner) in corners {
            let [x, y] = image(&solution, &shape, number, corner);
            assert!((-0.5..=1.5).contains(&x) && (-0.5..=1.5).contains(&y), "triangle {number} is at {x}, {y}");
        }
        assert!(solution.report.pin_errors.iter().all(|error| *error < 1e-3), "{:?}", solution.report.pin_errors);
    }
}

/// Each end of a gap lies in some support, whose sides it holds together up to that end, and nothing else does.
#[test]
fn no_handle_holds_together_what_is_far_apart_on_figures() {
    for (number, puppet) in std::iter::once(Puppet::girl()).chain((1..=10).map(Puppet::random)).enumerate() {
        let shape = puppet.mesh(SPACING);
        for dims in [[20, 25], [39, 64]] {
            let found = far_points(&grid_over(&shape, dims), &shape).expect("a right shape");
            assert!(found.is_empty(), "figure {number}, {dims:?}: {found:?}");
        }
    }
}
