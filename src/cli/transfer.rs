//! `pinwarp transfer`: renders a shot whose layers take their lattices from a file. The shot is created for this
//! purpose.

use super::args::{FitKind, TransferArgs};
use super::outcome::Outcome;
use super::{outputs, render};
use crate::export::{LatticeFile, LatticeTrack, Track};
use crate::files::{TABLE_BYTES, read_text};
use crate::image::{FileKind, SequencePath, replace_text};
use crate::pipeline::path_between;
use crate::scene;
use crate::shot::{LayerSpace, Shot, Transfer, TransferFit};
use crate::solve::Topology;
use crate::space::ScreenPoint;
use crate::spelling;
use anyhow::{Context, bail};
use serde_json::Value;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Default height in pixels of frames that show a scene.
const LINES: f64 = 1080.0;

pub(super) fn run(args: &TransferArgs) -> anyhow::Result<Outcome> {
    let lattices = LatticeFile::read(&args.lattice)?;
    let fit = fit(args)?;
    let shot = match target(&args.onto)? {
        FileKind::Shot => onto_shot(args, &lattices, &fit)?,
        target => NewShot { args, lattices: &lattices, fit: &fit, target }.write()?,
    };
    render::draw(shot, &args.draw, args.landmarks.iter().map(PathBuf::from).collect())
}

/// Returns what the lattices are applied to.
fn target(path: &Path) -> anyhow::Result<FileKind> {
    let kind =
        FileKind::of(path).filter(|kind| !matches!(kind, FileKind::Json | FileKind::Csv)).with_context(|| {
            format!(
                "--onto {}: give a picture (.png, .jpg, .exr), a scene (.glb, .gltf) or a shot (.toml)",
                path.display()
            )
        })?;
    if matches!(kind, FileKind::Picture(_)) && SequencePath::of_input(path)?.has_counter() {
        bail!(
            "--onto {0}: pictures of a shot are single images, but this is a sequence; warp it with \
             `pinwarp warp {0} --lattice FILE`",
            path.display()
        );
    }
    if !path.is_file() {
        bail!("--onto {}: there is no such file; check the path for typing errors", path.display());
    }
    Ok(kind)
}

/// Returns how the lattices are placed, by the arguments.
fn fit(args: &TransferArgs) -> anyhow::Result<TransferFit> {
    match (args.fit, &args.landmarks) {
        (Some(FitKind::Landmarks) | None, Some(text)) => Ok(TransferFit::Landmarks(landmarks(text)?)),
        (Some(FitKind::Landmarks), None) => {
            bail!("--fit landmarks needs --landmarks: pairs of points [source, target]")
        }
        (Some(_), Some(_)) => bail!("--landmarks goes with --fit landmarks; leave one of them out"),
        (Some(FitKind::AsIs), None) => Ok(TransferFit::AsIs),
        (Some(FitKind::Box) | None, None) => Ok(TransferFit::Box),
    }
}

/// Parses pairs of points from the text itself, or from the file that it names.
fn landmarks(text: &str) -> anyhow::Result<Vec<[ScreenPoint; 2]>> {
    const WANTED: &str = "pairs of screen points [source, target] are needed: [[[0.5,0.5],[0.9,0.4]]]";
    let is_inline = text.trim_start().starts_with('[');
    let json = if is_inline {
        text.to_owned()
    } else {
        read_text(Path::new(text), TABLE_BYTES).with_context(|| format!("--landmarks: cannot read {text}"))?
    };
    let pairs: Vec<[[f64; 2]; 2]> = serde_json::from_str(&json).with_context(|| format!("--landmarks: {WANTED}"))?;
    if pairs.is_empty() || pairs.iter().flatten().flatten().any(|number| !number.is_finite()) {
        bail!("--landmarks: {WANTED}");
    }
    Ok(pairs.into_iter().map(|pair| pair.map(|[x, y]| ScreenPoint::new(x, y))).collect())
}

/// Returns the requested track, else the one with the target layer's name, else the only one.
fn track<'a>(args: &TransferArgs, file: &'a LatticeFile, layer: Option<&str>) -> anyhow::Result<&'a LatticeTrack> {
    let names = || file.layers.iter().map(|layer| layer.name.as_str());
    let named = |name: &str| file.layers.iter().find(|track| track.name == name);
    let path = args.lattice.display();
    let found = match (&args.layer, file.layers.as_slice()) {
        (Some(name), _) => {
            named(name).with_context(|| format!("{path} has no layer '{name}'; {}", spelling::hint(name, names())))?
        }
        (None, [only]) => only,
        (None, _) => layer.and_then(named).with_context(|| {
            format!("{path} has {} layers; choose one with --layer: {}", file.layers.len(), spelling::list(names()))
        })?,
    };
    match found.track {
        Track::Screen(_) => Ok(found),
        Track::World(_) => bail!(
            "'{}' of {path} is a lattice of the scene; only lattices of the screen can be laid over something else",
            found.name
        ),
    }
}

/// Applies the lattices to another shot: they replace the pins of its screen-space layers.
fn onto_shot(args: &TransferArgs, file: &LatticeFile, fit: &TransferFit) -> anyhow::Result<Shot> {
    if args.shot.is_some() {
        bail!("--shot names the file to write for a picture or a scene; {} is a shot already", args.onto.display());
    }
    let mut shot = Shot::read(&args.onto)?;
    let is_screen = |space: &LayerSpace| matches!(space, LayerSpace::Screen { .. });
    if !shot.layers.iter().any(|layer| is_screen(&layer.space)) {
        bail!("{} has no layers on the screen that lattices could move; add a [[layer]]", args.onto.display());
    }
    for layer in shot.layers.iter_mut().filter(|layer| is_screen(&layer.space)) {
        let track = track(args, file, Some(&layer.name))?;
        let name = track.name.clone();
        if !track.branches.is_empty() {
            layer.settings.topology = Topology::Branching;
        }
        layer.transfer =
            Some(Transfer { file: args.lattice.clone(), layer: Some(name), fit: fit.clone(), start: None });
        (layer.pins, layer.handles, layer.stiffness, layer.strokes) = Default::default();
        layer.strength *= args.strength;
    }
    Ok(shot)
}

/// A shot for a picture or a scene to which lattices are applied.
struct NewShot<'a> {
    args: &'a TransferArgs,
    lattices: &'a LatticeFile,
    fit: &'a TransferFit,
    target: FileKind,
}

impl NewShot<'_> {
    /// Makes the shot, and writes its file where one is wanted.
    fn write(&self) -> anyhow::Result<Shot> {
        let track = track(self.args, self.lattices, None)?;
        let path = self.path()?;
        if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
            std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
        }
        let text = self.text(track, &path)?;
        let shot = Shot::parse(&text, &path)?;
        if self.args.shot.is_some() || self.target == FileKind::Scene {
            self.write_text(&path, &text)?;
        }
        Ok(shot)
    }

    /// Writes the file, unless it already holds the text; fails if another file may not be replaced.
    fn write_text(&self, path: &Path, text: &str) -> anyhow::Result<()> {
        let args = self.args;
        let mut inputs = outputs::inputs_of([&args.lattice, &args.onto]);
        args.landmarks.iter().for_each(|landmarks| inputs.add(Path::new(landmarks)));
        if self.target == FileKind::Scene {
            scene::load(&args.onto)?.files_beside.iter().for_each(|file| inputs.add(file));
        }
        outputs::allow_text(&inputs, (path, text), args.draw.existing)?;
        if !outputs::holds_text(path, text) {
            replace_text(path, text)?;
            writeln!(std::io::stderr(), "note: wrote {}", path.display())?;
        }
        Ok(())
    }

    /// Returns the path of the shot, whether it exists or not.
    fn path(&self) -> anyhow::Result<PathBuf> {
        let own = self.args.onto.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Ok(match (&self.args.shot, &self.args.draw.output, self.target) {
            (Some(path), ..) => path.clone(),
            (None, Some(output), FileKind::Scene) => {
                let stem = SequencePath::parse(output)?.stem();
                output.with_file_name(format!("{}.toml", if stem.is_empty() { own } else { stem }))
            }
            _ => PathBuf::from(format!("{own}.toml")),
        })
    }

    /// Returns the text of the shot, which has one layer.
    fn text(&self, track: &LatticeTrack, path: &Path) -> anyhow::Result<String> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let from_here = |file: &Path| Ok::<_, anyhow::Error>(quoted(outputs::as_text(&path_between(folder, file)?)?));
        let frames = match &track.track {
            Track::Screen(lattices) => {
                [lattices.keys().next(), lattices.keys().next_back()].map(|frame| frame.copied())
            }
            Track::World(_) => [None; 2],
        };
        let [first, last] = frames.map(Option::unwrap_or_default);
        let (key, size) = match self.target {
            FileKind::Picture(_) => ("image", String::new()),
            _ => ("scene", format!("size    = [{}, {LINES}]\n", (self.lattices.frame_aspect * LINES).round())),
        };
        let topology = if track.branches.is_empty() { "" } else { "lattice  = { topology = \"branching\" }\n" };
        let channels = if key == "image" { "channels = [\"beauty\", \"id\"]\n" } else { "" };
        Ok(format!(
            "# Lattices of another shot, laid over {what}.\nversion = 1\n{key}   = {what}\n\
             frames  = {{ first = {first}, last = {last}, rate = {rate:?} }}\n{size}\n\
             [[layer]]\nname     = {name}\nstrength = {strength:?}\n\
             transfer = {{ lattice = {lattice}, layer = {name}, fit = {fit} }}\n{topology}\n[output]\n{channels}",
            what = from_here(&self.args.onto)?,
            rate = self.lattices.rate,
            name = quoted(&track.name),
            strength = self.args.strength,
            lattice = from_here(&self.args.lattice)?,
            fit = fit_text(self.fit),
        ))
    }
}

fn fit_text(fit: &TransferFit) -> String {
    match fit {
        TransferFit::Box => "\"box\"".to_owned(),
        TransferFit::AsIs => "\"as-is\"".to_owned(),
        TransferFit::Landmarks(pairs) => {
            let pair = |pair: &[ScreenPoint; 2]| {
                let [a, b] = pair.map(|point| format!("[{:?}, {:?}]", point.0.x, point.0.y));
                format!("[{a}, {b}]")
            };
            format!("{{ landmarks = [{}] }}", pairs.iter().map(pair).collect::<Vec<_>>().join(", "))
        }
    }
}

/// Quotes a text for TOML, by JSON's escapes, which are valid in TOML.
fn quoted(text: &str) -> String {
    Value::from(text).to_string()
}
