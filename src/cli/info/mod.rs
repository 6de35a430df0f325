//! `pinwarp info`: describes the contents of a file.
//!
//! In: a scene, picture, shot or lattice file. Out: text, or one JSON object.

mod brief;
mod picture;
mod scene;

use super::Outcome;
use super::args::InfoArgs;
use crate::image::FileKind;
use anyhow::bail;
use serde::Serialize;
use std::io::{self, Write};

pub(super) fn run(args: &InfoArgs) -> anyhow::Result<Outcome> {
    match FileKind::of(&args.file) {
        Some(FileKind::Scene) => print(args, &scene::SceneInfo::read(&args.file, args.outside)?),
        Some(FileKind::Picture(_)) => print(args, &picture::PictureInfo::read(&args.file)?),
        Some(FileKind::Shot) => print(args, &brief::ShotInfo::read(&args.file)?),
        Some(FileKind::Json) => print(args, &brief::LatticeInfo::read(&args.file)?),
        _ => bail!(
            "{} is not a supported file; give a scene (.glb, .gltf), a picture (.exr, .png, .jpg), a shot (.toml) or \
             lattices (.json)",
            args.file.display()
        ),
    }
}

/// A description as lines of text.
trait Lines: Serialize {
    fn lines(&self) -> Vec<String>;
}

fn print(args: &InfoArgs, info: &impl Lines) -> anyhow::Result<Outcome> {
    let mut out = io::stdout().lock();
    if args.json {
        let text = serde_json::to_string(info)?;
        out.write_all(text.as_bytes())?;
        out.write_all(b"\n")?;
        return Ok(Outcome::Complete);
    }
    for line in info.lines() {
        writeln!(out, "{line}")?;
    }
    Ok(Outcome::Complete)
}
