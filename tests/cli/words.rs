//! Help, man page, completions, usage errors, colours.

use crate::support::Bench;

#[test]
fn help_is_short_or_long() {
    let bench = Bench::new();
    let [short, long] = ["render -h", "render --help"].map(|arguments| bench.run(arguments).says(0, &[]).stdout);
    for word in ["Usage: pinwarp render", "--frames", "--scale", "--resume", "--overlay", "--json", "1-48x2,60"] {
        assert!(short.contains(word) && long.contains(word), "{word}");
    }
    let commands = bench.run("--help").says(0, &[]).stdout;
    for word in ["render", "new", "check", "pick", "solve", "devices", "Exit codes: 0 all good"] {
        assert!(commands.contains(word), "{word} is not in:\n{commands}");
    }
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
fn man_page() {
    let page = Bench::new().run("man").says(0, &[]).stdout;
    assert!(page.contains(".TH pinwarp 1") && page.contains("Exit codes"), "{page}");
}

#[test]
fn every_detail_is_told_without_escape_codes() {
    // `checked` looks for them in every run.
    let bench = Bench::new();
    bench.render("-vv").says(0, &["busy: geometry"]);
    let mut command = bench.command(crate::support::PROGRAM);
    command.env("NO_COLOR", "1").args(["render", "nowhere.toml", "-v"]);
    bench.checked(command.output().expect("the program starts")).says(2, &["nowhere.toml"]);
}
