//! A folder with a tiny scene and a shot, and the program run in it.

use crate::tiny::{Tiny, grid};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Output;
use std::time::Duration;
use tempfile::TempDir;

/// The program under test.
pub(crate) const PROGRAM: &str = env!("CARGO_BIN_EXE_pinwarp");

/// A run that takes longer hangs.
const TIMEOUT: Duration = Duration::from_secs(120);

/// A shot of two frames without pins.
pub(crate) const HEAD: &str = r#"
version = 1
scene = "tiny.gltf"
frames = { first = 1, last = 2, rate = 24 }
size = [64, 36]
samples = 1

[[layer]]
name = "all"
lattice = { dims = [4, 4] }
"#;

/// A pin that moves.
pub(crate) const PIN: &str = r#"
  [[layer.pin]]
  name = "corner"
  anchor = { node = "Quad", triangle = 0, barycentric = [1.0, 0.0, 0.0] }
  keys = [ { frame = 1, offset = [0.0, 0.0] }, { frame = 2, offset = [0.1, 0.05] } ]
"#;

/// Where frames go.
pub(crate) const OUTPUT: &str = r#"
[output]
path = "out/f.####.exr"
"#;

/// A folder to run the program in.
pub(crate) struct Bench {
    folder: TempDir,
}

/// How a run ended.
#[derive(Debug)]
pub(crate) struct Ended {
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

/// A square that covers the middle of the frame.
pub(crate) fn square() -> Tiny {
    Tiny::of(vec![grid("Quad", [-0.4, -0.4, 0.4, 0.4], 2)])
}

impl Bench {
    /// The square and a shot with one pin.
    pub(crate) fn new() -> Self {
        Self::with(&square().json(), &format!("{HEAD}{PIN}{OUTPUT}"))
    }

    /// The usual shot with a plain lattice, which warps the whole of a picture.
    pub(crate) fn plain() -> Self {
        let head = HEAD.replace("dims = [4, 4]", "dims = [4, 4], topology = \"plain\"");
        Self::with(&square().json(), &format!("{head}{PIN}{OUTPUT}"))
    }

    /// A scene and a shot.
    pub(crate) fn with(scene: &Value, shot: &str) -> Self {
        let bench = Self { folder: tempfile::tempdir().expect("a temporary folder") };
        bench.write("tiny.gltf", scene.to_string().as_bytes());
        bench.write("shot.toml", shot.as_bytes());
        bench
    }

    /// The usual shot of another scene.
    pub(crate) fn with_scene(scene: &Value) -> Self {
        Self::with(scene, &format!("{HEAD}{PIN}{OUTPUT}"))
    }

    /// Another shot of the usual scene.
    pub(crate) fn with_shot(shot: &str) -> Self {
        Self::with(&square().json(), shot)
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, bytes: &[u8]) {
        std::fs::write(self.path(name), bytes).expect("the folder can be written to");
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).expect("the file is there")
    }

    /// Names below `out/`, sorted.
    pub(crate) fn frames(&self) -> Vec<String> {
        names_in(&self.path("out"))
    }

    /// A command in the folder, in a plain environment.
    pub(crate) fn command(&self, program: &str) -> assert_cmd::Command {
        let mut command = assert_cmd::Command::new(program);
        command.current_dir(self.folder.path()).timeout(TIMEOUT);
        for name in ["NO_COLOR", "CLICOLOR_FORCE", "RUST_LOG"] {
            command.env_remove(name);
        }
        command
    }

    /// Runs the program with arguments separated by spaces.
    pub(crate) fn run(&self, arguments: &str) -> Ended {
        let output = self.command(PROGRAM).args(arguments.split_whitespace()).output().expect("the program starts");
        self.checked(output)
    }

    /// Renders on the CPU, with more arguments.
    pub(crate) fn render(&self, arguments: &str) -> Ended {
        self.run(&format!("render shot.toml --device cpu {arguments}"))
    }

    /// What must hold after every run: no panic, no escape codes where there is no terminal, no half file.
    pub(crate) fn checked(&self, output: Output) -> Ended {
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("output is UTF-8");
        let ended = Ended { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) };
        assert!(!ended.stderr.contains("panicked") && ended.code != Some(101), "{ended:?}");
        assert!(!ended.stderr.contains('\x1b') && !ended.stdout.contains('\x1b'), "{ended:?}");
        let repeated = |line: &str| line.rsplit_once(": ").is_some_and(|(head, tail)| head.contains(tail));
        assert!(!ended.stderr.trim_end().lines().any(repeated), "a cause is told twice: {ended:?}");
        assert_whole(self.folder.path());
        ended
    }
}

/// A text with the separators of paths that the tests expect.
pub(crate) fn with_slashes(text: &str) -> String {
    if cfg!(windows) { text.replace('\\', "/") } else { text.to_owned() }
}

impl Ended {
    /// Checks the exit code, and that the error output says all of `words`.
    #[track_caller]
    pub(crate) fn says(self, code: i32, words: &[&str]) -> Self {
        assert_eq!(self.code, Some(code), "{}", self.stderr);
        let told = with_slashes(&self.stderr);
        for word in words {
            assert!(told.contains(word), "{word:?} is not in:\n{told}");
        }
        self
    }

    /// The lines of `--json`.
    pub(crate) fn events(&self) -> Vec<Value> {
        let event = |line: &str| serde_json::from_str(line).expect("a line of JSON");
        self.stdout.lines().map(event).collect()
    }
}

/// Names in a folder, sorted, but for the folder of kept trajectories; none where there is no folder.
pub(crate) fn names_in(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.retain(|name| name != ".pinwarp-trajectories");
    names.sort();
    names
}

/// Every EXR file in and below a folder is complete, and nothing temporary is left.
#[track_caller]
pub(crate) fn assert_whole(folder: &Path) {
    for entry in std::fs::read_dir(folder).expect("a folder").flatten() {
        let path = entry.path();
        let name = entry.file_name().to_string_lossy().into_owned();
        assert!(!name.ends_with(".tmp"), "{name} is left over");
        if path.is_dir() {
            assert_whole(&path);
        } else if path.is_file() && name.ends_with(".exr") {
            assert!(pinwarp::image::is_complete(&path), "{name} is not whole");
        }
    }
}

/// A shell that may mount: the mounts vanish with it. `None`, said loudly, where the system allows none.
pub(crate) fn private_mounts() -> Option<&'static [&'static str]> {
    const PREFIXES: [&[&str]; 2] = [&["unshare", "-m"], &["unshare", "-rm"]];
    let works = |prefix: &&&[&str]| {
        let probe = "mount -t tmpfs tmpfs /mnt";
        let mut command = std::process::Command::new(prefix[0]);
        command.args(&prefix[1..]).args(["sh", "-c", probe]).stderr(std::process::Stdio::null());
        command.status().is_ok_and(|status| status.success())
    };
    let found = PREFIXES.iter().find(works).copied();
    if found.is_none() {
        crate::skip::skip("mounts are not allowed here, so full and read-only disks cannot be tried");
    }
    found
}
