//! Who may import whom, where third-party crates and `unsafe` may appear, and that the documents name real files.

#[path = "support/imports.rs"]
mod imports;

use imports::Imports;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Identifiers that were replaced by the words of the glossary.
const RETIRED: &[&str] = &[
    "starch",
    "starched",
    "waypoint",
    "Waypoint",
    "PinMiss",
    "pin_misses",
    "yardstick",
    "grip",
    "packs",
    "Packs",
    "fans",
    "Fans",
    "patches",
    "Patched",
    "occupied",
    "weld",
    "buckets",
    "Turns",
    "Sheet",
    "Share",
    "share_out",
    "sheets",
    "Ground",
    "Mover",
    "mover",
    "movers",
    "Around",
    "Alike",
    "spare",
    "Meaning",
    "carved",
    "picks",
    "WarpRules",
    "MotionRule",
    "NormalRule",
    "Setup",
    "setup",
    "Moment",
    "Spoken",
    "spoken",
    "Claims",
    "Pinned",
    "Producer",
    "FollowWindow",
    "KeptBounds",
];

/// Retired words that mean something else in some stages, and those stages.
const RIGHT_ELSEWHERE: &[(&str, &[&str])] = &[
    ("pack", &["pipeline", "scene"]),
    ("fan", &["pipeline", "screen"]),
    ("quads", &["pipeline"]),
    ("misses", &["live", "pipeline"]),
    ("turns", &["edit", "export", "live", "ofx", "pipeline", "scene", "shot"]),
    ("reach", &["cli", "edit", "export", "image", "live", "ofx", "pipeline", "plate", "raster", "scene", "screen"]),
    ("small", &["edit", "image", "live", "pipeline"]),
    ("products", &["live"]),
    ("View", &["scene"]),
    ("Place", &["edit", "image", "ofx", "python"]),
    ("Kind", &["edit", "image", "shot"]),
    ("sheet", &["cli", "image", "pipeline"]),
    ("Link", &["pipeline", "solve"]),
    ("alike", &["pipeline"]),
    ("meaning", &["cli", "image", "ofx", "shot"]),
    ("laid", &["edit"]),
    ("Net", &["scene"]),
    ("Canvas", &["compare", "image", "pipeline"]),
    ("Pick", &["cli"]),
    ("pitch", &["pipeline", "raster", "screen", "shot", "solve"]),
    ("owners", &["edit", "solve"]),
];

/// A choice that many places could compare with, and how many files may do so.
const CHOICES: &[(&str, &[&str], usize)] = &[
    // Its functions, their display twins, its name in problem files, Blender's lattices, the plugin's list.
    ("Basis", &["Bernstein", "Bspline", "Bilinear", "Barytri"], 6),
    ("Energy", &["Area", "Edge", "Vertex", "Element", "SpokesAndRims", "Stroke"], 4),
];

/// A stage and the stages it may know. Front ends and the pipeline know everything below them.
const MAY_IMPORT: &[(&str, &[&str])] = &[
    ("space", &[]),
    ("disjoint_sets", &[]),
    ("files", &[]),
    ("key_fault", &[]),
    ("simd", &[]),
    ("smoothstep", &[]),
    ("spelling", &[]),
    ("memory", &[]),
    ("scene", &["disjoint_sets", "files", "memory", "space", "spelling"]),
    ("pose", &["scene", "space"]),
    ("screen", &["pose", "scene", "space"]),
    ("lattice", &["simd", "space", "spelling"]),
    ("image", &["files", "memory", "space", "spelling"]),
    ("solve", &["disjoint_sets", "files", "lattice", "simd", "smoothstep", "space", "spelling"]),
    ("plate", &["image", "lattice", "simd", "smoothstep", "space", "spelling"]),
    ("export", &["files", "image", "key_fault", "lattice", "plate", "scene", "space", "spelling"]),
    ("compare", &["image", "lattice", "solve", "space", "spelling"]),
    ("raster", &["image", "lattice", "plate", "pose", "scene", "screen", "solve", "space", "spelling"]),
    ("shot", &["files", "image", "lattice", "plate", "raster", "smoothstep", "solve", "space", "spelling"]),
    (
        "pipeline",
        &[
            "export",
            "files",
            "image",
            "key_fault",
            "lattice",
            "memory",
            "plate",
            "pose",
            "raster",
            "scene",
            "screen",
            "shot",
            "smoothstep",
            "solve",
            "space",
            "spelling",
        ],
    ),
    ("live", &["image", "lattice", "memory", "pipeline", "plate", "scene", "shot", "solve", "space", "spelling"]),
    (
        "edit",
        &["files", "image", "lattice", "pipeline", "plate", "raster", "scene", "shot", "solve", "space", "spelling"],
    ),
    ("ofx", &["image", "live", "memory", "plate", "shot", "space", "spelling"]),
    (
        "python",
        &[
            "cli", "export", "image", "lattice", "live", "pipeline", "plate", "pose", "raster", "scene", "screen",
            "shot", "solve", "space", "spelling",
        ],
    ),
    (
        "cli",
        &[
            "compare", "edit", "export", "files", "image", "lattice", "memory", "pipeline", "plate", "pose", "raster",
            "scene", "screen", "shot", "solve", "space", "spelling",
        ],
    ),
];

/// A third-party crate and the only places that may name it.
const ENTERS_ONLY: &[(&str, &[&str])] = &[
    ("gltf", &["src/scene/"]),
    ("spade", &["src/scene/outline/"]),
    ("bevy_mikktspace", &["src/scene/tangents.rs"]),
    ("toml", &["src/shot/"]),
    ("toml_edit", &["src/shot/"]),
    ("faer", &["src/lattice/fit.rs", "src/solve/"]),
    ("pulp", &["src/lattice/display.rs", "src/plate/filter/", "src/simd.rs", "src/solve/"]),
    ("ash", &["src/raster/vulkan/", "src/raster/error.rs"]),
    ("gpu_allocator", &["src/raster/vulkan/"]),
    ("exr", &["src/image/"]),
    ("clap", &["src/cli/"]),
    ("indicatif", &["src/cli/"]),
    ("ctrlc", &["src/cli/"]),
    ("eframe", &["src/edit/ui/"]),
    ("egui", &["src/edit/ui/"]),
    ("numpy", &["src/python/"]),
    ("pyo3", &["src/python/"]),
];

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// All Rust files below `folder`, as paths from the root with forward slashes, and their text.
fn sources(folder: &str) -> Vec<(String, String)> {
    let mut found = Vec::new();
    let mut open = vec![root().join(folder)];
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(&folder).expect("the folder is part of the repository") {
            let path = entry.expect("readable").path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let name = path.strip_prefix(root()).expect("below the root").to_string_lossy().replace('\\', "/");
                found.push((name, fs::read_to_string(&path).expect("readable")));
            }
        }
    }
    found.sort();
    found
}

/// The stage a file belongs to: `src/solve/area.rs` and `src/solve.rs` to `solve`.
fn stage_of(file: &str) -> &str {
    let rest = file.strip_prefix("src/").unwrap_or(file);
    rest.split(['/', '.']).next().unwrap_or(rest)
}

/// Lines of code, without line comments.
fn code_lines(text: &str) -> impl Iterator<Item = &str> {
    text.lines().map(|line| line.split("//").next().unwrap_or(line))
}

/// Stages that a text names as `crate::<stage>`, also in nested `use crate::{...}` lists.
fn stages_named(text: &str) -> BTreeSet<String> {
    let code: String = code_lines(text).collect::<Vec<_>>().join("\n");
    let first_word = |rest: &str| -> String { rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect() };
    let mut named = BTreeSet::new();
    for (at, _) in code.match_indices("crate::") {
        let rest = &code[at + "crate::".len()..];
        if let Some(list) = rest.strip_prefix('{') {
            named.extend(top_level_items(list).iter().map(|item| first_word(item)));
        } else {
            named.insert(first_word(rest));
        }
    }
    named.retain(|name| MAY_IMPORT.iter().any(|(stage, _)| stage == name));
    named
}

/// Items of a `{a::{b, c}, d}` list after its opening brace, without what is nested.
fn top_level_items(list: &str) -> Vec<String> {
    let mut depth = 1;
    let mut items = vec![String::new()];
    for letter in list.chars() {
        match letter {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 1 => items.push(String::new()),
            _ if depth == 1 && !letter.is_whitespace() => items.last_mut().expect("never empty").push(letter),
            _ => {}
        }
        if depth == 0 {
            break;
        }
    }
    items
}

/// Every forbidden import in a file.
fn forbidden(file: &str, text: &str) -> Vec<String> {
    let stage = stage_of(file);
    let Some((_, allowed)) = MAY_IMPORT.iter().find(|(name, _)| *name == stage) else { return Vec::new() };
    let may = |named: &String| named == stage || allowed.contains(&named.as_str());
    stages_named(text).into_iter().filter(|named| !may(named)).map(|named| format!("{file} imports {named}")).collect()
}

#[test]
fn stages_import_only_what_they_may() {
    let faults: Vec<String> = sources("src").iter().flat_map(|(file, text)| forbidden(file, text)).collect();
    assert!(faults.is_empty(), "forbidden imports:\n{}", faults.join("\n"));
}

#[test]
fn a_forbidden_import_is_found() {
    assert_eq!(forbidden("src/solve/mod.rs", "use crate::raster::Frame;"), ["src/solve/mod.rs imports raster"]);
    assert_eq!(forbidden("src/pose/a.rs", "use crate::{scene::Scene, cli};"), ["src/pose/a.rs imports cli"]);
    assert!(forbidden("src/pose/a.rs", "// crate::cli is not known here\nuse crate::scene::Scene;").is_empty());
}

/// Names of fields and arguments that are transforms and do not say from where to where.
fn unnamed_transforms(text: &str) -> Vec<String> {
    let is_transform = |kind: &str| {
        let kind = kind.trim_start_matches('&');
        ["Mat4", "DMat4"].iter().any(|name| kind.strip_prefix(name).is_some_and(|rest| !rest.starts_with(':')))
    };
    let code: String = code_lines(text).collect::<Vec<_>>().join("\n");
    let typed = code.match_indices(": ").filter(|(at, _)| is_transform(&code[at + 2..]));
    let names = typed.filter_map(|(at, _)| code[..at].rsplit(|c: char| !c.is_alphanumeric() && c != '_').next());
    names.filter(|name| !name.contains("_from_")).map(str::to_owned).collect()
}

#[test]
fn transforms_are_named_by_target_and_source() {
    for (file, text) in sources("src") {
        // A helper for any matrix.
        let unnamed: Vec<_> = unnamed_transforms(&text).into_iter().filter(|name| name != "matrix").collect();
        assert!(unnamed.is_empty(), "{file}: {unnamed:?}; docs/CONVENTIONS.md names transforms target_from_source");
    }
    assert_eq!(unnamed_transforms("fn f(a_from_b: &DMat4, view: DMat4, at: Vec3)"), ["view"]);
}

/// Every place where a third-party crate is named outside its stage.
fn strays(file: &str, text: &str) -> Vec<String> {
    let names = |line: &str, krate: &str| {
        line.match_indices(&format!("{krate}::")).any(|(at, _)| {
            let before = line[..at].chars().next_back();
            // `crate::image::` and `self::exr::` are modules of ours.
            !before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == ':')
                || line[..at].trim_end().ends_with("use ::")
        })
    };
    let stray = |(krate, places): &&(&str, &[&str])| {
        !places.iter().any(|place| file.starts_with(place)) && code_lines(text).any(|line| names(line, krate))
    };
    ENTERS_ONLY.iter().filter(stray).map(|(krate, _)| format!("{file} names {krate}")).collect()
}

#[test]
fn third_party_crates_enter_once() {
    let faults: Vec<String> = sources("src").iter().flat_map(|(file, text)| strays(file, text)).collect();
    assert!(faults.is_empty(), "third-party crates outside their stage:\n{}", faults.join("\n"));
    assert_eq!(strays("src/cli/a.rs", "use gltf::Gltf;"), ["src/cli/a.rs names gltf"]);
}

#[test]
fn unsafe_lives_in_two_folders() {
    let is_fenced = |file: &str| file.starts_with("src/raster/vulkan/") || file.starts_with("src/ofx/");
    let unsafe_code = |text: &str| code_lines(text).any(|line| line.contains("unsafe {") || line.contains("unsafe fn"));
    for (file, text) in sources("src") {
        assert!(is_fenced(&file) || !unsafe_code(&text), "{file} holds unsafe code");
    }
    assert!(unsafe_code("let x = unsafe { read() };"));
}

/// What the binding of the OpenFX API names of this crate beside the declarations.
fn known_beyond_the_api(text: &str) -> Vec<String> {
    let code: String = code_lines(text).collect::<Vec<_>>().join("\n");
    let own = code.replace("pub(in crate::ofx)", "").replace("crate::ofx::api", "");
    own.lines().filter(|line| line.contains("crate::") || line.contains("super::super")).map(str::to_owned).collect()
}

#[test]
fn the_host_s_binding_knows_no_warps() {
    for (file, text) in sources("src/ofx/host") {
        assert_eq!(known_beyond_the_api(&text), [""; 0], "{file}");
    }
    assert_eq!(known_beyond_the_api("use crate::live::Warp;"), ["use crate::live::Warp;"]);
    assert_eq!(known_beyond_the_api("use super::super::fault::Fault;").len(), 1);
}

#[test]
fn every_file_says_what_it_is_for() {
    for (file, text) in sources("src") {
        assert!(text.starts_with("//! "), "{file} has no module head");
        let head = text.lines().take_while(|line| line.starts_with("//!")).count();
        assert!(head <= 24, "{file}: its head has {head} lines");
    }
}

#[test]
fn files_stay_small() {
    for (file, text) in sources("src") {
        let lines = text.lines().count();
        assert!(lines <= 600, "{file} has {lines} lines; split it");
    }
}

/// Files of tests that neither Cargo.toml nor `tests/internal.rs` names.
fn unlisted(files: &[String], cargo: &str, internal: &str) -> Vec<String> {
    let is_root = |file: &&String| {
        let rest = file.strip_prefix("tests/").unwrap_or(file);
        rest != "internal.rs" && (!rest.contains('/') || rest.matches('/').count() == 1 && rest.ends_with("/main.rs"))
    };
    let is_listed = |file: &String| {
        let in_tests = file.strip_prefix("tests/").unwrap_or(file);
        cargo.contains(&format!("path = \"{file}\"")) || internal.contains(&format!("#[path = \"{in_tests}\"]"))
    };
    files.iter().filter(is_root).filter(|file| !is_listed(file)).cloned().collect()
}

#[test]
fn every_test_file_is_listed() {
    let [cargo, internal] =
        ["Cargo.toml", "tests/internal.rs"].map(|file| fs::read_to_string(root().join(file)).expect("readable"));
    let files: Vec<String> = sources("tests").into_iter().map(|(file, _)| file).collect();
    assert_eq!(unlisted(&files, &cargo, &internal), [""; 0], "tests that no crate includes");
    let files = ["tests/a.rs", "tests/b/main.rs", "tests/b/c.rs", "tests/d.rs"].map(str::to_owned);
    assert_eq!(unlisted(&files, "path = \"tests/a.rs\"", "#[path = \"b/main.rs\"]"), ["tests/d.rs"]);
}

#[test]
fn what_cannot_run_is_skipped_in_one_way() {
    let word = concat!("SKIP", "PED");
    for (file, text) in sources("tests").into_iter().chain(sources("src")) {
        assert!(file == "tests/support/skip.rs" || !text.contains(word), "{file} says {word}; call support/skip.rs");
    }
}

/// Paths in backticks that look like files of the repository.
fn paths_in(text: &str) -> Vec<&str> {
    let folders = ["src/", "shaders/", "scenes/", "tests/", "benches/", "docs/", ".ci/"];
    let is_path = |word: &&str| {
        (folders.iter().any(|folder| word.starts_with(folder)) || ["Cargo.toml", "README.md"].contains(word))
            && !word.contains(['*', '<', ' ', '#'])
    };
    text.split('`').skip(1).step_by(2).filter(is_path).collect()
}

#[test]
fn documents_name_files_that_are_there() {
    for document in
        ["docs/ARCHITECTURE.md", "docs/CONVENTIONS.md", "docs/METHOD.md", "docs/PERFORMANCE.md", "README.md"]
    {
        let text = fs::read_to_string(root().join(document)).unwrap_or_else(|error| panic!("{document}: {error}"));
        for path in paths_in(&text) {
            assert!(Path::new(&root()).join(path).exists(), "{document} names {path}, which is not there");
        }
    }
    assert_eq!(paths_in("see `src/x.rs`, `.ci/y` and `other`"), ["src/x.rs", ".ci/y"]);
}

/// What pictures name that is no type of ours: programs and file formats.
const NOT_TYPES: [&str; 5] = ["Nuke", "Blender", "After", "Effects", "STMap"];

/// The pictures of a text: what stands between "```text" and "```".
fn pictures(text: &str) -> Vec<String> {
    let starts = text.split("```text\n").skip(1);
    starts.filter_map(|rest| rest.split("```").next()).map(str::to_owned).collect()
}

/// Names of types in a picture.
fn types_in(picture: &str) -> BTreeSet<&str> {
    let words = picture.split(|c: char| !c.is_alphanumeric() && c != '_');
    let is_type = |word: &&str| {
        word.starts_with(|c: char| c.is_ascii_uppercase()) && word.contains(|c: char| c.is_ascii_lowercase())
    };
    words.filter(is_type).filter(|word| !NOT_TYPES.contains(word)).collect()
}

#[test]
fn pictures_name_types_that_are_there() {
    let read = |file: &str| fs::read_to_string(root().join(file)).expect("part of the repository");
    let page = pictures(&read("docs/ARCHITECTURE.md"));
    let library: String = read("src/lib.rs")
        .lines()
        .filter_map(|line| line.strip_prefix("//!"))
        .map(|line| format!("{line}\n"))
        .collect();
    let library = pictures(&library.replace("\n ", "\n"));
    let code: String = sources("src").into_iter().map(|(_, text)| text).collect();
    let is_defined = |name: &str| {
        let kinds = ["struct", "enum", "trait", "type"];
        kinds.iter().any(|kind| {
            let ends = |(at, found): (usize, &str)| {
                !code[at + found.len()..].starts_with(|c: char| c.is_alphanumeric() || c == '_')
            };
            code.match_indices(&format!("{kind} {name}")).any(ends)
        })
    };
    for picture in page.iter().chain(&library) {
        let absent: Vec<&str> = types_in(picture).into_iter().filter(|name| !is_defined(name)).collect();
        assert!(absent.is_empty(), "no type is called {absent:?}, which are in this picture:\n{picture}");
    }
    assert_eq!(library.first(), page.first(), "src/lib.rs and docs/ARCHITECTURE.md show the stages differently");
    assert!(!is_defined("Embedding") && types_in("a.exr ─▶ Frame, Nuke").contains("Frame"));
}

/// Rows of the page of conventions whose last column names no test, or one that its files do not have.
fn unproved(page: &str, read: impl Fn(&str) -> String) -> Vec<String> {
    let is_proved = |row: &&str| {
        let cell = row.trim_end().trim_end_matches('|').rsplit(" | ").next().unwrap_or_default();
        let (files, tests): (Vec<&str>, Vec<&str>) =
            cell.split('`').skip(1).step_by(2).partition(|word| word.contains('/'));
        let code: String = files.into_iter().map(&read).collect();
        !tests.is_empty() && tests.iter().all(|test| code.contains(&format!("fn {test}(")))
    };
    let rows = page.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| what |"));
    rows.filter(|row| !is_proved(row)).map(str::to_owned).collect()
}

#[test]
fn every_convention_names_a_test_that_proves_it() {
    let read = |file: &str| fs::read_to_string(root().join(file)).unwrap_or_else(|error| panic!("{file}: {error}"));
    assert_eq!(unproved(&read("docs/CONVENTIONS.md"), read), [""; 0], "conventions without a test");
    let page = "| a | `x/y` | `t` in `b/c.rs` |\n| d | e | `b/c.rs` |\n| f | g | – |\n| h | i | `u` in `b/c.rs` |";
    assert_eq!(unproved(page, |_| "fn t() {}".into()).len(), 3);
}

/// Versions of Rust in a text: 1.95 of "needs Rust 1.95.".
fn rust_versions(text: &str) -> Vec<&str> {
    let starts = text.match_indices("Rust 1.").map(|(at, _)| &text[at + "Rust ".len()..]);
    let number = |rest: &'_ str| rest.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(rest.len());
    starts.map(|rest| rest[..number(rest)].trim_end_matches('.')).collect()
}

#[test]
fn one_version_of_rust_is_promised_everywhere() {
    let read = |file: &str| fs::read_to_string(root().join(file)).expect("part of the repository");
    let cargo = read("Cargo.toml");
    let line = cargo.lines().find_map(|line| line.strip_prefix("rust-version = ")).expect("a promise");
    let promised = line.trim_matches('"');
    // Earlier releases needed other versions.
    let changes = read("CHANGELOG.md");
    assert_eq!(rust_versions(&changes).first(), Some(&promised), "CHANGELOG.md, topmost section");
    assert!(!rust_versions(&read("README.md")).is_empty(), "README.md names no version of Rust");
    let pages = fs::read_dir(root().join("docs")).expect("a folder").map(|entry| entry.expect("readable").file_name());
    let pages = pages.map(|name| format!("docs/{}", name.to_string_lossy())).filter(|page| page.ends_with(".md"));
    // The compiler of the measurements.
    let pages = pages.filter(|page| page != "docs/PERFORMANCE.md");
    for page in pages.chain(["README.md".to_owned()]) {
        let text = read(&page);
        assert!(rust_versions(&text).iter().all(|version| *version == promised), "{page} does not say {promised}");
    }
    assert_eq!(rust_versions("Rust 1.95, and Rust 1.9. Rust"), ["1.95", "1.9"]);
}

#[test]
fn files_import_no_circles() {
    let circles = Imports::of(&sources("src")).circles();
    assert!(circles.is_empty(), "circles of files: {circles:?}");
}

#[test]
fn a_circle_is_found_through_super_self_and_reexports() {
    let file = |name: &str, text: &str| (format!("src/{name}.rs"), text.to_owned());
    let tree = |leaf: &str, other: &str| {
        let files = [file("a/mod", "mod b;\nmod c;\npub use b::One;"), file("a/b", leaf), file("a/c", other)];
        Imports::of(&files).circles()
    };
    let circle = vec![vec!["src/a/b.rs".to_owned(), "src/a/c.rs".to_owned()]];
    for other in
        ["use super::One;", "use super::{b, x::Y};", "fn f() { crate::a::b::g() }", "use crate::{a::{b::*}, d};"]
    {
        assert_eq!(tree("pub struct One(super::c::Two);", other), circle, "{other}");
        // What tests import, and what comments say, makes no circle; nor does a module that only re-exports.
        assert!(
            tree("// super::c\n#[cfg(test)]\nmod tests { use super::super::c::Two; }", other).is_empty(),
            "{other}"
        );
    }
}

/// Identifiers of a text, without comments and strings.
fn identifiers(text: &str) -> BTreeSet<String> {
    let code: String = code_lines(text).collect::<Vec<_>>().join("\n");
    let outside: String = code.split('"').step_by(2).collect::<Vec<_>>().join(" ");
    outside.split(|c: char| !c.is_alphanumeric() && c != '_').map(str::to_owned).collect()
}

/// Retired words that a file uses.
fn retired_words(file: &str, text: &str) -> Vec<&'static str> {
    let words = identifiers(text);
    let elsewhere =
        RIGHT_ELSEWHERE.iter().filter(|(_, stages)| !stages.contains(&stage_of(file))).map(|(word, _)| word);
    RETIRED.iter().chain(elsewhere).filter(|word| words.contains(**word)).copied().collect()
}

#[test]
fn retired_words_stay_away() {
    for (file, text) in sources("src") {
        let back = retired_words(&file, &text);
        assert!(back.is_empty(), "{file} uses {back:?}: docs/ARCHITECTURE.md has the word of the field");
    }
    assert_eq!(retired_words("src/solve/a.rs", "let grip = 1; // packs"), ["grip"]);
    assert_eq!(retired_words("src/solve/a.rs", "f(\"grip\"); let pitch = Net;"), ["Net"]);
}

/// The rows of the glossary: names of code and the files that define them.
fn glossary(text: &str) -> Vec<(String, String)> {
    let section = text.split("## Words").nth(1).and_then(|rest| rest.split("\n## ").next()).unwrap_or_default();
    let rows = section.lines().filter(|line| line.starts_with("| ") && line.contains('`'));
    let code = rows.filter_map(|row| {
        let names: Vec<&str> = row.rsplit('|').nth(1)?.split('`').collect();
        Some((names.get(1)?.to_string(), names.get(3)?.to_string()))
    });
    code.collect()
}

#[test]
fn words_of_the_glossary_are_in_the_code() {
    let defines = |text: &str, name: &str| {
        let kinds = ["struct", "enum", "trait", "fn", "type", "const"];
        let starts = |line: &str, kind: &str| {
            line.split_once(&format!("{kind} {name}"))
                .is_some_and(|(_, rest)| !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_'))
        };
        code_lines(text).any(|line| kinds.iter().any(|kind| starts(line, kind)))
    };
    let text = fs::read_to_string(root().join("docs/ARCHITECTURE.md")).expect("the page is part of the repository");
    let words = glossary(&text);
    assert!(words.len() > 20, "{words:?}");
    for (name, file) in words {
        let text = fs::read_to_string(root().join(&file)).unwrap_or_else(|error| panic!("{file}: {error}"));
        assert!(defines(&text, &name), "{file} does not define {name}");
    }
    assert!(defines("pub struct Grid<D> {", "Grid") && !defines("pub struct Grids;", "Grid"));
}

#[test]
fn choices_are_compared_in_few_places() {
    for (choice, variants, limit) in CHOICES {
        let names = |text: &str| {
            let code = text.split("#[cfg(test)]").next().unwrap_or_default();
            let code: Vec<&str> = code_lines(code).collect();
            let own = format!("enum {choice} ");
            let is_named = |line: &&str| variants.iter().any(|variant| line.contains(&format!("{choice}::{variant}")));
            code.iter().any(|line| is_named(line) || line.contains(&own))
        };
        let files: Vec<String> =
            sources("src").into_iter().filter(|(_, text)| names(text)).map(|(file, _)| file).collect();
        assert!(files.len() <= *limit, "{choice} is compared in {} files, at most {limit}: {files:?}", files.len());
    }
}
