//! Disks that are full or read-only, and folders that cannot be made.

use crate::support::{Bench, Ended, HEAD, OUTPUT, PIN, PROGRAM, private_mounts};

/// Six frames without compression, about 110 kB each when the square fills them.
fn thick_shot() -> String {
    let head = HEAD.replace("last = 2", "last = 6");
    format!("{head}{PIN}{OUTPUT}compression = \"none\"\n")
}

/// Renders with `out/` on a disk mounted with `options`, then copies what the disk holds to `kept/`. `None`: no mounts.
fn render_on_disk(bench: &Bench, options: &str) -> Option<Ended> {
    let prefix = private_mounts()?;
    std::fs::create_dir_all(bench.path("out")).expect("a folder");
    let script = "mount -t tmpfs -o \"$1\" tmpfs out || exit 77
        \"$2\" render shot.toml --device cpu
        code=$?
        cp -a out kept
        exit $code";
    let mut command = bench.command(prefix[0]);
    command.args(&prefix[1..]).args(["sh", "-c", script, "sh", options, PROGRAM]);
    let ended = bench.checked(command.output().expect("a shell"));
    assert_ne!(ended.code, Some(77), "the disk was not mounted: {ended:?}");
    Some(ended)
}

fn kept(bench: &Bench) -> Vec<String> {
    crate::support::names_in(&bench.path("kept"))
}

#[test]
fn full_disk() {
    let bench = Bench::with_shot(&thick_shot());
    let Some(ended) = render_on_disk(&bench, "size=256k") else { return };
    let ended = ended.says(1, &["error: frame 6", "out/f.0006.exr", "o space left", "free some space", "FAILED"]);
    let done = ended.stderr.lines().filter(|line| line.starts_with("frame ")).count();
    assert!((1..6).contains(&done), "{}", ended.stderr);
    // `checked` saw to it that each of them is whole.
    assert_eq!(kept(&bench).len(), done, "{:?}", kept(&bench));
}

#[test]
fn a_disk_with_room() {
    let bench = Bench::with_shot(&thick_shot());
    let Some(ended) = render_on_disk(&bench, "size=4m") else { return };
    ended.says(0, &[]);
    assert_eq!(kept(&bench).len(), 6);
}

#[test]
fn read_only_folder() {
    let bench = Bench::new();
    let Some(ended) = render_on_disk(&bench, "ro") else { return };
    ended.says(2, &["out", "ead-only", "give another output path"]);
    assert!(kept(&bench).is_empty());
}

#[test]
fn a_file_where_a_folder_should_be() {
    let bench = Bench::new();
    bench.write("out", b"not a folder");
    bench.render("").says(2, &["out", "give another output path"]);
    assert_eq!(bench.read("out"), b"not a folder");
}

#[test]
fn a_folder_where_a_frame_should_be() {
    let bench = Bench::new();
    std::fs::create_dir_all(bench.path("out/f.0001.exr/inside")).expect("a folder");
    bench.render("").says(2, &["1 of the frames exists already", "f.0001.exr", "--resume", "--overwrite"]);
    let ended = bench.render("--overwrite").says(1, &["error: frame 1", "f.0001.exr", "folder of that name"]);
    assert!(ended.stderr.contains("frame 2 ->"), "{}", ended.stderr);
    assert_eq!(bench.frames(), ["f.0001.exr", "f.0002.exr"]);
}

#[test]
fn a_folder_that_cannot_be_made() {
    let bench = Bench::new();
    bench.render("-o /proc/pinwarp/f.####.exr").says(2, &["/proc/pinwarp", "give another output path"]);
}
