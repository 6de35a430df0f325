//! Checks the output name of an export: its extension has to be that of the format.
//!
//! In: the arguments. Out: permission, or an error that gives the right name.

use super::source::Source;
use crate::cli::args::{ExportArgs, ExportFormat};
use crate::image::FileKind;
use anyhow::bail;
use std::path::{Path, PathBuf};

/// Extensions of this program's outputs, besides those that it reads.
const WRITTEN: [&str; 3] = ["nk", "py", "txt"];

/// Refuses an output whose extension is not that of the format. Names without an extension are used as they are.
pub(super) fn check(args: &ExportArgs) -> anyhow::Result<()> {
    let Some(right) = args.output.as_ref().and_then(|output| right_name(args.to, output)) else { return Ok(()) };
    let output = args.output.as_deref().unwrap_or(Path::new(""));
    // That the output is an input matters more than its name.
    if let Ok(source) = Source::open(args) {
        source.inputs(args)?.refuse(output)?;
    }
    let (shown, right) = (output.display(), right.display());
    let format = args.to.name();
    match extension_of(args.to) {
        Some(wanted) => bail!("-o {shown}: --to {format} writes .{wanted} files; name the output -o {right}"),
        None => bail!(
            "-o {shown}: --to {format} writes several files; give the start of their names without an extension, -o {right}"
        ),
    }
}

/// Returns the name that an output should have; `None` if it has it.
fn right_name(format: ExportFormat, output: &Path) -> Option<PathBuf> {
    let extension = output.extension().filter(|extension| !has_counter(Path::new(extension)))?;
    match extension_of(format) {
        Some(wanted) if extension.eq_ignore_ascii_case(wanted) => None,
        Some(wanted) => Some(with_extension(output, wanted)),
        None => has_known_extension(output).then(|| output.with_extension("")).filter(|stem| !has_counter(stem)),
    }
}

/// Whether a name has a frame counter, which is refused with a message of its own.
fn has_counter(path: &Path) -> bool {
    path.to_string_lossy().contains(['#', '%'])
}

/// Returns the extension of a format's file; `None` if the format writes several files, each with its own.
const fn extension_of(format: ExportFormat) -> Option<&'static str> {
    match format {
        ExportFormat::LatticeJson => Some("json"),
        ExportFormat::Stmap => Some("exr"),
        ExportFormat::Nuke => Some("nk"),
        ExportFormat::Blender => Some("py"),
        ExportFormat::Gltf => Some("glb"),
        ExportFormat::AfterEffects => None,
    }
}

/// Whether a name ends in the extension of a file that this program reads or writes; other dots belong to the name.
fn has_known_extension(path: &Path) -> bool {
    let is_written = |extension: &std::ffi::OsStr| WRITTEN.iter().any(|known| extension.eq_ignore_ascii_case(known));
    FileKind::of(path).is_some() || path.extension().is_some_and(is_written)
}

/// Returns the name with another extension, in place of its own if it has one.
fn with_extension(path: &Path, extension: &str) -> PathBuf {
    if has_known_extension(path) {
        return path.with_extension(extension);
    }
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".");
    name.push(extension);
    path.with_file_name(name)
}
