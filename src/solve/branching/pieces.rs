//! Pieces of the shape in the cells of a grid, and branches: sets of pieces over which the lattice is a plain one.
//!
//! In: cuts with their copies. Out: pieces, their adjacency, and the branch of each.

use super::cell_parts::CellParts;
use super::copies::{Copies, Tie, coupling_degree, first_handle_of_cell, handles_of_cell};
use super::cuts::Cut;
use crate::lattice::Grid;
use std::collections::VecDeque;
use std::ops::Range;

/// A part of the shape that lies in one cell and on which the same copies act.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    /// Index of the cell.
    pub(super) cell: usize,
    /// The copies that act on the piece, in the order of the cell's handles.
    pub(super) copies: Vec<usize>,
    /// Area of the piece.
    pub(super) area: f64,
}

/// All pieces.
#[derive(Clone, Debug)]
pub(super) struct Pieces {
    /// The pieces, sorted by cell.
    pub(super) list: Vec<Piece>,
    /// The piece of each cut, #cuts.
    pub(super) of_cuts: Vec<usize>,
    /// Pieces of adjacent cells that have the same copies of all handles that act on both, #pieces, ascending.
    pub(super) neighbours: Vec<Vec<usize>>,
    /// All pieces of adjacent cells, #pieces, ascending, each with the degree to which the two pieces' copies of the handles that act on
    /// both count as one.
    pub(super) adjacent_pieces: Vec<Vec<(usize, f64)>>,
}

impl Pieces {
    /// Groups the parts of cells by cell and copies.
    pub(super) fn of<const D: usize>(
        grid: &Grid<D>,
        width: usize,
        cuts: &[Cut<D>],
        (parts, copies): (&CellParts<D>, &Copies),
    ) -> Self {
        let cells: Vec<usize> =
            (0..grid.cell_count()).flat_map(|cell| parts.in_cell(cell).map(move |_| cell)).collect();
        let key = |&part: &usize| (cells[part], copies.of_part(part));
        let mut order: Vec<usize> = (0..parts.len()).collect();
        order.sort_by(|a, b| key(a).cmp(&key(b)).then(a.cmp(b)));
        let (mut list, mut of_parts) = (Vec::<Piece>::new(), vec![0; parts.len()]);
        for same in order.chunk_by(|a, b| key(a) == key(b)) {
            same.iter().for_each(|&part| of_parts[part] = list.len());
            list.push(Piece { cell: cells[same[0]], copies: copies.of_part(same[0]).to_vec(), area: 0.0 });
        }
        let of_cuts: Vec<usize> = parts.of_cuts.iter().map(|&part| of_parts[part as usize]).collect();
        cuts.iter().zip(&of_cuts).for_each(|(cut, &piece)| list[piece].area += cut.area);
        let mut pieces = Self {
            neighbours: vec![Vec::new(); list.len()],
            adjacent_pieces: vec![Vec::new(); list.len()],
            list,
            of_cuts,
        };
        pieces.find_adjacent(grid, width, &copies.ties);
        pieces
    }

    /// The pieces of a cell.
    pub(super) fn in_cell(&self, cell: usize) -> Range<usize> {
        self.list.partition_point(|piece| piece.cell < cell)..self.list.partition_point(|piece| piece.cell <= cell)
    }

    /// The branch of every piece, and for every branch the copy of each handle (`None` if the branch has no copy of it). Branches
    /// are grown from the largest remaining piece over its neighbours, as long as no handle would need two copies.
    pub(super) fn branches<const D: usize>(
        &self,
        grid: &Grid<D>,
        width: usize,
    ) -> (Vec<usize>, Vec<Vec<Option<usize>>>) {
        let offsets = handles_of_cell(grid, width, 0);
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
                let first = first_handle_of_cell(grid, *cell);
                let handles = || offsets.iter().map(|offset| first + offset);
                let all_fit = handles().zip(wanted).all(|(handle, &copy)| fits(&copies, handle, copy));
                if branch_of[piece] != usize::MAX || !all_fit {
                    continue;
                }
                branch_of[piece] = branches.len();
                handles().zip(wanted).for_each(|(handle, &copy)| copies[handle] = Some(copy));
                waiting.extend(&self.neighbours[piece]);
            }
            branches.push(copies);
        }
        (branch_of, branches)
    }

    /// Finds the pieces of adjacent cells.
    fn find_adjacent<const D: usize>(&mut self, grid: &Grid<D>, width: usize, ties: &[Tie]) {
        let mut cell_stride = 1;
        for axis in 0..D {
            let spans = grid.basis.spans(grid.dims[axis]);
            // Pairs of positions in a cell and in the next one along the axis, of the handles that act on both.
            let slot_stride = width.pow(axis as u32);
            let slots: Vec<[usize; 2]> = (0..width.pow(D as u32))
                .filter(|slot| !(slot / slot_stride).is_multiple_of(width))
                .map(|slot| [slot, slot - slot_stride])
                .collect();
            for number in 0..self.list.len() {
                let piece = &self.list[number];
                if grid.cell_coords(piece.cell)[axis] + 1 == spans {
                    continue;
                }
                for next in self.in_cell(piece.cell + cell_stride) {
                    let copies = |&[own, theirs]: &[usize; 2]| [piece.copies[own], self.list[next].copies[theirs]];
                    let is_one = slots.iter().map(copies).all(|[own, theirs]| own == theirs);
                    let degree = if is_one { 1.0 } else { coupling_degree(ties, slots.iter().map(copies)) };
                    self.adjacent_pieces[number].push((next, degree));
                    self.adjacent_pieces[next].push((number, degree));
                    if is_one {
                        self.neighbours[number].push(next);
                        self.neighbours[next].push(number);
                    }
                }
            }
            cell_stride *= spans;
        }
        self.neighbours.iter_mut().for_each(|own| own.sort_unstable());
        self.adjacent_pieces.iter_mut().for_each(|own| own.sort_unstable_by_key(|(next, _)| *next));
    }
}
