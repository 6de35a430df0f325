//! Cameras of the shot and hidden nodes: where things are seen, what is drawn, exported and named.

use super::support::{Studio, at, pixels};
use super::tiny::{Lens, Tiny, grid};
use glam::DVec3;
use pinwarp::pipeline::{BakeTimes, PreparedShot};
use pinwarp::shot::Shot;
use pinwarp::space::ScreenPoint;

const MIDDLE: ScreenPoint = ScreenPoint(glam::DVec2::new(0.8, 0.5));

/// Two squares of one metre, 3 m apart; the scene has a camera of its own, `Cam`.
fn scene() -> Tiny {
    let mut left = grid("Sword_L", [-0.5, -0.5, 0.5, 0.5], 1);
    left.place = [-1.5, 0.0, 0.0];
    let mut right = grid("Body", [-0.5, -0.5, 0.5, 0.5], 1);
    right.place = [1.5, 1.0, 0.0];
    Tiny { lens: Lens::Perspective(0.8), ..Tiny::of(vec![left, right]) }
}

fn studio(lines: &str) -> Studio {
    Studio::tiny(&scene(), &format!("{lines}\n[output]\nchannels = [\"beauty\", \"id\", \"depth\"]\n"))
}

fn refused(lines: &str) -> String {
    PreparedShot::new(studio(lines).shot).map(|_| ()).expect_err(lines).to_string()
}

fn place(prepared: &PreparedShot, frame: f64, point: [f64; 3]) -> ScreenPoint {
    prepared.view(frame).1.project_exact(DVec3::from_array(point)).point()
}

fn ids(studio: &Studio) -> usize {
    let frame = studio.frame(1);
    pixels(&frame).filter(|&(x, y)| at(&frame, "id.object", x, y) > 0.0).count()
}

#[test]
fn a_camera_of_the_shot_looks_at_its_target() {
    for (lines, looked_at, depth) in [
        ("camera = { look_at = 'Body', distance = 4, yaw = 50, pitch = 20 }", [1.5, 1.0, 0.0], 4.0),
        ("camera = { look_at = [1, 2, 3], distance = 2, pitch = -80, roll = 33 }", [1.0, 2.0, 3.0], 2.0),
        ("camera = { position = [0, 1, 4], look_at = [0, 1, 1] }", [0.0, 1.0, 1.0], 3.0),
        ("camera = { position = [2, 1, 4], yaw = 90, fov = 60 }", [0.0, 1.0, 4.0], 2.0),
        ("camera = { distance = 7, ortho = 5 }", [0.0, 0.5, 0.0], 7.0),
    ] {
        let prepared = studio(lines).prepared();
        let camera = prepared.view(1.0).1;
        let seen = camera.project_exact(DVec3::from_array(looked_at));
        assert!((seen.point() - MIDDLE).0.length() < 1e-6, "{lines}: {:?}", seen.point());
        assert!((seen.depth - depth).abs() < 1e-6, "{lines}: {}", seen.depth);
    }
    // An ortho camera sees that many metres; a fov is vertical.
    let ortho = studio("camera = { ortho = 4 }").prepared();
    let up = place(&ortho, 1.0, [0.0, 1.5, 0.0]).0.y - place(&ortho, 1.0, [0.0, 0.5, 0.0]).0.y;
    assert!((up - 0.25).abs() < 1e-6, "{up}");
    let wide = studio("camera = { position = [0, 0, 2], fov = 90 }").prepared();
    assert!((place(&wide, 1.0, [0.0, 2.0, 0.0]).0.y - 1.0).abs() < 1e-6);
}

#[test]
fn views_show_everything_from_their_side() {
    for (name, towards) in
        [("front", DVec3::Z), ("back", DVec3::NEG_Z), ("side", DVec3::X), ("left", DVec3::NEG_X), ("top", DVec3::Y)]
    {
        let mut studio = studio("");
        studio.shot.camera = pinwarp::shot::CameraRule::Named(name.to_owned());
        let prepared = studio.prepared();
        let (pose, camera) = prepared.view(1.0);
        assert!((camera.towards_viewer().as_dvec3() - towards).length() < 1e-6, "{name}");
        let points: Vec<_> =
            pose.parts.iter().flat_map(|part| &part.positions).map(|at| camera.project(*at).point().0).collect();
        assert!(points.iter().all(|at| at.x >= 0.0 && at.x <= 1.6 && at.y >= 0.0 && at.y <= 1.0), "{name}: {points:?}");
        let spread =
            points.iter().fold(0.0f64, |most, at| most.max((at.x - 0.8).abs() / 0.8).max((at.y - 0.5).abs() * 2.0));
        assert!(spread > 0.9, "{name} is far away: {spread}");
    }
    let layers = "[[layer]]\nname = \"sword\"\nnodes = [\"Sword_L\"]\n";
    let mut studio = Studio::tiny(&scene(), layers);
    studio.shot.camera = pinwarp::shot::CameraRule::Named("front:sword".to_owned());
    let prepared = studio.prepared();
    assert!((place(&prepared, 1.0, [-1.5, 0.0, 0.0]) - MIDDLE).0.length() < 1e-6);
    let height = place(&prepared, 1.0, [-1.5, 0.5, 0.0]).0.y - place(&prepared, 1.0, [-1.5, -0.5, 0.0]).0.y;
    assert!(height > 0.9 && height < 1.0, "{height}");
}

#[test]
fn wrong_cameras_name_what_there_is() {
    for (lines, words) in [
        ("camera = 'Camm'", &["\"Camm\"", "did you mean \"Cam\"?", "three-quarter"][..]),
        ("camera = 'xyz'", &["there are: Cam", "views: front"]),
        ("camera = 'frnt'", &["did you mean \"front\"?"]),
        ("camera = 'front:bodi'", &["no layer 'bodi'"]),
        ("camera = { look_at = 'Bodi' }", &["camera.look_at", "no node matches 'Bodi'", "did you mean \"Body\"?"]),
    ] {
        let text = refused(lines);
        assert!(words.iter().all(|word| text.contains(word)), "{lines}\n{text}\nlacks one of {words:?}");
    }
}

#[test]
fn keys_move_the_camera_with_their_eases() {
    let keys =
        "keys = [{ frame = 1, yaw = 0, ease = 'smooth' }, { frame = 5, yaw = 90 }, { frame = 9, yaw = 90, fov = 60 }]";
    let prepared = studio(&format!("camera = {{ look_at = [0, 0, 0], distance = 5, {keys} }}")).prepared();
    for (frame, yaw, fov) in [
        (0.0, 0.0, 30.0),
        (1.0, 0.0, 30.0),
        (2.0, 90.0 * 0.15625, 30.0),
        (5.0, 90.0, 30.0),
        (7.0, 90.0, 45.0),
        (20.0, 90.0, 60.0f64),
    ] {
        let camera = prepared.view(frame).1;
        let (sin, cos) = f64::to_radians(yaw).sin_cos();
        let towards = camera.towards_viewer().as_dvec3();
        assert!((towards - DVec3::new(sin, 0.0, cos)).length() < 1e-6, "frame {frame}: {towards}");
        let pinwarp::scene::Lens::Perspective { yfov } = camera.lens() else { panic!("a perspective lens") };
        assert!((f64::from(yfov).to_degrees() - fov).abs() < 1e-4, "frame {frame}: {yfov}");
    }
}

#[test]
fn world_layers_pins_and_casts_see_through_the_shot_s_camera() {
    let pin = "[[layer]]\nname = \"all\"\nnodes = [\"Body\"]\nlattice = { space = \"world\", dims = [4, 4, 4] }\n\
               [[layer.pin]]\nanchor = { screen = [0.8, 0.5], frame = 1 }\nkeys = [{ frame = 1, offset = [0.1, 0.0] }]\n";
    let prepared = studio(&format!("camera = {{ look_at = 'Body', distance = 4, yaw = 30 }}\n{pin}")).prepared();
    let sample = prepared.sample_at(1.0).unwrap();
    let world = sample.layers[0].world.as_ref().expect("a solved lattice of the scene");
    let pinned = world.pins[0];
    assert!((pinned.rest - DVec3::new(1.5, 1.0, 0.0)).length() < 1e-4, "{pinned:?}");
    let reached = sample.camera.project_exact(world.lattice.warp(pinned.rest)).point();
    assert!((reached.0 - glam::DVec2::new(0.9, 0.5)).length() < 1e-3, "{reached:?}");
}

#[test]
fn hidden_nodes_are_not_drawn_picked_framed_or_named() {
    let all = ids(&studio("camera = { distance = 9 }"));
    let hidden = studio("hide = ['*Sword*']\ncamera = { distance = 9, look_at = [0, 0.5, 0] }");
    assert!(ids(&hidden) > 10 && ids(&hidden) < all * 6 / 10, "{} of {all}", ids(&hidden));
    let prepared = hidden.prepared();
    assert_eq!(prepared.assignment.layer_of_part.len(), 1);
    let behind = place(&prepared, 1.0, [-1.5, 0.0, 0.0]);
    assert!(prepared.cast(1, &[behind])[0].is_none());
    // What is hidden does not count for framing.
    assert!(
        (place(&studio("hide = ['Sword_L']\ncamera = {}").prepared(), 1.0, [1.5, 1.0, 0.0]) - MIDDLE).0.length() < 1e-6
    );
    for lines in ["show = ['Body']", "hide = ['*']\nshow = ['Bo*']", "hide = ['*d*']\nshow = ['Body']"] {
        let prepared = studio(lines).prepared();
        assert_eq!(prepared.assignment.layer_of_part.len(), 1, "{lines}");
        assert_eq!(prepared.scene.nodes[prepared.view(1.0).0.parts[0].node].name, "Body", "{lines}");
    }
    assert!(refused("hide = ['*']").contains("nothing is left to draw"));
    assert!(refused("hide = ['Sward_L']").contains("did you mean \"Sword_L\"?"));
}

#[test]
fn cryptomattes_know_no_hidden_nodes() {
    let text = "hide = ['Sword_L']\n[output]\nchannels = [\"beauty\", \"cryptomatte\"]\n";
    let studio = Studio::tiny(&scene(), text);
    let path = studio.files(&[1]).remove(0);
    let bytes = String::from_utf8_lossy(&std::fs::read(path).unwrap()).into_owned();
    assert!(bytes.contains("Body") && !bytes.contains("Sword_L"));
}

#[test]
fn exported_scenes_have_the_shot_s_camera_and_no_hidden_meshes() {
    let keys = "keys = [{ frame = 1, yaw = 0 }, { frame = 3, yaw = 40 }]";
    let studio = studio(&format!("hide = ['Sword_L']\ncamera = {{ look_at = 'Body', distance = 5, {keys} }}"));
    let prepared = studio.prepared();
    let frames = [1, 2, 3];
    let baked = prepared.bake(&frames, BakeTimes::Frames, |_| false, |_| {}).unwrap();
    let bytes = pinwarp::export::gltf::glb(prepared.packed().unwrap(), &baked).unwrap();
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.glb"), bytes).unwrap();
    let text = "version = 1\nscene = 'a.glb'\ncamera = 'pinwarp camera'\nsize = [64, 40]\n\
                frames = { first = 1, last = 3, rate = 24, clip_start = 0 }\n";
    let again = PreparedShot::new(Shot::parse(text, &folder.path().join("shot.toml")).unwrap()).unwrap();
    assert_eq!(again.assignment.layer_of_part.len(), 1, "the hidden mesh is gone");
    for frame in frames.map(f64::from) {
        for point in [[1.5, 1.0, 0.0], [2.0, 1.5, 0.0], [0.3, 0.2, -0.5]] {
            let [one, two] = [&prepared, &again].map(|prepared| place(prepared, frame, point));
            assert!((one - two).0.length() < 1e-4, "frame {frame}: {one:?} is not {two:?}");
        }
    }
    let moved = place(&again, 3.0, [2.0, 1.5, 0.0]) - place(&again, 1.0, [2.0, 1.5, 0.0]);
    assert!(moved.0.length() > 0.01, "the camera moves, or nothing was compared");
}
