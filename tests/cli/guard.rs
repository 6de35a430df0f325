//! Nothing that is read, that is there already or that is no regular file is written over, by any command.

use crate::support::{Bench, HEAD, OUTPUT, PIN, square};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::path::Path;

const READ: &[&str] = &["is an input of this job and would be overwritten", "-o"];
const THERE: &[&str] = &["--overwrite"];
const SPECIAL: &[&str] = &["is a device, pipe or socket, not a regular file"];

/// The square with its buffer in a file, a shot over a plate sequence, and a file of every kind that a command reads.
fn bench() -> Bench {
    let mut scene = square().json();
    let uri = scene["buffers"][0]["uri"].as_str().expect("a data URI").to_owned();
    scene["buffers"][0]["uri"] = "quad.bin".into();
    let bench = Bench::with(&scene, &format!("plate = \"in/b.####.exr\"\n{HEAD}{PIN}{OUTPUT}"));
    bench.write("quad.bin", &STANDARD.decode(uri.rsplit(',').next().expect("data")).expect("base64"));
    bench.render("").says(0, &[]);
    std::fs::create_dir_all(bench.path("in")).expect("a folder");
    for frame in [1, 2] {
        std::fs::copy(bench.path(&format!("out/f.000{frame}.exr")), bench.path(&format!("in/b.000{frame}.exr")))
            .expect("copied");
    }
    std::fs::copy(bench.path("in/b.0001.exr"), bench.path("in/c.0001.exr")).expect("copied");
    std::fs::remove_dir_all(bench.path("out")).expect("removed");
    bench.run("export shot.toml --to stmap -o in/m.####.exr").says(0, &[]);
    bench.run("export shot.toml --to lattice-json -o l.json").says(0, &[]);
    let picture = image::RgbaImage::from_fn(64, 36, |x, y| {
        image::Rgba(if (20..44).contains(&x) && (6..30).contains(&y) { [200, 100, 50, 255] } else { [0; 4] })
    });
    picture.save(bench.path("cat.png")).expect("saved");
    bench.write("q.json", PROBLEM.as_bytes());
    let pairs = r#"{"pairs": [{"a": [0.5, 0.5], "b": [0.6, 0.5]}], "unit": "frame"}"#;
    bench.write("pairs.json", pairs.as_bytes());
    bench.write("marks.json", b"[[[0.5,0.5],[0.6,0.5]]]");
    bench
}

const PROBLEM: &str = r#"{
  "dims": [6, 6], "vertices": [[0, 0], [1, 0], [1, 1], [0, 1]], "triangles": [[0, 1, 2], [0, 2, 3]],
  "pins": [{ "vertex": 0, "target": [0.5, 0.25] }]
}"#;

/// Every command that writes, with `OUT` where its output goes, and the inputs that it has.
const COMMANDS: &[(&str, &[&str])] = &[
    ("new cat.png -o OUT", &["cat.png"]),
    ("new tiny.gltf -o OUT", &["tiny.gltf", "quad.bin"]),
    ("solve q.json -o OUT", &["q.json"]),
    ("compare q.json -o OUT", &["q.json"]),
    ("compare shot.toml --frame 2 --methods default -o OUT", &["shot.toml", "tiny.gltf", "quad.bin"]),
    ("fit cat.png cat.png --pairs pairs.json -o OUT", &["cat.png", "pairs.json"]),
    ("fit shot.toml cat.png --pairs pairs.json -o OUT", &["shot.toml", "tiny.gltf", "quad.bin", "cat.png"]),
    ("resize l.json --dims 6,6 -o OUT", &["l.json"]),
    ("transfer --lattice l.json --onto cat.png --frames 1 -o new.exr --shot OUT", &["l.json", "cat.png"]),
    (
        "transfer --lattice l.json --onto tiny.gltf --landmarks marks.json --frames 1 -o new.exr --shot OUT",
        &["l.json", "tiny.gltf", "quad.bin", "marks.json"],
    ),
    ("export shot.toml --to lattice-json -o OUT", &["shot.toml", "tiny.gltf", "quad.bin", "in/b.0001.exr"]),
    ("export l.json --to lattice-json -o OUT", &["l.json"]),
    ("export shot.toml --to gltf -o OUT", &["shot.toml", "tiny.gltf", "quad.bin"]),
    ("export shot.toml --to blender -o OUT", &["shot.toml", "tiny.gltf", "quad.bin"]),
    ("export shot.toml --to nuke -o OUT", &["shot.toml", "tiny.gltf", "quad.bin"]),
    ("export shot.toml --to stmap --frames 1 -o OUT", &["shot.toml", "in/b.0001.exr"]),
    ("render shot.toml --device cpu --frames 1 -o OUT.exr", &["in/b.0001"]),
    ("warp --shot shot.toml --frames 1 -o OUT.exr", &["in/b.0001", "in/b.0002"]),
    ("warp in/b.####.exr --shot shot.toml --clean in/c.####.exr --frames 1 -o OUT.exr", &["in/c.0001", "in/b.0001"]),
    ("warp in/b.####.exr --lattice l.json --frames 1 -o OUT.exr", &["in/b.0001"]),
    ("warp in/b.####.exr --stmap in/m.####.exr --frames 1 -o OUT.exr", &["in/m.0001", "in/b.0001"]),
];

/// Commands that write frames, whose files end in .exr, with what they read that is no frame.
const FRAMES_FROM: &[(&str, &[&str])] = &[
    ("render shot.toml --device cpu --frames 1 -o OUT", &["shot.toml", "tiny.gltf", "quad.bin"]),
    ("warp --shot shot.toml --frames 1 -o OUT", &["shot.toml", "tiny.gltf", "quad.bin"]),
    ("warp in/b.####.exr --lattice l.json --frames 1 -o OUT", &["l.json"]),
    ("export shot.toml --to stmap --frames 1 -o OUT", &["shot.toml", "tiny.gltf", "quad.bin"]),
    ("export l.json --to stmap --frames 1 -o OUT", &["l.json"]),
    ("transfer --lattice l.json --onto cat.png --frames 1 -o OUT", &["l.json", "cat.png"]),
    (
        "transfer --lattice l.json --onto cat.png --landmarks marks.json --frames 1 -o OUT",
        &["l.json", "cat.png", "marks.json"],
    ),
    ("transfer --lattice l.json --onto shot.toml --frames 1 -o OUT", &["l.json", "shot.toml", "tiny.gltf", "quad.bin"]),
];

fn with(command: &str, out: &str) -> String {
    command.replace("OUT", out)
}

/// The file that a command names as its output.
fn file_of(command: &str, out: &str) -> String {
    if command.contains("OUT.exr") { format!("{out}.exr") } else { out.to_owned() }
}

/// Makes a symbolic link; returns false on systems where that needs privileges.
fn soft_link(target: impl AsRef<Path>, link: std::path::PathBuf) -> bool {
    #[cfg(unix)]
    std::os::unix::fs::symlink(target, link).expect("linked");
    #[cfg(not(unix))]
    let _ = (target, link);
    cfg!(unix)
}

#[test]
fn no_command_writes_over_what_it_reads() {
    let bench = bench();
    for (command, inputs) in COMMANDS {
        for input in *inputs {
            let file = file_of(command, input);
            let before = bench.read(&file);
            let ending = if command.contains("OUT.exr") { ".exr" } else { "" };
            std::fs::hard_link(bench.path(&file), bench.path(&format!("hard{ending}"))).expect("linked");
            let has_soft = soft_link(bench.path(&file), bench.path(&format!("soft{ending}")));
            let direct = format!("./in/../{input}");
            // Systems other than Unix do not tell what a hard link is a link to; writing replaces the link, not the input.
            let links = ["hard", "soft"].into_iter().filter(|_| has_soft);
            let names = [*input, direct.as_str()].into_iter().chain(links);
            for name in names {
                bench.run(&format!("{} --overwrite", with(command, name))).says(2, READ);
                assert_eq!(bench.read(&file), before, "{command} with {name}");
            }
            for link in ["hard", "soft"].iter().take(1 + usize::from(has_soft)) {
                std::fs::remove_file(bench.path(&format!("{link}{ending}"))).expect("removed");
            }
        }
    }
}

#[test]
fn no_frame_is_written_over_what_it_is_made_from_under_another_name() {
    let bench = bench();
    for (command, inputs) in FRAMES_FROM {
        for input in *inputs {
            let before = bench.read(input);
            // Elsewhere, since every picture in the folder of the bench has to be whole.
            let folder = tempfile::tempdir().expect("a folder");
            let path = |name: &str| folder.path().join(name);
            std::fs::hard_link(bench.path(input), path("hard.0001.exr")).expect("linked");
            let soft = soft_link(bench.path(input), path("soft.0001.exr")).then_some("soft.####.exr");
            let hard = ["hard.####.exr", "hard.0001.exr"].into_iter().filter(|_| cfg!(unix));
            for name in hard.chain(soft) {
                let output = path(name).display().to_string();
                bench.run(&format!("{} --overwrite", with(command, &output))).says(2, READ);
                assert_eq!(bench.read(input), before, "{command} with {name} for {input}");
            }
        }
    }
}

#[test]
fn no_command_replaces_what_is_there_without_being_asked() {
    let bench = bench();
    for (command, _) in COMMANDS {
        let file = file_of(command, "there");
        let mine = if file.ends_with(".exr") { bench.read("in/b.0002.exr") } else { b"mine".to_vec() };
        bench.write(&file, &mine);
        bench.run(&with(command, "there")).says(2, THERE);
        assert_eq!(bench.read(&file), mine, "{command}");
        bench.run(&format!("{} --overwrite", with(command, "there"))).says(0, &[]);
        assert_ne!(bench.read(&file), mine, "{command}");
        // A link to nowhere is there, too.
        std::fs::remove_file(bench.path(&file)).expect("removed");
        if soft_link("nowhere", bench.path(&file)) {
            bench.run(&with(command, "there")).says(2, THERE);
            std::fs::remove_file(bench.path(&file)).expect("removed");
        }
        for leftover in ["new.exr", "there.glb", "there.stmap.0001.exr", "there.stmap.0002.exr"] {
            let _ = std::fs::remove_file(bench.path(leftover));
        }
    }
}

#[cfg(unix)]
#[test]
fn no_command_writes_to_what_is_no_regular_file() {
    let bench = bench();
    for (command, _) in COMMANDS {
        let file = file_of(command, "pipe");
        let made = std::process::Command::new("mkfifo").arg(bench.path(&file)).status();
        assert!(made.is_ok_and(|status| status.success()), "mkfifo works");
        for flag in ["", "--overwrite"] {
            // A run that opens the pipe never ends: the bench stops it.
            bench.run(&format!("{} {flag}", with(command, "pipe"))).says(2, SPECIAL);
        }
        std::fs::remove_file(bench.path(&file)).expect("still there");
        assert!(soft_link("/dev/null", bench.path(&file)));
        bench.run(&format!("{} --overwrite", with(command, "pipe"))).says(2, SPECIAL);
        assert_eq!(std::fs::read_link(bench.path(&file)).expect("a link"), Path::new("/dev/null"), "{command}");
        std::fs::remove_file(bench.path(&file)).expect("still there");
    }
    bench.run("solve q.json -o /dev/stdout").says(2, SPECIAL);
}

#[test]
fn previews_notes_and_files_beside_the_output_are_guarded_too() {
    let bench = bench();
    std::fs::copy(bench.path("cat.png"), bench.path("mine.png")).expect("copied");
    let before = bench.read("mine.png");
    for flag in ["--preview", "--overlay"] {
        bench.render(&format!("--frames 1 -o mine.exr {flag}")).says(2, &["mine.png", "--overwrite"]);
    }
    assert_eq!(bench.read("mine.png"), before);
    bench.run("transfer --lattice l.json --onto cat.png --frames 1 -o cat.exr --preview --overwrite").says(2, READ);
    bench.run("export shot.toml --to blender -o both.glb").says(2, &["both.glb", ".py"]);
    bench.write("b.glb", b"mine");
    bench.run("export shot.toml --to blender -o b.py").says(2, &["b.glb", "--overwrite"]);
    // A frame that the plate's pattern names is the plate's, whether it is there or not.
    for output in ["in/b.####.exr", "in/b.%04d.exr"] {
        bench.render(&format!("--frames 7 -o {output} --overwrite")).says(2, READ);
    }
    bench.render("--frames 7 -o in/b.0007.exr --overwrite").says(2, READ);
    bench.run("man -o manual").says(0, &[]);
    bench.run("man -o manual").says(2, &["pinwarp.1", "--overwrite"]);
}

#[cfg(unix)]
#[test]
fn inputs_that_are_no_regular_files_are_refused_at_once() {
    let bench = bench();
    let made = std::process::Command::new("mkfifo").arg(bench.path("pipe")).status();
    assert!(made.is_ok_and(|status| status.success()), "mkfifo works");
    for name in ["pipe.toml", "pipe.json", "pipe.csv", "pipe.png", "pipe.exr"] {
        std::fs::hard_link(bench.path("pipe"), bench.path(name)).expect("linked");
    }
    for command in [
        "check pipe.toml",
        "render pipe.toml",
        "solve pipe.json",
        "compare pipe.json",
        "export pipe.json --to lattice-json -o x.json",
        "resize pipe.json --dims 6,6 -o x.json",
        "warp in/b.####.exr --lattice pipe.json -o x.####.exr",
        "fit cat.png cat.png --pairs pipe.json -o x.json",
        "fit cat.png cat.png --pairs pipe.csv -o x.json",
        "transfer --lattice l.json --onto tiny.gltf --landmarks pipe.json -o x.exr",
        "new pipe.png -o x.toml",
        "new pipe.exr -o x.toml",
        "warp pipe.png --lattice l.json --frames 1 -o x.png",
        "warp pipe.exr --lattice l.json --frames 1 -o x.exr",
    ] {
        bench.run(command).says(2, &["pipe", "regular file"]);
    }
    bench.write("shot.toml", &vec![b'#'; 70 << 20]);
    bench.run("check shot.toml").says(2, &["shot.toml", "MB"]);
}
