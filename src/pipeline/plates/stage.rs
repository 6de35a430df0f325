//! Second stage of a warp: solves the lattices of a frame and warps its plate.
//!
//! In: [`Loaded`] frames. Out: [`Warped`] frames.

use super::default_mattes::{DefaultMattes, FoundMattes};
use super::fill::Filler;
use super::fronts::{Fronts, MovingGroup};
use super::headers::check_shape;
use super::plan::Plan;
use super::read::{Loaded, Pictures};
use super::shared_meshes::SharedMeshes;
use super::write::Warped;
use super::{PlateWarp, WarpDirection, WarpJob, WarpReport, whole_scene};
use crate::export::{LatticeTrack, Track, lattice_at};
use crate::image::Plate;
use crate::pipeline::draw::overlaps::crossing_note;
use crate::pipeline::evaluate::time_sample::ScreenWarp;
use crate::pipeline::{
    BranchPart, BranchView, Exposure, LayerNote, PipelineError, SampleInMotion, lattices_of_file, parts_of_file,
    warnings_of_layer,
};
use crate::plate::{
    Field, Holes, LayerJob, Matte, PlateJob, PlateReport, WarpSettings, Warper, check_fill, has_motion, map_of_stmap,
};
use crate::solve::Solution;
use crate::space::{FrameSize, FrameWindow};
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, SyncSender};
use std::time::Instant;

/// Warps frames.
pub(super) struct Stage<'a> {
    job: &'a WarpJob<'a>,
    plan: &'a Plan,
    filler: Option<Filler<'a>>,
    default_mattes: Option<DefaultMattes<'a>>,
    shared_meshes: Option<SharedMeshes<'a>>,
    fronts: Option<Fronts<'a>>,
    warper: Warper,
}

/// A layer and its warp; `None` where it is not moved.
struct MovedLayer {
    layer: usize,
    now: Option<ScreenWarp>,
    /// The warps in the previous and the next frame.
    around: Option<[Option<ScreenWarp>; 2]>,
}

impl MovedLayer {
    fn is_still(&self) -> bool {
        self.now.is_none() && self.around.iter().flatten().all(Option::is_none)
    }
}

/// Returns the parts that the branches of a track cut out of a plate; `None` if its lattice has no branches in that
/// frame. If a neighbouring frame has another number of branches, its parts are taken to be at rest relative to this
/// frame.
fn file_parts(
    track: &LatticeTrack,
    (frame, has_around): (i32, bool),
    strength: f64,
    size: FrameSize,
) -> Option<Vec<BranchPart>> {
    let Track::Screen(lattices) = &track.track else { return None };
    let of_frame = |frame: i32| {
        let (frame, branches) = track.branches_at(frame)?;
        let lattices = lattices_of_file(branches, &lattices.get(&frame)?.grid);
        Some((branches, lattices.iter().map(|lattice| lattice.with_strength(strength)).collect::<Vec<_>>()))
    };
    let (branches, lattices) = of_frame(frame)?;
    let beside = |frame: i32| {
        let other = of_frame(frame).filter(|(other, _)| other.list.len() == branches.list.len());
        other.map_or_else(|| lattices.clone(), |(_, lattices)| lattices)
    };
    let around = has_around.then(|| [beside(frame - 1), beside(frame + 1)]);
    Some(parts_of_file(branches, lattices, around, size))
}

impl<'a> Stage<'a> {
    pub(super) fn of(job: &'a WarpJob<'a>, plan: &'a Plan, warper: Warper) -> Self {
        let filler = match &job.warp {
            PlateWarp::Shot(prepared) if job.settings.holes == Holes::Geometry => {
                Filler::of(prepared, &job.device, &plan.layers)
            }
            _ => None,
        };
        let (mut default_mattes, mut shared_meshes, mut fronts) = (None, None, None);
        if let (PlateWarp::Shot(prepared), WarpDirection::Forward) = (&job.warp, job.direction) {
            shared_meshes = plan.shared.as_ref().map(|group| SharedMeshes::new(prepared, &job.device, group));
            let shared = shared_meshes.as_ref().map_or(&[][..], SharedMeshes::layers);
            let own: Vec<usize> = plan.layers.iter().filter(|layer| !shared.contains(layer)).copied().collect();
            default_mattes = DefaultMattes::of(prepared, &job.device, &own);
            let moves_nodes = |layer: &&usize| prepared.moves_own_nodes(**layer);
            let alone = own.iter().filter(moves_nodes).map(|&layer| MovingGroup { layer, nodes: None });
            let joined = plan.shared.iter().filter_map(|group| {
                Some(MovingGroup { layer: *group.layers.first()?, nodes: Some(group.nodes.clone()) })
            });
            fronts = Fronts::of(prepared, &plan.layers, alone.chain(joined).collect());
        }
        Self { job, plan, filler, default_mattes, shared_meshes, fronts, warper }
    }

    /// Warps all plates that arrive.
    pub(super) fn run(&mut self, loads: Receiver<Loaded>, warped: &SyncSender<Warped>) {
        for Loaded { frame, pictures, read_ms } in loads {
            let begun = Instant::now();
            let outcome = pictures.and_then(|pictures| {
                let warped = self.warp(frame, &pictures);
                self.warper.recycle(pictures.plate);
                warped.map(|warped| (warped, pictures.memory))
            });
            let outcome = outcome.map(|((plate, report, mattes), memory)| {
                let PlateReport { channels, uncovered_pixels, folded_pixels, contained_samples, warnings } = report;
                let is_filled = self.job.settings.holes != Holes::Leave;
                let [hole_pixels, filled_pixels] =
                    if is_filled { [0, uncovered_pixels] } else { [uncovered_pixels, 0] };
                let warp_ms = begun.elapsed().as_secs_f64() * 1e3;
                let report = WarpReport {
                    frame,
                    read_ms,
                    warp_ms,
                    device: self.warper.device().unwrap_or_else(|| "CPU".into()),
                    hole_pixels,
                    filled_pixels,
                    folded_pixels,
                    contained_samples,
                    channels,
                    mattes,
                    warnings,
                    notes: self.notes(frame),
                    ..WarpReport::default()
                };
                (plate, report, memory)
            });
            if warped.send(Warped { frame, outcome }).is_err() {
                return;
            }
        }
    }

    /// Returns the warped plate, the report, and the source of the mattes of layers that name none.
    fn warp(&mut self, frame: i32, pictures: &Pictures) -> Result<(Plate, PlateReport, String), PipelineError> {
        let Pictures { plate, clean, map, .. } = pictures;
        let size = plate.frame_size();
        check_shape(&self.job.warp, &self.plan.plate.path_of(frame), size)?;
        let settings = self.job.settings.in_pixels(size);
        if let Some(map) = map {
            return self.remapped(frame, [plate, map], &settings);
        }
        if let Some(clean) = clean {
            self.check_clean(frame, [clean, plate])?;
        }
        let moved = self.moved(frame, has_motion(plate, &settings))?;
        let found = match &mut self.default_mattes {
            Some(mattes) if !moved.is_empty() => mattes.at(frame, (plate, &settings))?,
            _ => FoundMattes::default(),
        };
        let mut layers: Vec<LayerJob> = Vec::with_capacity(moved.len());
        // The layer of the shot that each job belongs to.
        let mut layer_of_job = Vec::with_capacity(moved.len());
        let mut is_blended = false;
        for moved in moved {
            if let Some(meshes) = self.shared_meshes.as_mut().filter(|meshes| meshes.layers().contains(&moved.layer)) {
                if !std::mem::replace(&mut is_blended, true) {
                    layers.push(meshes.job(frame, (plate, &settings))?);
                    layer_of_job.extend(meshes.layers().first());
                }
                continue;
            }
            let layer = moved.layer;
            match self.parts(frame, &moved, size)? {
                Some(parts) => layers.extend(self.part_jobs(moved.layer, parts, &found)),
                None => layers.push(self.layer_job(moved, &found)),
            }
            layer_of_job.resize(layers.len(), layer);
        }
        if let Some(fronts) = self.fronts.as_mut().filter(|_| !layers.is_empty()) {
            let fronts = fronts.at(frame, FrameWindow { frame: size, window: size.window().union(plate.reach()) })?;
            layers.iter_mut().zip(&layer_of_job).for_each(|(job, layer)| job.front = fronts.get(layer).cloned());
        }
        if self.job.direction == WarpDirection::Inverse {
            let job = PlateJob { layers, settings: &settings, fill: None };
            let (warped, report) = self.warper.undo(plate, &job, plate.reach())?;
            return Ok((warped, report, found.source));
        }
        let drawn = self.filler.as_mut().map(|filler| filler.draw(frame, (plate, &settings))).transpose()?;
        let job = PlateJob { layers, settings: &settings, fill: clean.as_ref().or(drawn.as_ref()) };
        let (warped, mut report) = self.warper.warp(plate, &job)?;
        if let PlateWarp::Shot(prepared) = &self.job.warp {
            report.warnings.extend(whole_scene::warning(prepared, &layer_of_job, (frame, plate))?);
            let sample = prepared.mid_exposure(frame)?;
            let told = self.plan.layers.iter().flat_map(|&layer| warnings_of_layer(prepared, layer, &sample));
            report.warnings.extend(told);
        }
        Ok((warped, report, found.source))
    }

    /// Returns the notes about the layers of a frame that was warped.
    fn notes(&self, frame: i32) -> Vec<LayerNote> {
        let PlateWarp::Shot(prepared) = &self.job.warp else { return Vec::new() };
        let Ok(sample) = prepared.mid_exposure(frame) else { return Vec::new() };
        self.plan.layers.iter().filter_map(|&layer| crossing_note(prepared, layer, &sample)).collect()
    }

    /// Returns the plate warped by an STMap.
    fn remapped(
        &self,
        frame: i32,
        [plate, map]: [&Plate; 2],
        settings: &WarpSettings,
    ) -> Result<(Plate, PlateReport, String), PipelineError> {
        let named = |source| PipelineError::StMap { path: self.map_path(frame), source };
        let map = map_of_stmap(map).map_err(named)?;
        let (warped, mut report) = self.warper.remap(plate, &map, settings).map_err(named)?;
        let doubt = map.doubt().map(|why| {
            let name = self.map_path(frame).file_name().unwrap_or_default().to_string_lossy().into_owned();
            format!("\"{name}\" is probably not an STMap, since {why}; check --stmap")
        });
        report.warnings.extend(doubt);
        Ok((warped, report, String::new()))
    }

    /// Refuses a clean plate of another size than its plate, which the headers of the first and last frame do not show.
    fn check_clean(&self, frame: i32, [clean, plate]: [&Plate; 2]) -> Result<(), PipelineError> {
        let path = || self.plan.clean.as_ref().map(|clean| clean.path_of(frame)).unwrap_or_default();
        check_fill(clean, plate).map_err(|source| PipelineError::CleanPlate { path: path(), source })
    }

    fn map_path(&self, frame: i32) -> PathBuf {
        self.plan.maps.as_ref().map(|maps| maps.path_of(frame)).unwrap_or_default()
    }

    /// Returns the layers that move in a frame. The warps of the neighbouring frames are computed if the plate stores motion.
    fn moved(&self, frame: i32, has_motion: bool) -> Result<Vec<MovedLayer>, PipelineError> {
        let now = self.warps(frame)?;
        let around = if has_motion { Some([self.warps(frame - 1)?, self.warps(frame + 1)?]) } else { None };
        let layers = self.plan.layers.iter().zip(now).enumerate().map(|(place, (&layer, now))| {
            let around = around.as_ref().map(|around| around.each_ref().map(|warps| warps[place].clone()));
            MovedLayer { layer, now, around }
        });
        Ok(layers.filter(|layer| !layer.is_still()).collect())
    }

    /// Returns the parts of a layer whose lattice branches in a frame.
    fn parts(&self, frame: i32, moved: &MovedLayer, size: FrameSize) -> Result<Option<Vec<BranchPart>>, PipelineError> {
        let prepared = match &self.job.warp {
            PlateWarp::Shot(prepared) => prepared,
            PlateWarp::Lattices { file, strength, .. } => {
                return Ok(file_parts(&file.layers[moved.layer], (frame, moved.around.is_some()), *strength, size));
            }
            PlateWarp::Maps(_) => return Ok(None),
        };
        let now = prepared.mid_exposure(frame)?;
        let has_branches = |solution: &Solution<2>| solution.branches.is_some();
        if !now.layers[moved.layer].solution.as_ref().is_some_and(has_branches) {
            return Ok(None);
        }
        let around = match &moved.around {
            Some(_) => Some([prepared.mid_exposure(frame - 1)?, prepared.mid_exposure(frame + 1)?]),
            None => None,
        };
        let around = around.as_ref().map(|around| around.each_ref().map(|sample| &**sample));
        let view = BranchView { size, exposure: Exposure::Shutter };
        Ok(prepared.branch_parts(moved.layer, SampleInMotion { now: &now, around }, view))
    }

    /// Creates one job per part of a layer, from back to front.
    fn part_jobs(&self, layer: usize, parts: Vec<BranchPart>, found: &FoundMattes) -> Vec<LayerJob> {
        let (name, matte) = self.job.warp.layer(layer);
        let whole = matte.or_else(|| found.mattes.get(&layer)).unwrap_or(&Matte::Alpha);
        let job = |BranchPart { lattice, around, share, .. }: BranchPart| {
            let around =
                around.map(|around| around.map(|lattice| Some(lattice.map_or_else(Field::identity, Field::of_branch))));
            let [previous, next] = around.unwrap_or_default();
            let matte = Some(Matte::Part { of: Box::new(whole.clone()), share });
            LayerJob { name: name.to_owned(), field: Field::of_branch(lattice), previous, next, matte, front: None }
        };
        parts.into_iter().map(job).collect()
    }

    /// Creates the job of a layer.
    fn layer_job(&self, MovedLayer { layer, now, around }: MovedLayer, found: &FoundMattes) -> LayerJob {
        let (name, matte) = self.job.warp.layer(layer);
        let matte = matte.or_else(|| found.mattes.get(&layer)).cloned();
        let field = |warp: Option<ScreenWarp>| warp.map_or_else(Field::identity, |warp| warp.field(matte.is_none()));
        let [previous, next] = around.map_or([None, None], |around| around.map(|warp| Some(field(warp))));
        LayerJob { name: name.to_owned(), field: field(now), previous, next, matte: matte.clone(), front: None }
    }

    /// Returns the warp of each layer in a frame; `None` where it is not moved.
    fn warps(&self, frame: i32) -> Result<Vec<Option<ScreenWarp>>, PipelineError> {
        let layers = self.plan.layers.iter();
        match &self.job.warp {
            PlateWarp::Shot(prepared) => {
                let sample = prepared.mid_exposure(frame)?;
                Ok(layers.map(|&layer| sample.layers[layer].screen_warp()).collect())
            }
            PlateWarp::Lattices { file, strength, .. } => {
                let warp = |&layer: &usize| match &file.layers[layer].track {
                    Track::Screen(lattices) => {
                        let lattice = lattice_at(lattices, f64::from(frame)).with_strength(*strength);
                        Some(ScreenWarp::Lattice(lattice))
                    }
                    Track::World(_) => None,
                };
                Ok(layers.map(warp).collect())
            }
            PlateWarp::Maps(_) => Ok(Vec::new()),
        }
    }
}
