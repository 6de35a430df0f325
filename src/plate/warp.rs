//! A finished frame, warped channel by channel.
//!
//! In: a plate, the fields of its layers, mattes, rules. Out: the warped plate and a report of what was done.

use super::canvas::{Canvas, Mover, find_maps, find_windows, give_map, settle_windows};
use super::contents::Contents;
use super::draw::Drawing;
use super::fill::Filling;
use super::map_view::Direction;
use super::resampler::{Resampler, Tools};
use super::{ChannelReport, Field, Matte, Meaning, PlateError, PlateReport, WarpMap, WarpRules};
use crate::image::Plate;
use crate::space::PixelRect;
use crate::spelling;
use std::sync::Arc;

/// What a plate's warp needs beside the plate.
#[derive(Clone, Debug)]
pub struct PlateJob<'a> {
    /// In the shot's order: later ones lie in front. Layers without a matte bend everything that lies below them too.
    pub layers: Vec<LayerJob>,
    /// Filter, meanings, motion.
    pub rules: &'a WarpRules,
    /// What is seen where a layer moved away: channels of the same names, over the same display window.
    pub fill: Option<&'a Plate>,
}

/// One layer of a plate at one frame.
#[derive(Clone, Debug)]
pub struct LayerJob {
    /// Its name in the shot, for messages.
    pub name: String,
    /// Where it goes.
    pub field: Field,
    /// Where it goes in the frame before; `None`: as in this one. Backward motion needs it.
    pub previous: Option<Field>,
    /// Where it goes in the next frame; `None`: as in this one. Forward motion needs it.
    pub next: Option<Field>,
    /// The part of the plate that it moves; `None`: the whole picture.
    pub matte: Option<Matte>,
}

/// Whether a plate holds motion vectors, so that the fields of neighbour frames are needed.
#[must_use]
pub fn has_motion(plate: &Plate, rules: &WarpRules) -> bool {
    has_any(plate, rules, &[Meaning::Forward, Meaning::Backward])
}

/// Whether a plate holds Cryptomattes, so that what fills its holes needs some too.
#[must_use]
pub fn has_cryptomattes(plate: &Plate, rules: &WarpRules) -> bool {
    has_any(plate, rules, &[Meaning::Cryptomatte])
}

fn has_any(plate: &Plate, rules: &WarpRules, meanings: &[Meaning]) -> bool {
    let contents = Contents::of(plate, &rules.meanings);
    contents.entries.iter().any(|entry| meanings.contains(&entry.known.meaning))
}

/// Checks what the head of a plate tells, before anything is warped: that it has what mattes (with the names of their
/// layers) ask for. No samples are needed. Gives back what the user should know.
///
/// # Errors
/// [`PlateError`] as [`warp_plate`] would give it.
pub fn check_plate(head: &Plate, mattes: &[(&str, &Matte)], rules: &WarpRules) -> Result<Vec<String>, PlateError> {
    let contents = Contents::of(head, &rules.meanings);
    mattes.iter().try_for_each(|(layer, matte)| contents.check_matte(layer, matte))?;
    let names = || contents.entries.iter().map(|entry| entry.name.full.as_str());
    let note = |pattern: String| {
        let hint = spelling::hint(&pattern, names());
        format!("[[warp.channels]]: no channel of the plate fits '{pattern}'; {hint}")
    };
    Ok(contents.idle_patterns(&rules.meanings).into_iter().map(note).collect())
}

/// What every channel of a plate is taken for, in the order of parts and channels. No samples are needed.
#[must_use]
pub fn channel_meanings(head: &Plate, rules: &WarpRules) -> Vec<ChannelReport> {
    Contents::of(head, &rules.meanings).entries.iter().map(|entry| entry.report(head)).collect()
}

/// Warps plates one after the other, and uses memory again.
#[derive(Default)]
pub struct Warper {
    tools: Tools,
}

impl Warper {
    /// A warper whose colour is resampled by a device, not by the kernels of this stage.
    #[must_use]
    pub fn on(device: Box<dyn Resampler>) -> Self {
        Self { tools: Tools::with_device(Some(device)) }
    }

    /// What resamples, where it is not the CPU; `None` too from the moment on when a device failed.
    #[must_use]
    pub fn device(&self) -> Option<String> {
        self.tools.device()
    }

    /// Takes a plate that is not needed any more: the next result lies in its memory.
    pub fn recycle(&self, plate: Plate) {
        self.tools.keep(plate);
    }

    /// As [`warp_plate`].
    ///
    /// # Errors
    /// As [`warp_plate`].
    pub fn warp(&self, plate: &Plate, job: &PlateJob) -> Result<(Plate, PlateReport), PlateError> {
        let contents = Contents::of(plate, &job.rules.meanings);
        let movers = Mover::all_of(job);
        let mut canvases = Canvas::all_of(&contents);
        for canvas in &mut canvases {
            canvas.share_out(&contents, &movers)?;
        }
        find_windows(&mut canvases, plate.frame_size(), &movers);
        find_maps(&mut canvases, plate.frame_size(), &movers);
        let filling = job.fill.map(|fill| Filling::of(fill, plate));
        let tools = &self.tools;
        let drawing = Drawing { contents: &contents, rules: job.rules, movers: Some(&movers), filling, tools };
        let (mut warped, report) = drawn(&drawing, &canvases, PlateReport::default());
        drawing.filling.iter().for_each(|filling| filling.add_names(&mut warped));
        Ok((warped, report))
    }

    /// As [`undo_plate`].
    ///
    /// # Errors
    /// As [`undo_plate`].
    pub fn undo(&self, plate: &Plate, job: &PlateJob, reach: PixelRect) -> Result<(Plate, PlateReport), PlateError> {
        let whole = Mover::all_of(job).swap_remove(0);
        let map = WarpMap::forward(&whole.now, plate.frame_size(), reach);
        let undone = Mover { course: Direction::Backward, ..whole };
        self.remapped(plate, &map, (job.rules, Some(&[undone])))
    }

    /// As [`remap_plate`].
    ///
    /// # Errors
    /// As [`remap_plate`].
    pub fn remap(&self, plate: &Plate, map: &WarpMap, rules: &WarpRules) -> Result<(Plate, PlateReport), PlateError> {
        self.remapped(plate, map, (rules, None))
    }

    fn remapped(
        &self,
        plate: &Plate,
        map: &WarpMap,
        (rules, movers): (&WarpRules, Option<&[Mover]>),
    ) -> Result<(Plate, PlateReport), PlateError> {
        let frame = plate.frame_size();
        if (frame.width, frame.height) != (map.frame.width, map.frame.height) {
            let (map, plate) = ([map.frame.width, map.frame.height], [frame.width, frame.height]);
            return Err(PlateError::WrongMap { map, plate });
        }
        let contents = Contents::of(plate, &rules.meanings);
        let mut canvases = Canvas::all_of(&contents);
        for canvas in &mut canvases {
            canvas.share_out(&contents, &[])?;
            canvas.window = canvas.window_under(map);
        }
        settle_windows(&mut canvases);
        give_map(&mut canvases, 0, &Arc::new(map.clone()));
        let mut report = PlateReport::default();
        if canvases.iter().any(|canvas| canvas.source.intersection(map.window) != canvas.source) {
            let what = "the map does not reach as far as the plate: what lies outside it is left out";
            report.warnings.push(format!("{what}; make the map with the plate's overscan"));
        }
        let drawing = Drawing { contents: &contents, rules, movers, filling: None, tools: &self.tools };
        Ok(drawn(&drawing, &canvases, report))
    }
}

/// What is drawn, and all that is to be told of it.
fn drawn(drawing: &Drawing, canvases: &[Canvas], mut report: PlateReport) -> (Plate, PlateReport) {
    let plate = drawing.draw(canvases, &mut report);
    report.warnings.extend(drawing.tools.take_warnings());
    (plate, report)
}

/// Warps a plate: every part and channel by its meaning, layer over layer. Windows, attributes and the order of
/// everything stay; data windows grow and shrink with the picture, unless the plate fills its frame.
///
/// # Errors
/// [`PlateError`] where a matte names something that the plate does not have.
pub fn warp_plate(plate: &Plate, job: &PlateJob) -> Result<(Plate, PlateReport), PlateError> {
    Warper::default().warp(plate, job)
}

/// Undoes the warp of a plate by the layers of a job, which have no mattes, where it is one-to-one: motion vectors too.
/// `reach`: the pixels of the result, from the upper left corner of the display window.
///
/// # Errors
/// None but those of [`remap_plate`].
pub fn undo_plate(plate: &Plate, job: &PlateJob, reach: PixelRect) -> Result<(Plate, PlateReport), PlateError> {
    Warper::default().undo(plate, job, reach)
}

/// Warps a plate by a map alone. Nothing tells how the map goes on in time, so motion vectors keep their values.
///
/// # Errors
/// [`PlateError::WrongMap`] where the map was made for another frame.
pub fn remap_plate(plate: &Plate, map: &WarpMap, rules: &WarpRules) -> Result<(Plate, PlateReport), PlateError> {
    Warper::default().remap(plate, map, rules)
}
