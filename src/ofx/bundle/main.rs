//! Builds `PinWarp.ofx.bundle`, the folder that OpenFX hosts load, and checks its contents: `cargo run --release
//! --example make_bundle -- -o FOLDER [--target TRIPLE[.GLIBC]]`
//!
//! In: this package's sources. Out: a bundle in FOLDER; libraries for other systems already in it are kept. A target
//! with a glibc version (`x86_64-unknown-linux-gnu.2.28`, that of Rocky Linux 8) is built by `cargo-zigbuild`, to run
//! on older systems.

mod elf;

use anyhow::{Context as _, bail, ensure};
use elf::Elf;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The symbols that hosts look up; the library may export no others.
const EXPORTS: [&str; 3] = ["OfxGetNumberOfPlugins", "OfxGetPlugin", "OfxSetHost"];
/// Libraries present on every Linux with glibc.
const SYSTEM: [&str; 7] =
    ["ld-linux-x86-64.so.2", "libc.so.6", "libdl.so.2", "libgcc_s.so.1", "libm.so.6", "libpthread.so.0", "librt.so.1"];

/// A platform: the name of its folder in the bundle, and the file name of Rust's library for it.
type Place = (&'static str, &'static str);

/// The command-line options.
struct Options {
    /// The folder to write the bundle to.
    folder: PathBuf,
    /// Rust's target triple; empty: this machine.
    triple: String,
    /// Newest glibc version that the library may need.
    glibc: Option<[u32; 2]>,
}

impl Options {
    fn parse(mut args: impl Iterator<Item = String>) -> anyhow::Result<Self> {
        let mut options = Self { folder: PathBuf::from("target"), triple: String::new(), glibc: None };
        while let Some(arg) = args.next() {
            let value = args.next().with_context(|| format!("{arg} needs a value"))?;
            match arg.as_str() {
                "-o" => options.folder = PathBuf::from(value),
                "--target" => (options.triple, options.glibc) = target(&value)?,
                _ => bail!("{arg} is unknown; use -o FOLDER and --target TRIPLE[.GLIBC]"),
            }
        }
        Ok(options)
    }
}

/// Splits `x86_64-unknown-linux-gnu.2.28` into triple and glibc version.
fn target(value: &str) -> anyhow::Result<(String, Option<[u32; 2]>)> {
    let Some((triple, version)) = value.split_once('.') else { return Ok((value.to_owned(), None)) };
    let glibc = elf::version(version).with_context(|| format!("{version} is not a glibc version such as 2.28"))?;
    Ok((triple.to_owned(), Some(glibc)))
}

/// Returns the platform of a target triple.
fn place(triple: &str) -> anyhow::Result<Place> {
    let named = if triple.is_empty() {
        format!("{}-{}", std::env::consts::ARCH, std::env::consts::OS)
    } else {
        triple.to_owned()
    };
    let is = |part: &str| named.contains(part);
    Ok(if is("x86_64") && is("linux") {
        ("Linux-x86-64", "libpinwarp.so")
    } else if is("apple") || is("macos") {
        ("MacOS", "libpinwarp.dylib")
    } else if is("x86_64") && is("windows") {
        ("Win64", "pinwarp.dll")
    } else {
        bail!("OpenFX names no folder for {named}; it knows Linux and Windows on x86-64, and macOS")
    })
}

/// Builds the library; returns its path.
fn build(options: &Options, library: &str) -> anyhow::Result<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from);
    let program = if options.glibc.is_some() {
        "cargo-zigbuild".into()
    } else {
        std::env::var("CARGO").unwrap_or("cargo".into())
    };
    let mut command = Command::new(&program);
    command.current_dir(root).args(["rustc", "--locked", "--release", "--lib", "--no-default-features"]);
    command.args(["--features", "ofx", "--crate-type", "cdylib"]);
    if !options.triple.is_empty() {
        let version = options.glibc.map(|[major, minor]| format!(".{major}.{minor}")).unwrap_or_default();
        command.arg("--target").arg(format!("{}{version}", options.triple));
    }
    command.env("CARGO_ENCODED_RUSTFLAGS", flags(&build_folders(root)));
    let status = command
        .status()
        .with_context(|| format!("{program} does not start; `pip install cargo-zigbuild ziglang` brings it"))?;
    ensure!(status.success(), "{program} failed");
    Ok(target.join(&options.triple).join("release").join(library))
}

/// Returns this machine's folders that compilers embed in libraries, longest first, with their replacements.
fn build_folders(root: &Path) -> Vec<(PathBuf, &'static str)> {
    let home = std::env::var_os("HOME").or_else(|| std::env::var_os("USERPROFILE")).map(PathBuf::from);
    let of = |name: &str, folder: &str| {
        std::env::var_os(name).map(PathBuf::from).or_else(|| Some(home.as_ref()?.join(folder)))
    };
    let folders = [
        (Some(root.to_owned()), "pinwarp"),
        (of("CARGO_HOME", ".cargo"), "cargo"),
        (of("RUSTUP_HOME", ".rustup"), "rustup"),
        (home.clone(), "home"),
    ];
    let is_long = |folder: &PathBuf| folder.components().count() > 1;
    let mut folders: Vec<_> =
        folders.into_iter().filter_map(|(folder, name)| Some((folder.filter(is_long)?, name))).collect();
    folders.sort_by_key(|(folder, _)| folder.as_os_str().len());
    // Of several matching prefixes, the compiler uses the one given last.
    folders
}

/// Returns the compiler flags: those already set, plus path remappings unless there are some. Separated as Cargo
/// expects.
fn flags(folders: &[(PathBuf, &str)]) -> String {
    let encoded = std::env::var("CARGO_ENCODED_RUSTFLAGS").ok();
    let plain =
        || std::env::var("RUSTFLAGS").ok().map(|flags| flags.split_whitespace().collect::<Vec<_>>().join(SPLIT));
    let own = encoded.or_else(plain).filter(|flags| !flags.is_empty());
    joined(own, folders)
}

/// Flags that already remap paths are left alone, so that nothing built with them is rebuilt.
fn joined(own: Option<String>, folders: &[(PathBuf, &str)]) -> String {
    if let Some(own) = own.as_ref().filter(|own| own.contains(REMAP)) {
        return own.clone();
    }
    let remap = |(folder, name): &(PathBuf, &str)| format!("{REMAP}={}={name}", folder.display());
    own.into_iter().chain(folders.iter().map(remap)).collect::<Vec<_>>().join(SPLIT)
}

/// The compiler's option that remaps path prefixes.
const REMAP: &str = "--remap-path-prefix";

/// Separator of flags in `CARGO_ENCODED_RUSTFLAGS`.
const SPLIT: &str = "\u{1f}";

/// Returns this machine's folders whose paths occur in a library.
fn named_folders(bytes: &[u8], folders: &[(PathBuf, &'static str)]) -> Vec<String> {
    let names = |folder: &Path| {
        let name = format!("{}{}", folder.display(), std::path::MAIN_SEPARATOR);
        bytes.windows(name.len()).any(|part| part == name.as_bytes())
    };
    let named = folders.iter().filter(|(folder, _)| names(folder));
    named.map(|(folder, _)| format!("it names {}, a folder of this machine", folder.display())).collect()
}

/// Returns every reason why the library would not load on another machine.
fn faults(library: &Elf, glibc: Option<[u32; 2]>) -> Vec<String> {
    let mut faults = Vec::new();
    if library.exports.iter().map(String::as_str).ne(EXPORTS) {
        faults.push(format!("it shows {:?}, where hosts need {EXPORTS:?} and nothing else", library.exports));
    }
    let foreign = library.needs.iter().filter(|name| !SYSTEM.contains(&name.as_str()));
    faults.extend(foreign.map(|name| format!("it needs {name}, which not every Linux has")));
    let newer = library.versions.iter().filter(|name| {
        let version = name.strip_prefix("GLIBC_").and_then(elf::version);
        matches!((version, glibc), (Some(version), Some(glibc)) if version > glibc)
    });
    faults.extend(newer.map(|name| format!("it needs {name}")));
    faults
}

/// Returns the `Info.plist` that macOS and openfx-runner require.
fn info() -> String {
    let entry = |key: &str, value: &str| format!("  <key>{key}</key>\n  <string>{value}</string>\n");
    let entries = [
        ("CFBundleDevelopmentRegion", "English"),
        ("CFBundleExecutable", "PinWarp.ofx"),
        ("CFBundleIdentifier", "io.github.pinwarp.ofx"),
        ("CFBundleInfoDictionaryVersion", "6.0"),
        ("CFBundleName", "PinWarp"),
        ("CFBundlePackageType", "BNDL"),
        ("CFBundleShortVersionString", env!("CARGO_PKG_VERSION")),
        ("CFBundleSignature", "????"),
        ("CFBundleVersion", env!("CARGO_PKG_VERSION")),
    ];
    let body: String = entries.iter().map(|(key, value)| entry(key, value)).collect();
    let kind =
        r#"<!DOCTYPE plist PUBLIC "-//Apple//DTD PLIST 1.0//EN" "http://www.apple.com/DTDs/PropertyList-1.0.dtd">"#;
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n{kind}\n<plist version=\"1.0\">\n<dict>\n{body}</dict>\n</plist>\n"
    )
}

fn main() -> anyhow::Result<()> {
    let options = Options::parse(std::env::args().skip(1))?;
    let (system, library) = place(&options.triple)?;
    let built = build(&options, library)?;
    let bytes = std::fs::read(&built).with_context(|| format!("reading {}", built.display()))?;
    let named = named_folders(&bytes, &build_folders(Path::new(env!("CARGO_MANIFEST_DIR"))));
    ensure!(named.is_empty(), "{}: {}", built.display(), named.join("; "));
    if library.ends_with(".so") {
        let elf = Elf::parse(&bytes).with_context(|| format!("{} is no ELF library", built.display()))?;
        let faults = faults(&elf, options.glibc);
        ensure!(faults.is_empty(), "{}: {}", built.display(), faults.join("; "));
        println!("shows {}; needs {}", elf.exports.join(", "), elf.needs.join(", "));
        println!("newest symbol of glibc: {}", elf.newest_glibc().map_or("none".into(), |[a, b]| format!("{a}.{b}")));
    } else {
        println!("not checked: exports and needs of {library} (only those of Linux are)");
    }
    let contents = options.folder.join("PinWarp.ofx.bundle").join("Contents");
    let place = contents.join(system);
    std::fs::create_dir_all(&place).with_context(|| format!("making {}", place.display()))?;
    std::fs::write(contents.join("Info.plist"), info()).context("writing Info.plist")?;
    let plugin = place.join("PinWarp.ofx");
    std::fs::write(&plugin, &bytes).with_context(|| format!("writing {}", plugin.display()))?;
    println!("{}: {} KiB", plugin.display(), bytes.len() >> 10);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plugin() -> Elf {
        Elf {
            exports: EXPORTS.map(str::to_owned).into(),
            needs: vec!["libc.so.6".into(), "libgcc_s.so.1".into()],
            versions: vec!["GLIBC_2.17".into(), "GCC_3.0".into()],
        }
    }

    #[test]
    fn a_good_library_passes_and_each_fault_is_found() {
        assert!(faults(&plugin(), Some([2, 28])).is_empty());
        let mut more = plugin();
        more.exports.push("rust_helper".into());
        assert!(faults(&more, None)[0].contains("rust_helper"));
        let foreign = Elf { needs: vec!["libGL.so.1".into()], ..plugin() };
        assert!(faults(&foreign, None)[0].contains("libGL.so.1"));
        let newer = Elf { versions: vec!["GLIBC_2.4".into(), "GLIBC_2.34".into()], ..plugin() };
        assert_eq!(faults(&newer, Some([2, 28])), ["it needs GLIBC_2.34"]);
    }

    #[test]
    fn folders_of_this_machine_are_found_and_given_other_names() {
        let folders = [(PathBuf::from("/home/me"), "home"), (PathBuf::from("/home/me/source"), "pinwarp")];
        assert!(named_folders(b"a pinwarp/src/lib.rs", &folders).is_empty());
        let named = named_folders(b"at /home/me/.cargo/registry/src/x.rs", &folders);
        assert!(named.len() == 1 && named[0].contains("/home/me"), "{named:?}");
        let flags = joined(None, &folders);
        let last = flags.split(SPLIT).last();
        assert_eq!(last, Some("--remap-path-prefix=/home/me/source=pinwarp"), "the last that fits is taken");
        assert_eq!(joined(Some("-Cx".into()), &folders).split(SPLIT).count(), 3);
        assert_eq!(joined(Some(flags.clone()), &folders), flags, "names that are given already");
        let own = build_folders(Path::new("/work/somewhere/deep"));
        assert!(own.iter().any(|(_, name)| *name == "pinwarp"), "{own:?}");
    }

    #[test]
    fn targets_are_split_and_placed() {
        let (triple, glibc) = target("x86_64-unknown-linux-gnu.2.28").expect("a target");
        assert_eq!((triple.as_str(), glibc), ("x86_64-unknown-linux-gnu", Some([2, 28])));
        assert!(target("x86_64-unknown-linux-gnu.two").is_err());
        assert_eq!(place(&triple).expect("known").0, "Linux-x86-64");
        assert_eq!(place("aarch64-apple-darwin").expect("known").0, "MacOS");
        assert_eq!(place("x86_64-pc-windows-msvc").expect("known"), ("Win64", "pinwarp.dll"));
        assert!(place("riscv64gc-unknown-linux-gnu").is_err());
    }

    #[test]
    #[cfg(all(target_os = "linux", target_arch = "x86_64"))]
    fn a_program_is_no_plugin() {
        let own = std::fs::read(std::env::current_exe().expect("it runs")).expect("readable");
        let elf = Elf::parse(&own).expect("an ELF file");
        assert!(elf.needs.iter().any(|name| name == "libc.so.6") && elf.newest_glibc() > Some([2, 2]));
        assert!(!faults(&elf, None).is_empty());
        assert!(Elf::parse(b"no ELF").is_none() && Elf::parse(&own[..100]).is_none());
    }
}
