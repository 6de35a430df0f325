//! `camera`, `hide` and `show`: what is read, and what is refused.

use super::parse;
use pinwarp::shot::{CameraAim, CameraKey, CameraLens, CameraRule, Ease, LookAt, OwnCamera, Shot};

fn shot(lines: &str) -> Shot {
    let text = format!("scene = 'a.glb'\nframes = {{ first = 3, last = 24 }}\n{lines}");
    parse(&text).unwrap_or_else(|error| panic!("{error}"))
}

fn fault(lines: &str) -> String {
    let text = format!("scene = 'a.glb'\nframes = {{ first = 3, last = 24 }}\n{lines}");
    parse(&text).map(|_| ()).expect_err(lines).to_string()
}

fn own(lines: &str) -> OwnCamera {
    match shot(lines).camera {
        CameraRule::Own(camera) => camera,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_camera_is_a_name_or_a_table() {
    assert_eq!(shot("").camera, CameraRule::Automatic);
    assert_eq!(shot("camera = 'front'").camera, CameraRule::Named("front".to_owned()));
    let aim = CameraAim::Orbit { look_at: LookAt::Scene, distance: None, yaw: 0.0, pitch: 0.0 };
    let plain = CameraKey { frame: 3.0, aim, roll: 0.0, lens: CameraLens::Fov(30.0), ease: Ease::Linear };
    assert_eq!(own("camera = {}").keys, std::slice::from_ref(&plain));
    let orbit = own("camera = { look_at = 'Head*', distance = 3, yaw = 30, pitch = 10, roll = 5, fov = 40 }");
    let look_at = LookAt::Nodes("Head*".to_owned());
    let aim = CameraAim::Orbit { look_at, distance: Some(3.0), yaw: 30.0, pitch: 10.0 };
    assert_eq!(orbit.keys, [CameraKey { aim, roll: 5.0, lens: CameraLens::Fov(40.0), ..plain.clone() }]);
    let towards = own("camera = { position = [0, 1, 4], look_at = [0, 1, 0], ortho = 2 }");
    let aim = CameraAim::Towards { position: [0.0, 1.0, 4.0], look_at: LookAt::Point([0.0, 1.0, 0.0]) };
    assert_eq!(towards.keys, [CameraKey { aim, lens: CameraLens::Ortho(2.0), ..plain.clone() }]);
    let along = own("[camera]\nposition = [0, 1, 4]\nyaw = -20");
    let aim = CameraAim::Along { position: [0.0, 1.0, 4.0], yaw: -20.0, pitch: 0.0 };
    assert_eq!(along.keys, [CameraKey { aim, ..plain }]);
}

#[test]
fn keys_take_what_they_leave_out_from_the_table() {
    let camera = own(
        "camera = { distance = 3, pitch = 10, keys = [{ frame = 1, yaw = 0, ease = 'smooth' }, { frame = 9, yaw = 90, pitch = 0 }] }",
    );
    let aim = |yaw, pitch| CameraAim::Orbit { look_at: LookAt::Scene, distance: Some(3.0), yaw, pitch };
    assert_eq!(camera.keys.iter().map(|key| key.aim.clone()).collect::<Vec<_>>(), [aim(0.0, 10.0), aim(90.0, 0.0)]);
    assert_eq!((camera.keys[0].ease, camera.keys[1].frame), (Ease::Smooth, 9.0));
    assert_eq!(camera.keys_at(0.0), Some((0, 0, 0.0)));
    assert_eq!(camera.keys_at(5.0), Some((0, 1, 0.5)));
    assert_eq!(camera.keys_at(20.0), Some((1, 1, 0.0)));
}

#[test]
fn impossible_cameras_are_refused_with_line_and_remedy() {
    for (lines, words) in [
        ("camera = { distnce = 3 }", &["camera.distnce", "did you mean `distance`?"][..]),
        ("camera = { distance = 3, position = [0, 0, 1] }", &["pot.toml:3: camera", "not both"]),
        ("camera = { position = [0, 0, 1], look_at = 'A', yaw = 3 }", &["say already where the camera looks"]),
        ("camera = { fov = 30, ortho = 2 }", &["fov", "ortho", "not both"]),
        ("camera = { fov = 0 }", &["camera.fov", "out of range"]),
        ("camera = { pitch = 91 }", &["camera.pitch", "out of range"]),
        ("camera = { position = [0, 1] }", &["camera.position", "3"]),
        ("camera = { look_at = [0, 1] }", &["camera.look_at"]),
        ("camera = { keys = [{ frame = 1 }, { frame = 1 }] }", &["camera.keys[1].frame", "not later"]),
        ("camera = { keys = [{ frame = 1 }, { frame = 2, distance = 3 }] }", &["camera.keys[1]", "of another kind"]),
        ("camera = { keys = [{ frame = 1, yew = 3 }] }", &["camera.keys[0].yew", "did you mean `yaw`?"]),
        ("camera = 7", &["camera"]),
        ("camera = ''", &["camera", "is empty"]),
        ("fov = 30", &["it belongs in camera"]),
        ("hide = 'Sword'", &["hide", "list"]),
        ("hide = ['']", &["hide[0]", "is empty"]),
        ("hid = ['A']", &["did you mean `hide`?"]),
    ] {
        let text = fault(lines);
        assert!(words.iter().all(|word| text.contains(word)), "{lines}\n{text}\nlacks one of {words:?}");
    }
    for lines in ["camera = { yaw = 3 }", "hide = ['A']", "show = ['A']"] {
        let text = format!("image = 'a.png'\nsize = [4, 4]\nframes = {{ first = 3, last = 24 }}\n{lines}");
        let error = parse(&text).map(|_| ()).expect_err(lines).to_string();
        assert!(error.contains("scene"), "{error}");
    }
}

#[test]
fn hidden_and_shown_nodes_are_read() {
    let visibility = shot("hide = ['*Sword*', 'Shield']\nshow = ['1H_Sword']").visibility;
    assert_eq!((visibility.hide.len(), visibility.show), (2, vec!["1H_Sword".to_owned()]));
}
