//! `pinwarp info`, views, hidden nodes and files outside, as a user meets them.

use crate::support::{Bench, square};
use base64::Engine;
use serde_json::Value;

fn json(bench: &Bench, file: &str) -> Value {
    let ended = bench.run(&format!("info {file} --json")).says(0, &[]);
    serde_json::from_str(&ended.stdout).unwrap_or_else(|error| panic!("{error}: {}", ended.stdout))
}

#[test]
fn a_scene_is_listed() {
    let bench = Bench::new();
    let words = bench.run("info tiny.gltf").says(0, &[]).stdout;
    for word in ["Quad", "Cam", "triangles", "bounds at rest", "cameras: 1", "clips: 0"] {
        assert!(words.contains(word), "{word} is not in\n{words}");
    }
    let info = json(&bench, "tiny.gltf");
    assert_eq!(info["kind"], "scene");
    assert_eq!(
        (info["nodes"][0]["name"].as_str(), info["nodes"][0]["mesh"]["triangles"].as_u64()),
        (Some("Quad"), Some(8))
    );
    assert_eq!(info["cameras"][0]["name"], "Cam");
    assert_eq!(info["counts"]["nodes"], 2);
    assert_eq!(info["bounds"][0][0].as_f64().map(|x| (x * 10.0).round()), Some(-4.0));
}

#[test]
fn clips_have_their_durations() {
    let mut tiny = square();
    tiny.camera_velocity = [1.0, 0.0, 0.0];
    let bench = Bench::with_scene(&tiny.json());
    let info = json(&bench, "tiny.gltf");
    assert_eq!((info["clips"][0]["name"].as_str(), info["clips"][0]["seconds"].as_f64()), (Some("Move"), Some(100.0)));
    assert!(bench.run("info tiny.gltf").stdout.contains("Move (100.00 s, 1 track)"));
}

#[test]
fn a_picture_says_what_a_warp_does_with_its_channels() {
    let bench = Bench::new();
    bench.render("--frames 1 --preview --scale 1/4").says(0, &[]);
    let frame = format!("out/{}", bench.frames().into_iter().find(|name| name.ends_with(".exr")).unwrap());
    let info = json(&bench, &frame);
    assert_eq!((info["kind"].as_str(), info["parts"][0]["compression"].as_str()), (Some("picture"), Some("zip")));
    let channels = info["parts"][0]["channels"].as_array().unwrap();
    let meaning = |name: &str| {
        let found = channels.iter().find(|channel| channel["name"] == name);
        found.unwrap_or_else(|| panic!("{name} is not in {info}"))["meaning"].clone()
    };
    assert_eq!((meaning("R"), meaning("A")), (Value::from("color"), Value::from("alpha")));
    let words = bench.run(&format!("info {frame}")).says(0, &[]).stdout;
    assert!(words.contains("R (") && words.contains("filtered as colour"), "{words}");
    let preview = frame.replace(".exr", ".png");
    assert_eq!(json(&bench, &preview)["parts"][0]["compression"], Value::Null);
}

#[test]
fn shots_and_lattices_are_summed_up() {
    let bench = Bench::new();
    let shot = json(&bench, "shot.toml");
    assert_eq!((shot["kind"].as_str(), shot["layers"][0]["pins"].as_u64()), (Some("shot"), Some(1)));
    assert!(bench.run("info shot.toml").stdout.contains("1 pin"));
    bench.run("export shot.toml --to lattice-json -o a.json").says(0, &[]);
    let lattices = json(&bench, "a.json");
    assert_eq!(
        (lattices["kind"].as_str(), lattices["layers"][0]["space"].as_str()),
        (Some("lattices"), Some("screen"))
    );
    assert!(lattices["layers"][0]["lattices"].as_u64().unwrap() > 0);
}

#[test]
fn unreadable_files_are_refused() {
    let bench = Bench::new();
    bench.write("a.psd", b"8BPS");
    bench.run("info a.psd").says(2, &["is not a supported file"]);
    bench.run("info gone.glb").says(2, &["gone.glb"]);
    bench.run("info gone.exr").says(2, &["gone.exr"]);
}

#[test]
fn views_replace_the_shot_s_camera() {
    let bench = Bench::new();
    bench.run("check shot.toml --camera three-quarter").says(0, &[]);
    bench.run("check shot.toml --camera Cam").says(0, &[]);
    bench.run("check shot.toml --camera Camm").says(2, &["did you mean \"Cam\"?", "front"]);
    // Seen from the side the square is a line: nothing can be picked where it is seen from the front.
    let front = bench.run("pick shot.toml --at 0.8,0.5 --camera front").says(0, &[]);
    assert!(front.stdout.contains("Quad"), "{}", front.stdout);
    bench.run("pick shot.toml --at 0.9,0.6 --camera side").says(2, &["there is no surface"]);
    bench.render("--frames 1 --camera back --scale 1/4").says(0, &[]);
}

#[test]
fn names_from_files_drive_no_terminal() {
    let mut scene = square().json();
    scene["nodes"][0]["name"] = Value::from("Qu\u{1b}[31mad\nerror: forged");
    scene["meshes"][0]["name"] = Value::from("Me\u{1b}]0;title\u{7}sh");
    scene["materials"][0]["name"] = Value::from("Ma\u{9b}31mt");
    scene["nodes"][1]["name"] = Value::from("Ca\rm");
    scene["images"] = serde_json::json!([{ "uri": "a\u{1b}[2Jb.png" }]);
    scene["textures"] = serde_json::json!([{ "source": 0 }]);
    scene["materials"][0]["emissiveTexture"] = serde_json::json!({ "index": 0 });
    let bench = Bench::with_scene(&scene);
    let escaped = |text: &str| text.chars().all(|letter| letter == '\n' || !letter.is_control());
    for arguments in [
        "info tiny.gltf",
        "check shot.toml",
        "check shot.toml --camera nobody",
        "new tiny.gltf -o new.toml",
        "pick shot.toml --at 0.8,0.5",
        "render shot.toml --device cpu --frames 1 --scale 1/8",
    ] {
        let ended = bench.run(arguments);
        assert!(escaped(&ended.stdout) && escaped(&ended.stderr), "{arguments}: {ended:?}");
        assert!(
            !ended.stderr.lines().chain(ended.stdout.lines()).any(|line| line.starts_with("error: forged")),
            "{ended:?}"
        );
    }
    assert!(bench.run("info tiny.gltf").stdout.contains(r"Qu\u{1b}[31mad\nerror: forged"));
    bench.write(
        "key.toml",
        b"scene = 'tiny.gltf'\nframes = { first = 1, last = 2 }\n\"a\\u001b[31m\\nb\" = 3\nhide = [\"\\u001b[1m\"]\n",
    );
    let ended = bench.run("check key.toml").says(2, &[]);
    assert!(escaped(&ended.stderr), "{ended:?}");
    let strange = bench.run("info gone\u{1b}[31m.glb").says(2, &[]);
    assert!(escaped(&strange.stderr), "{strange:?}");
}

#[test]
fn scenes_stay_in_their_folder_unless_allowed() {
    let bench = Bench::new();
    std::fs::create_dir(bench.path("inner")).unwrap();
    let mut scene = square().json();
    let uri = scene["buffers"][0]["uri"].as_str().unwrap().to_owned();
    let (_, data) = uri.split_once(',').unwrap();
    bench.write("outside.bin", &base64::engine::general_purpose::STANDARD.decode(data).unwrap());
    scene["buffers"][0]["uri"] = Value::from("../outside.bin");
    bench.write("inner/tiny.gltf", scene.to_string().as_bytes());
    let shot = String::from_utf8(bench.read("shot.toml")).unwrap().replace("tiny.gltf", "inner/tiny.gltf");
    bench.write("shot.toml", shot.as_bytes());
    for arguments in [
        "info inner/tiny.gltf",
        "new inner/tiny.gltf -o new.toml",
        "check shot.toml",
        "pick shot.toml --at 0.8,0.5",
        "render shot.toml --device cpu --frames 1 --scale 1/8",
        "export shot.toml --to gltf -o a.glb",
    ] {
        bench.run(arguments).says(2, &["outside the folder of the scene", "--allow-outside"]);
        bench.run(&format!("{arguments} --allow-outside")).says(0, &[]);
    }
}

#[test]
fn a_new_shot_lists_what_hangs_in_one_hand() {
    let mut scene = square().json();
    let base = scene["nodes"][0].clone();
    let nodes = scene["nodes"].as_array_mut().unwrap();
    for name in ["Sword", "Axe"] {
        let mut node = base.clone();
        node["name"] = Value::from(name);
        nodes.push(node);
    }
    nodes.push(serde_json::json!({ "name": "hand", "children": [2, 3] }));
    scene["skins"] = serde_json::json!([{ "joints": [4] }]);
    scene["nodes"][0]["skin"] = Value::from(0);
    scene["scenes"][0]["nodes"] = serde_json::json!([0, 1, 4]);
    // Nine vertices, all of the first joint.
    let joints = vec![0u8; 36];
    let weights: Vec<u8> = [1.0f32, 0.0, 0.0, 0.0].repeat(9).into_iter().flat_map(f32::to_le_bytes).collect();
    for (bytes, component) in [(joints, 5121), (weights, 5126)] {
        let uri = format!("data:;base64,{}", base64::engine::general_purpose::STANDARD.encode(&bytes));
        let place = scene["buffers"].as_array().unwrap().len();
        scene["buffers"].as_array_mut().unwrap().push(serde_json::json!({ "byteLength": bytes.len(), "uri": uri }));
        let views = scene["bufferViews"].as_array_mut().unwrap();
        views.push(serde_json::json!({ "buffer": place, "byteLength": bytes.len() }));
        let view = views.len() - 1;
        let accessor =
            serde_json::json!({ "bufferView": view, "componentType": component, "count": 9, "type": "VEC4" });
        scene["accessors"].as_array_mut().unwrap().push(accessor);
    }
    let count = scene["accessors"].as_array().unwrap().len();
    let mut skinned = scene["meshes"][0].clone();
    skinned["primitives"][0]["attributes"]["JOINTS_0"] = Value::from(count - 2);
    skinned["primitives"][0]["attributes"]["WEIGHTS_0"] = Value::from(count - 1);
    scene["meshes"].as_array_mut().unwrap().push(skinned);
    scene["nodes"][0]["mesh"] = Value::from(1);
    let bench = Bench::with_scene(&scene);
    bench.run("new tiny.gltf -o new.toml").says(0, &[]);
    let text = String::from_utf8(bench.read("new.toml")).unwrap();
    assert!(text.contains("# hide = [\"Sword\", \"Axe\"]"), "{text}");
    bench.write("new.toml", text.replace("# hide =", "hide =").as_bytes());
    bench.run("check new.toml --frames 1").says(0, &[]);
}
