//! Draws pictures: each is warped by its layer's lattice and composited over those behind it.
//!
//! In: a [`Gallery`] and solved samples. Out: a [`Frame`]. Where nothing moves, samples keep their bits.

use super::branches::{PartMap, warped_branches};
use super::composite_parts::{REGION, RIM};
use super::read::CHANNELS;
use super::{FlatPicture, Gallery};
use crate::image::{Channel, Frame, Plate, Storage};
use crate::lattice::ScreenLattice;
use crate::pipeline::evaluate::ordered_parts::OrderedParts;
use crate::pipeline::evaluate::part_order::ordered_parts;
use crate::pipeline::{PreparedShot, TimeSample};
use crate::plate::{Field, Filter, LayerJob, Matte, PlateJob, Semantic, WarpSettings, warp_plate};
use crate::raster::ChannelGroup;
use crate::solve::BranchedLattice;
use crate::space::PixelRect;
use rayon::prelude::*;

/// Smallest coverage at which a picture counts as visible at a pixel, as for surfaces.
const SEEN: f32 = 0.5;

/// A warped picture at some time.
struct WarpedPicture {
    /// The warp; `None` if the picture is at rest.
    warp: Option<Warp>,
    /// The picture, with [`CHANNELS`], over the window of pixels that it may touch.
    picture: Frame,
    /// The part of every pixel, if the lattice branches.
    part_map: Option<PartMap>,
    /// Warnings, for example that the picture visibly overlaps itself.
    warnings: Vec<String>,
}

impl Gallery {
    /// Returns the combined coverage (0 to 1) of the unwarped pictures for whose index `shown` holds, per pixel of the frame.
    #[cfg(any(test, feature = "cli"))]
    pub(in crate::pipeline) fn coverage(&self, shown: impl Fn(usize) -> bool) -> Vec<f32> {
        let window = self.frame.window();
        let mut covered = vec![0.0_f32; window.area()];
        for (_, flat_picture) in self.flat_pictures.iter().enumerate().filter(|(index, _)| shown(*index)) {
            let picture = flat_picture.plate.clone().into_frame();
            for [to, from] in window.shared_rows(picture.data_window) {
                let rows = covered[to].iter_mut().zip(&picture.channels[3].samples[from]);
                rows.for_each(|(covered, alpha)| *covered = covered.max(alpha.clamp(0.0, 1.0)));
            }
        }
        covered
    }
}

/// The warp of a picture.
#[derive(Clone, Debug, PartialEq)]
enum Warp {
    Plain(ScreenLattice),
    Branching(BranchedLattice<2>, OrderedParts),
}

impl Warp {
    fn of(prepared: &PreparedShot, sample: &TimeSample, layer: usize) -> Option<Self> {
        Some(match ordered_parts(prepared, layer, sample) {
            Some((branches, parts)) => Self::Branching(branches.clone(), parts.clone()),
            None => Self::Plain(sample.layers[layer].solution.as_ref()?.lattice.clone()),
        })
    }
}

fn alpha(picture: &Frame) -> &[f32] {
    &picture.channels[3].samples
}

/// Draws frames, reusing pictures that do not move between the samples of an exposure.
pub(super) struct Painter<'a> {
    gallery: &'a Gallery,
    prepared: &'a PreparedShot,
    /// One per picture.
    warped_pictures: Vec<Option<WarpedPicture>>,
}

impl<'a> Painter<'a> {
    pub(super) fn new(gallery: &'a Gallery, prepared: &'a PreparedShot) -> Self {
        let warped_pictures = gallery.flat_pictures.iter().map(|_| None).collect();
        Self { gallery, prepared, warped_pictures }
    }

    /// Returns the mean of the samples at `times`, with the ids of the sample `middle`.
    ///
    /// # Errors
    /// Those of `sample_at`.
    pub(super) fn frame<E>(
        &mut self,
        times: &[f64],
        middle: &TimeSample,
        sample_at: impl Fn(f64) -> Result<std::sync::Arc<TimeSample>, E>,
    ) -> Result<Frame, E> {
        let size = self.gallery.frame;
        let groups = &self.prepared.shot.output.channels;
        let mut channels = Vec::new();
        if groups.contains(&ChannelGroup::Beauty) {
            let mut sum: Option<[Vec<f32>; 4]> = None;
            for &time in times {
                let picture = self.beauty(&*sample_at(time)?);
                match &mut sum {
                    None => sum = Some(picture),
                    Some(sum) => sum.iter_mut().zip(&picture).for_each(|(sum, plane)| add(sum, plane)),
                }
            }
            let planes = scaled(sum.unwrap_or_default(), times.len());
            let named = CHANNELS.into_iter().zip(planes);
            channels.extend(named.map(|(name, samples)| channel(name, self.gallery.storage, samples)));
        }
        if groups.contains(&ChannelGroup::Id) {
            let ids = self.ids(middle);
            let named = ChannelGroup::Id.channels().iter().zip(ids);
            channels.extend(named.map(|(spec, samples)| channel(spec.name, spec.storage, samples)));
        }
        let (display, pixel_aspect) = (size.window(), size.pixel_aspect);
        Ok(Frame { display, data_window: display, pixel_aspect, channels }.crop_to_covered())
    }

    /// Returns one sample, with colour alone.
    #[cfg(any(test, feature = "editor"))]
    pub(super) fn draft(&mut self, sample: &TimeSample) -> Frame {
        let size = self.gallery.frame;
        let named = CHANNELS.into_iter().zip(self.beauty(sample));
        let channels = named.map(|(name, samples)| channel(name, self.gallery.storage, samples)).collect();
        let (display, pixel_aspect) = (size.window(), size.pixel_aspect);
        Frame { display, data_window: display, pixel_aspect, channels }
    }

    /// Returns the warnings of the pictures drawn last.
    pub(super) fn warnings(&self) -> Vec<String> {
        self.warped_pictures.iter().flatten().flat_map(|warped| warped.warnings.iter().cloned()).collect()
    }

    /// Composites all pictures.
    fn beauty(&mut self, sample: &TimeSample) -> [Vec<f32>; 4] {
        let window = self.gallery.frame.window();
        let mut canvas: [Vec<f32>; 4] = std::array::from_fn(|_| vec![0.0; window.area()]);
        for index in 0..self.gallery.flat_pictures.len() {
            composite_over(&mut canvas, window, &self.warp_picture(index, sample).picture);
        }
        canvas
    }

    /// Returns the layer id and the object id of the front-most picture at every pixel.
    fn ids(&mut self, sample: &TimeSample) -> [Vec<f32>; 2] {
        let window = self.gallery.frame.window();
        let mut ids = [vec![0.0; window.area()], vec![0.0; window.area()]];
        for index in 0..self.gallery.flat_pictures.len() {
            let layer = self.prepared.assignment.layer_of_part[index].map_or(0, |layer| layer + 1);
            let here = [layer as f32, (index + 1) as f32];
            let picture = &self.warp_picture(index, sample).picture;
            for [to, from] in window.shared_rows(picture.data_window) {
                let seen = to.zip(&alpha(picture)[from]).filter(|(_, alpha)| **alpha >= SEEN);
                seen.for_each(|(at, _)| (ids[0][at], ids[1][at]) = (here[0], here[1]));
            }
        }
        ids
    }

    /// Returns a picture warped as in a sample.
    fn warp_picture(&mut self, index: usize, sample: &TimeSample) -> &WarpedPicture {
        let owner = self.prepared.assignment.layer_of_part[index];
        let warp = owner.and_then(|layer| Warp::of(self.prepared, sample, layer));
        let flat_picture = &self.gallery.flat_pictures[index];
        let warped_picture = match self.warped_pictures[index].take() {
            Some(known) if known.warp == warp => known,
            last => {
                let layer = owner.map_or("", |layer| &self.prepared.shot.layers[layer].name);
                warped(flat_picture, (layer, warp), (self.prepared.shot.warp.filter, last))
            }
        };
        self.warped_pictures[index].insert(warped_picture)
    }
}

fn channel(name: &str, storage: Storage, samples: Vec<f32>) -> Channel {
    Channel { name: name.to_owned(), storage, samples }
}

/// Warps a picture as the only layer of a plate; where it overlaps itself, the front shows. `last`: the same picture
/// under its previous warp.
fn warped(
    flat_picture: &FlatPicture,
    (layer, warp): (&str, Option<Warp>),
    (filter, last): (Filter, Option<WarpedPicture>),
) -> WarpedPicture {
    let by_field = |plate: &Plate, field: Field| {
        let name = layer.to_owned();
        let layer = LayerJob { name, field, previous: None, next: None, matte: Some(Matte::Alpha), front: None };
        let semantics = [REGION, RIM].map(|name| (name.to_owned(), Semantic::Color)).into();
        let settings = WarpSettings { filter, semantics, ..WarpSettings::default() };
        let job = PlateJob { layers: vec![layer], settings: &settings, fill: None };
        let (plate, report) = warp_plate(plate, &job).expect("a matte of all that is there names nothing");
        (plate.into_frame(), report)
    };
    let (picture, part_map, warnings) = match &warp {
        None => (flat_picture.plate.clone().into_frame(), None, Vec::new()),
        Some(Warp::Plain(lattice)) => {
            let (picture, report) = by_field(&flat_picture.plate, Field::of_layer(lattice.clone()));
            (picture, None, report.warnings)
        }
        Some(Warp::Branching(branches, parts)) => {
            let map = last
                .and_then(|last| last.part_map_of(branches, parts))
                .unwrap_or_else(|| PartMap::of(flat_picture, branches, parts));
            let (picture, warnings) = warped_branches(flat_picture, (&map, branches, parts), |plate, lattice| {
                by_field(plate, Field::of_branch(lattice))
            });
            (picture, Some(map), warnings)
        }
    };
    WarpedPicture { warp, picture, part_map, warnings }
}

impl WarpedPicture {
    /// Returns the part map if the shape is split into the same pieces and parts under the given branches.
    fn part_map_of(self, branches: &BranchedLattice<2>, parts: &OrderedParts) -> Option<PartMap> {
        match self.warp {
            Some(Warp::Branching(last, known)) if last.has_same_pieces(branches) && known == *parts => self.part_map,
            _ => None,
        }
    }
}

/// Porter and Duff's over operator. Where nothing lies behind, the front keeps its bits.
fn composite_over(canvas: &mut [Vec<f32>; 4], window: PixelRect, picture: &Frame) {
    let rows = window.shared_rows(picture.data_window);
    for (plane, front) in canvas.iter_mut().zip(&picture.channels) {
        for [to, from] in rows.clone() {
            let (behind, front, alpha) = (&mut plane[to], &front.samples[from.clone()], &alpha(picture)[from]);
            for ((behind, front), alpha) in behind.iter_mut().zip(front).zip(alpha) {
                // Filters with negative lobes can make alpha overshoot.
                *behind = if *behind == 0.0 { *front } else { front + *behind * (1.0 - alpha.clamp(0.0, 1.0)) };
            }
        }
    }
}

fn add(sum: &mut [f32], plane: &[f32]) {
    sum.par_iter_mut().zip(plane).for_each(|(sum, sample)| *sum += sample);
}

/// Divides a sum by the number of samples; a single sample keeps its bits.
fn scaled(mut planes: [Vec<f32>; 4], count: usize) -> [Vec<f32>; 4] {
    if count > 1 {
        let share = 1.0 / count as f32;
        planes.iter_mut().for_each(|plane| plane.par_iter_mut().for_each(|sample| *sample *= share));
    }
    planes
}
