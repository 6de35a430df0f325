//! Second stage of a warp: solves the lattices of a frame and warps its plate.
//!
//! In: [`Loaded`] frames. Out: [`Warped`] ones.

use super::super::PipelineError;
use super::fill::Filler;
use super::heads::check_shape;
use super::plan::Plan;
use super::read::{Loaded, Pictures};
use super::write::Warped;
use super::{PlateWarp, WarpDirection, WarpJob, WarpReport};
use crate::export::{Track, lattice_at};
use crate::image::Plate;
use crate::lattice::ScreenLattice;
use crate::plate::{Field, Holes, LayerJob, PlateJob, PlateReport, Warper, has_motion, map_of_stmap};
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, SyncSender};
use std::time::Instant;

/// Warps frames.
pub(super) struct Stage<'a> {
    job: &'a WarpJob<'a>,
    plan: &'a Plan,
    filler: Option<Filler<'a>>,
    warper: Warper,
}

impl<'a> Stage<'a> {
    pub(super) fn of(job: &'a WarpJob<'a>, plan: &'a Plan, warper: Warper) -> Self {
        let filler = match &job.warp {
            PlateWarp::Shot(setup) if job.rules.holes == Holes::Geometry => {
                Filler::of(setup, &job.device, &plan.layers)
            }
            _ => None,
        };
        Self { job, plan, filler, warper }
    }

    /// Warps everything that arrives.
    pub(super) fn run(&mut self, loads: Receiver<Loaded>, warped: &SyncSender<Warped>) {
        for Loaded { frame, pictures, read_ms } in loads {
            let begun = Instant::now();
            let outcome = pictures.and_then(|pictures| {
                let warped = self.warp(frame, &pictures);
                self.warper.recycle(pictures.plate);
                warped.map(|warped| (warped, pictures.memory))
            });
            let outcome = outcome.map(|((plate, report), memory)| {
                let PlateReport { channels, hole_pixels, folded_pixels, contained_samples, warnings } = report;
                let warp_ms = begun.elapsed().as_secs_f64() * 1e3;
                let report = WarpReport {
                    frame,
                    read_ms,
                    warp_ms,
                    device: self.warper.device().unwrap_or_else(|| "CPU".into()),
                    hole_pixels,
                    folded_pixels,
                    contained_samples,
                    channels,
                    warnings,
                    ..WarpReport::default()
                };
                (plate, report, memory)
            });
            if warped.send(Warped { frame, outcome }).is_err() {
                return;
            }
        }
    }

    fn warp(&mut self, frame: i32, pictures: &Pictures) -> Result<(Plate, PlateReport), PipelineError> {
        let Pictures { plate, clean, map, .. } = pictures;
        let size = plate.frame_size();
        check_shape(&self.job.warp, &self.plan.plate.path_of(frame), size)?;
        let rules = self.job.rules.in_pixels(size);
        if let Some(map) = map {
            let warped = map_of_stmap(map).and_then(|map| self.warper.remap(plate, &map, &rules));
            return warped.map_err(|source| PipelineError::StMap { path: self.map_path(frame), source });
        }
        let layers = self.layers(frame, has_motion(plate, &rules))?;
        if self.job.direction == WarpDirection::Inverse {
            return Ok(self.warper.undo(plate, &PlateJob { layers, rules: &rules, fill: None }, plate.reach())?);
        }
        let drawn = self.filler.as_mut().map(|filler| filler.draw(frame, (plate, &rules))).transpose()?;
        let job = PlateJob { layers, rules: &rules, fill: clean.as_ref().or(drawn.as_ref()) };
        Ok(self.warper.warp(plate, &job)?)
    }

    fn map_path(&self, frame: i32) -> PathBuf {
        self.plan.maps.as_ref().map(|maps| maps.path_of(frame)).unwrap_or_default()
    }

    /// What warps a frame: one a layer that moves. The neighbours' lattices are looked at where motion is stored.
    fn layers(&self, frame: i32, has_motion: bool) -> Result<Vec<LayerJob>, PipelineError> {
        let at = |frame: i32| self.lattices(frame);
        let now = at(frame)?;
        let around = if has_motion { Some([at(frame - 1)?, at(frame + 1)?]) } else { None };
        let jobs = self.plan.layers.iter().zip(now).enumerate().filter_map(|(place, (&layer, lattice))| {
            let (name, matte) = self.job.warp.layer(layer);
            let field = |lattice: &ScreenLattice| match matte {
                Some(_) => Field::of_layer(lattice.clone()),
                None => Field::of_picture(lattice.clone()),
            };
            let beside = |side: usize| {
                around.as_ref().map(|around| around[side][place].as_ref().map_or_else(Field::identity, field))
            };
            let is_still = lattice.is_none()
                && around.as_ref().is_none_or(|around| around.iter().all(|layers| layers[place].is_none()));
            (!is_still).then(|| LayerJob {
                name: name.to_owned(),
                field: lattice.as_ref().map_or_else(Field::identity, field),
                previous: beside(0),
                next: beside(1),
                matte: matte.cloned(),
            })
        });
        Ok(jobs.collect())
    }

    /// The lattices of a frame: one a layer that warps; `None` where it is not moved.
    fn lattices(&self, frame: i32) -> Result<Vec<Option<ScreenLattice>>, PipelineError> {
        let layers = self.plan.layers.iter();
        match &self.job.warp {
            PlateWarp::Shot(setup) => {
                let moment = setup.exposed(frame)?;
                let lattice = |&layer: &usize| Some(moment.layers[layer].solution.as_ref()?.lattice.clone());
                Ok(layers.map(lattice).collect())
            }
            PlateWarp::Lattices { file, strength, .. } => {
                let lattice = |&layer: &usize| match &file.layers[layer].track {
                    Track::Screen(lattices) => Some(lattice_at(lattices, f64::from(frame)).with_strength(*strength)),
                    Track::World(_) => None,
                };
                Ok(layers.map(lattice).collect())
            }
            PlateWarp::Maps(_) => Ok(Vec::new()),
        }
    }
}
