//! Runs that end early: interrupts and readers that hang up.

use crate::support::{Bench, HEAD, OUTPUT, PIN, PROGRAM};
use std::io::{BufRead, BufReader, Read};
use std::process::{Command, Stdio};

/// Enough frames that an interrupt arrives in the middle.
const FRAMES: usize = 400;

fn long_shot() -> Bench {
    let head = HEAD.replace("last = 2", &format!("last = {FRAMES}")).replace("samples = 1", "samples = 4");
    Bench::with_shot(&format!("{head}{PIN}{OUTPUT}"))
}

#[test]
#[cfg(unix)]
fn an_interrupt_leaves_whole_frames_and_resume_completes() {
    let bench = long_shot();
    let mut command = Command::new(PROGRAM);
    command.current_dir(bench.path("")).args(["render", "shot.toml", "--device", "cpu"]);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("the program starts");
    let mut words = BufReader::new(child.stderr.take().expect("piped"));
    let mut line = String::new();
    while !line.starts_with("frame 2 ->") {
        line.clear();
        assert!(words.read_line(&mut line).expect("words") > 0, "ended before the second frame");
    }
    let interrupt = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(interrupt.is_ok_and(|status| status.success()), "the interrupt was not sent");
    let mut rest = String::new();
    words.read_to_string(&mut rest).expect("words");
    assert_eq!(child.wait().expect("an end").code(), Some(1), "{rest}");
    assert!(rest.contains("stopping after the frames in flight") && rest.contains("go on with --resume"), "{rest}");
    let done = bench.frames().len();
    assert!((2..FRAMES).contains(&done), "{done} frames");
    let ended = bench.render(&format!("--resume --frames 1-{}", done + 5)).says(0, &["5 frames on CPU"]);
    assert!(ended.stderr.contains(&format!("{done} kept")), "{}", ended.stderr);
    assert_eq!(bench.frames().len(), done + 5);
}

/// Reads one line of a run's output, then hangs up; gives the exit code and what was said.
fn hang_up(bench: &Bench, arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(PROGRAM);
    command.current_dir(bench.path("")).args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("the program starts");
    let mut first = String::new();
    BufReader::with_capacity(1, child.stdout.take().expect("piped")).read_line(&mut first).expect("a line");
    let output = child.wait_with_output().expect("an end");
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn a_reader_that_hangs_up_is_no_error() {
    let bench = Bench::new();
    let render = ["render", "shot.toml", "--device", "cpu", "--json"];
    assert_eq!(hang_up(&bench, &render), (Some(0), String::new()));
    assert_eq!(bench.frames(), ["f.0001.exr", "f.0002.exr"], "the frames are rendered all the same");
    for arguments in [&["completions", "bash"][..], &["man"], &["check", "shot.toml"], &["--help"]] {
        let (code, words) = hang_up(&bench, arguments);
        assert_eq!((code, words.as_str()), (Some(0), ""), "{arguments:?}");
    }
}
