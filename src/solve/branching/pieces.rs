//! Pieces of the shape in the cells of a grid, and branches: sets of pieces on which the lattice is a plain one.
//!
//! In: cuts with their copies. Out: pieces, those that continue each other, and the branch of each.

use super::copies::{Copies, handles_of_cell};
use super::cuts::Cut;
use crate::lattice::Grid;
use std::collections::{BTreeSet, VecDeque};

/// What one cell holds of the shape under the same copies.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    /// Number of the cell.
    pub(super) cell: usize,
    /// Copies that act on it, in the order of the cell's handles.
    pub(super) copies: Vec<usize>,
    /// Its area.
    pub(super) area: f64,
}

/// All pieces.
#[derive(Clone, Debug)]
pub(super) struct Pieces {
    /// By cell.
    pub(super) list: Vec<Piece>,
    /// The piece of each cut, #cuts.
    pub(super) of_cuts: Vec<usize>,
    /// Pieces of neighbouring cells that a triangle joins, #pieces, ascending.
    pub(super) neighbours: Vec<Vec<usize>>,
}

impl Pieces {
    /// Groups cuts by cell and copies.
    pub(super) fn of<const D: usize>(grid: &Grid<D>, cuts: &[Cut<D>], copies: &Copies) -> Self {
        let per_cut = copies.of_cuts.len() / cuts.len().max(1);
        let copies_of = |cut: usize| &copies.of_cuts[cut * per_cut..][..per_cut];
        let key = |&cut: &usize| (cuts[cut].cell, copies_of(cut));
        let mut order: Vec<usize> = (0..cuts.len()).collect();
        order.sort_by(|a, b| key(a).cmp(&key(b)).then(a.cmp(b)));
        let (mut list, mut of_cuts) = (Vec::new(), vec![0; cuts.len()]);
        for same in order.chunk_by(|a, b| key(a) == key(b)) {
            same.iter().for_each(|&cut| of_cuts[cut] = list.len());
            let area = same.iter().map(|&cut| cuts[cut].area).sum();
            list.push(Piece { cell: cuts[same[0]].cell, copies: copies_of(same[0]).to_vec(), area });
        }
        let mut neighbours = vec![BTreeSet::new(); list.len()];
        let mut start = 0;
        for cuts_of_triangle in cuts.chunk_by(|a, b| a.triangle == b.triangle) {
            for (a, one) in cuts_of_triangle.iter().enumerate() {
                for (b, other) in cuts_of_triangle.iter().enumerate().skip(a + 1) {
                    // A triangle that meets two cells side by side crosses the face between them: both are convex.
                    if are_side_by_side(grid.cell_coords(one.cell), grid.cell_coords(other.cell)) {
                        let [a, b] = [a, b].map(|place| of_cuts[start + place]);
                        neighbours[a].insert(b);
                        neighbours[b].insert(a);
                    }
                }
            }
            start += cuts_of_triangle.len();
        }
        let neighbours = neighbours.into_iter().map(|set| set.into_iter().collect()).collect();
        Self { list, of_cuts, neighbours }
    }

    /// The branch of every piece, and for every branch the copy of each handle (`None`: the branch has none), from the
    /// largest piece on: each grows over neighbouring pieces as long as no handle would need two copies.
    pub(super) fn branches<const D: usize>(
        &self,
        grid: &Grid<D>,
        width: usize,
    ) -> (Vec<usize>, Vec<Vec<Option<usize>>>) {
        let mut branch_of = vec![usize::MAX; self.list.len()];
        let mut branches: Vec<Vec<Option<usize>>> = Vec::new();
        let mut seeds: Vec<usize> = (0..self.list.len()).collect();
        seeds.sort_by(|&a, &b| self.list[b].area.total_cmp(&self.list[a].area).then(a.cmp(&b)));
        for seed in seeds {
            if branch_of[seed] != usize::MAX {
                continue;
            }
            let mut copies = vec![None; grid.handle_count()];
            let mut waiting = VecDeque::from([seed]);
            while let Some(piece) = waiting.pop_front() {
                let fits = |copies: &[Option<usize>], handle: usize, copy: usize| {
                    copies[handle].is_none_or(|known| known == copy)
                };
                let Piece { cell, copies: wanted, .. } = &self.list[piece];
                let handles = handles_of_cell(grid, width, *cell);
                let all_fit = handles.iter().zip(wanted).all(|(&handle, &copy)| fits(&copies, handle, copy));
                if branch_of[piece] != usize::MAX || !all_fit {
                    continue;
                }
                branch_of[piece] = branches.len();
                handles.iter().zip(wanted).for_each(|(&handle, &copy)| copies[handle] = Some(copy));
                waiting.extend(&self.neighbours[piece]);
            }
            branches.push(copies);
        }
        (branch_of, branches)
    }
}

fn are_side_by_side<const D: usize>(one: [usize; D], other: [usize; D]) -> bool {
    one.iter().zip(&other).map(|(a, b)| a.abs_diff(*b)).sum::<usize>() == 1
}
