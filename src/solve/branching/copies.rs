//! The copies of handles: one for each connected component of the shape in a handle's support.
//!
//! In: the cuts and links of a shape. Out: for every cut the copies that act on it, and ties, which tell how close copies of one
//! handle are to each other.

use super::adjacency::{Adjacency, PlacedLink};
use super::cuts::Cut;
use super::disjoint_sets::DisjointSets;
use super::support_box::{SupportBox, cells_between};
use crate::lattice::Grid;
use std::collections::BTreeMap;

/// Two copies of one handle whose pieces become connected when the support of the handle grows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tie {
    /// The copies.
    pub(super) copies: [usize; 2],
    /// Smallest growth of the support at which the pieces are connected, in spans, 0 to 1.
    pub(super) growth: f64,
}

/// All copies.
#[derive(Clone, Debug)]
pub(super) struct Copies {
    /// The handle of each copy, ascending.
    pub(super) handles: Vec<usize>,
    /// The first triangle in the piece of each copy.
    pub(super) first_triangles: Vec<usize>,
    /// The copies that act on each cut, in the order of the cell's handles: #cuts times #handles of a cell.
    pub(super) of_cuts: Vec<usize>,
    /// Ties between copies of one handle, sorted by copies.
    pub(super) ties: Vec<Tie>,
}

/// The handles of a tensor basis that act on a cell, ascending; `width` per axis.
pub(super) fn handles_of_cell<const D: usize>(grid: &Grid<D>, width: usize, cell: usize) -> Vec<usize> {
    let first = grid.cell_coords(cell);
    let mut handles = vec![0];
    for axis in (0..D).rev() {
        let count = grid.dims[axis];
        handles = handles.iter().flat_map(|handle| (0..width).map(move |k| handle * count + first[axis] + k)).collect();
    }
    handles
}

/// Finds all copies. `width` is the number of handles with a non-zero weight at a coordinate.
pub(super) fn copies<const D: usize>(
    grid: &Grid<D>,
    width: usize,
    cuts: &[Cut<D>],
    adjacency: &Adjacency<D>,
) -> Copies {
    let handles_per_cell = width.pow(D as u32);
    let mut finder = Finder {
        grid,
        adjacency,
        cuts,
        cuts_of_cell: cuts_by_cell(grid.cell_count(), cuts),
        place_of: vec![usize::MAX; cuts.last().map_or(0, |cut| cut.triangle + 1)],
    };
    let mut copies = Copies {
        handles: Vec::new(),
        first_triangles: Vec::new(),
        of_cuts: vec![0; cuts.len() * handles_per_cell],
        ties: Vec::new(),
    };
    for handle in 0..grid.handle_count() {
        let support = SupportBox::of(grid, width, handle);
        finder.add(handle, &support, width, &mut copies);
    }
    copies.ties.sort_by_key(|tie| tie.copies);
    copies
}

fn cuts_by_cell<const D: usize>(count: usize, cuts: &[Cut<D>]) -> Vec<Vec<usize>> {
    let mut of_cell = vec![Vec::new(); count];
    cuts.iter().enumerate().for_each(|(number, cut)| of_cell[cut.cell].push(number));
    of_cell
}

/// Finds the connected components of the shape in a support.
struct Finder<'a, const D: usize> {
    grid: &'a Grid<D>,
    adjacency: &'a Adjacency<D>,
    cuts: &'a [Cut<D>],
    cuts_of_cell: Vec<Vec<usize>>,
    /// Position of each triangle in the list being processed, #triangles; `usize::MAX` if it is not in the list.
    place_of: Vec<usize>,
}

impl<const D: usize> Finder<'_, D> {
    /// Adds the copies of a handle.
    fn add(&mut self, handle: usize, support: &SupportBox<D>, width: usize, copies: &mut Copies) {
        let cells = cells_between(self.grid, support.cells);
        let triangles = self.triangles_in(&cells);
        if triangles.is_empty() {
            return;
        }
        let mut pieces = DisjointSets::of(triangles.len());
        for (link, pair) in self.links_among(&triangles) {
            if support.connects(link) {
                pieces.join(pair);
            }
        }
        let first = copies.handles.len();
        let mut copy_of_root = vec![usize::MAX; triangles.len()];
        for (place, &triangle) in triangles.iter().enumerate() {
            let root = pieces.root(place);
            if copy_of_root[root] == usize::MAX {
                copy_of_root[root] = copies.handles.len();
                copies.handles.push(handle);
                copies.first_triangles.push(triangle);
            }
        }
        let of_triangle: Vec<usize> = (0..triangles.len()).map(|place| copy_of_root[pieces.root(place)]).collect();
        let per_cut = width.pow(D as u32);
        for &cell in &cells {
            let slot = slot_in_cell(self.grid, width, cell, handle);
            for &cut in &self.cuts_of_cell[cell] {
                copies.of_cuts[cut * per_cut + slot] = of_triangle[self.place_of[self.cuts[cut].triangle]];
            }
        }
        self.forget(&triangles);
        if copies.handles.len() > first + 1 {
            let inside: Vec<(usize, usize)> = triangles.into_iter().zip(of_triangle).collect();
            copies.ties.extend(self.ties(support, &inside));
        }
    }

    /// Ties between all pairs of copies of a handle, with the growth at which their pieces become connected (Kruskal's algorithm:
    /// the spanning tree contains the paths that need the least growth). The edges of the tree alone would change from frame to
    /// frame where two growths are equal.
    fn ties(&mut self, support: &SupportBox<D>, inside: &[(usize, usize)]) -> Vec<Tie> {
        let cells = cells_between(self.grid, support.grown(self.grid));
        let triangles = self.triangles_in(&cells);
        let mut pieces = DisjointSets::of(triangles.len());
        let mut first_of_copy = BTreeMap::new();
        for &(triangle, copy) in inside {
            let place = self.place_of[triangle];
            pieces.join([place, *first_of_copy.entry(copy).or_insert(place)]);
        }
        let mut copies_at = vec![Vec::new(); triangles.len()];
        first_of_copy.into_iter().for_each(|(copy, place)| copies_at[pieces.root(place)].push(copy));
        // Most links lie within one copy, and need no growth.
        let mut links: Vec<(f64, [usize; 2])> = Vec::new();
        for (link, pair) in self.links_among(&triangles) {
            if pieces.root(pair[0]) != pieces.root(pair[1])
                && let Some(growth) = support.growth_below_one(link)
            {
                links.push((growth, pair));
            }
        }
        links.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut ties = Vec::new();
        for (growth, pair) in links {
            let [a, b] = pair.map(|place| pieces.root(place));
            if a == b {
                continue;
            }
            let [ours, theirs] = [a, b].map(|root| std::mem::take(&mut copies_at[root]));
            let pairs = ours.iter().flat_map(|&one| theirs.iter().map(move |&other| [one.min(other), one.max(other)]));
            ties.extend(pairs.map(|copies| Tie { copies, growth: growth.max(0.0) }));
            pieces.join([a, b]);
            copies_at[pieces.root(a)] = [ours, theirs].concat();
        }
        self.forget(&triangles);
        ties
    }

    /// The triangles with a part in the given cells, ascending. Their positions stay in `place_of` until [`Self::forget`] is
    /// called.
    fn triangles_in(&mut self, cells: &[usize]) -> Vec<usize> {
        let mut triangles = Vec::new();
        for &cut in cells.iter().flat_map(|&cell| &self.cuts_of_cell[cell]) {
            let triangle = self.cuts[cut].triangle;
            if self.place_of[triangle] == usize::MAX {
                self.place_of[triangle] = 0;
                triangles.push(triangle);
            }
        }
        triangles.sort_unstable();
        triangles.iter().enumerate().for_each(|(place, &triangle)| self.place_of[triangle] = place);
        triangles
    }

    fn forget(&mut self, triangles: &[usize]) {
        triangles.iter().for_each(|&triangle| self.place_of[triangle] = usize::MAX);
    }

    /// The links between the given triangles, with the positions of both.
    fn links_among(&self, triangles: &[usize]) -> impl Iterator<Item = (&PlacedLink<D>, [usize; 2])> {
        let links = triangles.iter().flat_map(|&triangle| self.adjacency.from(triangle));
        links.filter_map(|link| {
            let pair = link.triangles.map(|triangle| self.place_of.get(triangle).copied().unwrap_or(usize::MAX));
            (pair[1] != usize::MAX).then_some((link, pair))
        })
    }
}

/// Position of a handle among those of a cell.
fn slot_in_cell<const D: usize>(grid: &Grid<D>, width: usize, cell: usize, handle: usize) -> usize {
    let (first, place) = (grid.cell_coords(cell), grid.handle_coords(handle));
    (0..D).rev().fold(0, |slot, axis| slot * width + place[axis] - first[axis])
}
