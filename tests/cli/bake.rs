//! `pinwarp bake`: trajectories solved ahead, kept beside the frames, the same as those solved on the spot.

use crate::support::{Bench, HEAD, OUTPUT, PIN, PROGRAM, names_in, with_slashes};
use crate::tiny::{Tiny, grid};
use std::path::PathBuf;
use std::process::{Command, Stdio};

const FOLDER: &str = "out/.pinwarp-trajectories";

/// A shot of nine frames whose layer is solved over time.
fn timed() -> String {
    let head =
        HEAD.replace("last = 2", "last = 9").replace("name = \"all\"", "name = \"all\"\nsolve = { temporal = 0.3 }");
    format!("{head}{PIN}{OUTPUT}")
}

fn trajectories(bench: &Bench) -> Vec<PathBuf> {
    let folder = bench.path(FOLDER);
    names_in(&folder).into_iter().map(|name| folder.join(name)).collect()
}

/// The bytes of all frames.
fn pictures(bench: &Bench) -> Vec<Vec<u8>> {
    let frames = bench.frames().into_iter().filter(|name| name.ends_with(".exr"));
    frames.map(|name| bench.read(&format!("out/{name}"))).collect()
}

#[test]
fn a_bake_is_found_by_renders_and_changes_no_byte() {
    let bench = Bench::with_shot(&timed());
    let ended = bench
        .run("bake shot.toml")
        .says(0, &["1 layer over frames 1 to 9", "layer 'all' solved at 9 times", "1 layer solved in"]);
    assert!(ended.stdout.is_empty(), "{}", ended.stdout);
    let [file] = &trajectories(&bench)[..] else { panic!("one file: {:?}", trajectories(&bench)) };
    let baked = std::fs::read(file).expect("it is there");
    bench.run("bake shot.toml").says(0, &["layer 'all' kept", "0 layers solved", "1 kept"]);
    bench.run("-v render shot.toml --device cpu").says(0, &["9 frames", "0 solved, 1 read"]);
    let with = pictures(&bench);
    assert_eq!(with.len(), 9);

    // Solved on the spot, in two runs, backwards.
    let other = Bench::with_shot(&timed());
    other.run("-v render shot.toml --device cpu --frames 7,5,9,8,6").says(0, &["1 solved, 0 read"]);
    std::fs::remove_dir_all(other.path(FOLDER)).expect("it was kept");
    other.render("--frames 4,1,3,2").says(0, &["4 frames"]);
    assert_eq!(pictures(&other), with);
    let again = std::fs::read(&trajectories(&other)[0]).expect("kept again");
    assert_eq!(again, baked, "another folder, another run: the same bytes");
    assert_eq!(trajectories(&other)[0].file_name(), file.file_name());
}

#[test]
fn exports_and_warps_read_what_a_render_has_solved() {
    let bench = Bench::with_shot(&timed());
    bench.run("-v render shot.toml --device cpu").says(0, &["1 solved, 0 read"]);
    let solved: Vec<_> = trajectories(&bench).iter().map(|file| std::fs::read(file).expect("it is there")).collect();
    let targets = [
        "stmap -o m/m.####.exr",
        "nuke -o n/s.nk",
        "after-effects -o a/s",
        "lattice-json -o l.json",
        "gltf -o g/s.glb",
    ];
    for target in targets.into_iter().chain(["blender -o b/s.py"]) {
        bench.run(&format!("-v export shot.toml --to {target}")).says(0, &["0 solved, 1 read"]);
    }
    bench.run("-v warp out/f.####.exr --shot shot.toml -o w/w.####.exr").says(0, &["0 solved, 1 read"]);
    // An export that comes first keeps what it solves, for renders too: the same bytes under the same name.
    let other = Bench::with_shot(&timed());
    other.run("-v export shot.toml --to stmap").says(0, &["1 solved, 0 read"]);
    let kept: Vec<_> = trajectories(&other).iter().map(|file| std::fs::read(file).expect("it is there")).collect();
    assert_eq!((kept.len(), &kept), (1, &solved));
    other.run("-v render shot.toml --device cpu").says(0, &["0 solved, 1 read"]);
    assert_eq!(pictures(&other), pictures(&bench));
}

#[test]
fn a_damaged_file_is_noticed_and_made_again() {
    let bench = Bench::with_shot(&timed());
    bench.run("bake shot.toml").says(0, &[]);
    let file = &trajectories(&bench)[0];
    let whole = std::fs::read(file).expect("it is there");
    let mut flipped = whole.clone();
    flipped[whole.len() / 2] ^= 1;
    for damaged in [&whole[..whole.len() / 2], &flipped, b""] {
        std::fs::write(file, damaged).expect("it can be written");
        bench.run("bake shot.toml").says(0, &["is damaged", "1 layer solved"]);
        assert_eq!(std::fs::read(file).expect("it is there"), whole);
    }
}

#[test]
fn two_writers_and_any_number_of_threads_write_the_same() {
    let bench = Bench::with_shot(&timed());
    let start = |threads: &str| {
        let mut command = Command::new(PROGRAM);
        command.current_dir(bench.path("")).args(["bake", "shot.toml"]).env("RAYON_NUM_THREADS", threads);
        command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the program starts")
    };
    let mut written = Vec::new();
    for _ in 0..3 {
        let runs = ["1", "3", "2"].map(start);
        for mut run in runs {
            assert!(run.wait().expect("an end").success());
        }
        let [file] = &trajectories(&bench)[..] else { panic!("one file: {:?}", trajectories(&bench)) };
        written.push(std::fs::read(file).expect("it is there"));
        std::fs::remove_file(file).expect("removed");
    }
    assert!(written.windows(2).all(|pair| pair[0] == pair[1]));
}

#[test]
fn a_changed_shape_is_solved_again_and_a_trim_is_not() {
    let ranged = timed().replace("samples = 1", "samples = 1\nsolve_range = [1, 9]");
    let bench = Bench::with_shot(&ranged);
    bench.run("bake shot.toml").says(0, &["1 layer solved"]);
    for (from, to, says) in [
        ("last = 9", "last = 5", "1 kept"),
        ("samples = 1", "samples = 4", "1 kept"),
        ("offset = [0.1, 0.05]", "offset = [0.1, 0.06]", "1 layer solved"),
        ("temporal = 0.3", "temporal = 0.4", "1 layer solved"),
        ("solve_range = [1, 9]", "solve_range = [1, 8]", "1 layer solved"),
    ] {
        assert!(ranged.contains(from), "{from}");
        bench.write("shot.toml", ranged.replace(from, to).as_bytes());
        bench.run("bake shot.toml").says(0, &[says]);
    }
    bench.write("shot.toml", ranged.as_bytes());
    let scene = String::from_utf8(bench.read("tiny.gltf")).expect("JSON");
    bench.write("tiny.gltf", scene.replace("\"Quad\"", "\"Quad\" ").as_bytes());
    bench.run("bake shot.toml").says(0, &["1 layer solved"]);
}

/// Bakes a shot into an empty folder, and returns the names and bytes of its trajectories.
fn baked(bench: &Bench, text: &str) -> Vec<(PathBuf, Vec<u8>)> {
    _ = std::fs::remove_dir_all(bench.path(FOLDER));
    bench.write("shot.toml", text.as_bytes());
    bench.run("bake shot.toml").says(0, &["1 layer solved"]);
    trajectories(bench).into_iter().map(|file| (file.clone(), std::fs::read(&file).expect("it is there"))).collect()
}

#[test]
fn trimming_the_head_and_another_shutter_name_and_solve_the_same_trajectory() {
    const RESTING: &str = "\n[[layer.pin]]\nanchor = { node = \"Quad\", triangle = 1, barycentric = [0.0, 1.0, 0.0] }\n\
                           [[layer.handle]]\nindex = [1, 1]\n";
    let ranged = timed()
        .replace("samples = 1", "samples = 1\ncamera = { yaw = 10 }\nshutter = { angle = 0 }\nsolve_range = [1, 9]")
        .replace(OUTPUT, &format!("{RESTING}{OUTPUT}"));
    let on_twos = ranged.replace("name = \"all\"", "name = \"all\"\nstep = 2");
    let bench = Bench::new();
    let (whole, twos) = (baked(&bench, &ranged), baked(&bench, &on_twos));
    for (text, whole, from, to, is_same) in [
        (&ranged, &whole, "first = 1,", "first = 4,", true),
        (&ranged, &whole, "{ angle = 0", "{ angle = 180, phase = 0", true),
        (&ranged, &whole, "solve_range = [1, 9]", "solve_range = [2, 9]", false),
        (&ranged, &whole, "yaw = 10", "yaw = 11", false),
        (&on_twos, &twos, "first = 1,", "first = 5,", true),
        (&on_twos, &twos, "first = 1,", "first = 4,", false),
        (&on_twos, &twos, "{ angle = 0", "{ angle = 180", true),
        (&on_twos, &twos, "{ angle = 0", "{ angle = 180, phase = 0", false),
    ] {
        assert!(text.contains(from), "{from}");
        let found = baked(&bench, &text.replace(from, to));
        // Files begin with their digest, so equal bytes also mean equal names.
        assert_eq!(found == *whole, is_same, "{to}: {:?} instead of {:?}", found[0].0, whole[0].0);
    }
}

#[test]
fn a_clip_starts_where_the_shot_says_and_counts_only_where_it_moves_something() {
    let ranged = timed().replace("samples = 1", "samples = 1\nsolve_range = [1, 9]");
    let clip = |start: i32| ranged.replace("rate = 24", &format!("rate = 24, clip_start = {start}"));
    let still = Bench::new();
    assert_eq!(baked(&still, &clip(1)), baked(&still, &clip(3)));
    let mut part = grid("Quad", [-0.4, -0.3, 0.4, 0.3], 2);
    part.velocity = [0.5, 0.0, 0.0];
    let moving = Bench::with_scene(&Tiny::of(vec![part]).json());
    let [early, late] = [1, 3].map(|start| baked(&moving, &clip(start)));
    assert_ne!(early[0].0, late[0].0);
}

#[test]
fn events_in_json_and_shots_without_time() {
    let bench = Bench::with_shot(&timed());
    let events = bench.run("bake shot.toml --json -o elsewhere/f.####.exr").says(0, &[]).events();
    let kinds: Vec<&str> = events.iter().filter_map(|event| event["event"].as_str()).collect();
    assert!(
        kinds.contains(&"started") && kinds.contains(&"progress") && kinds.last() == Some(&"finished"),
        "{kinds:?}"
    );
    let done = events.iter().find(|event| event["event"] == "layer_done").expect("a layer is done");
    let path = &*with_slashes(done["path"].as_str().expect("a path"));
    assert!(path.starts_with("elsewhere/.pinwarp-trajectories") && bench.path(path).is_file(), "{path}");
    assert_eq!((done["knots"].as_u64(), done["is_kept"].as_bool()), (Some(9), Some(false)));
    assert_eq!(events[events.len() - 1]["solved"], 1);

    let alone = Bench::with_shot(&timed().replace("temporal = 0.3", "temporal = 0"));
    alone.run("bake shot.toml").says(0, &["nothing to bake"]);
    assert!(trajectories(&alone).is_empty());
    alone.run("bake none.toml").says(2, &["none.toml"]);
}

#[test]
fn a_trajectory_that_cannot_be_written_names_its_file_and_the_reason() {
    let bench = Bench::with_shot(&timed());
    std::fs::create_dir_all(bench.path("out")).expect("a folder");
    bench.write(FOLDER, b"no folder");
    let ended = bench.run("bake shot.toml").says(1, &["its trajectory could not be written"]);
    let error = ended.stderr.lines().find(|line| line.starts_with("error: layer 'all'"));
    assert!(error.is_some_and(|line| line.contains("cannot write") && line.contains(FOLDER)), "{}", ended.stderr);
}
