//! `export --to gltf` and `--to blender`: what other programs make of the files.

use crate::python;
use crate::support::{Bench, HEAD, OUTPUT, PIN, square};
use crate::tiny::{Lens, Tiny, grid};
use glam::{DVec3, Vec3};
use pinwarp::pipeline::{PreparedShot, TimeSample};
use pinwarp::pose::{ClipChoice, Pose, pose};
use pinwarp::scene::{AlphaMode, Scene, load};
use pinwarp::screen::primitive;
use pinwarp::shot::Shot;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use toml_edit::DocumentMut;

/// What the issue asks of Blender: scene units.
const TOLERANCE: f64 = 1e-5;

/// Corners of the triangles of each node, in drawing order.
type Corners = BTreeMap<String, Vec<DVec3>>;

fn corners_of(scene: &Scene, pose: &Pose, place: impl Fn(usize, usize) -> DVec3) -> Corners {
    let mut corners = Corners::new();
    for (part, posed) in pose.parts.iter().enumerate() {
        let places = primitive(scene, posed).triangles.iter().flatten().map(|&corner| place(part, corner as usize));
        corners.entry(scene.nodes[posed.node].name.clone()).or_default().extend(places);
    }
    corners
}

/// Where a shot puts its triangles in a frame: screen layers move them across the view.
fn warped(prepared: &PreparedShot, frame: i32) -> Corners {
    let sample: &TimeSample = &prepared.sample_at(f64::from(frame)).expect("solved");
    let mesh = sample.mesh();
    corners_of(&prepared.scene, &sample.pose, |part, vertex| {
        let (place, seen) = (sample.pose.parts[part].positions[vertex].0.as_dvec3(), mesh.parts[part].vertices[vertex]);
        let solution = prepared.assignment.layer_of_part[part].and_then(|layer| sample.layers[layer].solution.as_ref());
        let by = |lattice: &pinwarp::lattice::ScreenLattice| {
            sample.camera.scene_from_screen_vector(lattice.warp(seen.point()) - seen.point(), seen.w)
        };
        solution.map_or(place, |solution| place + by(&solution.lattice))
    })
}

fn prepared(path: &Path) -> PreparedShot {
    PreparedShot::new(Shot::read(path).expect("a right shot")).expect("the scene fits")
}

/// Greatest distance of a corner from where it belongs; infinite where the lists do not match.
fn gap(wanted: &Corners, found: &Corners) -> f64 {
    let of_node = |(name, wanted): (&String, &Vec<DVec3>)| match found.get(name) {
        Some(found) if found.len() == wanted.len() => {
            wanted.iter().zip(found).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
        }
        _ => f64::INFINITY,
    };
    wanted.iter().map(of_node).fold(0.0, f64::max)
}

/// A bent sheet seen in perspective.
fn sheet() -> Value {
    let mut part = grid("Quad", [-0.4, -0.3, 0.4, 0.3], 12);
    part.positions.iter_mut().for_each(|point| point[2] = 0.3 * (3.0 * point[0]).cos() + 0.2 * point[1]);
    part.velocity = [0.5, 0.0, 0.0];
    Tiny { lens: Lens::Perspective(0.25), ..Tiny::of(vec![part]) }.json()
}

/// A second pin, which stays: one alone would only shift the lattice as a whole.
const HOLD: &str = r#"
  [[layer.pin]]
  name = "hold"
  anchor = { node = "Quad", triangle = 1, barycentric = [0.0, 1.0, 0.0] }
"#;

fn usual(scene: &Value) -> Bench {
    Bench::with(scene, &format!("{HEAD}{PIN}{HOLD}{OUTPUT}"))
}

/// One of the program's own shots in a bench's folder, its frames solved alone: few of them are exported.
fn shot_of(bench: &Bench, scene: &str) -> PathBuf {
    let (from, to) = (Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(scene), bench.path(scene));
    std::fs::create_dir_all(&to).expect("there is room");
    for file in std::fs::read_dir(from).expect("it comes with the program").flatten() {
        if file.path().is_file() {
            std::fs::copy(file.path(), to.join(file.file_name())).expect("there is room");
        }
    }
    let shot = to.join("shot.toml");
    let mut text: DocumentMut = std::fs::read_to_string(&shot).expect("a shot").parse().expect("TOML");
    for layer in text["layer"].as_array_of_tables_mut().expect("layers").iter_mut() {
        layer["solve"]["temporal"] = 0.into();
    }
    std::fs::write(&shot, text.to_string()).expect("there is room");
    shot
}

/// Runs an export of one of the program's own shots into a bench's folder.
fn export_scene(bench: &Bench, scene: &str, arguments: &str) -> String {
    let shot = shot_of(bench, scene);
    bench.run(&format!("export {} {arguments}", shot.display())).says(0, &[]).stdout
}

#[test]
fn morph_targets_stand_where_the_warp_puts_the_vertices() {
    let cases = [("gingerman", "1-24x6"), ("hare", "1-24x6"), ("cat", "1-24x6"), ("walker", "5,11")];
    let bench = Bench::new();
    for (scene, list) in cases {
        export_scene(&bench, scene, &format!("--to gltf --frames {list} -o {scene}.glb"));
        let prepared = prepared(&shot_of(&bench, scene));
        let exported = load(&bench.path(&format!("{scene}.glb"))).expect("our own loader reads it");
        assert_eq!((exported.nodes.len(), exported.clips.len()), (prepared.scene.nodes.len(), 1));
        assert_eq!(exported.materials.len(), prepared.scene.materials.len());
        for frame in if scene == "walker" { vec![5, 11] } else { vec![1, 13, 19] } {
            let choice = ClipChoice { clip: Some(0), is_looped: false };
            let posed = pose(&exported, choice, prepared.shot.frames.seconds(f64::from(frame)));
            let found = corners_of(&exported, &posed, |part, vertex| posed.parts[part].positions[vertex].0.as_dvec3());
            let wanted = warped(&prepared, frame);
            assert!(gap(&wanted, &found) < 2e-6, "{scene}, frame {frame}: {:e}", gap(&wanted, &found));
            let unwarped = prepared.view(f64::from(frame)).0;
            let still = corners_of(&prepared.scene, &unwarped, |part, vertex| {
                unwarped.parts[part].positions[vertex].0.as_dvec3()
            });
            assert!(frame == 1 || gap(&still, &found) > 1e-3, "{scene}, frame {frame} is not warped at all");
        }
    }
}

#[test]
fn normals_turn_with_world_layers_and_stay_on_the_screen() {
    let bench = Bench::new();
    for (scene, turns) in [("hare", true), ("gingerman", false)] {
        export_scene(&bench, scene, &format!("--to gltf --frames 8 -o {scene}.glb"));
        let prepared = prepared(&shot_of(&bench, scene));
        let exported = load(&bench.path(&format!("{scene}.glb"))).expect("readable");
        let posed = pose(&exported, ClipChoice { clip: Some(0), is_looped: false }, prepared.shot.frames.seconds(8.0));
        let sample = prepared.sample_at(8.0).expect("solved");
        let (unwarped, _) = prepared.view(8.0);
        let gap_to = |other: &Pose| {
            let normals = |pose: &Pose| -> Vec<Vec3> {
                pose.parts.iter().flat_map(|part| part.normals.iter().map(|normal| normal.0)).collect()
            };
            normals(&posed).iter().zip(normals(other)).map(|(a, b)| a.distance(b)).fold(0.0, f32::max)
        };
        assert!(gap_to(&sample.pose) < 1e-4, "{scene}: {}", gap_to(&sample.pose));
        assert_eq!(gap_to(&unwarped) > 0.1, turns, "{scene}: {}", gap_to(&unwarped));
    }
}

/// Pixels of two frames that differ by more than `limit` in any channel that both have, as a share.
fn share_of_different_pixels(bench: &Bench, [a, b]: [&str; 2], limit: f32) -> f64 {
    let [a, b] = [a, b].map(|name| pinwarp::image::read_exr(&bench.path(name)).expect("a frame"));
    let at = |frame: &pinwarp::image::Frame, name: &str, x: i32, y: i32| {
        let window = frame.data_window;
        let (column, row) = (x - window.x, y - window.y);
        let is_inside = (0..window.width as i32).contains(&column) && (0..window.height as i32).contains(&row);
        let channel = frame.channel(name).expect("a colour channel");
        if is_inside { channel.samples[(row * window.width as i32 + column) as usize] } else { 0.0 }
    };
    let (width, height) = (a.display.width as i32, a.display.height as i32);
    let differs = |x: i32, y: i32| {
        ["R", "G", "B", "A"].iter().any(|name| (at(&a, name, x, y) - at(&b, name, x, y)).abs() > limit)
    };
    let count = (0..width * height).filter(|k| differs(k % width, k / width)).count();
    count as f64 / f64::from(width * height)
}

#[test]
fn the_exported_scene_renders_like_the_warped_one() {
    let bench = usual(&sheet());
    let told = bench.run("export shot.toml --to gltf").says(0, &[]).stdout;
    assert!(told.contains("wrote shot.warped.glb: 2 frames, 1 deformed node"), "{told}");
    assert!(told.contains("its normals stay"), "{told}");
    bench.render("").says(0, &[]);
    let still = format!("{HEAD}{OUTPUT}").replace("tiny.gltf", "shot.warped.glb").replace("out/f", "out/g");
    bench.write("still.toml", still.as_bytes());
    bench.run("render still.toml --device cpu").says(0, &[]);
    for frame in ["0001", "0002"] {
        let names = [format!("out/f.{frame}.exr"), format!("out/g.{frame}.exr")];
        let share = share_of_different_pixels(&bench, [&names[0], &names[1]], 1e-3);
        assert!(share < 0.004, "frame {frame}: {share}");
    }
    // The comparison can fail: the two frames of the shot are different pictures.
    assert!(share_of_different_pixels(&bench, ["out/f.0001.exr", "out/f.0002.exr"], 1e-3) > 0.02);
}

/// Runs scripts (or imports scenes), each in a new file, and writes the corners of every mesh in some frames.
const BLENDER: &str = r#"
import bpy, json, runpy, sys

def facts(source, frames, later):
    # Scripts meet the cube, light and camera of a new file, and take them out.
    bpy.ops.wm.read_factory_settings(use_empty=not source.endswith(".py"))
    if source.endswith(".py"):
        runpy.run_path(source, run_name="__main__")
    else:
        bpy.context.scene.render.fps = 24
        bpy.ops.import_scene.gltf(filepath=source)
    told = {}
    for frame in frames:
        bpy.context.scene.frame_set(frame + later)
        graph = bpy.context.evaluated_depsgraph_get()
        told[frame] = {}
        for thing in [thing for thing in bpy.data.objects if thing.type == "MESH"]:
            seen = thing.evaluated_get(graph)
            mesh, place = seen.to_mesh(), seen.matrix_world
            points = [place @ vertex.co for vertex in mesh.vertices]
            corners = [points[k] for face in mesh.polygons for k in face.vertices]
            told[frame][thing.name] = [[p.x, p.z, -p.y] for p in corners]
            seen.to_mesh_clear()
    modifiers = sum(modifier.type == "LATTICE" for thing in bpy.data.objects for modifier in thing.modifiers)
    scene = bpy.context.scene
    default = [thing.name for thing in bpy.data.objects if thing.name in ("Cube", "Light", "Camera")]
    camera = scene.camera and scene.camera.name
    return {"default": default, "frames": told, "modifiers": modifiers, "camera": camera, "end": scene.frame_end}

json.dump([facts(*job) for job in json.loads(sys.argv[1])], open(sys.argv[2], "w"))
"#;

/// Scripts or scenes, the frames to look at, and how much later those are in Blender.
type Shown<'a> = (PathBuf, &'a [i32], i32);

/// What Blender shows of scripts and scenes; `None` without Blender.
fn in_blender<const N: usize>(shown: [Shown; N]) -> Option<[Value; N]> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (jobs, out) = (serde_json::json!(shown.as_slice()).to_string(), folder.path().join("blender.json"));
    python::run(&["bpy"], BLENDER, &[jobs.as_ref(), out.as_os_str()])?;
    let facts: Vec<Value> = serde_json::from_slice(&std::fs::read(out).expect("it was written")).expect("JSON");
    assert!(facts.iter().all(|facts| facts["default"] == serde_json::json!([])), "Blender's default objects are gone");
    Some(facts.try_into().expect("as many as were asked for"))
}

fn corners_in(told: &Value, frame: i32) -> Corners {
    let nodes = told["frames"][frame.to_string()].as_object().expect("a frame").iter();
    let places = |list: &Value| serde_json::from_value::<Vec<DVec3>>(list.clone()).expect("points");
    nodes.map(|(name, list)| (name.clone(), places(list))).collect()
}

/// Greatest gap between Blender and a shot over frames.
fn gap_to_blender(shot: &Path, told: &Value, frames: &[i32]) -> f64 {
    let prepared = prepared(shot);
    frames.iter().map(|&frame| gap(&warped(&prepared, frame), &corners_in(told, frame))).fold(0.0, f64::max)
}

#[test]
fn blender_shows_the_exported_scene_where_we_do() {
    let bench = Bench::new();
    export_scene(&bench, "hare", "--to gltf --frames 1-24x4 -o hare.glb");
    // The importer counts frames from 0 and the shot from 1.
    let Some([told]) = in_blender([(bench.path("hare.glb"), &[1, 13], -1)]) else { return };
    let gap = gap_to_blender(&shot_of(&bench, "hare"), &told, &[1, 13]);
    assert!(gap < TOLERANCE, "{gap:e}");
}

#[test]
fn lattice_objects_of_the_world_move_vertices_like_ours_in_blender() {
    let bench = Bench::new();
    let said = export_scene(&bench, "hare", "--to blender --frames 1-24x4,20 -o hare.py");
    assert!(said.contains("layer 'hare': a lattice object of 5 x 5 x 5 points, exact"), "{said}");
    // The comparison can fail: another blend of the same points is somewhere else.
    let script = String::from_utf8(bench.read("hare.py")).expect("text").replace("KEY_BSPLINE", "KEY_CARDINAL");
    bench.write("other.py", script.as_bytes());
    let shown: [Shown; 2] = [(bench.path("hare.py"), &[1, 5, 20, 21], 0), (bench.path("other.py"), &[5, 20], 0)];
    let Some([told, other]) = in_blender(shown) else { return };
    assert_eq!((&told["modifiers"], &told["camera"]), (&Value::from(3), &Value::from("ShotCam")));
    let gap = gap_to_blender(&shot_of(&bench, "hare"), &told, &[1, 5, 20, 21]);
    assert!(gap < TOLERANCE, "{gap:e}");
    assert!(gap_to_blender(&shot_of(&bench, "hare"), &other, &[5, 20]) > 100.0 * TOLERANCE);
}

#[test]
fn cards_get_lattice_objects_and_what_has_depth_is_baked() {
    let cards = Tiny::of(vec![grid("Quad", [-0.4, -0.4, 0.4, 0.4], 6)]);
    let far = Tiny { lens: Lens::Perspective(0.25), camera_velocity: [0.5, 0.2, -0.7], ..cards.clone() };
    let plain = format!("{HEAD}{PIN}{HOLD}");
    let bernstein = plain.replace("dims = [4, 4]", "dims = [5, 4], basis = \"bernstein\"");
    let cells = bernstein.replace("bernstein", "bilinear");
    let early = plain.replace("first = 1, last = 2,", "first = -30, last = -29, clip_start = -30,");
    let early = early.replace("frame = 1,", "frame = -30,").replace("frame = 2,", "frame = -29,");
    let cases = [
        ("orthographic", cards.json(), plain.clone(), 1, "a lattice object of 4 x 4 x 1 points", 0),
        ("cells", cards.json(), cells, 1, "a lattice object of 5 x 4 x 1 points", 0),
        ("card", far.json(), plain.clone(), 1, "a lattice object of 4 x 4 x 1 points", 0),
        ("depth", sheet(), plain, 0, "baked shape keys, no lattice: in frame 1 its vertices", 0),
        ("bernstein", cards.json(), bernstein, 0, "do not support Bernstein polynomials", 0),
        ("early", cards.json(), early, 1, "48 later than the shot's", 48),
    ];
    let exported = cases.map(|(name, scene, shot, modifiers, says, later)| {
        let bench = Bench::with(&scene, &format!("{shot}{OUTPUT}"));
        let said = bench.run("export shot.toml --to blender").says(0, &[]).stdout;
        assert!(said.contains(says), "{name}: {said}");
        let script = String::from_utf8(bench.read("shot.blender.py")).expect("text");
        assert_eq!(script.contains("NO lattice but baked shape keys"), modifiers == 0, "{name}: the head tells");
        (name, bench, modifiers, if later == 0 { [1, 2] } else { [-30, -29] }, later)
    });
    let shown = exported
        .each_ref()
        .map(|(_, bench, _, frames, later)| -> Shown { (bench.path("shot.blender.py"), frames.as_slice(), *later) });
    let Some(told) = in_blender(shown) else { return };
    for ((name, bench, modifiers, frames, _), told) in exported.iter().zip(&told) {
        assert_eq!(told["modifiers"], *modifiers, "{name}");
        let gap = gap_to_blender(&bench.path("shot.toml"), told, frames);
        assert!(gap < TOLERANCE, "{name}: {gap:e}");
    }
}

#[test]
fn pictures_travel_as_textured_cards_with_their_lattices() {
    let bench = Bench::new();
    export_scene(&bench, "flag", "--to gltf --frames 1,7 -o flag.glb");
    let flag = load(&bench.path("flag.glb")).expect("our own loader reads it");
    let names: Vec<&str> = flag.nodes.iter().map(|node| node.name.as_str()).collect();
    assert_eq!(names, ["pole", "flag", "camera"]);
    assert_eq!((flag.images.len(), flag.images[1].width, flag.images[1].height), (2, 720, 480));
    let textures = flag.materials.iter().map(|material| material.base_color_texture.as_ref().map(|told| told.texture));
    assert_eq!(textures.collect::<Vec<_>>(), [Some(0), Some(1)]);
    assert!(flag.materials.iter().all(|material| material.unlit && material.alpha == AlphaMode::Blend));
    let said = export_scene(&bench, "cat", "--to blender --frames 1,8,16 -o cat.py");
    assert!(said.contains("layer 'cat': a lattice object of 10 x 10 x 1 points, exact"), "{said}");
    let Some([told]) = in_blender([(bench.path("cat.py"), &[1, 8, 16], 0)]) else { return };
    assert_eq!((&told["modifiers"], &told["camera"]), (&Value::from(1), &Value::from("camera")));
    let gap = gap_to_blender(&shot_of(&bench, "cat"), &told, &[1, 8, 16]);
    assert!(gap < TOLERANCE, "{gap:e}");
}

#[test]
fn impossible_exports_are_refused() {
    let bench = usual(&square().json());
    bench.run("export shot.toml --to lattice-json").says(0, &[]);
    for to in ["gltf", "blender"] {
        bench.run(&format!("export shot.lattice.json --to {to}")).says(2, &["holds lattices only", "give the shot"]);
        bench.run(&format!("export shot.toml --to {to}")).says(0, &[]);
        bench.run(&format!("export shot.toml --to {to}")).says(2, &["exists already", "--overwrite"]);
        bench.run(&format!("export shot.toml --to {to} --overwrite")).says(0, &[]);
    }
    let still = Bench::with(&square().json(), &format!("{HEAD}{OUTPUT}"));
    still.run("export shot.toml --to gltf").says(2, &["no layer of shot.toml is warped", "add pins"]);
    for flag in ["--layer front", "--inverse", "--size 64x36", "--overscan 8", "--resume"] {
        bench.run(&format!("export shot.toml --to gltf {flag} -o x.glb")).says(2, &["is for maps", "leave it out"]);
    }
    bench.run("export shot.toml --to after-effects --inverse").says(2, &["displacement maps cannot be inverted"]);
    bench.run("export shot.toml --to fbx").says(2, &["possible values", "blender"]);
}

/// The formats that `export` knows, from its own list.
fn formats(bench: &Bench) -> Vec<String> {
    let told = bench.run("export shot.toml --to nothing").says(2, &["possible values: "]).stderr;
    let list = told.split("possible values: ").nth(1).and_then(|rest| rest.split(']').next()).expect("a list");
    list.split(", ").map(str::to_owned).collect()
}

#[test]
fn every_export_tells_what_a_render_tells() {
    let rival = PIN.replace("\"corner\"", "\"rival\"").replace("[0.1, 0.05]", "[-0.1, 0.05]");
    let bench = Bench::with_shot(&format!("{HEAD}{PIN}{rival}{OUTPUT}"));
    let warnings = |text: &str| -> Vec<String> {
        text.lines().filter(|line| line.starts_with("warning: ")).map(str::to_owned).collect()
    };
    let rendered = warnings(&bench.render("--frames 2").says(0, &["'corner' and 'rival'", "7.20 px apart"]).stderr);
    let formats = formats(&bench);
    assert!(formats.len() >= 6 && formats.iter().any(|format| format == "gltf"), "{formats:?}");
    for format in formats {
        let run = |frames: &str| bench.run(&format!("export shot.toml --to {format} --frames {frames} --overwrite"));
        let told = warnings(&run("2").says(0, &[]).stderr);
        let missing: Vec<&String> = rendered.iter().filter(|warning| !told.contains(warning)).collect();
        assert!(missing.is_empty(), "{format} leaves out {missing:?}, tells {told:?}");
        assert!(!run("1").says(0, &[]).stderr.contains("rival"), "{format}: the pins agree in frame 1");
    }
}

#[test]
fn similar_warnings_of_an_export_share_a_line_and_rest_layers_are_silent() {
    let keys = "keys = [ { frame = 1, offset = [-0.1, 0.05] } ]";
    let rival = PIN.replace("\"corner\"", "\"rival\"");
    let rival = format!("{}{keys}\n", rival.split("keys").next().expect("a head"));
    let other = "\n[[layer]]\nname = \"other\"\nnodes = [\"Other\"]\nlattice = { dims = [4, 4] }\n\
                 [[layer.pin]]\nanchor = { node = \"Other\", triangle = 0, barycentric = [1.0, 0.0, 0.0] }\n\
                 keys = [{ frame = 1, offset = [0.1, 0] }]\n";
    let parts = vec![grid("Quad", [-0.4, -0.3, 0.0, 0.3], 2), grid("Other", [0.1, -0.3, 0.4, 0.3], 2)];
    let head = HEAD.replace("name = \"all\"", "name = \"all\"\nnodes = [\"Quad\"]");
    let bench = Bench::with(&Tiny::of(parts).json(), &format!("{head}{PIN}{rival}{other}{OUTPUT}"));
    bench
        .run("export shot.toml --to gltf")
        .says(0, &["warning: frames 1 to 2: layer 'all': pins 'corner' and 'rival'"]);
    let all = bench.run("export shot.toml --to lattice-json --layer all").says(0, &["'corner' and 'rival'"]);
    assert_eq!(all.stderr.matches("'corner' and 'rival'").count(), 1, "{}", all.stderr);
    let other = bench.run("export shot.toml --to lattice-json --layer other --overwrite").says(0, &[]);
    assert!(!other.stderr.contains("rival"), "{}", other.stderr);
}
