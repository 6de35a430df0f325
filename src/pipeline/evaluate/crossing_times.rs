//! Follows crossings of a drawing's limbs through the frames of a shot.
//!
//! In: a [`Crossing`] at some time. Out: the same crossing over all frames in which it lasts, so that what is decided from it is constant
//! while limbs pass each other. Crossings of neighbouring frames are one if pieces of the one lie beside those of the other on both
//! sides. The drawing is connected alike in all frames, so its pieces have the same indices.

use super::frame_crossings::FrameCrossings;
use crate::pipeline::draw::passes::mid_shutter;
use crate::pipeline::{PreparedShot, TimeSample};
use crate::solve::{BranchedLattice, Crossing};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::{Arc, OnceLock, PoisonError};

/// Follows crossings of one layer.
pub(super) struct CrossingTimes<'a> {
    pub(super) prepared: &'a PreparedShot,
    pub(super) layer: usize,
    pub(super) now: &'a TimeSample,
    pub(super) branches: &'a BranchedLattice<2>,
    /// Digest of the pieces of `branches`.
    pub(super) pieces: u64,
}

/// A crossing at one time: its frame, and its index there.
type Occurrence = (i32, usize);

impl CrossingTimes<'_> {
    /// Returns a crossing of this time over all frames in which it lasts. Where each time is solved alone, it is that of this time.
    pub(super) fn over_time(&self, crossing: &Crossing) -> Crossing {
        if !self.now.layers[self.layer].is_on_trajectory {
            return crossing.clone();
        }
        let exposed = self.now.frame - mid_shutter(self.prepared.shot.shutter);
        let near = self.branches.near_pairs(crossing);
        let mut largest: Option<(u64, Occurrence, bool)> = None;
        for frame in [exposed.floor() as i32, exposed.ceil() as i32] {
            for (index, other) in self.crossings(frame).list.iter().enumerate() {
                let Some(is_swapped) = other.is_swapped_near(&near) else { continue };
                if largest.is_none_or(|(area, ..)| area < other.area()) {
                    largest = Some((other.area(), (frame, index), is_swapped));
                }
            }
        }
        let Some((_, occurrence, is_swapped)) = largest else { return crossing.clone() };
        self.joined(occurrence).oriented(is_swapped)
    }

    /// Returns a crossing of a frame joined with the same ones of all frames, with the sides of that frame.
    fn joined(&self, occurrence: Occurrence) -> Crossing {
        let (frame, index) = occurrence;
        let crossings = self.crossings(frame);
        if let Some(whole) = crossings.over_time[index].get() {
            return whole.clone();
        }
        // In the order of frames, so that sums have the same bits whichever of the frames is drawn first.
        let found = self.connected(occurrence);
        let frames: Vec<(Arc<FrameCrossings>, usize, bool)> =
            found.iter().map(|(&(frame, index), &is_swapped)| (self.crossings(frame), index, is_swapped)).collect();
        let parts = frames.iter().map(|(crossings, index, is_swapped)| (&crossings.list[*index], *is_swapped));
        let whole = self.branches.joined_crossing(&parts.collect::<Vec<_>>());
        for (crossings, index, is_swapped) in &frames {
            // Another thread may have found the same.
            let _ = crossings.over_time[*index].set(whole.clone().oriented(*is_swapped));
        }
        whole.oriented(found[&occurrence])
    }

    /// Returns the crossings of all frames that are the same as that of `first`, ascending, each with whether its sides are the other way
    /// round than those of the first in this order.
    fn connected(&self, first: Occurrence) -> BTreeMap<Occurrence, bool> {
        let [start, end] = self.prepared.shot.solve_range;
        let mut found = BTreeMap::from([(first, false)]);
        let mut waiting = vec![first];
        while let Some(occurrence @ (frame, index)) = waiting.pop() {
            let is_swapped = found[&occurrence];
            let near = self.branches.near_pairs(&self.crossings(frame).list[index]);
            for next in [frame - 1, frame + 1].into_iter().filter(|next| (start..=end).contains(next)) {
                for (other, crossing) in self.crossings(next).list.iter().enumerate() {
                    let Some(is_other) = crossing.is_swapped_near(&near) else { continue };
                    if let Entry::Vacant(slot) = found.entry((next, other)) {
                        slot.insert(is_swapped != is_other);
                        waiting.push((next, other));
                    }
                }
            }
        }
        let is_swapped = found.values().next() == Some(&true);
        found.values_mut().for_each(|swapped| *swapped = *swapped != is_swapped);
        found
    }

    /// Returns the crossings of a frame of the shot; none where nothing is solved, or where the drawing has other pieces.
    fn crossings(&self, frame: i32) -> Arc<FrameCrossings> {
        let cache = || self.prepared.cache.crossings.lock().unwrap_or_else(PoisonError::into_inner);
        let known = cache().get(&(self.layer, frame)).map(Arc::clone);
        let crossings = known.unwrap_or_else(|| {
            let found = Arc::new(self.found(frame).unwrap_or_default());
            cache().insert((self.layer, frame), Arc::clone(&found));
            found
        });
        if crossings.pieces == self.pieces { crossings } else { Arc::default() }
    }

    fn found(&self, frame: i32) -> Option<FrameCrossings> {
        let time = self.prepared.mid_exposure_time(f64::from(frame));
        let of_sample = |sample: &TimeSample| {
            let branches = sample.layers[self.layer].solution.as_ref()?.branches.as_ref()?;
            let list = branches.crossings(&vec![0; branches.pieces().count()]);
            let over_time = list.iter().map(|_| OnceLock::new()).collect();
            Some(FrameCrossings { pieces: branches.digest_of_pieces(), list, over_time })
        };
        if self.now.frame == time {
            return of_sample(self.now);
        }
        match self.prepared.cache.sample(time) {
            Some(sample) => of_sample(&sample),
            // A frame that cannot be solved reports that when it is drawn.
            None => of_sample(&self.prepared.evaluate(time).ok()?),
        }
    }
}
