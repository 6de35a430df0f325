//! Where lattices stand, and where pins are.

use super::support::{Studio, write_scene};
use super::tiny::{Lens, Part, Tiny, grid};
use pinwarp::pipeline::{PinAnchor, PreparedShot};
use pinwarp::raster::ChannelGroup;
use pinwarp::screen::project;
use pinwarp::shot::{Shot, Shutter};
use pinwarp::space::ScreenPoint;

/// A square from (.6, .3) to (1, .7) on the screen that moves by `x` frame heights a frame.
fn square(x: f32) -> Part {
    Part { velocity: [24.0 * x, 0.0, 0.0], ..grid("Quad", [-0.2, -0.2, 0.2, 0.2], 2) }
}

fn studio(part: Part, bounds: &str) -> Studio {
    let layer = format!(
        "[[layer]]\nlattice = {{ dims = [4, 4], box = {bounds} }}\n[[layer.pin]]\n\
         anchor = {{ node = \"Quad\", triangle = 0, barycentric = [1.0, 0.0, 0.0] }}\n\
         keys = [{{ frame = 1, offset = [0.1, 0.0] }}]\n"
    );
    Studio::tiny(&Tiny::of(vec![part]), &layer)
}

/// Lower left and upper right corner of the lattice's rest box.
fn box_at(studio: &Studio, frame: f64) -> [f64; 4] {
    let sample = studio.prepared().sample_at(frame).expect("the frame is solved");
    let grid = sample.layers[0].solution.as_ref().map(|solution| &solution.lattice.grid).expect("the layer is warped");
    [grid.lo[0], grid.lo[1], grid.hi[0], grid.hi[1]]
}

#[track_caller]
fn assert_box(found: [f64; 4], expected: [f64; 4]) {
    let is_near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5);
    assert!(is_near, "{found:?} is not {expected:?}");
}

#[test]
fn fixed_boxes_have_the_given_position() {
    assert_box(box_at(&studio(square(0.02), "{ fixed = [0.1, 0.2, 1.5, 0.9] }"), 5.0), [0.1, 0.2, 1.5, 0.9]);
    assert_box(box_at(&studio(square(0.02), "\"frame\""), 5.0), [0.0, 0.0, 1.6, 1.0]);
}

#[test]
fn a_box_follows_with_a_tenth_of_air() {
    assert_box(box_at(&studio(square(0.0), "\"follow\""), 5.0), [0.56, 0.26, 1.04, 0.74]);
    // Even motion is followed exactly, between frames too.
    for frame in [5.0, 5.25, 8.0] {
        let x = 0.02 * (frame - 1.0);
        assert_box(box_at(&studio(square(0.02), "\"follow\""), frame), [0.56 + x, 0.26, 1.04 + x, 0.74]);
    }
}

#[test]
fn a_followed_box_always_holds_what_it_follows() {
    // A jump: the smoothed box would lag behind.
    let studio = studio(Part { velocity: [24.0 * 0.15, 0.0, 0.0], ..square(0.0) }, "\"follow\"");
    for frame in [1.0, 2.0, 3.0] {
        let [x0, _, x1, _] = box_at(&studio, frame);
        let x = 0.15 * (frame - 1.0);
        assert!(x0 <= 0.6 + x + 1e-6 && x1 >= 1.0 + x - 1e-6, "{x0} {x1} in frame {frame}");
    }
}

/// A square under a camera with these keys of distances.
fn seen_from(keys: &[(i32, f64, &str)]) -> Studio {
    pulled_and_seen_from("", keys)
}

/// Same as [`seen_from`], with keys of the pin that pulls a corner.
fn pulled_and_seen_from(pin: &str, keys: &[(i32, f64, &str)]) -> Studio {
    let key = |(frame, distance, ease): &(i32, f64, &str)| {
        format!("{{ frame = {frame}, yaw = 20, distance = {distance}, ease = \"{ease}\" }}")
    };
    let keys: Vec<String> = keys.iter().map(key).collect();
    let layer = format!(
        "camera = {{ look_at = \"Quad\", keys = [{}] }}\n[[layer]]\nlattice = {{ dims = [4, 4] }}\nsolve = {{ temporal = 2 }}\n[[layer.pin]]\n\
         anchor = {{ node = \"Quad\", triangle = 0, barycentric = [1.0, 0.0, 0.0] }}\nkeys = [{pin}]\n\
         [[layer.pin]]\nanchor = {{ node = \"Quad\", triangle = 7, barycentric = [0.0, 1.0, 0.0] }}\n",
        keys.join(", ")
    );
    Studio::tiny(&Tiny::of(vec![square(0.0)]), &layer)
}

#[test]
fn a_followed_box_is_not_smoothed_across_a_cut_of_the_camera() {
    let (near, far) = (seen_from(&[(1, 2.0, "linear")]), seen_from(&[(1, 5.0, "linear")]));
    let keys = [(1, 2.0, "hold"), (6, 5.0, "linear")];
    // The same as a move within one frame, as baked cameras have it.
    let baked = [(1, 2.0, "linear"), (5, 2.0, "linear"), (6, 5.0, "linear")];
    for cut in [seen_from(&keys), seen_from(&baked)] {
        for frame in [2.0, 4.0, 5.0] {
            assert_box(box_at(&cut, frame), box_at(&near, frame));
        }
        for frame in [6.0, 7.0, 9.0] {
            assert_box(box_at(&cut, frame), box_at(&far, frame));
        }
    }
    // A fast move over several frames is not a cut: the box before it already grows.
    let fast = seen_from(&[(1, 2.0, "linear"), (5, 2.0, "linear"), (8, 5.0, "linear")]);
    let grown = box_at(&fast, 5.0)[0] - box_at(&near, 5.0)[0];
    assert!(grown.abs() > 1e-3, "{grown}");
}

#[test]
fn the_shutter_and_motion_see_one_side_of_a_cut() {
    let open = |keys: &[(i32, f64, &str)]| {
        let mut studio = seen_from(keys);
        studio.shot.shutter = Shutter { angle: 180.0, phase: -90.0 };
        (studio.shot.samples, studio.shot.output.channels) = (4, vec![ChannelGroup::Beauty, ChannelGroup::Motion]);
        studio
    };
    let (near, far) = (open(&[(1, 2.0, "linear")]), open(&[(1, 5.0, "linear")]));
    let baked = [(1, 2.0, "linear"), (5, 2.0, "linear"), (6, 5.0, "linear")];
    for cut in [open(&[(1, 2.0, "hold"), (6, 5.0, "linear")]), open(&baked)] {
        assert_eq!(cut.frame(5).channels, near.frame(5).channels);
        assert_eq!(cut.frame(6).channels, far.frame(6).channels);
    }
    assert_ne!(near.frame(6).channels, far.frame(6).channels, "the comparison can fail");
}

#[test]
fn a_layer_is_not_coupled_across_a_cut_of_the_camera() {
    let pulled = "{ frame = 1, offset = [0.02, -0.01], rotate = 60, ease = \"hold\" }, { frame = 6, offset = [0.0, 0.02], rotate = 10 }";
    let let_go = "{ frame = 1, offset = [0.0, 0.02], rotate = 10 }";
    let keys = [(1, 2.0, "hold"), (6, 5.0, "linear")];
    let cut = pulled_and_seen_from(pulled, &keys).prepared();
    let far = pulled_and_seen_from(let_go, &[(1, 5.0, "linear")]).prepared();
    let moving = pulled_and_seen_from(pulled, &[(1, 5.0, "linear")]).prepared();
    let handles = |prepared: &PreparedShot, frame: f64| -> Vec<[f64; 2]> {
        let sample = prepared.sample_at(frame).expect("the frame is solved");
        sample.layers[0].solution.as_ref().expect("the layer is warped").lattice.handles.clone()
    };
    let apart = |a: &PreparedShot, b: &PreparedShot, frame: f64| {
        let [a, b] = [a, b].map(|prepared| handles(prepared, frame));
        a.iter().zip(&b).map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1])).fold(0.0, f64::max)
    };
    for frame in [6.0, 6.4, 7.0, 9.0] {
        let off = apart(&cut, &far, frame);
        assert!(off < 1e-5, "{off} of a frame height in frame {frame}");
    }
    let coupled = apart(&moving, &far, 6.0);
    assert!(coupled > 1e-4, "without a cut the frames are coupled: {coupled}");
}

#[test]
fn pins_follow_an_animated_surface() {
    let studio = studio(square(0.02), "\"follow\"");
    let prepared = studio.prepared();
    for frame in [1.0, 3.5, 7.0] {
        let sample = prepared.sample_at(frame).expect("the frame is solved");
        let pin = sample.layers[0].pins[0];
        let expected = glam::DVec2::new(0.6 + 0.02 * (frame - 1.0), 0.3);
        assert!((pin.rest.0 - expected).length() < 1e-6, "{:?} in frame {frame}", pin.rest);
        assert!((pin.target.0 - expected - glam::DVec2::new(0.1, 0.0)).length() < 1e-6);
        let lattice = &sample.layers[0].solution.as_ref().expect("the layer is warped").lattice;
        assert!((lattice.warp(pin.rest).0 - pin.target.0).length() < 1e-5);
    }
}

#[test]
fn pins_fade_before_the_near_plane() {
    // Towards the camera, half a metre a frame: depth 5 in frame 1; the near plane is at half a metre.
    let part = Part { velocity: [0.0, 0.0, 12.0], ..square(0.0) };
    let mut studio = studio(part, "\"frame\"");
    studio.shot.frames.last = 12;
    let tiny =
        Tiny { lens: Lens::Perspective(1.0), ..Tiny::of(vec![Part { velocity: [0.0, 0.0, 12.0], ..square(0.0) }]) };
    write_scene(&tiny, studio.scene());
    let prepared = studio.prepared();
    let pinned = PinAnchor::Surface { part: 0, triangle: 0, corners: [0, 1, 4], barycentric: [1.0, 0.0, 0.0] };
    let weight = |frame: f64| {
        let (pose, camera) = prepared.view(frame);
        pinned.rest(&project(&pose, &camera), &camera).presence
    };
    assert_eq!([weight(1.0), weight(8.9)], [1.0, 1.0], "twice the near distance and more");
    let fading: Vec<f64> = (0..=10).map(|step| weight(9.0 + f64::from(step) / 10.0)).collect();
    assert!(fading.windows(2).all(|pair| pair[1] < pair[0] || pair[0] == 0.0), "{fading:?}");
    assert!((fading[5] - 0.5).abs() < 1e-6, "{fading:?}");
    assert_eq!(weight(10.1), 0.0);
    // The whole layer hangs on this pin: it comes to rest as the pin fades, and does not jump when it is gone.
    let carried = |frame: f64| {
        let sample = prepared.sample_at(frame).expect("the frame is solved");
        let lattice = sample.layers[0].solution.as_ref().map(|solution| solution.lattice.clone());
        lattice.map_or(0.0, |lattice| lattice.warp(ScreenPoint::new(0.8, 0.5)).0.x - 0.8)
    };
    for (frame, expected) in [(8.0, 0.1), (9.5, 0.05), (9.99, 0.0), (10.1, 0.0)] {
        assert!((carried(frame) - expected).abs() < 1e-3, "{} in frame {frame}", carried(frame));
    }
    let acting = |frame: f64| prepared.sample_at(frame).map_or(99, |sample| sample.layers[0].pins.len());
    assert_eq!([acting(8.0), acting(9.5), acting(10.5)], [1, 1, 0]);
}

/// The same studio with the square turned, and the box turned with it.
fn turned(angle: f64, lattice: &str) -> Studio {
    let layer = format!(
        "[[layer]]\nlattice = {{ dims = [4, 4], {lattice} }}\n[[layer.pin]]\nunit = \"box\"\n\
         anchor = {{ node = \"Quad\", triangle = 0, barycentric = [1.0, 0.0, 0.0] }}\n\
         keys = [{{ frame = 1, offset = [0.1, 0.05], rotate = 20 }}]\n[[layer.pin]]\nname = \"still\"\n\
         anchor = {{ node = \"Quad\", triangle = 7, barycentric = [0.0, 1.0, 0.0] }}\n\
         [[layer.handle]]\nindex = [1, 2]\nkeys = [{{ frame = 1, offset = [0.2, 0.1] }}]\n"
    );
    let mut studio = Studio::tiny(&Tiny::of(vec![square(0.0)]), &layer);
    let scene: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(studio.scene()).expect("the scene is there")).expect("JSON");
    let node = scene["nodes"].as_array().expect("nodes").iter().position(|node| node["name"] == "Quad");
    studio.turn_node(node.expect("the square"), glam::DQuat::from_rotation_z(angle));
    studio
}

#[test]
fn a_box_that_turns_with_its_node_moves_the_model_alike() {
    let (center, frame) = (glam::DVec2::new(0.8, 0.5), "frame = { node = \"Quad\" }");
    let lattice = |angle: f64, lattice: &str| {
        let sample = turned(angle, lattice).prepared().sample_at(3.0).expect("the frame is solved");
        sample.layers[0].solution.as_ref().expect("the layer is warped").lattice.clone()
    };
    let upright = lattice(0.0, frame);
    for angle in [0.4, 2.5, -2.0] {
        let turn = |point: glam::DVec2| center + glam::DVec2::from_angle(angle).rotate(point - center);
        let miss = |found: &pinwarp::lattice::ScreenLattice| {
            let places = (0..25).map(|k| glam::DVec2::new(0.6 + 0.1 * f64::from(k % 5), 0.3 + 0.1 * f64::from(k / 5)));
            let gap = |place: glam::DVec2| {
                (found.warp(ScreenPoint(turn(place))).0 - turn(upright.warp(ScreenPoint(place)).0)).length()
            };
            places.map(gap).fold(0.0, f64::max)
        };
        let (with, without) = (lattice(angle, frame), lattice(angle, "box = \"follow\""));
        assert!((with.grid.angle - angle).abs() < 1e-6, "{}", with.grid.angle);
        assert!(miss(&with) < 1e-6, "{:.1e} at {angle}", miss(&with));
        assert!(miss(&without) > 1e-3, "an upright box moves the turned square otherwise: {:.1e}", miss(&without));
        // The same by a number: the square at rest with a turned box, and a quarter turn that changes nothing but the axes.
        let by_angle = lattice(angle, &format!("frame = {{ angle = {} }}", angle.to_degrees()));
        assert!(miss(&by_angle) < 1e-6, "{:.1e} at {angle}", miss(&by_angle));
    }
}

/// A figure beside the origin of its node circles in the picture, because the camera rolls: its box follows it in the frame of the node,
/// at both ends of the shot as in the middle.
#[test]
fn a_box_that_turns_with_its_node_follows_a_figure_that_circles() {
    let layer = "camera = { look_at = [0, 0, 0], distance = 5, ortho = 2, keys = [{ frame = 1, roll = 0 }, { frame = 9, roll = 240 }] }\n\
         [[layer]]\nlattice = { dims = [6, 5], basis = \"bilinear\", frame = { node = \"Quad\" } }\n\
         [[layer.pin]]\nunit = \"box\"\nanchor = { node = \"Quad\", triangle = 0, barycentric = [1.0, 0.0, 0.0] }\n\
         keys = [{ frame = 1, offset = [0.2, 0.1], rotate = 20 }]\n\
         [[layer.pin]]\nname = \"still\"\nanchor = { node = \"Quad\", triangle = 70, barycentric = [1.0, 0.0, 0.0] }\n";
    let studio = Studio::tiny(&Tiny::of(vec![grid("Quad", [0.1, -0.2, 0.5, 0.2], 8)]), layer);
    let prepared = studio.prepared();
    let center = glam::DVec2::new(0.8, 0.5);
    let images = |frame: f64| -> (f64, Vec<glam::DVec2>) {
        let sample = prepared.sample_at(frame).expect("the frame is solved");
        let lattice = &sample.layers[0].solution.as_ref().expect("the layer is warped").lattice;
        let turn = glam::DVec2::from_angle(lattice.grid.angle);
        let places = (0..25).map(|k| glam::DVec2::new(0.05 + 0.05 * f64::from(k % 5), 0.05 * f64::from(k / 5) - 0.1));
        let back = glam::DVec2::from_angle(-lattice.grid.angle);
        let image = |place: glam::DVec2| back.rotate(lattice.warp(ScreenPoint(center + turn.rotate(place))).0 - center);
        (lattice.grid.angle, places.map(image).collect())
    };
    let (start, wanted) = images(1.0);
    assert!(wanted.iter().any(|place| place.x > 0.26), "the warp moves the figure: {wanted:?}");
    for frame in [2.0, 3.5, 5.0, 8.0, 9.0] {
        let (angle, found) = images(frame);
        let miss = found.iter().zip(&wanted).map(|(a, b)| (*a - *b).length()).fold(0.0, f64::max);
        assert!((angle - start).abs() > 0.1 && miss < 1e-6, "frame {frame}: {miss:.1e}, turned by {angle}");
    }
}

#[test]
fn faults_of_box_frames_name_the_key() {
    let studio = Studio::tiny(&Tiny::of(vec![square(0.0)]), "");
    let fault = |lattice: &str| {
        let text = format!(
            "version = 1\nscene = \"tiny.gltf\"\nframes = {{ first = 1, last = 3, rate = 24 }}\n[[layer]]\nlattice = {{ {lattice} }}\n"
        );
        match Shot::parse(&text, &studio.scene().with_file_name("shot.toml")) {
            Ok(shot) => PreparedShot::new(shot).expect_err("a fault").to_string(),
            Err(error) => error.to_string(),
        }
    };
    for (lattice, wanted) in [
        ("frame = {}", "names no node and no angle"),
        ("frame = { axis = \"x\" }", "add `node`"),
        ("frame = { node = \"Quat\" }", "there is no node 'Quat' in the scene"),
        ("frame = { angle = 20 }, box = \"frame\"", "cannot turn the box of the whole frame"),
    ] {
        let told = fault(lattice);
        assert!(told.contains("layer[0].lattice.frame") && told.contains(wanted), "{lattice}: {told}");
    }
    let prepared = turned(0.0, "frame = { node = \"Quad\", axis = \"z\" }").prepared();
    let note = prepared.notes.iter().find(|note| note.contains("points at the camera around frame"));
    assert!(note.is_some_and(|note| note.contains("the z axis of 'Quad'")), "{:?}", prepared.notes);
}

#[test]
fn a_vertex_beyond_all_measure_leaves_the_dims_in_their_range() {
    let mut part = square(0.0);
    part.positions[0] = [1e14; 3];
    let layer = "[[layer]]\nlattice = { dims = \"auto\" }\n[[layer.pin]]\nanchor = { screen = [0.8, 0.5] }\n\
                 keys = [{ frame = 1, offset = [0.1, 0.0] }]\n";
    let prepared = Studio::tiny(&Tiny::of(vec![part]), layer).prepared();
    let [across, up, _] = prepared.shot.layers[0].space.dims();
    assert!((10..=64).contains(&across) && (10..=64).contains(&up), "{across} x {up}");
}
