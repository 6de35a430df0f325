//! Jobs for render farms, and the report of what they made.

use crate::python;
use crate::support::{Bench, Ended, HEAD, OUTPUT, PIN, PROGRAM};
use serde_json::{Value, json};
use std::ffi::OsStr;
use std::path::Path;

/// Seven frames, some before zero.
fn shot() -> String {
    let head = HEAD.replace("first = 1, last = 2", "first = -2, last = 4");
    format!("{head}{PIN}{OUTPUT}")
}

fn bench() -> Bench {
    Bench::with_shot(&shot())
}

fn template(bench: &Bench, name: &str) -> Value {
    serde_json::from_slice(&bench.read(name)).expect("JSON")
}

/// Ended with that code, and these words are on standard output.
fn tells(ended: Ended, code: i32, words: &[&str]) -> Ended {
    assert_eq!(ended.code, Some(code), "{ended:?}");
    words.iter().for_each(|word| assert!(ended.stdout.contains(word), "{word:?} is not in:\n{}", ended.stdout));
    ended
}

/// All frames of a folder, by name.
fn bytes_in(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let names = crate::support::names_in(folder);
    names.into_iter().map(|name| (name.clone(), std::fs::read(folder.join(name)).expect("read"))).collect()
}

#[test]
fn frames_are_the_same_however_they_are_cut_into_chunks() {
    let whole = bench();
    whole.render("").says(0, &[]);
    let chunks = bench();
    for list in ["3-4", "-2-2:4,0", "1,-1"] {
        chunks.render(&format!("--frames {list} --resume")).says(0, &[]);
    }
    assert_eq!(bytes_in(&whole.path("out")), bytes_in(&chunks.path("out")));
    assert_eq!(whole.frames().len(), 7);
}

#[test]
fn a_template_has_frames_and_chunks_as_parameters() {
    let bench = bench();
    tells(bench.run("job shot.toml --chunk 3 -- --device cpu"), 0, &["7 frames in 3 tasks", "shot.openjd.json"]);
    let template = template(&bench, "shot.openjd.json");
    let defaults: Vec<&Value> =
        template["parameterDefinitions"].as_array().expect("a list").iter().map(|p| &p["default"]).collect();
    assert_eq!(defaults, [&json!("-2-4"), &json!(3), &json!("shot.toml"), &json!("out"), &json!("pinwarp")]);
    let names: Vec<&Value> = template["steps"].as_array().expect("a list").iter().map(|step| &step["name"]).collect();
    assert_eq!(names, ["Prepare", "Render", "Report"]);
    let arguments = &template["steps"][1]["script"]["actions"]["onRun"]["args"];
    assert_eq!(arguments.as_array().expect("a list").last(), Some(&json!("cpu")));
    // Written twice it is the same; over anything else only when asked.
    bench.run("job shot.toml --chunk 3 -- --device cpu").says(0, &[]);
    bench.run("job shot.toml --chunk 4").says(2, &["--overwrite"]);
    bench.run("job shot.toml -o shot.toml --overwrite").says(2, &["shot.toml"]);
}

#[test]
fn jobs_that_no_farm_could_run_are_refused() {
    let bench = bench();
    bench.run("job shot.toml --chunk 0").says(2, &["--chunk"]);
    bench.run("job shot.toml --to slurm --frames 1-2000 --chunk 1").says(2, &["2000 tasks", "--chunk 2"]);
    bench.run("job shot.toml --program {{it}}").says(2, &["two braces"]);
    bench.run("job nowhere.toml").says(2, &["nowhere.toml"]);
    bench.run("job shot.toml --warp in.####.exr warped.exr").says(2, &["warped.####.exr"]);
    let plates = Bench::with_shot(
        "version = 1\nplate = \"in.####.exr\"\nframes = { first = 1, last = 2, rate = 24 }\nsize = [64, 36]\n[[layer]]\n",
    );
    plates.run("job shot.toml").says(2, &["--warp beauty.####.exr warped.####.exr"]);
}

const OPENJD: &str = r#"
import subprocess, sys
folder, program = sys.argv[1:3]
def openjd(*words):
    done = subprocess.run([sys.executable, "-m", "openjd", *words], cwd=folder, capture_output=True, text=True)
    print(done.stdout[-4000:], done.stderr[-2000:])
    return done.returncode
assert openjd("check", "shot.openjd.json") == 0
assert openjd("run", "shot.openjd.json", "--step", "Report", "--run-dependencies", "-p", "Program=" + program) == 0
# Some frames again, in chunks of another size.
assert openjd("run", "shot.openjd.json", "--step", "Render", "-p", "Program=" + program, "-p", "Frames=-2-4:3", "-p", "ChunkSize=2") == 0
"#;

#[test]
fn openjd_runs_the_template_to_the_bytes_of_a_single_run() {
    let single = bench();
    single.render("").says(0, &[]);
    let farm = bench();
    farm.run("job shot.toml --chunk 3 -- --device cpu").says(0, &[]);
    let arguments = [farm.path("").into_os_string(), PROGRAM.into()];
    let arguments: Vec<&OsStr> = arguments.iter().map(AsRef::as_ref).collect();
    let Some(said) = python::run(&["openjd.cli"], OPENJD, &arguments) else { return };
    assert!(said.contains("openjd_progress: 100.0") && said.contains("7 complete frames"), "{said}");
    assert!(said.contains("2 kept"), "{said}");
    assert_eq!(bytes_in(&single.path("out")), bytes_in(&farm.path("out")));
}

/// Takes the place of `sbatch`.
const SBATCH: &str = include_str!("../support/sbatch.sh");

#[cfg(unix)]
#[test]
fn slurm_s_script_submits_three_jobs_that_make_all_frames() {
    use std::os::unix::fs::PermissionsExt;
    let single = bench();
    single.render("").says(0, &[]);
    let farm = bench();
    farm.write("sbatch", SBATCH.as_bytes());
    std::fs::set_permissions(farm.path("sbatch"), PermissionsExt::from_mode(0o755)).expect("allowed");
    farm.run(&format!("job shot.toml --to slurm --chunk 3 --program {PROGRAM} -- --device cpu")).says(0, &[]);
    let path = format!("{}:{}", farm.path("").display(), std::env::var("PATH").unwrap_or_default());
    let output = farm
        .command("bash")
        .args(["shot.slurm.sh", "--partition=render"])
        .env("PATH", path)
        .output()
        .expect("bash starts");
    let log = || String::from_utf8_lossy(&std::fs::read(farm.path("log.txt")).unwrap_or_default()).into_owned();
    let ended: Ended = farm.checked(output);
    assert_eq!(ended.code, Some(0), "{ended:?} {}", log());
    let submitted = String::from_utf8(farm.read("submitted.txt")).expect("text");
    let lines: Vec<&str> = submitted.lines().collect();
    assert_eq!(lines.len(), 3, "{submitted}");
    assert!(lines.iter().all(|line| line.contains("--partition=render")), "{submitted}");
    assert!(lines[1].contains("--dependency=afterok:1 --array=0-2"), "{submitted}");
    assert!(lines[2].contains("--dependency=afterany:2"), "{submitted}");
    assert!(log().contains("7 complete frames"), "{}", log());
    assert_eq!(bytes_in(&single.path("out")), bytes_in(&farm.path("out")));
}

#[test]
fn plates_are_warped_by_jobs_too() {
    let bench = Bench::new();
    bench.render("-o in/b.####.exr").says(0, &[]);
    tells(bench.run("job shot.toml --warp in/b.####.exr warped/b.####.exr"), 0, &["2 frames in 1 task"]);
    let steps = template(&bench, "shot.openjd.json")["steps"].clone();
    let words = |step: usize| steps[step]["script"]["actions"]["onRun"]["args"].to_string().replace(r"\\", "/");
    assert!(words(1).starts_with(r#"["warp","#) && words(1).contains("in/b.####.exr"), "{}", words(1));
    assert!(words(2).contains("warped/b.####.exr"), "{}", words(2));
    bench.run("warp in/b.####.exr --shot shot.toml -o warped/b.####.exr --device cpu --openjd").says(0, &[]);
    tells(bench.run("report warped"), 0, &["2 complete frames"]);
}

#[test]
fn a_report_tells_what_is_missing_damaged_mixed_or_over_limits() {
    let bench = bench();
    bench.render("--preview").says(0, &[]);
    let good =
        tells(bench.run("report shot.toml --verify"), 0, &["7 complete frames", "layer 'all': pins off by at most"]);
    assert!(!good.stdout.contains("error"), "{}", good.stdout);
    tells(bench.run("report out --max-pin-error 0.5 --max-folds 0 --max-warnings 0"), 0, &[]);
    // Half of the model's corner moved: a limit below what was measured fails.
    tells(bench.run("report out --max-jerk 0"), 1, &["jerk of the warp, in pixels, is", "at most 0 is allowed"]);

    let changed = |name: &str, change: &dyn Fn(&mut Vec<u8>)| {
        let mut bytes = bench.read(name);
        change(&mut bytes);
        bench.write(name, &bytes);
    };
    std::fs::remove_file(bench.path("out/f.0001.exr")).expect("removed");
    changed("out/f.0002.exr", &|bytes| bytes.truncate(bytes.len() / 2));
    changed("out/f.0003.exr", &|bytes| *bytes.last_mut().expect("bytes") ^= 1);
    let report = |arguments: &[&str]| {
        let output = bench.command(PROGRAM).arg("report").args(arguments).output().expect("the program starts");
        let text = |bytes| String::from_utf8(bytes).expect("text");
        Ended { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
    };
    let told = report(&["out/f.####.exr", "--sheet", "sheet.png"]);
    let told = tells(told, 1, &["1 frame is missing: 1", "frame 2: the file is cut off"]);
    assert!(!told.stdout.contains("frame 3:"), "{}", told.stdout);
    tells(report(&["out", "--verify"]), 1, &["frame 3: its pixels do not match their checksum"]);
    let sheet = image::open(bench.path("sheet.png")).expect("a picture");
    assert_eq!(sheet.width(), 8 + 3 * 328, "three columns of seven tiles");
    report(&["out", "--sheet", "sheet.png"]).says(2, &["--overwrite"]);

    let other = shot().replace("[0.1, 0.05]", "[0.1, 0.06]");
    bench.write("shot.toml", other.as_bytes());
    bench.render("--frames 1-3 --overwrite").says(0, &[]);
    tells(bench.run("report shot.toml"), 1, &["different states of the shot"]);
    let line = tells(bench.run("report shot.toml --json"), 1, &[]).stdout;
    let line: Value = serde_json::from_str(&line).expect("one line of JSON");
    assert_eq!(line["report"]["frames"], 7);
    assert_eq!(line["report"]["states"].as_object().map(serde_json::Map::len), Some(2));
    bench.run("report nowhere").says(2, &["nowhere"]);
}
