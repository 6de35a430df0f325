//! A set of frames, stored as runs, so that sets of very long shots cost little.
//!
//! In: frames, mostly one after the other. Out: how many of a range are there, and the runs of those that are missing.

use std::collections::{BTreeMap, VecDeque};

/// A set of frame numbers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(in crate::edit) struct FrameRuns {
    /// The last frame of each run, by its first. Runs neither overlap nor touch.
    runs: BTreeMap<i32, i32>,
}

impl FrameRuns {
    /// Adds a frame.
    pub(in crate::edit) fn insert(&mut self, frame: i32) {
        let below = self.runs.range(..=frame).next_back().map(|(&first, &last)| [first, last]);
        if below.is_some_and(|[_, last]| frame <= last) {
            return;
        }
        let first = below.filter(|[_, last]| last.checked_add(1) == Some(frame)).map_or(frame, |[first, _]| first);
        let above = frame.checked_add(1).and_then(|next| self.runs.remove(&next));
        self.runs.insert(first, above.unwrap_or(frame));
    }

    /// Removes all frames.
    pub(in crate::edit) fn clear(&mut self) {
        self.runs.clear();
    }

    /// Returns the runs within a range, from first to last, clipped to it.
    fn within(&self, [first, last]: [i32; 2]) -> impl Iterator<Item = [i32; 2]> {
        let begins_before = self.runs.range(..first).next_back().filter(|(_, end)| **end >= first);
        let inside = (first <= last).then(|| self.runs.range(first..=last)).into_iter().flatten();
        let runs = begins_before.filter(|_| first <= last).into_iter().chain(inside);
        runs.map(move |(&begin, &end)| [begin.max(first), end.min(last)])
    }

    /// Returns how many frames of a range are there.
    pub(in crate::edit) fn count(&self, range: [i32; 2]) -> usize {
        self.within(range).map(length).sum()
    }

    /// Returns the runs of a range's frames that are missing, in order.
    pub(in crate::edit) fn gaps(&self, [first, last]: [i32; 2]) -> VecDeque<[i32; 2]> {
        let mut gaps = VecDeque::new();
        let mut next = i64::from(first);
        for [begin, end] in self.within([first, last]) {
            push_gap(&mut gaps, next, i64::from(begin) - 1);
            next = i64::from(end) + 1;
        }
        push_gap(&mut gaps, next, i64::from(last));
        gaps
    }
}

/// Returns the number of frames of a range.
pub(in crate::edit) fn length([first, last]: [i32; 2]) -> usize {
    usize::try_from(i64::from(last) - i64::from(first) + 1).unwrap_or(0)
}

/// Takes the first frame out of runs.
pub(in crate::edit) fn pop_frame(runs: &mut VecDeque<[i32; 2]>) -> Option<i32> {
    let [first, last] = runs.pop_front()?;
    if first < last {
        runs.push_front([first + 1, last]);
    }
    Some(first)
}

/// Appends a run unless it is empty. Both ends lie within the range that is looked at, so they are frame numbers.
fn push_gap(gaps: &mut VecDeque<[i32; 2]>, first: i64, last: i64) {
    if let (true, Ok(first), Ok(last)) = (first <= last, i32::try_from(first), i32::try_from(last)) {
        gaps.push_back([first, last]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// Every set of six frames, added in two orders, against a plain set.
    #[test]
    fn runs_are_what_a_plain_set_is() {
        for bits in 0_u32..64 {
            let frames: Vec<i32> = (0..6).filter(|frame| bits >> frame & 1 == 1).map(|frame| frame - 3).collect();
            let (mut runs, mut turned) = (FrameRuns::default(), FrameRuns::default());
            frames.iter().for_each(|&frame| runs.insert(frame));
            frames.iter().chain(&frames).rev().for_each(|&frame| turned.insert(frame));
            assert_eq!(runs, turned, "{frames:?}");
            let set: BTreeSet<i32> = frames.into_iter().collect();
            for range in (-4..=4).flat_map(|first| (first - 1..=4).map(move |last| [first, last])) {
                let plain = (range[0]..=range[1]).filter(|frame| set.contains(frame)).count();
                assert_eq!(runs.count(range), plain, "{set:?} {range:?}");
                let mut gaps = runs.gaps(range);
                assert!(gaps.len() <= plain + 1);
                let missing: Vec<i32> = std::iter::from_fn(|| pop_frame(&mut gaps)).collect();
                let wanted: Vec<i32> = (range[0]..=range[1]).filter(|frame| !set.contains(frame)).collect();
                assert_eq!(missing, wanted, "{set:?} {range:?}");
            }
        }
    }

    #[test]
    fn the_longest_shot_is_one_run() {
        let mut runs = FrameRuns::default();
        let all = [i32::MIN, i32::MAX];
        assert_eq!((runs.gaps(all), length(all)), ([all].into(), 1 << 32));
        [i32::MIN, i32::MAX, 0].into_iter().for_each(|frame| runs.insert(frame));
        assert_eq!(runs.gaps(all), [[i32::MIN + 1, -1], [1, i32::MAX - 1]]);
        runs.clear();
        assert_eq!(runs.count(all), 0);
    }
}
