//! Warps a finished frame channel by channel.
//!
//! In: a plate, the fields of its layers, mattes, settings. Out: the warped plate and a report.

use super::channel_table::ChannelTable;
use super::compose::compose;
use super::composite::Composite;
use super::composite_layout::{
    assign_coverage, assign_map, assign_maps, assign_windows, composites, settle_windows, window_under,
};
use super::compositor::PlateCompositor;
use super::hole_filling::HoleFilling;
use super::matte::check_matte;
use super::moving_layer::MovingLayer;
use super::pixel_field::Direction;
use super::resampler::{ResampleContext, Resampler};
use super::visibility::assign_visibility;
use super::{ChannelReport, Matte, PlateError, PlateJob, PlateReport, Semantic, WarpMap, WarpSettings};
use crate::image::Plate;
use crate::space::PixelRect;
use crate::spelling;
use std::sync::Arc;

/// Whether a plate holds motion vectors, for which the fields of the neighbouring frames are needed.
#[must_use]
pub(crate) fn has_motion(plate: &Plate, settings: &WarpSettings) -> bool {
    has_any(plate, settings, &[Semantic::Forward, Semantic::Backward])
}

/// Whether a plate holds Cryptomattes, which a fill plate must then provide too.
#[must_use]
pub(crate) fn has_cryptomattes(plate: &Plate, settings: &WarpSettings) -> bool {
    has_any(plate, settings, &[Semantic::Cryptomatte])
}

fn has_any(plate: &Plate, settings: &WarpSettings, semantics: &[Semantic]) -> bool {
    let table = ChannelTable::of(plate, &settings.semantics);
    table.entries.iter().any(|entry| semantics.contains(&entry.class.semantic))
}

/// Checks from the header that a plate has what the mattes (given with the names of their layers) refer to; needs no
/// samples. Returns warnings for the user.
///
/// # Errors
/// [`PlateError`] in the cases in which [`warp_plate`] returns it.
pub(crate) fn check_plate(
    head: &Plate,
    mattes: &[(&str, &Matte)],
    settings: &WarpSettings,
) -> Result<Vec<String>, PlateError> {
    let table = ChannelTable::of(head, &settings.semantics);
    mattes.iter().try_for_each(|(layer, matte)| check_matte(&table, layer, matte))?;
    let names = || table.entries.iter().map(|entry| entry.name.full.as_str());
    let note = |pattern: String| {
        let hint = spelling::hint(&pattern, names());
        format!("[[warp.channels]]: no channel of the plate matches '{pattern}'; {hint}")
    };
    Ok(table.unmatched_patterns(&settings.semantics).into_iter().map(note).collect())
}

/// Returns the semantic of every channel of a plate, ordered by part and channel; needs no samples.
#[cfg_attr(not(any(test, feature = "cli")), expect(dead_code, reason = "only commands call it"))]
#[must_use]
pub(crate) fn channel_semantics(head: &Plate, settings: &WarpSettings) -> Vec<ChannelReport> {
    ChannelTable::of(head, &settings.semantics).entries.iter().map(|entry| entry.report(head)).collect()
}

/// Warps a sequence of plates and reuses memory between them.
#[derive(Default)]
pub(crate) struct Warper {
    context: ResampleContext,
}

impl Warper {
    /// Creates a warper that resamples colour on a device instead of on the CPU.
    #[must_use]
    pub(crate) fn on(device: Box<dyn Resampler>) -> Self {
        Self { context: ResampleContext::with_device(Some(device)) }
    }

    /// Returns the name of the resampling device; `None` for the CPU, including after the device has failed.
    #[must_use]
    pub(crate) fn device(&self) -> Option<String> {
        self.context.device()
    }

    /// Recycles a plate: the next result reuses its memory.
    pub(crate) fn recycle(&self, plate: Plate) {
        self.context.recycle(plate);
    }

    /// As [`warp_plate`].
    ///
    /// # Errors
    /// As [`warp_plate`].
    pub(crate) fn warp(&self, plate: &Plate, job: &PlateJob) -> Result<(Plate, PlateReport), PlateError> {
        let table = ChannelTable::of(plate, &job.settings.semantics);
        let moving_layers = MovingLayer::all_of(job);
        let mut composites = composites(&table);
        for composite in &mut composites {
            assign_coverage(composite, &table, &moving_layers)?;
        }
        assign_windows(&mut composites, plate.frame_size(), &moving_layers);
        assign_maps(&mut composites, plate.frame_size(), &moving_layers);
        assign_visibility(&mut composites, &moving_layers);
        let filling = job.fill.map(|fill| HoleFilling::of(fill, plate)).transpose()?;
        let compositor = PlateCompositor {
            table: &table,
            settings: job.settings,
            moving_layers: Some(&moving_layers),
            filling,
            context: &self.context,
        };
        let (mut warped, report) = composed(&compositor, &composites, PlateReport::default());
        compositor.filling.iter().for_each(|filling| filling.add_names(&mut warped));
        Ok((warped, report))
    }

    /// As [`undo_plate`].
    ///
    /// # Errors
    /// As [`undo_plate`].
    pub(crate) fn undo(
        &self,
        plate: &Plate,
        job: &PlateJob,
        reach: PixelRect,
    ) -> Result<(Plate, PlateReport), PlateError> {
        let whole = MovingLayer::all_of(job).swap_remove(0);
        let map = WarpMap::forward(&whole.now, plate.frame_size(), reach);
        let undone = MovingLayer { direction: Direction::Backward, ..whole };
        self.remapped(plate, &map, (job.settings, Some(&[undone])))
    }

    /// As [`remap_plate`].
    ///
    /// # Errors
    /// As [`remap_plate`].
    pub(crate) fn remap(
        &self,
        plate: &Plate,
        map: &WarpMap,
        settings: &WarpSettings,
    ) -> Result<(Plate, PlateReport), PlateError> {
        self.remapped(plate, map, (settings, None))
    }

    fn remapped(
        &self,
        plate: &Plate,
        map: &WarpMap,
        (settings, moving_layers): (&WarpSettings, Option<&[MovingLayer]>),
    ) -> Result<(Plate, PlateReport), PlateError> {
        let frame = plate.frame_size();
        if (frame.width, frame.height) != (map.frame.width, map.frame.height) {
            let (map, plate) = ([map.frame.width, map.frame.height], [frame.width, frame.height]);
            return Err(PlateError::WrongMap { map, plate });
        }
        let table = ChannelTable::of(plate, &settings.semantics);
        let mut composites = composites(&table);
        for composite in &mut composites {
            assign_coverage(composite, &table, &[])?;
            composite.window = window_under(composite, map);
        }
        settle_windows(&mut composites);
        assign_map(&mut composites, 0, &Arc::new(map.clone()));
        let mut report = PlateReport::default();
        if composites.iter().any(|composite| composite.source.intersection(map.window) != composite.source) {
            let what = "the map does not cover the whole plate: pixels outside it are dropped";
            report.warnings.push(format!("{what}; make the map with the plate's overscan"));
        }
        let compositor =
            PlateCompositor { table: &table, settings, moving_layers, filling: None, context: &self.context };
        Ok(composed(&compositor, &composites, report))
    }
}

/// Composes the plate and returns it with its full report.
fn composed(compositor: &PlateCompositor, composites: &[Composite], mut report: PlateReport) -> (Plate, PlateReport) {
    let plate = compose(compositor, composites, &mut report);
    report.warnings.extend(compositor.context.take_warnings());
    (plate, report)
}

/// Warps a plate: every part and channel by its semantic, composited layer by layer. Keeps display windows, attributes
/// and the order of parts and channels; data windows follow the picture, unless the plate fills its frame.
///
/// # Errors
/// [`PlateError`] if a matte refers to something that is not in the plate.
pub fn warp_plate(plate: &Plate, job: &PlateJob) -> Result<(Plate, PlateReport), PlateError> {
    Warper::default().warp(plate, job)
}

/// Undoes the warp of a plate by the unmatted layers of a job, including its motion vectors, where the warp is
/// one-to-one. `reach`: the window of the result, relative to the upper left corner of the display window.
///
/// # Errors
/// The errors of [`remap_plate`].
#[cfg(test)]
pub(crate) fn undo_plate(plate: &Plate, job: &PlateJob, reach: PixelRect) -> Result<(Plate, PlateReport), PlateError> {
    Warper::default().undo(plate, job, reach)
}

/// Warps a plate by a map. Since a map says nothing about other frames, motion vectors keep their values.
///
/// # Errors
/// [`PlateError::WrongMap`] if the map belongs to a frame of another size.
#[cfg(test)]
pub(crate) fn remap_plate(
    plate: &Plate,
    map: &WarpMap,
    settings: &WarpSettings,
) -> Result<(Plate, PlateReport), PlateError> {
    Warper::default().remap(plate, map, settings)
}
