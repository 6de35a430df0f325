//! `pinwarp export --to after-effects`: for each layer its unwarped element over transparent black, the displacement
//! maps that warp it, and the settings of the effect that applies them.

use super::maps::{Maps, check_frames, write_frames};
use super::source::{frames, is_on_screen, moved_layers};
use super::stmap::print_written;
use crate::cli::args::ExportArgs;
use crate::cli::outcome::Outcome;
use crate::cli::outputs;
use crate::export::gltf::glb;
use crate::export::{DisplacementNote, displacement, greatest_offset};
use crate::image::{SequencePath, replace_text, without_counter, write_codes};
use crate::pipeline::{BakeTimes, Event, PreparedShot, RenderOptions, input_files, render};
use crate::shot::{Shot, Source as ShotSource, digest};
use crate::spelling::pluralised;
use anyhow::{Context, bail};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// Maximum displacement of After Effects, in pixels.
const MAX_PX: u32 = 32_000;

pub(super) fn run(args: &ExportArgs) -> anyhow::Result<Outcome> {
    let stem = args.output.clone().unwrap_or_else(|| without_counter(&args.shot.with_extension("")));
    if stem.file_name().unwrap_or_default().to_string_lossy().contains(['#', '%']) {
        let stem = stem.display();
        bail!(
            "-o {stem}: this export writes several sequences; give the start of their names, without a frame counter"
        );
    }
    let (maps, prepared) = Maps::open_layers(args)?;
    // All outputs are checked before any is written.
    let warps =
        maps.iter().map(|(name, maps)| Displacement::of(args, &named(&stem, name), (maps, prepared.as_deref())));
    let warps = warps.collect::<anyhow::Result<Vec<_>>>()?;
    // A lattice file has no pictures, hence no elements.
    let elements = prepared.as_deref().map(|prepared| Element::all_of(args, prepared, &stem)).transpose()?;
    warps.iter().try_for_each(|warp| warp.write(args, prepared.as_deref()))?;
    let mut outcome = Outcome::Complete;
    for element in elements.into_iter().flatten() {
        if !element.write(args)? {
            outcome = Outcome::Partial;
        }
    }
    Ok(outcome)
}

/// Returns the stem of a layer's files; layer names are free text and need escaping.
fn named(stem: &Path, layer: &str) -> PathBuf {
    let plain: String = layer.chars().map(|c| if c.is_alphanumeric() || "-_".contains(c) { c } else { '_' }).collect();
    let mut name = stem.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{plain}"));
    stem.with_file_name(name)
}

fn with_ending(stem: &Path, ending: &str) -> PathBuf {
    let mut name = stem.file_name().unwrap_or_default().to_owned();
    name.push(ending);
    stem.with_file_name(name)
}

/// The displacement maps of a layer, and the note with their settings.
struct Displacement<'a> {
    maps: &'a Maps,
    pattern: PathBuf,
    /// The checked output files.
    sequence: SequencePath,
    note: DisplacementNote,
    note_path: PathBuf,
}

impl<'a> Displacement<'a> {
    /// Prepares a layer's maps; fails if an output may not be written.
    fn of(args: &ExportArgs, stem: &Path, (maps, prepared): (&'a Maps, Option<&PreparedShot>)) -> anyhow::Result<Self> {
        let frames = &maps.frames;
        // All frames share one scale, so the largest displacement of all frames must be known first.
        let mut drawings = prepared.map(|prepared| maps.drawings(prepared)).transpose()?;
        let mut farthest = 0.0_f64;
        for &frame in frames {
            farthest = farthest.max(greatest_offset(&maps.map(frame, drawings.as_mut())?));
        }
        let reach_px = farthest.ceil().max(1.0) as u32;
        if reach_px > MAX_PX {
            bail!("pixels come from up to {reach_px} pixels away, more than After Effects can displace ({MAX_PX})");
        }
        let pattern = with_ending(stem, &format!(".displacement_{reach_px}px.####.png"));
        let note = DisplacementNote {
            maps: pattern.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            reach_px,
            size: maps.pixels(),
            frames: [frames.first(), frames.last()].map(|frame| frame.copied().unwrap_or_default()),
            rate: maps.lattices.rate,
            state: digest(&frames.iter().map(|&frame| maps.digest(frame)).collect::<String>()),
        };
        let note_path = with_ending(stem, ".after-effects.txt");
        outputs::allow_text(&maps.inputs, (&note_path, &note.text()), args.existing)?;
        let sequence = check_frames(args, (&pattern, &maps.inputs), frames)?;
        Ok(Self { maps, pattern, sequence, note, note_path })
    }

    fn write(&self, args: &ExportArgs, prepared: Option<&PreparedShot>) -> anyhow::Result<()> {
        let mut drawings = prepared.map(|prepared| self.maps.drawings(prepared)).transpose()?;
        let Self { maps, pattern, sequence, note, note_path } = self;
        let reach = f64::from(note.reach_px);
        let written = write_frames(args, (maps, sequence), |path, metadata| {
            let map = maps.map(metadata.frame, drawings.as_mut())?;
            write_codes(path, maps.pixels(), &displacement(&map, reach), metadata)?;
            Ok(maps.fold_warning(&map))
        })?;
        replace_text(note_path, &note.text())?;
        print_written(pattern, &written)?;
        let step = reach / 32767.0;
        writeln!(io::stdout(), "wrote {}: max displacement {reach} px, steps of {step:.5} px", note_path.display())?;
        Ok(())
    }
}

/// A layer rendered alone, unwarped, over transparent black.
struct Element<'a> {
    prepared: &'a PreparedShot,
    layer: usize,
    pattern: PathBuf,
    frames: Vec<i32>,
}

impl<'a> Element<'a> {
    /// Prepares the elements of the selected layers; fails if an output may not be written.
    fn all_of(args: &ExportArgs, prepared: &'a PreparedShot, stem: &Path) -> anyhow::Result<Vec<Self>> {
        let frames = frames(args, prepared);
        let inputs = input_files(prepared)?;
        let mut elements = Vec::new();
        for layer in moved_layers(prepared).into_iter().filter(|&layer| is_on_screen(prepared, layer)) {
            let name = &prepared.shot.layers[layer].name;
            if !args.layer.is_empty() && !args.layer.contains(name) {
                continue;
            }
            let pattern = with_ending(&named(stem, name), ".element.####.exr");
            check_frames(args, (&pattern, &inputs), &frames)?;
            elements.push(Self { prepared, layer, pattern, frames: frames.clone() });
        }
        Ok(elements)
    }

    /// Renders the element; returns `false` if a frame failed.
    fn write(self, args: &ExportArgs) -> anyhow::Result<bool> {
        let Self { prepared, layer, pattern, frames } = self;
        let folder = tempfile::tempdir().context("cannot make a temporary folder for the layer's scene")?;
        let alone = match prepared.pictures_of(layer, pattern.clone())? {
            Some(alone) => alone,
            None => still_scene(prepared, layer, (&frames, folder.path(), &pattern))?,
        };
        let options = RenderOptions { frames, existing: args.existing.into(), ..RenderOptions::default() };
        let on_event = |event: Event| match event {
            Event::FrameFailed { frame, error } => tracing::error!("frame {frame}: {error}"),
            // The scene's notes were already shown when the shot was read, and the missing warp is intended here.
            Event::Note { text } if !alone.notes.contains(&text) => {
                tracing::warn!("layer '{}': {text}", prepared.shot.layers[layer].name);
            }
            _ => {}
        };
        let summary = render(&alone, &options, &AtomicBool::new(false), &on_event)?;
        let frames = pluralised(summary.rendered, "frame", "frames");
        writeln!(io::stdout(), "wrote {}: {frames}", pattern.display())?;
        Ok(summary.failed == 0)
    }
}

/// Writes a scene with the meshes of one layer to `folder`, and returns its shot.
fn still_scene(
    prepared: &PreparedShot,
    layer: usize,
    (frames, folder, pattern): (&[i32], &Path, &Path),
) -> anyhow::Result<PreparedShot> {
    let scene = folder.join("layer.glb");
    let mut packed = prepared.packed()?;
    prepared.hide_all_but(layer, &mut packed);
    // Only clip and camera are needed, as nothing is deformed. A looping clip is baked frame by frame.
    let baked_frames = if prepared.shot.is_looped { frames.to_vec() } else { vec![prepared.shot.frames.clip_start] };
    let baked = prepared.bake(&baked_frames, BakeTimes::Clip, |_| false, |_| {})?;
    crate::image::replace_bytes(&scene, &glb(packed, &baked)?)?;
    let mut shot = Shot { source: ShotSource::Scene(scene), layers: Vec::new(), clip: None, ..prepared.shot.clone() };
    shot.is_looped = false;
    pattern.clone_into(&mut shot.output.path);
    Ok(PreparedShot::new(shot)?)
}
