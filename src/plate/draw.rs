//! A warped plate, put together: every channel of every canvas by its meaning.
//!
//! In: contents, canvases with sheets and maps, rules. Out: the plate, and the rest of the report.

use super::canvas::{Canvas, Mover};
use super::contents::{Contents, Entry, Place};
use super::cryptomatte::Ranks;
use super::fill::{Filling, add_behind};
use super::nearest::{Pick, copied};
use super::over::Overlay;
use super::resampler::{Resampling, Tools};
use super::{Filter, Meaning, Planes, PlateReport, WarpRules};
use crate::image::{Channel, EMPTY_DEPTH, Plate};
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

/// A share of a pixel that counts, as a hole or taken twice: half a step of an 8-bit picture.
pub(super) const HOLE: f32 = 0.5 / 255.0;

/// Samples of channels of the result.
pub(super) type Planned = BTreeMap<Place, Vec<f32>>;

/// What is drawn, and how.
pub(super) struct Drawing<'a> {
    pub(super) contents: &'a Contents<'a>,
    pub(super) rules: &'a WarpRules,
    /// `None` where a map alone is known.
    pub(super) movers: Option<&'a [Mover<'a>]>,
    pub(super) filling: Option<Filling<'a>>,
    pub(super) tools: &'a Tools,
}

/// What the channels of one canvas with one alpha share.
pub(super) struct Shared<'a> {
    entries: Vec<&'a Entry>,
    overlay: Overlay,
    pub(super) picks: Vec<Pick>,
}

impl Drawing<'_> {
    pub(super) fn draw(&self, canvases: &[Canvas], report: &mut PlateReport) -> Plate {
        self.contents.report(report);
        report.warnings.extend(self.filling.iter().filter_map(|filling| filling.refusal.clone()));
        report.warnings.extend(canvases.iter().find_map(|canvas| canvas.overlap.clone()));
        let mut planes = Planned::new();
        for canvas in canvases {
            let shares = canvas.sheets.iter().filter_map(|sheet| sheet.share.warning.clone());
            report.warnings.extend(shares);
            if report.folded_pixels == 0 {
                self.report_folds(canvas, report);
            }
            self.draw_canvas(canvas, &mut planes, report);
        }
        let mut seen = BTreeSet::new();
        report.warnings.retain(|warning| seen.insert(warning.clone()));
        self.put_together(canvases, planes)
    }

    fn draw_canvas(&self, canvas: &Canvas, planes: &mut Planned, report: &mut PlateReport) {
        let mut by_alpha: BTreeMap<Option<Place>, Vec<&Entry>> = BTreeMap::new();
        for entry in &canvas.entries {
            // Where all moves as one, nothing lies over anything.
            let alpha = entry.alpha.filter(|_| canvas.sheets.len() > 1);
            by_alpha.entry(alpha).or_default().push(entry);
        }
        for (place, entries) in by_alpha {
            let alpha = place.and_then(|place| self.alpha(place, canvas));
            let is_copied = |entry: &&Entry| !matches!(entry.known.meaning, Meaning::Color | Meaning::Alpha);
            let picks = if entries.iter().any(is_copied) { canvas.picks(alpha.as_deref()) } else { Vec::new() };
            let overlay = canvas.overlay(alpha.as_deref(), self.by(self.rules.filter));
            let shared = Shared { entries, overlay, picks };
            self.report_holes(&shared, report);
            self.draw_colors(canvas, &shared, planes, report);
            self.draw_data(canvas, &shared, planes);
            self.draw_mattes(canvas, &shared, planes);
            self.draw_vectors(canvas, &shared, planes, report);
        }
    }

    /// The coverage of a canvas's colour. One that is 0 everywhere tells nothing where nothing but the picture moves.
    fn alpha(&self, place: Place, canvas: &Canvas) -> Option<Cow<'_, [f32]>> {
        let alpha = self.contents.over(place, canvas.source, 0.0);
        let has_mattes = !canvas.matted_sheets().is_empty();
        (has_mattes || alpha.iter().any(|alpha| *alpha > 0.0)).then_some(alpha)
    }

    /// Counts the pixels of visible folds, and says which layers fold.
    fn report_folds(&self, canvas: &Canvas, report: &mut PlateReport) {
        let alpha = canvas.entries.iter().find_map(|entry| entry.alpha).and_then(|place| self.alpha(place, canvas));
        let Some(movers) = self.movers else { return };
        let mut all = BTreeSet::new();
        for (index, mover) in movers.iter().enumerate() {
            let folded = canvas.folded_pixels(index, alpha.as_deref());
            if !folded.is_empty() {
                let frame = self.contents.plate.frame_size();
                report.warnings.push(mover.fold_warning(folded.len(), (frame, canvas.window)));
            }
            all.extend(folded);
        }
        report.folded_pixels = all.len();
    }

    /// Counts the holes of the first view that has some, and tells which channels nothing fills.
    fn report_holes(&self, shared: &Shared, report: &mut PlateReport) {
        let holes = shared.overlay.holes.iter().flatten().filter(|hole| **hole > HOLE).count();
        if report.hole_pixels == 0 {
            report.hole_pixels = holes;
        }
        let Some(filling) = self.filling.as_ref().filter(|filling| holes > 0 && filling.refusal.is_none()) else {
            return;
        };
        let missing = shared.entries.iter().filter(|entry| filling.find(entry).is_none());
        let names: Vec<&str> = missing.map(|entry| entry.name.full.as_str()).collect();
        if !names.is_empty() {
            report.warnings.push(format!("what fills the holes has no {}: they stay empty there", names.join(", ")));
        }
        let is_ours = filling.plate().is_own_render() && !self.contents.plate.is_own_render();
        if is_ours && shared.of(&[Meaning::Normal]).into_iter().any(|entry| filling.find(entry).is_some()) {
            report.warnings.push("normals that fill the holes lie in scene space, y up, as the scene has them".into());
        }
    }

    fn draw_colors(&self, canvas: &Canvas, shared: &Shared, planes: &mut Planned, report: &mut PlateReport) {
        let entries = shared.of(&[Meaning::Color, Meaning::Alpha]);
        let sources: Vec<Cow<[f32]>> =
            entries.iter().map(|entry| Cow::Borrowed(&self.contents.channel(entry.place).samples[..])).collect();
        if canvas.sheets.iter().any(|sheet| sheet.map.is_some()) {
            let bad = Planes { window: canvas.source, planes: sources.iter().map(|plane| &plane[..]).collect() };
            let bad = bad.not_finite();
            report.contained_samples += bad.nan + bad.infinite;
        }
        let colors = canvas.colors(&sources, &shared.overlay, self.by(self.rules.filter));
        for (entry, mut color) in entries.into_iter().zip(colors) {
            if let Some((holes, filling)) =
                shared.overlay.holes.as_ref().zip(self.fill(entry, canvas, self.rules.filter))
            {
                add_behind(&mut color, holes, &filling);
            }
            planes.insert(entry.place, color);
        }
    }

    /// What fills holes in a channel.
    fn fill(&self, entry: &Entry, canvas: &Canvas, filter: Filter) -> Option<Vec<f32>> {
        let filling = self.filling.as_ref()?;
        Some(filling.seen(filling.find(entry)?.place, canvas, self.by(filter)))
    }

    fn draw_data(&self, canvas: &Canvas, shared: &Shared, planes: &mut Planned) {
        self.copy(&shared.of(&[Meaning::Depth, Meaning::Id, Meaning::Data, Meaning::Normal]), (canvas, shared), planes);
    }

    /// Samples of channels as they are, all together: what a pixel shows is the same in all of them.
    pub(super) fn copy(&self, entries: &[&Entry], (canvas, shared): (&Canvas, &Shared), planes: &mut Planned) {
        let empty = |entry: &Entry| if entry.known.meaning == Meaning::Depth { EMPTY_DEPTH } else { 0.0 };
        let source = |entry: &&Entry| (&self.contents.channel(entry.place).samples[..], empty(entry));
        let sources: Vec<(&[f32], f32)> = entries.iter().map(source).collect();
        let mut copies: Vec<_> = entries.iter().map(|_| self.tools.plane(shared.picks.len())).collect();
        copied(&shared.picks, canvas.window.width as usize, &sources, &mut copies);
        for (entry, mut plane) in entries.iter().zip(copies) {
            self.fill_picked(entry, canvas, shared, &mut plane);
            planes.insert(entry.place, plane);
        }
    }

    fn by(&self, filter: Filter) -> Resampling<'_> {
        Resampling { tools: self.tools, filter }
    }

    /// Puts what fills holes into a channel that is never blended. Vectors of whose units nothing is known are left out.
    pub(super) fn fill_picked(&self, entry: &Entry, canvas: &Canvas, shared: &Shared, plane: &mut [f32]) {
        let Some(filling) = &self.filling else { return };
        let Some(behind) = filling.find(entry) else { return };
        let is_motion = matches!(entry.known.meaning, Meaning::Forward | Meaning::Backward);
        if is_motion && !filling.is_stored_alike(behind, entry) {
            return;
        }
        let storage = self.contents.channel(entry.place).storage;
        let samples = plane.iter_mut().zip(&shared.picks).enumerate();
        samples.filter(|(_, (_, pick))| **pick == Pick::Hole).for_each(|(at, (sample, _))| {
            *sample = filling.nearest(behind.place, (canvas, at), storage).unwrap_or(*sample);
        });
    }

    fn draw_mattes(&self, canvas: &Canvas, shared: &Shared, planes: &mut Planned) {
        let entries = shared.of(&[Meaning::Cryptomatte]);
        for matte in self.contents.matte_layers(entries.iter().copied()) {
            let samples = |place: Place| &self.contents.channel(place).samples[..];
            let entry = |place: Place| entries.iter().find(|entry| entry.place == place);
            let filling = |place: Place| self.fill(entry(place)?, canvas, Filter::Nearest);
            let fillings = matte.ranks.iter().map(|rank| Some([filling(rank.id)?, filling(rank.coverage)?]));
            let ranks = Ranks {
                name: &matte.name,
                ranks: matte.ranks.iter().map(|rank| [samples(rank.id), samples(rank.coverage)]).collect(),
                filling: if shared.overlay.holes.is_some() { fillings.flatten().collect() } else { Vec::new() },
            };
            let matted = canvas.matted(&ranks, &shared.overlay, self.tools);
            for (rank, [ids, coverage]) in matte.ranks.iter().zip(matted) {
                planes.insert(rank.id, ids);
                planes.insert(rank.coverage, coverage);
            }
        }
        // Half a pair of ranks cannot be read: it stays data.
        let alone: Vec<&Entry> = entries.into_iter().filter(|entry| !planes.contains_key(&entry.place)).collect();
        self.copy(&alone, (canvas, shared), planes);
    }

    fn put_together(&self, canvases: &[Canvas], mut planes: Planned) -> Plate {
        let plate = self.contents.plate;
        let parts = plate.parts.iter().enumerate().map(|(part, stored)| {
            let source = plate.window_of(stored);
            let canvas = canvases.iter().find(|canvas| canvas.source == source);
            let window = canvas.map_or(stored.data_window, |canvas| canvas.window.placed_in(plate.display));
            let channels = stored.channels.iter().enumerate().map(|(channel, stored)| Channel {
                name: stored.name.clone(),
                storage: stored.storage,
                samples: planes.remove(&Place { part, channel }).expect("every channel has a meaning that is drawn"),
            });
            stored.with_channels(window, channels.collect())
        });
        plate.with_parts(parts.collect())
    }
}

impl<'a> Shared<'a> {
    pub(super) fn of(&self, meanings: &[Meaning]) -> Vec<&'a Entry> {
        self.entries.iter().copied().filter(|entry| meanings.contains(&entry.known.meaning)).collect()
    }
}
