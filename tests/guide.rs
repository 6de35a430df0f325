//! The guide, followed as it stands: each section of `docs/GUIDE.md` runs in a folder of its own with a copy of `scenes/`.
//!
//! Fences hold commands for bash (`sh`, or `sh needs=NAME` where they need a program that may be missing), lines that the commands above
//! print (`text`; `…` stands for anything), or code for the Python package (`python`). Other fences are faults, so that no command goes
//! untested.
#![cfg(unix)]
#![allow(clippy::duplicate_mod, reason = "modules share what is in support/, each with what it needs of it")]

#[path = "support/python.rs"]
mod python;
#[path = "support/skip.rs"]
mod skip;

use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::time::Duration;
use tempfile::TempDir;

/// Name of the document in messages.
const NAME: &str = "docs/GUIDE.md";

/// A block that takes longer hangs.
const TIMEOUT: Duration = Duration::from_secs(300);

/// What fences may need, the module of `PINWARP_PYTHON` that brings it, and the program that they call.
const NEEDS: &[(&str, &str, &str)] = &[("openjd", "openjd.cli", "openjd"), ("bpy", "bpy", "python")];

/// Takes the place of `sbatch` even where there is one: a test submits nothing to a cluster.
const SBATCH: &str = include_str!("support/sbatch.sh");

/// Endings of the files that scenes consist of.
const SCENE_FILES: &[&str] = &["toml", "glb", "png"];

/// Makes a test of each section, and the list of their titles.
macro_rules! follow_sections {
    ($($test:ident: $title:literal,)+) => {
        const TESTED: &[&str] = &[$($title),+];

        $(
            #[test]
            fn $test() {
                follow(&guide(), $title).unwrap_or_else(|fault| panic!("{fault}"));
            }
        )+
    };
}

follow_sections! {
    a_3d_scene: "Warp a 3D scene",
    a_walk_on_twos: "A walk on twos",
    frames_of_another_renderer: "Frames of another renderer",
    a_puppet: "A puppet",
    other_programs: "Nuke, Natron, Blender, Resolve",
    a_render_farm: "A render farm",
    the_python_package: "Python",
}

/// A fenced block of a document.
struct Fence {
    /// Number of the line that opens it, from 1.
    line: usize,
    /// What follows the backticks.
    info: String,
    text: String,
}

/// What a heading of the second level begins.
struct Section {
    title: String,
    fences: Vec<Fence>,
}

/// What a fence holds.
enum Kind<'a> {
    /// Commands for bash, and the name of what they need.
    Commands(Option<&'a str>),
    /// Lines that the block above prints.
    Output,
    /// Code for the Python package, after that of the section's fences above.
    Python,
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn guide() -> String {
    fs::read_to_string(root().join(NAME)).unwrap_or_else(|error| panic!("{NAME}: {error}"))
}

/// Cuts a document into its sections.
fn sections(document: &str) -> Result<Vec<Section>, String> {
    let mut sections: Vec<Section> = Vec::new();
    let mut open: Option<Fence> = None;
    for (line, text) in (1..).zip(document.lines()) {
        if let Some(mut fence) = open.take() {
            if text == "```" {
                let section = sections.last_mut().ok_or_else(|| format!("line {line}: a fence above all sections"))?;
                section.fences.push(fence);
            } else {
                fence.text.push_str(text);
                fence.text.push('\n');
                open = Some(fence);
            }
        } else if let Some(info) = text.strip_prefix("```") {
            open = Some(Fence { line, info: info.to_owned(), text: String::new() });
        } else if text.trim_start().starts_with("```") || text.trim_start().starts_with("~~~") {
            return Err(format!("line {line}: a fence begins with three backticks at the start of its line"));
        } else if let Some(title) = text.strip_prefix("## ") {
            sections.push(Section { title: title.to_owned(), fences: Vec::new() });
        }
    }
    open.map_or(Ok(sections), |fence| Err(format!("line {}: the fence is not closed", fence.line)))
}

fn kind(fence: &Fence) -> Result<Kind<'_>, String> {
    match fence.info.as_str() {
        "sh" => Ok(Kind::Commands(None)),
        "text" => Ok(Kind::Output),
        "python" => Ok(Kind::Python),
        info => info
            .strip_prefix("sh needs=")
            .filter(|need| NEEDS.iter().any(|(name, _, _)| name == need))
            .map(|need| Kind::Commands(Some(need)))
            .ok_or_else(|| format!("fences of the kind '{info}' are not tested")),
    }
}

/// Whether a line holds the parts of a pattern between its `…`, in their order.
fn matches(line: &str, pattern: &str) -> bool {
    pattern.split('…').try_fold(line, |rest, part| Some(rest.split_once(part)?.1)).is_some()
}

/// The first line of a fence that was not printed.
fn unprinted<'a>(fence: &'a Fence, printed: &str) -> Option<&'a str> {
    fence.text.lines().find(|pattern| !printed.lines().any(|line| matches(line, pattern.trim())))
}

/// Copies a scene's files; frames that were rendered beside them stay behind.
fn copy_scenes(from: &Path, to: &Path) {
    fs::create_dir(to).expect("there is room");
    for entry in fs::read_dir(from).expect("the folder is part of the repository") {
        let entry = entry.expect("readable");
        let (path, target) = (entry.path(), to.join(entry.file_name()));
        if path.is_dir() && entry.file_name() != "out" {
            copy_scenes(&path, &target);
        } else if path.extension().is_some_and(|ending| SCENE_FILES.iter().any(|known| ending == *known)) {
            fs::copy(&path, &target).expect("there is room");
        }
    }
}

/// The folder of a program that may be missing; `None` where it is.
fn folder_of(need: &str) -> Option<PathBuf> {
    let (_, module, program) = NEEDS.iter().find(|(name, _, _)| *name == need)?;
    let said = python::run(&[*module], "import sys\nprint(sys.executable)", &[])?;
    let folder = Path::new(said.lines().next_back()?).parent()?.to_owned();
    folder.join(program).exists().then_some(folder)
}

/// `PINWARP_PYTHON`, if it has the Python package. `.ci/python` builds that and runs the same code, so it is not required here.
fn python_with_package() -> Option<String> {
    let python = std::env::var("PINWARP_PYTHON").ok()?;
    let probe = std::process::Command::new(&python).args(["-c", "import pinwarp"]).output();
    probe.is_ok_and(|output| output.status.success()).then_some(python)
}

fn has_bash() -> bool {
    let probe = std::process::Command::new("bash").arg("--version").output();
    let is_there = probe.is_ok_and(|output| output.status.success());
    if !is_there {
        skip::skip("there is no bash, so the commands of docs/GUIDE.md are not run");
    }
    is_there
}

/// Where a section is followed.
struct Workplace {
    /// The folder that the commands run in.
    folder: TempDir,
    /// Programs that come first on the path.
    programs: TempDir,
    /// What the block above printed; `None` if it was skipped.
    printed: Option<String>,
    /// The Python code of the blocks above.
    code: String,
}

impl Workplace {
    fn new() -> Self {
        let temporary = || tempfile::tempdir().expect("a temporary folder");
        let workplace = Self { folder: temporary(), programs: temporary(), printed: None, code: String::new() };
        copy_scenes(&root().join("scenes"), &workplace.folder.path().join("scenes"));
        let programs = workplace.programs.path();
        symlink(env!("CARGO_BIN_EXE_pinwarp"), programs.join("pinwarp")).expect("a link can be made");
        fs::write(programs.join("sbatch"), SBATCH).expect("there is room");
        fs::set_permissions(programs.join("sbatch"), PermissionsExt::from_mode(0o755)).expect("allowed");
        workplace
    }

    /// What a program prints; its exit status and what it prints as an error if it fails.
    fn run(&self, program: &str, arguments: &[&str], folder: Option<PathBuf>) -> Result<String, String> {
        let path = std::env::var_os("PATH").unwrap_or_default();
        let first = std::iter::once(self.programs.path().to_owned()).chain(folder);
        let path = std::env::join_paths(first.chain(std::env::split_paths(&path))).expect("no colons in folders");
        let mut command = assert_cmd::Command::new(program);
        command.args(arguments).current_dir(self.folder.path()).env("PATH", path).timeout(TIMEOUT);
        for name in ["NO_COLOR", "CLICOLOR_FORCE", "RUST_LOG"] {
            command.env_remove(name);
        }
        let output = command.output().map_err(|error| format!("{program} does not start: {error}"))?;
        let printed = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
        if output.status.success() { Ok(printed) } else { Err(format!("{}\n{printed}", output.status)) }
    }

    /// Runs commands up to the first that fails, and then prints its line in the document; `None` if something is missing.
    fn run_commands(&self, fence: &Fence, need: Option<&str>) -> Result<Option<String>, String> {
        let folder = need.and_then(folder_of);
        if let (Some(need), None) = (need, &folder) {
            skip::skip(&format!("{NAME}, line {}: {need} is not at hand", fence.line));
            return Ok(None);
        }
        // The commands begin in the script's second line.
        let before = fence.line - 1;
        let tell = format!("trap 'echo \"{NAME}:$((LINENO + {before})): $BASH_COMMAND\" >&2' ERR");
        let script = format!("set -Eeuo pipefail; {tell}\n{}", fence.text);
        self.run("bash", &["-c", &script], folder).map(Some)
    }

    /// Runs the code up to here with the Python package; `None` without it.
    fn run_python(&self) -> Result<Option<String>, String> {
        let Some(python) = python_with_package() else {
            skip::skip(&format!("PINWARP_PYTHON has no pinwarp, so the Python of {NAME} is left to .ci/python"));
            return Ok(None);
        };
        self.run(&python, &["-c", &self.code], None).map(Some)
    }

    /// Runs a block, or looks for its lines in what the one above printed.
    fn follow(&mut self, fence: &Fence) -> Result<(), String> {
        match kind(fence)? {
            Kind::Commands(need) => self.printed = self.run_commands(fence, need)?,
            Kind::Python => {
                self.code.push_str(&fence.text);
                self.printed = self.run_python()?;
            }
            Kind::Output => {
                if let Some(printed) = &self.printed
                    && let Some(line) = unprinted(fence, printed)
                {
                    return Err(format!("'{line}' is not in:\n{printed}"));
                }
            }
        }
        Ok(())
    }
}

/// Runs a section of a document.
fn follow(document: &str, title: &str) -> Result<(), String> {
    let sections = sections(document)?;
    let section = sections.iter().find(|section| section.title == title);
    let section = section.ok_or_else(|| format!("there is no section '{title}'"))?;
    if section.fences.first().is_some_and(|fence| fence.info == "text") {
        return Err(format!("section '{title}' begins with lines that no block prints"));
    }
    if !has_bash() {
        return Ok(());
    }
    let mut workplace = Workplace::new();
    for fence in &section.fences {
        let told = |fault: String| format!("{NAME}, section '{title}', block in line {}: {fault}", fence.line);
        workplace.follow(fence).map_err(told)?;
    }
    Ok(())
}

#[test]
fn every_section_has_a_test() {
    let sections = sections(&guide()).expect("its fences are right");
    let titles: Vec<&str> = sections.iter().map(|section| section.title.as_str()).collect();
    assert_eq!(titles, TESTED);
    for section in &sections {
        let runs = |fence: &Fence| !matches!(kind(fence), Ok(Kind::Output));
        assert!(section.fences.iter().any(runs), "section '{}' runs nothing", section.title);
    }
}

/// The fault of a document with one section, which begins in line 5; `None` without bash.
fn fault_of(fences: &str) -> Option<String> {
    let document = format!("# A document\n\n## One\n\n{fences}\n");
    has_bash().then(|| follow(&document, "One").expect_err("the document is wrong"))
}

#[track_caller]
fn assert_tells(fault: &str, words: &[&str]) {
    words.iter().for_each(|word| assert!(fault.contains(word), "{word:?} is not in:\n{fault}"));
}

#[test]
fn a_wrong_command_is_found() {
    let Some(fault) = fault_of("```sh\ntrue\npinwarp rendre\ntouch later\n```") else { return };
    assert_tells(&fault, &["section 'One', block in line 5", "exit status: 2", "docs/GUIDE.md:7: pinwarp rendre"]);
    assert_tells(&fault, &["unrecognized subcommand 'rendre'"]);
    let fault = fault_of("```sh\ntrue\n```\n\n```sh\ncat missing.toml | tail -1\n```").expect("there was bash");
    assert_tells(&fault, &["block in line 9", "docs/GUIDE.md:10", "missing.toml"]);
}

#[test]
fn a_line_that_is_not_printed_is_found() {
    let Some(fault) = fault_of("```sh\necho one two\n```\n\n```text\none\ntwo … one\n```") else { return };
    assert_tells(&fault, &["block in line 9", "'two … one' is not in:\none two"]);
    assert_tells(&fault_of("```text\none\n```").expect("there was bash"), &["begins with lines that no block prints"]);
    assert!(matches("wrote 3 frames in 2.1 s", "3 frames in … s") && !matches("3 frames", "3 … s"));
}

#[test]
fn blocks_of_a_section_share_a_folder_with_the_scenes() {
    let document = "## One\n```sh\necho three > count\n```\n```sh\ncat count\nls scenes/teapot\n```\n```text\nthree\nshot.toml\n```\n";
    assert_eq!(follow(document, "One"), Ok(()));
    assert_tells(&follow(document, "Two").expect_err("there is only one"), &["no section 'Two'"]);
}

#[test]
fn fences_that_would_not_be_tested_are_found() {
    let cases = [
        ("```bash\ntrue\n```", "fences of the kind 'bash'"),
        ("```sh needs=nothing\ntrue\n```", "fences of the kind 'sh needs=nothing'"),
        ("```\ntrue\n```", "fences of the kind ''"),
        ("  ```sh\ntrue\n  ```", "line 5: a fence begins"),
        ("~~~sh\ntrue\n~~~", "line 5: a fence begins"),
        ("```sh\ntrue", "line 5: the fence is not closed"),
    ];
    for (fences, words) in cases {
        let Some(fault) = fault_of(fences) else { return };
        assert_tells(&fault, &[words]);
    }
}
