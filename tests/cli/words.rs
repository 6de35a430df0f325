//! Help, man page, completions, usage errors, colours.

use crate::support::Bench;

/// All commands, as the help lists them.
pub(crate) fn commands(bench: &Bench) -> Vec<String> {
    let help = bench.run("-h").says(0, &[]).stdout;
    let list = help.split("Commands:").nth(1).expect("a list").split("Options:").next().expect("before the options");
    // Lines that go on are indented more.
    let lines = list.lines().filter_map(|line| line.strip_prefix("  ").filter(|line| !line.starts_with(' ')));
    let names = lines.filter_map(|line| line.split_whitespace().next().map(str::to_owned));
    names.filter(|name| name != "help").collect()
}

#[test]
fn help_is_short_or_long() {
    let bench = Bench::new();
    let all = commands(&bench);
    for name in ["render", "warp", "new", "check", "pick", "solve", "compare", "export", "fit", "transfer", "man"] {
        assert!(all.iter().any(|other| other == name), "{name} is not in {all:?}");
    }
    for command in &all {
        let [short, long] = ["-h", "--help"].map(|flag| bench.run(&format!("{command} {flag}")).says(0, &[]).stdout);
        assert!(short.len() < long.len(), "{command}: the long help says more");
        assert!(!short.contains("  pinwarp "), "{command}: examples are for the long help:\n{short}");
        assert!(long.contains("  pinwarp "), "{command}: the long help has an example:\n{long}");
        for line in short.lines().filter(|line| line.trim_start().starts_with("--")) {
            let flag = line.split_whitespace().next().unwrap_or_default();
            assert!(long.contains(flag), "{command}: {flag} is not in the long help");
        }
    }
    let [short, long] = ["render -h", "render --help"].map(|arguments| bench.run(arguments).says(0, &[]).stdout);
    for word in ["Usage: pinwarp render", "--frames", "--scale", "--resume", "--overlay", "--json", "1-48x2,60"] {
        assert!(short.contains(word) && long.contains(word), "{word}");
    }
    let reason = "the reason is given";
    assert!(long.contains(reason) && !short.contains(reason), "only the long help explains --resume");
    assert!(bench.run("--help").says(0, &[]).stdout.contains("Exit codes: 0 success"));
    assert_eq!(bench.run("--version").says(0, &[]).stdout, format!("pinwarp {}\n", env!("CARGO_PKG_VERSION")));
}

#[test]
fn usage_errors_exit_with_2() {
    let bench = Bench::new();
    bench.run("").says(2, &["Usage: pinwarp"]);
    bench.run("rendr shot.toml").says(2, &["rendr", "render"]);
    bench.run("render").says(2, &["<SHOT>"]);
    bench.render("--fames 1").says(2, &["--fames", "--frames"]);
}

#[test]
fn completions_for_four_shells() {
    let bench = Bench::new();
    for shell in ["bash", "zsh", "fish", "powershell"] {
        let script = bench.run(&format!("completions {shell}")).says(0, &[]).stdout;
        assert!(script.contains("overlay") && script.contains("pinwarp"), "{shell}");
    }
    bench.run("completions csh").says(2, &["csh", "possible values"]);
}

#[test]
fn the_manual_has_a_page_for_every_command() {
    let bench = Bench::new();
    let printed = bench.run("man").says(0, &[]).stdout;
    assert!(printed.contains(".TH pinwarp 1") && printed.contains("Exit codes"), "{printed}");
    let told = bench.run("man -o pages").says(0, &[]).stdout;
    let all = commands(&bench);
    assert!(told.contains(&format!("wrote {} pages into pages", all.len() + 1)), "{told}");
    for command in &all {
        let page = String::from_utf8(bench.read(&format!("pages/pinwarp-{command}.1"))).expect("text");
        assert!(page.contains(&format!(".TH pinwarp-{command} 1")), "{command}: {page}");
        assert!(printed.contains(&page), "{command} is not printed");
    }
    assert!(String::from_utf8(bench.read("pages/pinwarp-render.1")).expect("text").contains("\\-\\-overlay"));
}

#[test]
#[cfg(target_os = "linux")]
fn output_that_nobody_can_store_is_a_failure() {
    let bench = Bench::new();
    std::fs::write(
        bench.path("q.json"),
        r#"{ "dims": [4, 4], "vertices": [[0, 0], [1, 0], [1, 1], [0, 1]], "triangles": [[0, 1, 2], [0, 2, 3]],
            "pins": [{ "vertex": 0, "target": [0.5, 0.25] }] }"#,
    )
    .expect("written");
    bench.render("-o in/b.####.exr").says(0, &[]);
    for arguments in [
        "render shot.toml --device cpu --json --frames 1",
        "warp in/b.####.exr --shot shot.toml --device cpu --json --frames 1 -o w.####.exr",
        "compare q.json --methods hsu --json",
    ] {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").expect("there is /dev/full");
        let mut command = std::process::Command::new(crate::support::PROGRAM);
        let ended = command.current_dir(bench.path("")).args(arguments.split(' ')).stdout(full).output();
        let ended = ended.expect("the program starts");
        let words = String::from_utf8_lossy(&ended.stderr).into_owned();
        assert_eq!(ended.status.code(), Some(1), "{arguments}: {words}");
        assert!(words.contains("cannot write to standard output") && words.contains("No space left"), "{words}");
    }
    assert_eq!(bench.frames(), ["f.0001.exr"], "the frame is rendered all the same");
    assert!(bench.path("w.0001.exr").exists());
}

#[test]
fn verbose_output_has_no_escape_codes() {
    // `checked` looks for them in every run.
    let bench = Bench::new();
    bench.render("-vv").says(0, &["busy: geometry"]);
    let mut command = bench.command(crate::support::PROGRAM);
    command.env("NO_COLOR", "1").args(["render", "nowhere.toml", "-v"]);
    bench.checked(command.output().expect("the program starts")).says(2, &["nowhere.toml"]);
}
