//! Splits a picture into the branches of a layer: the lattice of each branch, its share of every pixel, and the depth order.
//!
//! In: a [`PreparedShot`], a solved [`TimeSample`], and a layer whose lattice branches. Out: [`BranchPart`]s from back
//! to front. The pieces of the branches are rasterised over the unwarped picture with the samples and the shutter of a
//! render; a pixel outside the shape gets the branch of the nearest pixel inside.

mod depth_order;
mod drawn_pieces;
mod labels;
mod shares;

use crate::export::LatticeBranches;
use crate::lattice::ScreenLattice;
use crate::pipeline::draw::passes::{PassPlan, mid_shutter, plan_passes};
use crate::pipeline::evaluate::ordered_parts::{OrderedPart, OrderedParts};
use crate::pipeline::evaluate::part_order::ordered_parts;
use crate::pipeline::{PreparedShot, TimeSample};
use crate::plate::{Coverage, Field, SharedParts};
use crate::raster::PassRole;
use crate::shot::Shutter;
use crate::solve::Solution;
use crate::space::{FrameSize, PixelRect};
use depth_order::from_back_to_front;
use drawn_pieces::{DrawnPieces, PlacedPieces};
use labels::{Label, LabelledPieces};
use rayon::prelude::*;
use shares::Shares;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A branch, or the portion of it whose points also share a branch in the neighbouring frames.
#[derive(Clone, Debug)]
pub(crate) struct BranchPart {
    /// The lattice that moves this part; handles that do not act on it continue it smoothly.
    pub(crate) lattice: ScreenLattice,
    /// The lattices in the previous and the next frame, `None` where the part rests; `None` as a whole if no motion is wanted.
    pub(crate) around: Option<[Option<ScreenLattice>; 2]>,
    /// Share of this part in every pixel of the frame; the shares of all parts sum to 1.
    pub(crate) share: Arc<Coverage>,
    /// Coverage of the whole shape in every pixel; the same for all parts.
    pub(crate) covered: Arc<Coverage>,
}

/// The exposure of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Exposure {
    /// One sample per pixel, at the time of the scene's sample.
    Instant,
    /// The samples and the shutter of the shot, around the time of the scene's sample.
    Shutter,
}

/// A solved time with its neighbours.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SampleInMotion<'a> {
    pub(crate) now: &'a TimeSample,
    /// The samples of the previous and the next frame if motion is wanted; each part then moves as one in all three.
    pub(crate) around: Option<[&'a TimeSample; 2]>,
}

/// The picture in which parts are seen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BranchView {
    pub(crate) size: FrameSize,
    pub(crate) exposure: Exposure,
}

/// The labels of a layer as seen in one picture.
struct VisibleLabels {
    labels: Vec<Label>,
    /// One per label.
    lattices: Vec<ScreenLattice>,
    /// Labels from back to front.
    order: Vec<usize>,
    /// Share of each label; `None` if nothing of it is visible.
    shares: Vec<Option<Coverage>>,
    /// Coverage of all labels together.
    covered: Coverage,
}

impl PreparedShot {
    /// Returns the parts of a layer from back to front, for a picture of the unwarped scene; `None`
    /// if the layer's lattice does not branch at that time.
    pub(crate) fn branch_parts(
        &self,
        layer: usize,
        sample: SampleInMotion,
        view: BranchView,
    ) -> Option<Vec<BranchPart>> {
        let VisibleLabels { labels, lattices, order, mut shares, covered } =
            self.visible_labels(layer, sample, view)?;
        let covered = Arc::new(covered);
        let around =
            sample.around.map(|samples| samples.map(|sample| sample.layers[layer].solution.as_ref().map(lattices_of)));
        let lattice_around = |label: &Label| {
            let lattice = |side: usize, of_side: &Option<Vec<ScreenLattice>>| {
                of_side.as_ref().map(|lattices| lattices[label.around[side].unwrap_or(0)].clone())
            };
            around.as_ref().map(|[before, after]| [lattice(0, before), lattice(1, after)])
        };
        let part = |label: usize| {
            let share = Arc::new(shares[label].take()?);
            let around = lattice_around(&labels[label]);
            Some(BranchPart { lattice: lattices[label].clone(), around, share, covered: Arc::clone(&covered) })
        };
        Some(order.into_iter().filter_map(part).collect())
    }

    /// Returns the branches of a layer as stored in a lattice file; `None` if its lattice does not branch.
    pub(super) fn file_branches(&self, layer: usize, now: &TimeSample) -> Option<LatticeBranches> {
        let (branches, OrderedParts { list, of_pieces, .. }) = ordered_parts(self, layer, now)?;
        let seen = self.visible_labels(
            layer,
            SampleInMotion { now, around: None },
            BranchView { size: self.shot.size, exposure: Exposure::Instant },
        );
        let order = seen.map(|seen| seen.order.into_iter().map(|label| seen.labels[label].now).collect());
        // Without any visible part, the largest branch is the rearmost.
        let order: Vec<OrderedPart> = order.unwrap_or_else(|| list.clone());
        let mut regions: BTreeMap<OrderedPart, Vec<Vec<[f64; 2]>>> =
            if list.iter().all(|part| part.order == 0 && part.level == 0) {
                let regions = branches.regions().into_iter().enumerate();
                regions.map(|(branch, region)| (OrderedPart { order: 0, branch, level: 0 }, region)).collect()
            } else {
                let mut regions: BTreeMap<OrderedPart, Vec<Vec<[f64; 2]>>> = BTreeMap::new();
                for (&part, (_, corners)) in of_pieces.iter().zip(branches.pieces()) {
                    regions.entry(list[part as usize]).or_default().push(corners.to_vec());
                }
                regions
            };
        let branch = |part: OrderedPart| (branches.handles_of(part.branch), regions.remove(&part).unwrap_or_default());
        Some(LatticeBranches::of(order.into_iter().map(branch).collect()))
    }

    fn visible_labels(
        &self,
        layer: usize,
        SampleInMotion { now, around }: SampleInMotion,
        BranchView { size, exposure }: BranchView,
    ) -> Option<VisibleLabels> {
        let LabelledPieces { labels, pieces } = LabelledPieces::of(self, layer, now, around)?;
        let (begin, plan) = self.passes_of(now, exposure);
        let pieces = DrawnPieces { prepared: self, now, pieces: &pieces, size };
        // All passes at the same time share one projection.
        let mut placed: Vec<PlacedPieces> = Vec::new();
        let place = |time: f64, placed: &mut Vec<PlacedPieces>| {
            placed.iter().position(|pieces| pieces.time() == time).unwrap_or_else(|| {
                placed.push(pieces.at(time));
                placed.len() - 1
            })
        };
        let planned: Vec<_> = plan.iter().map(|pass| (*pass, place(begin + pass.time_frames, &mut placed))).collect();
        let of_branches = lattices_of(now.layers[layer].solution.as_ref()?);
        let lattices: Vec<ScreenLattice> = labels.iter().map(|label| of_branches[label.now.branch].clone()).collect();
        let orders: Vec<i32> = labels.iter().map(|label| label.now.order).collect();
        let (order, shares, covered) = drawn((&placed, &planned), (&lattices, &orders), size)?;
        Some(VisibleLabels { labels, lattices, order, shares, covered })
    }

    /// Returns the time from which the passes of a picture are counted, and the passes.
    fn passes_of(&self, now: &TimeSample, exposure: Exposure) -> (f64, Vec<PassPlan>) {
        match exposure {
            Exposure::Instant => (now.frame, plan_passes(1, Shutter::CLOSED)),
            Exposure::Shutter => {
                let shutter = self.shot.shutter;
                (now.frame - mid_shutter(shutter), plan_passes(self.shot.samples, shutter))
            }
        }
    }
}

/// Returns the parts of a picture that the branches of a lattice file define, from back to front. `around`: their
/// lattices in the previous and the next frame.
pub(crate) fn parts_of_file(
    branches: &LatticeBranches,
    lattices: Vec<ScreenLattice>,
    around: Option<[Vec<ScreenLattice>; 2]>,
    size: FrameSize,
) -> Vec<BranchPart> {
    let polygons = (0..branches.list.len()).flat_map(|branch| {
        let nearness = branch as f64;
        branches.polygons(branch).map(move |corners| (branch as u32, nearness, corners))
    });
    let placed = [PlacedPieces::of_screen(polygons, size)];
    let planned: Vec<_> = plan_passes(FILE_SAMPLES, Shutter::CLOSED).into_iter().map(|pass| (pass, 0)).collect();
    let orders = vec![0; lattices.len()];
    let Some((_, shares, covered)) = drawn((&placed, &planned), (&lattices, &orders), size) else { return Vec::new() };
    let covered = Arc::new(covered);
    let part = |(branch, (lattice, share)): (usize, (ScreenLattice, Option<Coverage>))| {
        let around = around.as_ref().map(|around| around.each_ref().map(|lattices| lattices.get(branch).cloned()));
        Some(BranchPart { lattice, around, share: Arc::new(share?), covered: Arc::clone(&covered) })
    };
    lattices.into_iter().zip(shares).enumerate().filter_map(part).collect()
}

/// Returns the field and the coverage of each part, and the coverage of the whole shape; `None` if there are no parts.
pub(crate) fn fields_of(parts: Vec<BranchPart>) -> Option<SharedParts> {
    let covered = (*parts.first()?.covered).clone();
    let field = |part: BranchPart| (Field::of_branch(part.lattice), Arc::unwrap_or_clone(part.share));
    Some((parts.into_iter().map(field).collect(), covered))
}

/// Samples per pixel for branches from a lattice file, which specifies no number.
const FILE_SAMPLES: u32 = 16;

/// Returns labels from back to front, the share of each label in every pixel, and the coverage of all; `None` if
/// nothing is in the frame. `planned`: each pass with the index of its projection in `placed`.
fn drawn(
    (placed, planned): (&[PlacedPieces], &[(PassPlan, usize)]),
    (lattices, orders): (&[ScreenLattice], &[i32]),
    size: FrameSize,
) -> Option<(Vec<usize>, Vec<Option<Coverage>>, Coverage)> {
    let window = placed.iter().map(PlacedPieces::window).reduce(PixelRect::union)?.intersection(size.window());
    if window.area() == 0 {
        return None;
    }
    let beauty = planned.par_iter().filter(|(pass, _)| pass.role != PassRole::Data);
    let seen = beauty.map(|(pass, place)| placed[*place].labels(window, pass.jitter_px)).collect::<Vec<_>>();
    let data = planned.iter().find(|(pass, _)| pass.role != PassRole::Beauty);
    let front = data.map(|(pass, place)| placed[*place].front(window, pass.jitter_px)).unwrap_or_default();
    let shares = Shares::of(&seen, (window, size), lattices.len());
    let order = from_back_to_front((lattices, orders), (&front, window, size));
    let of_labels = (0..lattices.len()).map(|label| shares.of_label(label as u32)).collect();
    Some((order, of_labels, shares.covered()))
}

/// Returns the lattices of all branches, or the single lattice of a layer that does not branch.
fn lattices_of(solution: &Solution<2>) -> Vec<ScreenLattice> {
    match &solution.branches {
        Some(branches) => (0..branches.branch_count()).into_par_iter().map(|k| branches.extended_lattice(k)).collect(),
        None => vec![solution.lattice.clone()],
    }
}
