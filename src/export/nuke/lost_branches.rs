//! The branches of a layer that its grid leaves out, and how much of the picture they move.
//!
//! In: the lattices of a layer with their branches, the size of the frame. Out: [`LostBranches`] of the frame in which the grid leaves
//! out most.

use crate::export::{LatticeBranch, LatticeBranches, LatticeTrack, Track};
use crate::lattice::ScreenLattice;
use crate::space::{FrameSize, ImagePoint, ScreenPoint};
use crate::spelling::pluralised;
use std::cmp::Reverse;

/// Distance between handles below which they are the same, frame heights.
const SAME: f64 = 1e-9;

/// Largest number of branches that are named by their places.
const NAMED: usize = 3;

/// The branches that a grid leaves out in one frame, the largest first.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LostBranches {
    frame: i32,
    list: Vec<LostBranch>,
}

/// A branch that a grid leaves out.
#[derive(Clone, Copy, Debug, PartialEq)]
struct LostBranch {
    /// Number of pixels that it covers at rest.
    pixels: usize,
    /// Their middle, frame heights.
    middle: [f64; 2],
}

impl LostBranches {
    /// Compares the branches of a layer with the lattice that its grid holds; `None` if that moves all of them alike.
    pub(crate) fn of(layer: &LatticeTrack, size: FrameSize) -> Option<Self> {
        let Track::Screen(lattices) = &layer.track else { return None };
        let of_frame = |(&frame, branches): (&i32, &LatticeBranches)| {
            let lattice = lattices.get(&frame)?;
            let is_lost = |branch: &usize| !is_held(&branches.list[*branch], lattice);
            let lost = (0..branches.list.len()).filter(is_lost);
            let mut list: Vec<LostBranch> =
                lost.filter_map(|branch| LostBranch::of(branches.polygons(branch), size)).collect();
            list.sort_by_key(|branch| Reverse(branch.pixels));
            (!list.is_empty()).then_some(Self { frame, list })
        };
        layer.branches.iter().filter_map(of_frame).max_by_key(|lost| (lost.pixels(), Reverse(lost.frame)))
    }

    fn pixels(&self) -> usize {
        self.list.iter().map(|branch| branch.pixels).sum()
    }
}

impl std::fmt::Display for LostBranches {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let places = self.list.iter().take(NAMED).map(|branch| {
            let [x, y] = branch.middle;
            format!("{} around {x:.2}, {y:.2}", branch.pixels)
        });
        let places = places.collect::<Vec<_>>().join("; ");
        let more = if self.list.len() > NAMED { "; .." } else { "" };
        let branches = pluralised(self.list.len(), "branch", "branches");
        write!(f, "in frame {} it leaves out {branches}, {} pixels ({places}{more})", self.frame, self.pixels())
    }
}

impl LostBranch {
    /// Counts the pixels of the frame whose centres lie in a region; `None` if there are none.
    fn of(polygons: impl Iterator<Item = Vec<[f64; 2]>>, size: FrameSize) -> Option<Self> {
        let (width, height) = (size.width as usize, size.height as usize);
        // Front and back of a model, and neighbours, cover the same pixels.
        let mut is_covered = vec![false; width * height];
        let (mut pixels, mut sum) = (0, [0.0; 2]);
        for polygon in polygons {
            let corners: Vec<[f64; 2]> =
                polygon.into_iter().map(|[x, y]| size.image_from_screen(ScreenPoint::new(x, y)).0.to_array()).collect();
            for row in centres(corners.iter().map(|corner| corner[1]), height) {
                let y = row as f64 + 0.5;
                let sides = (0..corners.len()).map(|k| [corners[k], corners[(k + 1) % corners.len()]]);
                for column in centres(sides.filter_map(|side| crossing(side, y)), width) {
                    if !std::mem::replace(&mut is_covered[row * width + column], true) {
                        pixels += 1;
                        [sum[0], sum[1]] = [sum[0] + column as f64 + 0.5, sum[1] + y];
                    }
                }
            }
        }
        let [x, y] = sum.map(|sum| sum / pixels.max(1) as f64);
        let middle = size.screen_from_image(ImagePoint::new(x, y)).0.to_array();
        (pixels > 0).then_some(Self { pixels, middle })
    }
}

/// Whether a lattice has all handles that act on a branch where the branch has them.
fn is_held(branch: &LatticeBranch, lattice: &ScreenLattice) -> bool {
    let is_same = |(own, of_grid): (&Option<[f64; 2]>, &[f64; 2])| {
        own.is_none_or(|own| (0..2).all(|axis| (own[axis] - of_grid[axis]).abs() < SAME))
    };
    branch.handles.iter().zip(&lattice.handles).all(is_same)
}

/// Returns the pixels, of `count` in a line, whose centres lie between the least and the greatest of some values.
fn centres(values: impl Iterator<Item = f64>, count: usize) -> std::ops::Range<usize> {
    let [low, high] = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)]);
    let at = |x: f64| (x - 0.5).ceil().clamp(0.0, count as f64) as usize;
    at(low)..at(high).max(at(low))
}

/// Returns the x at which a side meets the line at height `y`.
fn crossing([[ax, ay], [bx, by]]: [[f64; 2]; 2], y: f64) -> Option<f64> {
    ((ay <= y) != (by <= y)).then(|| ax + (y - ay) / (by - ay) * (bx - ax))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::lattice::{Basis, Grid};
    use std::collections::BTreeMap;

    /// A layer whose second branch, half as wide as a frame height, moves in the second of its two frames.
    pub(in crate::export::nuke) fn two_branches() -> LatticeTrack {
        let grid = Grid { dims: [4, 4], basis: Basis::Bspline, lo: [0.0; 2], hi: [1.5, 1.0], angle: 0.0 };
        let square = |left: f64, right: f64| vec![vec![[left, 0.0], [right, 0.0], [right, 1.0], [left, 1.0]]];
        let branches = |shift: f64| {
            let rest = grid.at_rest().handles;
            let own = rest.iter().map(|&handle| Some(handle)).collect();
            let moved = rest.iter().enumerate().map(|(k, &[x, y])| (k % 4 > 0).then_some([x + shift, y])).collect();
            // The region of the second is listed twice, as front and back of a model are.
            let twice = [square(1.0, 1.5), square(1.0, 1.5)].concat();
            LatticeBranches::of(vec![(own, square(0.0, 1.0)), (moved, twice)])
        };
        LatticeTrack {
            name: "arm".into(),
            track: Track::Screen(BTreeMap::from([(1, grid.at_rest()), (2, grid.at_rest())])),
            placements: BTreeMap::new(),
            branches: BTreeMap::from([(1, branches(0.0)), (2, branches(0.1))]),
            has_branches_in_scene: false,
            wholes: BTreeMap::new(),
        }
    }

    #[test]
    fn branches_that_move_unlike_the_grid_are_lost() {
        let lost = LostBranches::of(&two_branches(), FrameSize::new(200, 100)).expect("one is lost");
        assert_eq!((lost.frame, lost.list.len(), lost.list[0].pixels), (2, 1, 5000));
        let [x, y] = lost.list[0].middle;
        assert!((x - 1.25).abs() < 1e-9 && (y - 0.5).abs() < 1e-9, "{x}, {y}");
        assert_eq!(lost.to_string(), "in frame 2 it leaves out 1 branch, 5000 pixels (5000 around 1.25, 0.50)");
        let mut still = two_branches();
        still.branches.remove(&2);
        assert_eq!(LostBranches::of(&still, FrameSize::new(200, 100)), None, "both rest");
    }
}
