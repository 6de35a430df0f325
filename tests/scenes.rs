//! The scenes that come with the program: code makes the same files as are stored, and they can be shot.

#[path = "../scenes/make/mod.rs"]
mod make;

#[path = "support/shared.rs"]
mod shared;

use std::path::{Path, PathBuf};

fn scenes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes")
}

#[test]
fn code_makes_the_stored_files() {
    for (name, bytes) in make::files().expect("textures are drawn") {
        let stored = std::fs::read(scenes().join(name)).unwrap_or_default();
        assert!(stored == bytes, "scenes/{name} differs from what code makes: run `cargo run --example make_scenes`");
        assert!(bytes.len() < 1_000_000, "scenes/{name} has {} bytes", bytes.len());
    }
}

#[test]
fn code_makes_the_stored_figures() {
    for (name, text) in make::figures::files() {
        let stored = std::fs::read_to_string(scenes().join(&name)).unwrap_or_default();
        assert!(stored == text, "scenes/{name} differs from what code makes: run `cargo run --example make_scenes`");
        assert!(text.len() < 40_000, "scenes/{name} has {} bytes", text.len());
    }
}

#[test]
fn figures_have_as_many_vertices_as_in_the_paper() {
    for (name, count) in
        [("ginger", 225), ("frog", 315), ("panda", 444), ("unicorn", 549), ("girl", 637), ("dinosaur", 734)]
    {
        let read = pinwarp::solve::problem_file::read_figure(&scenes().join(format!("figures/{name}.json")));
        let Ok(pinwarp::solve::problem_file::Figures::Plane(figure)) = read else { panic!("{name}: {read:?}") };
        let mut is_used = vec![false; figure.shape.points.len()];
        for corners in &figure.shape.triangles {
            let [a, b, c] = corners.map(|corner| figure.shape.points[corner as usize]);
            let doubled = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            assert!(doubled > 0.0, "{name}: triangle {corners:?} is turned over");
            corners.iter().for_each(|&corner| is_used[corner as usize] = true);
        }
        assert_eq!(is_used.iter().filter(|is_used| **is_used).count(), count, "{name}");
        assert!(figure.poses.len() >= 3 && figure.poses.iter().all(|pose| pose.pins.len() >= 6), "{name}");
    }
}

#[test]
fn teapot_has_as_many_vertices_as_in_the_paper() {
    let teapot = make::teapot::teapot();
    assert_eq!(teapot.positions.len(), 530);
    assert_eq!(teapot.triangles.len(), 32 * 16 * 2 - 32, "32 patches of 4x4 quads, less a triangle at each pole");
    for [a, b, c] in teapot.triangles.iter().map(|corners| corners.map(|corner| corner as usize)) {
        let at = |index: usize| teapot.positions[index];
        let facing =
            (at(b) - at(a)).cross(at(c) - at(a)).dot(teapot.normals[a] + teapot.normals[b] + teapot.normals[c]);
        assert!(facing > 0.0, "triangle {a} {b} {c} faces inwards");
    }
}

#[test]
fn gingerman_is_about_as_fine_as_in_the_paper() {
    let parts = make::gingerman::parts([0, 1, 2]);
    let of = |wanted: fn(&str) -> bool| {
        parts.iter().filter(|(name, _)| wanted(name)).map(|(_, surface)| surface.positions.len()).sum::<usize>()
    };
    assert!((215..=235).contains(&of(|name| name != "Shadow")), "{}", of(|name| name != "Shadow"));
    for (name, surface) in &parts {
        for corners in &surface.triangles {
            let [a, b, c] = corners.map(|corner| surface.positions[corner as usize]);
            assert!((b - a).cross(c - a).z > 0.0, "{name}: triangle {corners:?} is turned over");
        }
    }
}

#[test]
fn hare_is_closed_and_about_as_fine_as_the_bunny_of_the_paper() {
    let hare = make::hare::body(0);
    assert!((485..=520).contains(&hare.positions.len()), "{}", hare.positions.len());
    let mut sides = std::collections::HashMap::new();
    for [a, b, c] in &hare.triangles {
        [(a, b), (b, c), (c, a)].iter().for_each(|&side| *sides.entry(side).or_insert(0) += 1);
    }
    // Surface nets may touch themselves along an edge; they are closed all the same.
    let is_closed = |(&(from, to), count): (&(&u32, &u32), &i32)| sides.get(&(to, from)) == Some(count);
    assert!(sides.iter().all(is_closed), "every side has a neighbour that runs the other way");
}

#[test]
fn hare_turns_with_its_lattice() {
    let mut shot =
        pinwarp::shot::Shot::read(&scenes().join("hare/shot.toml")).unwrap_or_else(|error| panic!("{error}"));
    // Over time the frames around count, too.
    shot.layers.iter_mut().for_each(|layer| layer.settings.temporal = 0.0);
    let prepared = pinwarp::pipeline::PreparedShot::new(shot).unwrap_or_else(|error| panic!("{error}"));
    // Offsets are in box sizes and equal in both frames; the hare faces left in one and right in the other.
    let handles = [8.0, 24.0].map(|frame| {
        let sample = prepared.sample_at(frame).unwrap_or_else(|error| panic!("{error}"));
        let world = sample.layers[0].world.as_ref().expect("the layer is warped");
        assert!(world.report.is_converged && world.report.pin_errors.iter().all(|error| *error < 1e-5));
        (world.lattice.lattice.handles.clone(), world.lattice.frame)
    });
    let apart = handles[0].0.iter().flatten().zip(handles[1].0.iter().flatten()).map(|(a, b)| (a - b).abs());
    let apart = apart.fold(0.0, f64::max);
    assert!(apart < 1e-5, "handles are {apart} m apart in the frame of the box");
    let turned = handles[0].1.axes().x_axis.angle_between(handles[1].1.axes().x_axis).to_degrees();
    // 16 of 24 frames of 130 degrees a second.
    assert!((turned - 130.0 * 16.0 / 24.0).abs() < 0.1, "{turned}");
}

/// The shot files of all scenes.
fn shots() -> Vec<PathBuf> {
    let folders = std::fs::read_dir(scenes()).expect("the folder exists").flatten().map(|entry| entry.path());
    let mut shots: Vec<_> = folders.map(|folder| folder.join("shot.toml")).filter(|path| path.is_file()).collect();
    shots.sort();
    shots
}

#[test]
fn every_shot_is_read_and_has_pins() {
    assert!(shots().len() >= 2, "{:?}", shots());
    for path in shots() {
        let shot = pinwarp::shot::Shot::read(&path).unwrap_or_else(|error| panic!("{error}"));
        let Some(scene) = shot.scene() else { continue };
        assert!(scene.is_file(), "{} is missing", scene.display());
        assert!(path.with_file_name("LICENSE.txt").is_file(), "{} has no licence", path.display());
        assert!(shot.layers.iter().all(|layer| !layer.pins.is_empty()), "{}", path.display());
    }
}

/// Distance in metres from a surface anchor's stored rest position to where its triangle is in the scene.
fn anchor_drift(scene: &pinwarp::scene::Scene, anchor: &pinwarp::shot::Anchor) -> Option<f32> {
    let pinwarp::shot::Anchor::Surface { node, primitive, triangle, barycentric, rest } = anchor else { return None };
    let mesh = scene.nodes[scene.node_named(node)?].mesh?;
    let surface = &scene.meshes[mesh].primitives[*primitive];
    let corners = surface.triangles[*triangle].map(|corner| surface.positions[corner as usize]);
    let point: glam::Vec3 = corners.into_iter().zip(barycentric).map(|(corner, share)| corner * *share as f32).sum();
    rest.map(|rest| point.distance(glam::DVec3::from_array(rest).as_vec3()))
}

#[test]
fn pins_lie_where_they_were_made() {
    for path in shots() {
        let shot = pinwarp::shot::Shot::read(&path).unwrap_or_else(|error| panic!("{error}"));
        let Some(scene) = shot.scene() else { continue };
        let scene = pinwarp::scene::load(scene).unwrap_or_else(|error| panic!("{error}"));
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        for (layer, pin) in shot.layers.iter().flat_map(|layer| layer.pins.iter().map(move |pin| (layer, pin))) {
            let drift = anchor_drift(&scene, &pin.anchor);
            let place = format!("{}: {} / {}", path.display(), layer.name, pin.name);
            assert!(drift.is_some_and(|drift| drift < 2e-4), "{place}: {drift:?}; was the scene made anew?");
        }
    }
}

#[test]
fn walk_repeats_without_a_seam_and_stands_on_the_ground() {
    let scene = pinwarp::scene::load(&scenes().join("walker/walker.glb")).unwrap_or_else(|error| panic!("{error}"));
    let clip = scene.find_clip(Some("Walk"), None).unwrap_or_else(|error| panic!("{error}"));
    let choice = pinwarp::pose::ClipChoice { clip, is_looped: false };
    let boots = scene.node_named("Legs").expect("the gnome has legs");
    let positions = |seconds: f64| -> Vec<glam::Vec3> {
        let pose = pinwarp::pose::pose(&scene, choice, seconds);
        let parts = pose.parts.iter().filter(|part| part.node == boots);
        parts.flat_map(|part| part.positions.iter().map(|at| at.0)).collect()
    };
    let (start, end) = (positions(0.0), positions(1.0));
    let apart = start.iter().zip(&end).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    assert!(apart < 1e-5, "the cycle ends {apart} m from where it began");
    for frame in 0..24 {
        let lowest = positions(f64::from(frame) / 24.0).iter().map(|at| at.y).fold(f32::INFINITY, f32::min);
        assert!((-0.02..0.02).contains(&lowest), "frame {frame}: the lower boot is {lowest} m over the ground");
    }
    let moved = positions(0.25).iter().zip(&start).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    assert!(moved > 0.1, "the legs move by {moved} m only");
}

#[test]
fn every_shot_passes_check() {
    for path in shots() {
        assert_cmd::Command::cargo_bin("pinwarp").expect("it is built").arg("check").arg(path).assert().success();
    }
}

/// A foreign file, which is not part of the repository.
#[test]
fn knight_is_rendered() {
    let Some(knight) = shared::shared("assets/kaykit/Knight.glb") else { return };
    let folder = tempfile::tempdir().expect("there is room");
    let shot = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/shots/knight.toml");
    std::fs::copy(knight, folder.path().join("Knight.glb")).expect("there is room");
    std::fs::copy(shot, folder.path().join("knight.toml")).expect("there is room");
    let arguments =
        ["render", "knight.toml", "--frames", "8,11", "--scale", "1/4", "--samples", "2", "--device", "cpu"];
    let mut program = assert_cmd::Command::cargo_bin("pinwarp").expect("it is built");
    program.current_dir(&folder).args(arguments).args(["-o", "knight.####.exr"]).assert().success();
    for name in ["knight.0008.exr", "knight.0011.exr"] {
        let frame = pinwarp::image::read_exr(&folder.path().join(name)).unwrap_or_else(|error| panic!("{error}"));
        let alpha = frame.channel("A").expect("beauty has alpha");
        let covered = alpha.samples.iter().filter(|alpha| **alpha > 0.5).count();
        assert!(covered > 1000, "{name}: only {covered} pixels are covered");
        assert_eq!(frame.nan_count(), 0, "{name}");
    }
}
