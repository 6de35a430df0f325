//! Damaged files of every kind that is read give a result or an error: no panic, no endless work, no memory without bounds.
//!
//! Cases are the same everywhere. Others, and more of them: `PINWARP_FUZZ_SEED=7 PINWARP_FUZZ_TIMES=20 cargo test --test fuzz`.
//! A case that fails stays in the folder that is named.
#![allow(clippy::duplicate_mod, reason = "modules share what is in support/, each with what it needs of it")]

#[path = "../support/assets.rs"]
mod assets;
mod damage;
mod kinds;
mod readers;
#[path = "../support/skip.rs"]
mod skip;

use damage::{Rng, damaged};
use kinds::Kind;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError, mpsc};
use std::time::{Duration, Instant};

/// Longest that a damaged file may keep its reader, on a busy machine.
const MAX_SECONDS: u64 = 60;
/// Memory that reading damaged files may take at its peak: the largest sound one takes a tenth of that.
const MAX_MEGABYTES: u64 = 2048;
/// Threads that read damaged files.
const THREADS: u64 = 2;
/// Cases of a kind that may fail before the others are left out.
const MAX_FAULTS: usize = 3;

fn from_environment(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(otherwise)
}

/// Most memory that this process ever held, MB; `None`: the system does not say.
fn peak_megabytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().trim_end_matches(" kB").parse::<u64>().ok()? / 1024)
}

/// How a case went.
struct Outcome {
    case: u64,
    /// `Err`: what it panicked with.
    taken: Result<bool, String>,
    took: Duration,
}

/// Reads one file where a panic does no harm.
fn attempt(kind: &Kind, case: u64, path: &Path) -> Outcome {
    let begun = Instant::now();
    let taken = catch_unwind(AssertUnwindSafe(|| (kind.read)(path)));
    let said = |panic: Box<dyn std::any::Any + Send>| {
        let text = panic.downcast_ref::<String>().cloned();
        text.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned())).unwrap_or_default()
    };
    Outcome { case, taken: taken.map_err(said), took: begun.elapsed() }
}

/// All cases of a kind, each in a file of its own name while it is read.
struct Round {
    folder: PathBuf,
    seed: u64,
    count: u64,
}

impl Round {
    fn of(kind: &Kind) -> Self {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("fuzz").join(kind.name.replace(' ', "_"));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).expect("the folder of the build");
        let count = kind.cases * from_environment("PINWARP_FUZZ_TIMES", 1);
        Self { folder, seed: from_environment("PINWARP_FUZZ_SEED", 2405), count }
    }

    fn path(&self, kind: &Kind, case: u64) -> PathBuf {
        self.folder.join(format!("{case}.{}", kind.ending))
    }

    /// One thread's cases, from a first one on: what never ends is left behind.
    fn run(&self, kind: &Kind, first: u64, report: &mpsc::Sender<Outcome>) {
        for case in (first..self.count).step_by(THREADS as usize) {
            let mut rng = Rng::new(self.seed, case);
            let bytes = damaged(rng.pick::<Vec<u8>>(&kind.sound), kind.words, &mut rng);
            let path = self.path(kind, case);
            std::fs::write(&path, bytes).expect("the folder of the build");
            let outcome = attempt(kind, case, &path);
            if outcome.taken.is_ok() {
                std::fs::remove_file(&path).expect("just written");
            }
            if report.send(outcome).is_err() {
                return;
            }
        }
    }
}

/// Kinds one after the other, so that peaks of memory are their own.
static ALONE: Mutex<()> = Mutex::new(());

/// The files that damage starts from are taken.
fn try_sound(kind: &Kind, folder: &Path) {
    for (number, sound) in kind.sound.iter().enumerate() {
        let path = folder.join(format!("sound{number}.{}", kind.ending));
        std::fs::write(&path, sound).expect("the folder of the build");
        assert!((kind.read)(&path), "{}: sound file {number} is refused", kind.name);
        std::fs::remove_file(&path).expect("just written");
    }
}

/// Tries all cases of a kind; fails where one panics, does not end or takes too much.
fn survive(kind: Kind) {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    if kind.sound.is_empty() {
        skip::skip(kind.name);
        return;
    }
    let round = Round::of(&kind);
    try_sound(&kind, &round.folder);
    let before = peak_megabytes();
    let (report, outcomes) = mpsc::channel();
    let (mut taken, mut slowest, mut faults) = (0, Duration::ZERO, Vec::new());
    let (name, count, folder) = (kind.name, round.count, round.folder.clone());
    let shared = Arc::new((round, kind));
    for first in 0..THREADS {
        let (shared, report) = (Arc::clone(&shared), report.clone());
        std::thread::spawn(move || shared.0.run(&shared.1, first, &report));
    }
    drop(report);
    for _ in 0..count {
        let Ok(outcome) = outcomes.recv_timeout(Duration::from_secs(MAX_SECONDS)) else {
            panic!("{name}: a case in {} does not end", folder.display());
        };
        slowest = slowest.max(outcome.took);
        match outcome.taken {
            Ok(went) => taken += u64::from(went),
            Err(text) => faults.push(format!("case {} in {}: {text}", outcome.case, folder.display())),
        }
        if faults.len() >= MAX_FAULTS {
            break;
        }
    }
    assert!(faults.is_empty(), "{name}: readers panic:\n{}", faults.join("\n"));
    let grown = peak_megabytes().zip(before).map_or(0, |(after, before)| after - before);
    eprintln!("{name}: {count} damaged files, {taken} read, slowest {} ms, {grown} MB more", slowest.as_millis());
    assert!(grown < MAX_MEGABYTES, "{name}: {grown} MB");
    assert!(0 < taken && taken < count, "{name}: {taken} of {count} were read: damages reach nothing");
}

macro_rules! survives {
    ($($kind:ident),*) => {
        $(#[test]
        fn $kind() {
            survive(kinds::$kind());
        })*
    };
}

survives!(
    shots,
    lattices,
    pairs_as_csv,
    pairs_as_json,
    problems,
    figures,
    exr_files,
    real_exr_files,
    png_files,
    jpeg_files,
    glb_files,
    gltf_files
);

/// Files on which coverage-guided fuzzing (`.ci/fuzz`) found a fault that has been fixed, in a folder for each target.
#[test]
fn cases_found_before_are_survived() {
    type Reader = fn(&Path) -> bool;
    let readers: [(&str, &str, Reader); 7] = [
        ("shot", "toml", readers::read_shot),
        ("lattice", "json", readers::read_lattice),
        ("landmarks", "json", readers::read_pairs),
        ("problem", "json", readers::read_problem),
        ("exr", "exr", readers::read_image),
        ("picture", "png", readers::read_image),
        ("scene", "glb", readers::read_scene),
    ];
    let found = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/found");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut count = 0;
    for (target, ending, read) in readers {
        for case in std::fs::read_dir(found.join(target)).into_iter().flatten() {
            let case = case.expect("readable").path();
            let copy = folder.path().join(format!("case.{ending}"));
            std::fs::copy(&case, &copy).expect("both are files");
            eprintln!("{}: {}", case.display(), if read(&copy) { "accepted" } else { "refused" });
            count += 1;
        }
    }
    eprintln!("{count} cases");
}

/// A kind whose reader does not like a letter.
fn stumbling(read: fn(&Path) -> bool) -> Kind {
    Kind { name: "stumbling reader", ending: "txt", sound: vec!["11".into()], words: &["2"], cases: 50, read }
}

#[test]
#[should_panic(expected = "readers panic")]
fn a_reader_that_panics_is_found() {
    survive(stumbling(|path| std::fs::read(path).is_ok_and(|text| text == b"11" || panic!("on purpose"))));
}

#[test]
#[should_panic(expected = "damages reach nothing")]
fn a_reader_that_takes_nothing_is_found() {
    survive(stumbling(|path| path.ends_with("sound0.txt")));
}
