//! Branching lattices over a model: legs that cross on the screen stay apart, steadily.

use super::assets::asset;
use super::support::Studio;
use pinwarp::pipeline::{PinAnchor, PreparedShot, TimeSample, lattices, report};
use pinwarp::shot::Shot;
use pinwarp::solve::Guard;
use std::collections::BTreeMap;
use std::path::Path;

/// A fox that walks: a front paw is pulled ahead, the other paws and the body are held. In frame 5 the front legs cross.
fn walking_fox(scene: &Path, lattice: ([usize; 2], &str), offset: [f64; 2]) -> PreparedShot {
    walking_fox_over_time(scene, lattice, offset, 0.0)
}

/// The same with a temporal weight.
fn walking_fox_over_time(
    scene: &Path,
    (dims, topology): ([usize; 2], &str),
    offset: [f64; 2],
    temporal: f64,
) -> PreparedShot {
    let held = [[1.445, 0.184], [0.86, 0.13], [0.60, 0.14], [1.0, 0.62], [0.7, 0.65], [1.62, 0.7]];
    let pin = |number: usize, [x, y]: [f64; 2], [dx, dy]: [f64; 2]| {
        format!(
            "[[layer.pin]]\nname = 'p{number}'\nanchor = {{ screen = [{x}, {y}], frame = 1 }}\n\
             keys = [{{ frame = 1, offset = [{dx}, {dy}] }}]\n"
        )
    };
    let pins: String = held.iter().enumerate().map(|(number, at)| pin(number + 1, *at, [0.0; 2])).collect();
    let text = format!(
        "version = 1\nscene = '{}'\ncamera = 'left'\nframes = {{ first = 1, last = 17, rate = 24, clip = 'Walk' }}\n\
         solve_range = [1, 9]\nsize = [960, 540]\nshutter = {{ angle = 0 }}\n[[layer]]\nname = 'all'\n\
         lattice = {{ dims = {dims:?}, topology = '{topology}' }}\nsolve = {{ temporal = {temporal} }}\n{}{pins}",
        scene.display(),
        pin(0, [1.037, 0.13], offset)
    );
    let shot = Shot::parse(&text, Path::new("/fox.toml")).expect("a right shot");
    PreparedShot::new(shot).expect("the scene is there")
}

/// How far every vertex moves on the screen, frame heights. The camera sees all of the fox: its triangles are those of the shape.
fn displacements(prepared: &PreparedShot, sample: &TimeSample) -> Vec<[f64; 2]> {
    let mesh = sample.mesh();
    let vertices = &mesh.parts[0].vertices;
    let triangles = &prepared.scene.meshes[0].primitives[0].triangles;
    let solution = sample.layers[0].solution.as_ref().expect("its pins act");
    let mut moved = vec![[0.0; 2]; vertices.len()];
    for (number, corners) in triangles.iter().enumerate() {
        for &corner in corners {
            let from = vertices[corner as usize].point();
            let to = match &solution.branches {
                Some(branches) => branches.warp(number..number + 1, from.0.to_array()),
                None => solution.lattice.warp(from).0.to_array(),
            };
            moved[corner as usize] = [to[0] - from.0.x, to[1] - from.0.y];
        }
    }
    moved
}

fn length([x, y]: [f64; 2]) -> f64 {
    x.hypot(y)
}

/// Vertices that a joint moves most.
fn of_joints(prepared: &PreparedShot, wanted: &str) -> Vec<usize> {
    let primitive = &prepared.scene.meshes[0].primitives[0];
    let joints = &prepared.scene.skins[0].joints;
    let name = |vertex: usize| {
        let most = primitive.influences[vertex].iter().max_by(|a, b| a.weight.total_cmp(&b.weight));
        most.map_or("", |most| prepared.scene.nodes[joints[most.joint as usize]].name.as_str())
    };
    (0..primitive.influences.len()).filter(|&vertex| name(vertex) == wanted).collect()
}

/// Most that the front paw moves which the first pin does not hold, in a frame.
fn other_paw(prepared: &PreparedShot, frame: f64) -> f64 {
    let sample = prepared.sample_at(frame).expect("solvable");
    let sides = ["b_RightHand_08", "b_LeftHand_011"].map(|name| of_joints(prepared, name));
    let PinAnchor::Surface { corners, .. } = prepared.anchors_of(0)[0] else { panic!("it holds the paw") };
    let other = usize::from(sides[0].contains(&(corners[0] as usize)));
    assert!(sides[1 - other].contains(&(corners[0] as usize)) && !sides[other].is_empty());
    let moved = displacements(prepared, &sample);
    sides[other].iter().map(|&vertex| length(moved[vertex])).fold(0.0, f64::max)
}

#[test]
fn a_leg_that_another_crosses_stays() {
    let Some(fox) = asset("gltf-samples/Fox.glb") else { return };
    let [plain, branching] = ["plain", "branching"]
        .map(|topology| 540.0 * other_paw(&walking_fox(&fox, ([40, 30], topology), [0.16, 0.10]), 5.0));
    println!("the other front paw moves by {plain:.2} px on a plain lattice, by {branching:.2} px on a branching one");
    assert!(branching < 15.0 && plain > 5.0 * branching, "plain {plain}, branching {branching}");
}

/// The greatest jump of a vertex from frame 3 to 7, bisected in time, in pixels, and when.
fn greatest_jump(prepared: &PreparedShot) -> (f64, f64) {
    let at = |time: f64| displacements(prepared, &prepared.sample_at(time).expect("solvable"));
    let change = |a: &[[f64; 2]], b: &[[f64; 2]]| {
        a.iter().zip(b).map(|(a, b)| length([a[0] - b[0], a[1] - b[1]])).fold(0.0, f64::max)
    };
    let mut greatest = (0.0_f64, 0.0);
    let mut before = at(3.0);
    for step in 1..=20 {
        let (mut low, mut high) = (3.0 + 0.2 * f64::from(step - 1), 3.0 + 0.2 * f64::from(step));
        let now = at(high);
        let (mut from, mut to) = (before, now.clone());
        before = now;
        while change(&from, &to) > 0.2 / 540.0 && high - low > 1e-5 {
            let middle = f64::midpoint(low, high);
            let between = at(middle);
            if change(&from, &between) > change(&between, &to) {
                (high, to) = (middle, between);
            } else {
                (low, from) = (middle, between);
            }
        }
        let jump = 540.0 * change(&from, &to);
        if jump > greatest.0 {
            greatest = (jump, low);
        }
    }
    greatest
}

/// Pieces split and join as the box moves over the model: nothing jumps because of it.
#[test]
fn branches_are_steady_in_time() {
    let Some(fox) = asset("gltf-samples/Fox.glb") else { return };
    for dims in [[24, 18], [40, 30]] {
        let jump = greatest_jump(&walking_fox(&fox, (dims, "branching"), [0.03, 0.01]));
        println!("{dims:?}: greatest jump {jump:.3?} px");
        assert!(jump.0 < 1.0, "{dims:?}: {jump:?}");
    }
}

/// Over time the copies of handles change from frame to frame; each frame is the same whatever was solved before.
#[test]
fn branches_are_steady_over_time_and_the_same_in_any_order() {
    let Some(fox) = asset("gltf-samples/Fox.glb") else { return };
    let lattice = ([24, 18], "branching");
    let solved = || walking_fox_over_time(&fox, lattice, [0.16, 0.10], 0.3);
    let prepared = solved();
    let jump = greatest_jump(&prepared);
    println!("greatest jump over time {jump:.3?} px");
    assert!(jump.0 < 1.0, "{jump:?}");
    let at =
        |prepared: &PreparedShot, time: f64| displacements(prepared, &prepared.sample_at(time).expect("it is solved"));
    let times = [5.0, 7.25, 9.5, 2.0];
    let forward = times.map(|time| at(&prepared, time));
    let again = solved();
    let mut backward = times;
    backward.reverse();
    let mut found = backward.map(|time| at(&again, time));
    found.reverse();
    assert!(forward == found, "another order, another bit");
    // The paw is where it is pulled to, and more than one branch is there.
    let sample = prepared.sample_at(5.0).expect("it is solved");
    let solution = sample.layers[0].solution.as_ref().expect("its pins act");
    assert!(solution.branches.as_ref().is_some_and(|branches| branches.branch_count() > 1));
    assert!(solution.report.pin_errors.iter().all(|&error| error < 0.05 / 540.0), "{:?}", solution.report.pin_errors);
    assert!(prepared.notes.iter().all(|note| !note.contains("alone")), "{:?}", prepared.notes);
}

#[test]
fn dims_fit_the_thin_parts_of_a_model() {
    let Some(fox) = asset("gltf-samples/Fox.glb") else { return };
    let text = format!(
        "version = 1\nscene = '{}'\ncamera = 'left'\nframes = {{ first = 1, last = 17, rate = 24, clip = 'Walk' }}\nsize = [960, 540]\n[[layer]]\nlattice = {{ dims = 'auto', topology = 'branching' }}",
        fox.display()
    );
    let prepared = PreparedShot::new(Shot::parse(&text, Path::new("/fox.toml")).expect("a right shot"));
    let prepared = prepared.expect("the scene is there");
    let [across, up, _] = prepared.shot.layers[0].space.dims();
    // Its legs would need more than a scene gets by itself.
    assert!(across == 24 && (10..24).contains(&up), "{across} x {up}");
    let words = ["thinnest parts", "the most that \"auto\" gives a scene", "dims = [64, "];
    let is_told = |note: &String| words.iter().all(|word| note.contains(word));
    assert!(prepared.notes.iter().any(is_told), "{:?}", prepared.notes);
}

/// A lattice file carries branches to another shot: each part of its shape goes with the branch that owns most of it.
#[test]
fn branches_are_laid_over_another_shape() {
    let Some(fox) = asset("gltf-samples/Fox.glb") else { return };
    let source = walking_fox(&fox, ([40, 30], "branching"), [0.16, 0.10]);
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("fox.json");
    lattices(&source, &[5, 6], |_| ()).expect("solvable").write(&file).expect("it is written");
    let transferred = |topology: &str, fit: &str| {
        let text = format!(
            "version = 1\nscene = '{}'\ncamera = 'left'\nframes = {{ first = 1, last = 17, rate = 24, clip = 'Walk' }}\n\
             size = [960, 540]\nshutter = {{ angle = 0 }}\n[[layer]]\nname = 'all'\n\
             lattice = {{ topology = '{topology}' }}\ntransfer = {{ lattice = '{}', fit = '{fit}' }}\n",
            fox.display(),
            file.display()
        );
        PreparedShot::new(Shot::parse(&text, Path::new("/fox.toml")).expect("a right shot"))
    };
    let plain = transferred("plain", "box").expect_err("a plain layer cannot take it").to_string();
    assert!(plain.contains("topology = \"branching\""), "{plain}");
    let own =
        |prepared: &PreparedShot, frame: f64| displacements(prepared, &prepared.sample_at(frame).expect("solvable"));
    let farthest = |a: &[[f64; 2]], b: &[[f64; 2]]| {
        a.iter().zip(b).map(|(a, b)| 540.0 * length([a[0] - b[0], a[1] - b[1]])).fold(0.0, f64::max)
    };
    let wanted = own(&source, 5.0);
    let moved = wanted.iter().map(|by| 540.0 * length(*by)).fold(0.0, f64::max);
    for fit in ["as-is", "box"] {
        let prepared = transferred("branching", fit).expect("the same fox");
        let gap = farthest(&own(&prepared, 5.0), &wanted);
        println!("{fit}: {gap:.2e} px of {moved:.0}");
        assert!(moved > 50.0 && gap < 1e-6, "{fit}: {gap}");
        // Between frames the branches of both are mixed.
        let [before, between, after] = [5.0, 5.5, 6.0].map(|frame| own(&prepared, frame));
        let mean: Vec<[f64; 2]> =
            (before.iter().zip(&after)).map(|(a, b)| [0, 1].map(|d| f64::midpoint(a[d], b[d]))).collect();
        let root_mean_square = |a: &[[f64; 2]], b: &[[f64; 2]]| {
            let square = |(a, b): (&[f64; 2], &[f64; 2])| length([a[0] - b[0], a[1] - b[1]]).powi(2);
            540.0 * (a.iter().zip(b).map(square).sum::<f64>() / a.len() as f64).sqrt()
        };
        let (beside, change) = (root_mean_square(&between, &mean), root_mean_square(&before, &after));
        println!("{fit}: {beside:.2} px beside the mean, of {change:.2} px; at most {:.1}", farthest(&between, &mean));
        // Either frame alone is half the change beside the mean; legs that move under the lattice bend the way a little.
        assert!(beside < 0.35 * change, "{fit}: {beside} px of {change}");
    }
}

/// A fox of which a front leg is cut off by its joints and pulled ahead.
fn fox_with_cut_leg(scene: &Path, cut: &str) -> PreparedShot {
    let text = format!(
        "version = 1\nscene = '{}'\ncamera = 'left'\nframes = {{ first = 1, last = 2, rate = 24, clip = 'Walk' }}\n\
         size = [960, 540]\nshutter = {{ angle = 0 }}\n[[layer]]\nname = 'all'\n\
         lattice = {{ dims = [24, 18], topology = 'branching', cuts = [{cut}] }}\n\
         [[layer.pin]]\nanchor = {{ screen = [1.037, 0.13], frame = 1 }}\nkeys = [{{ frame = 1, offset = [0.1, 0.05] }}]\n\
         [[layer.pin]]\nanchor = {{ screen = [0.7, 0.65], frame = 1 }}\n",
        scene.display()
    );
    PreparedShot::new(Shot::parse(&text, Path::new("/fox.toml")).expect("a right shot")).expect("the scene is there")
}

/// The widest gap between two triangles at a vertex that they share, pixels.
fn widest_gap(prepared: &PreparedShot) -> f64 {
    let sample = prepared.sample_at(1.0).expect("solved");
    let mesh = sample.mesh();
    let vertices = &mesh.parts[0].vertices;
    let solution = sample.layers[0].solution.as_ref().expect("its pins act");
    let branches = solution.branches.as_ref().expect("it branches");
    let mut places: BTreeMap<[u64; 3], Vec<[f64; 2]>> = BTreeMap::new();
    for (number, corners) in prepared.scene.meshes[0].primitives[0].triangles.iter().enumerate() {
        for &corner in corners {
            let vertex = vertices[corner as usize];
            let from = vertex.point();
            let at = [from.0.x, from.0.y, vertex.depth].map(f64::to_bits);
            places.entry(at).or_default().push(branches.warp(number..number + 1, from.0.to_array()));
        }
    }
    let gap = |ends: &Vec<[f64; 2]>| {
        ends.iter().map(|end| length([end[0] - ends[0][0], end[1] - ends[0][1]]) * 540.0).fold(0.0, f64::max)
    };
    places.values().map(gap).fold(0.0, f64::max)
}

#[test]
fn a_leg_that_is_cut_off_by_its_joints_stays_on_the_body() {
    let Some(scene) = asset("gltf-samples/Fox.glb") else { return };
    let [whole, opened] = ["", ", open = true"]
        .map(|open| widest_gap(&fox_with_cut_leg(&scene, &format!("{{ joints = ['b_RightUpperArm*'] {open} }}"))));
    println!("the surface opens by {whole:.3} px, and by {opened:.1} px where that is wanted");
    assert!(whole < 0.01 && opened > 2.0, "{whole} {opened}");
}

#[test]
fn folds_beside_a_drawing_are_not_reported_as_its_own() {
    let folded = |prepared: &PreparedShot| {
        let sample = prepared.mid_exposure(11).expect("solvable");
        let told = report(prepared, 11, &sample).warnings;
        let solution = sample.layers[0].solution.as_ref().expect("its pins act");
        (solution.report.folded_model_cells, solution.report.min_cell_det, told)
    };
    let is_told = |told: &[String]| told.iter().any(|text| text.contains("the model folds over itself"));
    let of_dims = |dims: &str| {
        let mut studio = Studio::puppet(dims, "branching");
        studio.shot.layers[0].settings.guard = Guard::Report;
        studio.prepared()
    };
    for dims in ["\"auto\"", "[20, 20]"] {
        let (cells, least, told) = folded(&of_dims(dims));
        assert!(cells == 0 && least > 0.0 && !is_told(&told), "{dims}: {cells} cells, {least}, {told:?}");
    }
    // So few handles crush a foot.
    let (cells, least, told) = folded(&of_dims("[6, 6]"));
    assert!(cells > 0 && least < -0.5 && is_told(&told), "{cells} cells, {least}, {told:?}");
}
