//! `pinwarp new`: writes a shot file that can be rendered immediately.
//!
//! In: a scene or a picture. Out: commented TOML with its clips, cameras, nodes and size.

use super::args::NewArgs;
use super::outcome::Outcome;
use super::outputs;
use crate::image::replace_text;
use crate::pipeline::{NewShot, new_shot, path_between};
use crate::shot::template;
use std::io::Write;
use std::path::Path;

pub(super) fn run(args: &NewArgs) -> anyhow::Result<Outcome> {
    let mut inputs = outputs::inputs_of([&args.scene]);
    let NewShot { facts, warnings, files_beside, .. } = new_shot(&args.scene, args.outside.access())?;
    files_beside.iter().for_each(|file| inputs.add(file));
    outputs::allow(&inputs, &args.output, args.overwrite)?;
    let path = path_between(args.output.parent().unwrap_or(Path::new("")), &args.scene)?;
    let text = template::write(outputs::as_text(&path)?, &facts);
    replace_text(&args.output, &text)?;
    for warning in &warnings {
        writeln!(std::io::stderr(), "warning: {warning}")?;
    }
    writeln!(std::io::stdout(), "wrote {0}; next: pinwarp render {0} --frames 1 --preview", args.output.display())?;
    Ok(Outcome::Complete)
}
