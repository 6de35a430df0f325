//! `pinwarp fit`: fits the lattice that maps landmarks of one picture or pose to those of another.
//!
//! In: two pictures or shots and pairs of points. Out: a lattice file, and the residual of each landmark.

use super::args::FitArgs;
use super::outcome::Outcome;
use super::outputs;
use crate::export::{LandmarkUnit, Landmarks, LatticeFile, LatticeTrack, Track};
use crate::image::{FileKind, Inputs, read_any};
use crate::pipeline::{PreparedShot, Registration, input_files, layer_shape, picture_shape, register};
use crate::shot::Shot;
use crate::solve::Shape;
use crate::space::{FrameSize, FrameWindow, ImagePoint, ScreenPoint, ScreenVector};
use crate::spelling::{self, pluralised};
use anyhow::{Context, bail};
use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::Path;

/// Frames per second of a lattice file fitted to pictures.
const PICTURE_RATE: f64 = 24.0;

/// Residual in pixels above which a landmark is reported, with the reason.
const MISSED_PX: f64 = 0.05;

/// The shape that the lattice is fitted over.
struct Subject {
    shape: Shape<2>,
    size: FrameSize,
    frame: i32,
    rate: f64,
    /// The layer's name.
    name: String,
}

pub(super) fn run(args: &FitArgs) -> anyhow::Result<Outcome> {
    let mut inputs = outputs::inputs_of([&args.a, &args.b, &args.pairs]);
    outputs::allow(&inputs, &args.output, args.overwrite)?;
    let dims = <[usize; 2]>::try_from(args.dims.as_slice()).ok().with_context(|| {
        let given = pluralised(args.dims.len(), "number", "numbers");
        format!("--dims has {given}, a lattice of the screen has 2 axes")
    })?;
    let landmarks = Landmarks::read(&args.pairs)?;
    let subject = subject(args, &mut inputs)?;
    inputs.refuse(&args.output)?;
    let size_of_b = size_of(&args.b)?;
    check_inside(args, &landmarks, [subject.size, size_of_b])?;
    let pairs = pairs(&landmarks, subject.size, size_of_b);
    let found = register(&subject.shape, &pairs, dims, args.basis.unwrap_or_default())?;
    print(&landmarks, &found, subject.size)?;
    let lattices = BTreeMap::from([(subject.frame, found.lattice)]);
    let (placements, branches, wholes) = (BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
    let (name, track, has_branches_in_scene) = (subject.name, Track::Screen(lattices), false);
    let track = LatticeTrack { name, track, placements, branches, has_branches_in_scene, wholes };
    let file = LatticeFile { frame_aspect: subject.size.aspect(), rate: subject.rate, layers: vec![track] };
    file.write(&args.output)?;
    let output = args.output.display();
    let landmarks = pluralised(pairs.len(), "landmark", "landmarks");
    writeln!(io::stdout(), "wrote {output}: {} x {} handles, {landmarks}", dims[0], dims[1])?;
    writeln!(
        io::stdout(),
        "to apply it to a layer of a shot: transfer = {{ lattice = \"{output}\", fit = \"as-is\" }}"
    )?;
    Ok(Outcome::Complete)
}

/// Returns the shape of `A`: a layer of a shot or a scene at one frame, or a picture.
fn subject(args: &FitArgs, inputs: &mut Inputs) -> anyhow::Result<Subject> {
    match FileKind::of(&args.a) {
        Some(FileKind::Shot) => shot_subject(args.outside.read(&args.a)?, args, inputs),
        Some(FileKind::Scene) => {
            // Quoted as a JSON string, which is a valid TOML string.
            let scene = serde_json::to_string(&args.a.file_name().unwrap_or_default().to_string_lossy())?;
            let text = format!(
                "version = 1\nscene = {scene}\nframes = {{ first = 0, last = 0, rate = 24 }}\nsize = [1920, 1080]\n\
                 [[layer]]\nname = \"all\"\n"
            );
            shot_subject(args.outside.allow(Shot::parse(&text, &args.a)?), args, inputs)
        }
        _ => picture_subject(args),
    }
}

fn shot_subject(shot: Shot, args: &FitArgs, inputs: &mut Inputs) -> anyhow::Result<Subject> {
    let names: Vec<String> = shot.layers.iter().map(|layer| layer.name.clone()).collect();
    let layer = match &args.layer {
        Some(name) => names.iter().position(|other| other == name).with_context(|| {
            let hint = spelling::hint(name, names.iter().map(String::as_str));
            format!("{} has no layer '{name}'; {hint}", args.a.display())
        })?,
        None if names.len() == 1 => 0,
        None => bail!("{} has {} layers; choose one with --layer", args.a.display(), names.len()),
    };
    let frame = args.frame.unwrap_or(shot.frames.first);
    let (size, rate) = (shot.size, shot.frames.rate);
    let prepared = PreparedShot::new(shot)?;
    *inputs = input_files(&prepared)?;
    [&args.a, &args.b, &args.pairs].into_iter().for_each(|input| inputs.add(input));
    let shape = layer_shape(&prepared, layer, frame)?;
    if shape.triangles.is_empty() {
        bail!("nothing of layer '{}' is seen in frame {frame} of {}", names[layer], args.a.display());
    }
    Ok(Subject { shape, size, frame, rate, name: names[layer].clone() })
}

fn picture_subject(args: &FitArgs) -> anyhow::Result<Subject> {
    let plate = read_any(&args.a)?;
    let size = plate.frame_size();
    let Some(part) = plate.parts.first() else { bail!("{} holds no picture", args.a.display()) };
    let alpha = part.channels.iter().find(|channel| channel.name == "A").map(|channel| channel.samples.as_slice());
    let shape = picture_shape(&args.a, FrameWindow { frame: size, window: plate.window_of(part) }, alpha)?;
    let name = args.a.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Ok(Subject { shape, size, frame: args.frame.unwrap_or(1), rate: PICTURE_RATE, name })
}

/// Returns the size of `B`.
fn size_of(path: &Path) -> anyhow::Result<FrameSize> {
    if FileKind::of(path) == Some(FileKind::Shot) {
        return Ok(Shot::read(path)?.size);
    }
    Ok(read_any(path)?.frame_size())
}

/// Returns the pairs in A's screen space. B is scaled to the same height and centred on A.
fn pairs(landmarks: &Landmarks, a: FrameSize, b: FrameSize) -> Vec<[ScreenPoint; 2]> {
    let place = |size: FrameSize, [x, y]: [f64; 2]| match landmarks.unit {
        LandmarkUnit::Pixels => size.screen_from_image(ImagePoint::new(x, y)),
        LandmarkUnit::Frame => ScreenPoint::new(x, y),
    };
    let shift = ScreenVector::new(0.5 * (a.aspect() - b.aspect()), 0.0);
    landmarks.pairs.iter().map(|pair| [place(a, pair.a), place(b, pair.b) + shift]).collect()
}

/// Fails for landmarks more than a picture's extent outside their picture, and warns of others outside: usually the
/// unit is wrong.
fn check_inside(args: &FitArgs, landmarks: &Landmarks, sizes: [FrameSize; 2]) -> anyhow::Result<()> {
    for pair in &landmarks.pairs {
        for (point, size, path) in [(pair.a, sizes[0], &args.a), (pair.b, sizes[1], &args.b)] {
            let (extent, unit, other) = match landmarks.unit {
                LandmarkUnit::Pixels => ([f64::from(size.width), f64::from(size.height)], "pixels", "frame"),
                LandmarkUnit::Frame => ([size.aspect(), 1.0], "frame heights", "pixels"),
            };
            let outside =
                |reach: f64| (0..2).any(|k| point[k] < -reach * extent[k] || point[k] > (1.0 + reach) * extent[k]);
            let [x, y] = point;
            let what = format!(
                "landmark '{}' at {x},{y} lies outside of {}, which is {} x {} {unit} large",
                pair.name,
                path.display(),
                extent[0],
                extent[1]
            );
            if outside(1.0) {
                bail!("{}: {what}; correct it, or write unit = \"{other}\"", args.pairs.display());
            }
            if outside(0.0) {
                writeln!(io::stderr(), "warning: {what}")?;
            }
        }
    }
    Ok(())
}

/// Prints the residuals and folds.
fn print(landmarks: &Landmarks, found: &Registration, size: FrameSize) -> anyhow::Result<()> {
    let mut out = io::stdout().lock();
    let px = |length: f64| length * f64::from(size.height);
    for (pair, &residual) in landmarks.pairs.iter().zip(&found.residuals) {
        writeln!(out, "  {:<16} {:8.3} px off", pair.name, px(residual))?;
    }
    let name_of = |pin: usize| format!("'{}'", landmarks.pairs[pin].name);
    let missed = found.report.pin_residuals.iter().filter(|miss| px(miss.distance) > MISSED_PX);
    for miss in missed {
        let reason = miss.reason.words(name_of).replace("pin '", "'");
        writeln!(out, "warning: landmark {} is off: {reason}", name_of(miss.pin))?;
    }
    match found.report.folded_model_cells {
        0 => {}
        count => writeln!(
            out,
            "warning: {} over what is seen; look for landmarks that are swapped, or leave some out",
            pluralised(count, "cell folds", "cells fold")
        )?,
    }
    for warning in &found.report.warnings {
        writeln!(out, "warning: {warning}")?;
    }
    Ok(())
}
