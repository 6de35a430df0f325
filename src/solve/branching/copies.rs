//! The copies of handles: one for each connected component of the shape in a handle's support.
//!
//! In: the cuts and links of a shape. Out: for every part of a cell the copies that act on it, and ties, which tell how close copies of one
//! handle are to each other.

use super::cell_connections::{CellConnections, connection};
use super::cell_parts::{CellParts, ComponentFinder};
use super::cuts::Cut;
use super::support_box::{SupportBox, cells_between};
use super::tie_nodes::{Role, TieNodes};
use crate::disjoint_sets::DisjointSets;
use crate::lattice::Grid;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Largest number of copies of one handle. With more pieces in a support (grass, loose triangles) the largest have copies of their own, and all
/// others share one, as on a plain lattice: time and memory grow with the square of this number.
const MAX_COPIES: usize = 48;

/// The growth of a support at which two copies count about half as one.
const HALF_APART: f64 = 0.1;

/// Two copies of one handle whose pieces become connected when the support of the handle grows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tie {
    /// The copies.
    pub(super) copies: [usize; 2],
    /// Smallest growth of the support at which the pieces are connected, in spans, 0 to 1.
    pub(super) growth: f64,
}

/// The degree to which pairs of copies count as one: 1 if they are equal or have just split, 0 if the pieces of some pair are a
/// span apart.
pub(super) fn coupling_degree(ties: &[Tie], pairs: impl Iterator<Item = [usize; 2]>) -> f64 {
    let growth = |[one, other]: [usize; 2]| {
        let copies = [one.min(other), one.max(other)];
        let tie = || ties.binary_search_by_key(&copies, |tie| tie.copies);
        if one == other { 0.0 } else { tie().map_or(1.0, |place| ties[place].growth) }
    };
    let growth = pairs.map(growth).fold(0.0, f64::max).min(1.0);
    let near = (1.0 - growth).powi(2);
    near / (near + (growth / HALF_APART).powi(2))
}

/// All copies.
#[derive(Clone, Debug)]
pub(super) struct Copies {
    /// The handle of each copy, ascending.
    pub(super) handles: Vec<usize>,
    /// The first triangle in the piece of each copy.
    pub(super) first_triangles: Vec<usize>,
    /// The copies that act on each part of a cell, in the order of the cell's handles: #parts times #handles of a cell.
    of_parts: Vec<usize>,
    handles_per_cell: usize,
    /// Ties between copies of one handle, sorted by copies.
    pub(super) ties: Vec<Tie>,
}

impl Copies {
    /// The copies that act on a part of a cell, in the order of the cell's handles.
    pub(super) fn of_part(&self, part: usize) -> &[usize] {
        &self.of_parts[part * self.handles_per_cell..][..self.handles_per_cell]
    }
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

/// The first of the handles that act on a cell.
pub(super) fn first_handle_of_cell<const D: usize>(grid: &Grid<D>, cell: usize) -> usize {
    let place = grid.cell_coords(cell);
    (0..D).rev().fold(0, |handle, axis| handle * grid.dims[axis] + place[axis])
}

/// Finds all copies. `width` is the number of handles with a non-zero weight at a coordinate.
pub(super) fn copies<const D: usize>(grid: &Grid<D>, width: usize, cuts: &[Cut<D>], parts: &CellParts<D>) -> Copies {
    let handles_per_cell = width.pow(D as u32);
    let mut finder = Finder {
        grid,
        parts,
        components: ComponentFinder::new(parts),
        connections: CellConnections::new(grid, parts, cuts),
        nodes: TieNodes::new(parts),
    };
    let mut copies = Copies {
        handles: Vec::new(),
        first_triangles: Vec::new(),
        of_parts: vec![0; parts.len() * handles_per_cell],
        handles_per_cell,
        ties: Vec::new(),
    };
    for handle in 0..grid.handle_count() {
        let support = SupportBox::of(grid, width, handle);
        finder.add(handle, &support, width, &mut copies);
    }
    copies.ties.sort_by_key(|tie| tie.copies);
    copies
}

/// Finds the connected components of the shape in a support.
struct Finder<'a, const D: usize> {
    grid: &'a Grid<D>,
    parts: &'a CellParts<D>,
    components: ComponentFinder<'a, D>,
    connections: CellConnections<'a, D>,
    nodes: TieNodes<'a, D>,
}

impl<const D: usize> Finder<'_, D> {
    /// Adds the copies of a handle, in the order of their first triangles.
    fn add(&mut self, handle: usize, support: &SupportBox<D>, width: usize, copies: &mut Copies) {
        let cells = cells_between(self.grid, support.cells);
        let inside = self.components.components(&cells, |link| support.connects(link));
        if inside.parts.is_empty() {
            return;
        }
        let mut pieces: BTreeMap<usize, Piece> = BTreeMap::new();
        for (&part, &root) in inside.parts.iter().zip(&inside.roots) {
            let triangle = self.parts.first_triangle(part as usize);
            let piece = pieces.entry(root).or_insert(Piece { first_triangle: triangle, root, part_count: 0 });
            piece.first_triangle = piece.first_triangle.min(triangle);
            piece.part_count += 1;
        }
        let mut pieces: Vec<Piece> = pieces.into_values().collect();
        let smallest = split_off_smallest(&mut pieces);
        let first = copies.handles.len();
        let mut copy_of_root = vec![usize::MAX; inside.parts.len()];
        for pieces in pieces.chunks(1).chain((!smallest.is_empty()).then_some(&smallest[..])) {
            pieces.iter().for_each(|piece| copy_of_root[piece.root] = copies.handles.len());
            copies.handles.push(handle);
            copies.first_triangles.push(pieces[0].first_triangle);
        }
        for &cell in &cells {
            let slot = slot_in_cell(self.grid, width, cell, handle);
            for part in self.parts.in_cell(cell) {
                let root = inside.root_of(part as u32).unwrap_or_default();
                copies.of_parts[part * copies.handles_per_cell + slot] = copy_of_root[root];
            }
        }
        if copies.handles.len() > first + 1 {
            let copy_of = |(&part, &root): (&u32, &usize)| (part, copy_of_root[root]);
            let copy_of_part: Vec<(u32, usize)> = inside.parts.iter().zip(&inside.roots).map(copy_of).collect();
            copies.ties.extend(self.ties(support, &cells, (first..copies.handles.len(), &copy_of_part)));
        }
    }

    /// Ties between all pairs of copies of a handle, with the growth at which their pieces become connected (Kruskal's algorithm:
    /// the spanning tree contains the paths that need the least growth). The edges of the tree alone would change from frame to
    /// frame where two growths are equal. `copies`: those of the handle, with the copy of each part in the
    /// support.
    fn ties(
        &mut self,
        support: &SupportBox<D>,
        inside: &[usize],
        (copies, copy_of_part): (Range<usize>, &[(u32, usize)]),
    ) -> Vec<Tie> {
        let cells = cells_between(self.grid, support.grown(self.grid));
        // Copies in different components stay apart up to a growth of one.
        let around = self.components.components(&cells, |_| true);
        let mut copies_of_root = BTreeMap::<usize, BTreeSet<usize>>::new();
        for &(part, copy) in copy_of_part {
            copies_of_root.entry(around.root_of(part).unwrap_or_default()).or_default().insert(copy);
        }
        let mut missing: usize = copies_of_root.values().map(|copies| copies.len() - 1).sum();
        if missing == 0 {
            return Vec::new();
        }
        let is_tied = |root: &usize| copies_of_root.get(root).is_some_and(|copies| copies.len() > 1);
        let tied = around.parts.iter().zip(&around.roots).filter(|(_, root)| is_tied(root));
        tied.for_each(|(&part, _)| self.nodes.set_role(part, Role::Beside));
        let number = |copy: usize| Role::Copy((copy - copies.start) as u32);
        copy_of_part.iter().for_each(|&(part, copy)| self.nodes.set_role(part, number(copy)));
        self.nodes.start_with(copies.len());
        let mut links = Vec::new();
        for &cell in &cells {
            if !self.nodes.has_any(self.parts.in_cell(cell)) {
                continue;
            }
            if inside.binary_search(&cell).is_err() {
                let connections = self.connections.beside(support, cell).iter();
                links.extend(connections.filter_map(|&(growth, pair)| Some((growth, self.nodes.pair(pair)?))));
            }
            for link in self.parts.between(cell) {
                let pair = self.nodes.pair(link.triangles.map(|triangle| triangle as u32));
                links.extend(pair.and_then(|pair| connection(support, link, pair)));
            }
        }
        links.sort_unstable_by_key(|(growth, _)| *growth);
        let mut pieces = DisjointSets::of(self.nodes.count());
        let mut copies_of_piece: BTreeMap<usize, Vec<usize>> = copies.map(|copy| vec![copy]).enumerate().collect();
        let mut ties = Vec::new();
        for (growth, pair) in links {
            let [a, b] = pair.map(|node| pieces.root(node as usize));
            if a == b {
                continue;
            }
            let [ours, theirs] = [a, b].map(|root| copies_of_piece.remove(&root).unwrap_or_default());
            let pairs = ours.iter().flat_map(|&one| theirs.iter().map(move |&other| [one.min(other), one.max(other)]));
            ties.extend(pairs.map(|copies| Tie { copies, growth: f64::from_bits(growth) }));
            pieces.join([a, b]);
            if !ours.is_empty() && !theirs.is_empty() {
                missing -= 1;
                if missing == 0 {
                    break;
                }
            }
            let together = [ours, theirs].concat();
            if !together.is_empty() {
                copies_of_piece.insert(pieces.root(a), together);
            }
        }
        self.nodes.clear(&around.parts);
        ties
    }
}

/// A connected piece of the shape in a support.
struct Piece {
    first_triangle: usize,
    /// Its root among the components.
    root: usize,
    /// Number of its parts of cells.
    part_count: usize,
}

/// Sorts pieces by first triangle. With more than [`MAX_COPIES`] the smallest are taken out and returned.
fn split_off_smallest(pieces: &mut Vec<Piece>) -> Vec<Piece> {
    let mut smallest = Vec::new();
    if pieces.len() > MAX_COPIES {
        pieces.sort_unstable_by_key(|piece| (Reverse(piece.part_count), piece.first_triangle));
        smallest = pieces.split_off(MAX_COPIES - 1);
    }
    for pieces in [pieces, &mut smallest] {
        pieces.sort_unstable_by_key(|piece| piece.first_triangle);
    }
    smallest
}

/// Position of a handle among those of a cell.
fn slot_in_cell<const D: usize>(grid: &Grid<D>, width: usize, cell: usize, handle: usize) -> usize {
    let (first, place) = (grid.cell_coords(cell), grid.handle_coords(handle));
    (0..D).rev().fold(0, |slot, axis| slot * width + place[axis] - first[axis])
}
