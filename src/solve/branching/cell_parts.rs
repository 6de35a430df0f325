//! The connected parts of a shape in each cell of a grid.
//!
//! In: cuts and links. Out: the part of each cut, and the components that the parts of a box of cells form. A link inside a cell
//! connects in every box that contains the cell, so boxes are searched part by part instead of triangle by triangle.

use super::adjacency::{Adjacency, PlacedLink};
use super::cuts::Cut;
use super::link::LinkKind;
use super::support_box::{ROUNDING, SupportBox};
use crate::disjoint_sets::DisjointSets;
use crate::lattice::Grid;
use std::ops::Range;

/// Stands for a part or triangle that is not in a box.
const NONE: u32 = u32::MAX;

/// Largest number of cells in which a triangle's parts are connected pair by pair.
const PAIRED_CELLS: usize = 8;

/// The connected parts of a shape in each cell, sorted by cell.
#[derive(Clone, Debug)]
pub(super) struct CellParts<const D: usize> {
    /// The part of each cut, #cuts.
    pub(super) of_cuts: Vec<u32>,
    /// First part of each cell, #cells + 1.
    first_of_cell: Vec<u32>,
    /// First triangle of each part, #parts.
    first_triangles: Vec<u32>,
    /// Whether a triangle is connected beyond a cell, #triangles: it has cuts in several cells, or is the end of a link that is not inside
    /// a cell.
    is_terminal: Vec<bool>,
    /// Links inside each cell, #cells.
    inside: Vec<Vec<PlacedLink<D>>>,
    /// All other links, at the cells that they lead from or through, #cells.
    between: Vec<Vec<PlacedLink<D>>>,
    /// Pairs of parts of two cells that are connected in every box that contains both cells, at the cell of the first part, #cells.
    across: Vec<Vec<[u32; 2]>>,
    /// Triangles in more than [`PAIRED_CELLS`] cells, each with its part, #cells.
    wide: Vec<Vec<[u32; 2]>>,
    /// Links that are inside of no cell, as along a border between two, at the cells of their first triangle, #cells.
    on_borders: Vec<Vec<PlacedLink<D>>>,
    /// First cut of each triangle, #triangles + 1.
    first_cuts: Vec<u32>,
}

impl<const D: usize> CellParts<D> {
    /// Finds the parts. `cuts` are sorted by triangle.
    pub(super) fn of(grid: &Grid<D>, cuts: &[Cut<D>], adjacency: &Adjacency<D>) -> Self {
        let triangle_count = cuts.last().map_or(0, |cut| cut.triangle + 1);
        let mut first_cuts = vec![0_u32; triangle_count + 1];
        cuts.iter().for_each(|cut| first_cuts[cut.triangle + 1] += 1);
        (0..triangle_count).for_each(|triangle| first_cuts[triangle + 1] += first_cuts[triangle]);
        let cuts_of = |triangle: usize| {
            let [first, end] = [*first_cuts.get(triangle)?, *first_cuts.get(triangle + 1)?];
            Some(first as usize..end as usize)
        };
        let mut sets = DisjointSets::of(cuts.len());
        let lists = || vec![Vec::new(); grid.cell_count()];
        let (mut across, mut inside, mut between, mut on_borders) = (Vec::new(), lists(), lists(), lists());
        let mut is_terminal = vec![false; triangle_count];
        for link in (0..triangle_count).flat_map(|triangle| adjacency.from(triangle)) {
            let cells = link.ends.each_ref().map(|end| SupportBox::cell_inside(grid, end));
            let cut_in = |end: usize, cell: usize| {
                let own = cuts_of(link.triangles[end])?;
                own.into_iter().find(|&cut| cuts[cut].cell == cell)
            };
            let pair_in = |[from, to]: [usize; 2]| Some([cut_in(0, from)?, cut_in(1, to)?]);
            if let [Some(from), Some(to)] = cells
                && from == to
                && join(&mut sets, pair_in([from, to]))
            {
                inside[from].push(*link);
                continue;
            }
            // A box that has grown to a link contains the start of one across a gap, and a part of an edge.
            let way = match link.kind {
                LinkKind::Edge => link.ends,
                LinkKind::Across => [link.ends[0]; 2],
            };
            let around = SupportBox::cells_around(grid, &way);
            let is_placed = match (link.kind, cells) {
                (LinkKind::Edge, _) => {
                    let mut is_placed = true;
                    for &cell in &around {
                        is_placed &= match SupportBox::of_cell(grid, cell).growth(&link.ends) {
                            growth if growth < -ROUNDING => join(&mut sets, pair_in([cell, cell])),
                            // Each box has to tell whether it meets what only touches the cell.
                            growth => growth > ROUNDING,
                        };
                    }
                    is_placed
                }
                (LinkKind::Across, [Some(from), Some(to)]) => {
                    let pair = pair_in([from, to]);
                    across.extend(pair);
                    pair.is_some()
                }
                (LinkKind::Across, _) => false,
            };
            around.into_iter().for_each(|cell| between[cell].push(*link));
            if !is_placed {
                let own = cuts_of(link.triangles[0]).into_iter().flatten();
                own.for_each(|cut| on_borders[cuts[cut].cell].push(*link));
            }
            for end in link.triangles.into_iter().filter(|&end| end < triangle_count) {
                is_terminal[end] = true;
            }
        }
        let mut parts = Self::numbered(grid.cell_count(), cuts, sets, first_cuts);
        (parts.inside, parts.between, parts.on_borders) = (inside, between, on_borders);
        parts.is_terminal = is_terminal;
        parts.add_wide_triangles(cuts);
        let mut pairs: Vec<[u32; 2]> = across.into_iter().map(|pair| pair.map(|cut| parts.of_cuts[cut])).collect();
        for own in (0..triangle_count).filter_map(|triangle| parts.parts_of(triangle)) {
            if own.len() <= PAIRED_CELLS {
                let of = |(k, &from): (usize, &u32)| own[k + 1..].iter().map(move |&to| [from, to]);
                pairs.extend(own.iter().enumerate().flat_map(of));
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
        for pair in pairs {
            let cell = parts.cell_of(pair[0]);
            parts.across[cell].push(pair);
        }
        parts
    }

    /// Numbers the sets of cuts by their cells.
    fn numbered(cell_count: usize, cuts: &[Cut<D>], mut sets: DisjointSets, first_cuts: Vec<u32>) -> Self {
        let mut of_cell: Vec<Vec<u32>> = vec![Vec::new(); cell_count];
        for (number, cut) in cuts.iter().enumerate() {
            if sets.root(number) == number {
                of_cell[cut.cell].push(number as u32);
            }
        }
        let (mut part_of_root, mut first_triangles) = (vec![NONE; cuts.len()], Vec::new());
        let mut first_of_cell = vec![0];
        for roots in of_cell {
            for root in roots {
                part_of_root[root as usize] = first_triangles.len() as u32;
                first_triangles.push(cuts[root as usize].triangle as u32);
            }
            first_of_cell.push(first_triangles.len() as u32);
        }
        Self {
            of_cuts: (0..cuts.len()).map(|cut| part_of_root[sets.root(cut)]).collect(),
            first_of_cell,
            first_triangles,
            is_terminal: Vec::new(),
            inside: Vec::new(),
            between: Vec::new(),
            across: vec![Vec::new(); cell_count],
            wide: vec![Vec::new(); cell_count],
            on_borders: Vec::new(),
            first_cuts,
        }
    }

    /// Notes the triangles in several cells.
    fn add_wide_triangles(&mut self, cuts: &[Cut<D>]) {
        for (cut, &part) in cuts.iter().zip(&self.of_cuts) {
            let count = (self.first_cuts[cut.triangle + 1] - self.first_cuts[cut.triangle]) as usize;
            self.is_terminal[cut.triangle] |= count > 1;
            if count > PAIRED_CELLS {
                self.wide[cut.cell].push([cut.triangle as u32, part]);
            }
        }
    }

    /// Whether a triangle is connected beyond a cell.
    pub(super) fn is_terminal(&self, triangle: usize) -> bool {
        self.is_terminal[triangle]
    }

    /// Links inside a cell.
    pub(super) fn inside(&self, cell: usize) -> &[PlacedLink<D>] {
        &self.inside[cell]
    }

    /// Links that are inside of no cell or of several, at the cells that they lead from or through.
    pub(super) fn between(&self, cell: usize) -> &[PlacedLink<D>] {
        &self.between[cell]
    }

    /// Number of parts.
    pub(super) fn len(&self) -> usize {
        self.first_triangles.len()
    }

    /// Number of triangles with a part.
    pub(super) fn triangle_count(&self) -> usize {
        self.first_cuts.len() - 1
    }

    /// The parts of a cell.
    pub(super) fn in_cell(&self, cell: usize) -> Range<usize> {
        self.first_of_cell[cell] as usize..self.first_of_cell[cell + 1] as usize
    }

    /// The cell of a part.
    pub(super) fn cell_of(&self, part: u32) -> usize {
        self.first_of_cell.partition_point(|&first| first <= part) - 1
    }

    /// The first triangle of a part.
    pub(super) fn first_triangle(&self, part: usize) -> usize {
        self.first_triangles[part] as usize
    }

    /// The parts of a triangle; `None` for triangles after the last one with a part.
    pub(super) fn parts_of(&self, triangle: usize) -> Option<&[u32]> {
        let [first, end] = [*self.first_cuts.get(triangle)?, *self.first_cuts.get(triangle + 1)?];
        Some(&self.of_cuts[first as usize..end as usize])
    }
}

/// Unites the sets of two cuts; returns false if there are none.
fn join(sets: &mut DisjointSets, cuts: Option<[usize; 2]>) -> bool {
    cuts.map(|cuts| sets.join(cuts)).is_some()
}

/// Finds the components that the parts of boxes of cells form.
pub(super) struct ComponentFinder<'a, const D: usize> {
    parts: &'a CellParts<D>,
    /// Position of each part among those of the box, #parts.
    place_of_part: Vec<u32>,
    /// A part of each wide triangle in the box, #triangles.
    part_of_triangle: Vec<u32>,
}

/// The parts in a box of cells, with their components.
pub(super) struct Components {
    /// The parts, ascending.
    pub(super) parts: Vec<u32>,
    /// The component of each of these parts: the position of its first part.
    pub(super) roots: Vec<usize>,
}

impl Components {
    /// The component of a part of the box.
    pub(super) fn root_of(&self, part: u32) -> Option<usize> {
        self.parts.binary_search(&part).ok().map(|place| self.roots[place])
    }
}

impl<'a, const D: usize> ComponentFinder<'a, D> {
    pub(super) fn new(parts: &'a CellParts<D>) -> Self {
        Self { parts, place_of_part: vec![NONE; parts.len()], part_of_triangle: vec![NONE; parts.triangle_count()] }
    }

    /// The components of these cells, ascending, which form a box. `connects` says whether the box connects the triangles of a link that
    /// is inside of no cell.
    pub(super) fn components(&mut self, cells: &[usize], connects: impl Fn(&PlacedLink<D>) -> bool) -> Components {
        let parts: Vec<u32> = cells.iter().flat_map(|&cell| self.parts.in_cell(cell)).map(|part| part as u32).collect();
        parts.iter().zip(0..).for_each(|(&part, place)| self.place_of_part[part as usize] = place);
        let mut sets = DisjointSets::of(parts.len());
        let place = |places: &[u32], part: u32| places[part as usize] as usize;
        for &[triangle, part] in cells.iter().flat_map(|&cell| &self.parts.wide[cell]) {
            match &mut self.part_of_triangle[triangle as usize] {
                known if *known == NONE => *known = part,
                known => sets.join([*known, part].map(|part| place(&self.place_of_part, part))),
            }
        }
        for &[from, to] in cells.iter().flat_map(|&cell| &self.parts.across[cell]) {
            if self.place_of_part[to as usize] != NONE {
                sets.join([from, to].map(|part| place(&self.place_of_part, part)));
            }
        }
        for link in cells.iter().flat_map(|&cell| &self.parts.on_borders[cell]).filter(|link| connects(link)) {
            let in_box = |triangle: usize| {
                let mut places = self.parts.parts_of(triangle)?.iter().map(|&part| self.place_of_part[part as usize]);
                places.find(|&place| place != NONE)
            };
            if let [Some(from), Some(to)] = link.triangles.map(in_box) {
                sets.join([from as usize, to as usize]);
            }
        }
        for &[triangle, _] in cells.iter().flat_map(|&cell| &self.parts.wide[cell]) {
            self.part_of_triangle[triangle as usize] = NONE;
        }
        parts.iter().for_each(|&part| self.place_of_part[part as usize] = NONE);
        let roots = (0..parts.len()).map(|place| sets.root(place)).collect();
        Components { parts, roots }
    }
}

#[cfg(test)]
mod tests {
    use super::super::copies::{Tie, copies, handles_of_cell};
    use super::super::cuts::cuts;
    use super::super::support_box::cells_between;
    use super::*;
    use crate::lattice::Basis;
    use crate::solve::branching::{Link, LinkEnd};
    use crate::solve::problem::Shape;
    use proptest::prelude::*;
    use std::collections::BTreeSet;
    use std::sync::Arc;

    /// Pieces of each handle's support by search over all links, as sorted sets of cuts.
    fn searched(grid: &Grid<2>, width: usize, shape: &Shape<2>) -> Vec<Vec<Vec<usize>>> {
        let (cuts, adjacency) = (cuts(grid, shape), Adjacency::of(shape));
        let of_handle = |handle: usize| {
            let support = SupportBox::of(grid, width, handle);
            let cells = cells_between(grid, support.cells);
            let inside: Vec<usize> = (0..cuts.len()).filter(|&cut| cells.contains(&cuts[cut].cell)).collect();
            let mut sets = DisjointSets::of(shape.triangles.len());
            for link in (0..shape.triangles.len()).flat_map(|triangle| adjacency.from(triangle)) {
                let is_in = |&triangle: &usize| inside.iter().any(|&cut| cuts[cut].triangle == triangle);
                if link.triangles.iter().all(is_in) && support.connects(link) {
                    sets.join(link.triangles);
                }
            }
            let mut pieces = std::collections::BTreeMap::<usize, Vec<usize>>::new();
            inside.iter().for_each(|&cut| pieces.entry(sets.root(cuts[cut].triangle)).or_default().push(cut));
            let mut pieces: Vec<Vec<usize>> = pieces.into_values().collect();
            pieces.sort();
            pieces
        };
        (0..grid.handle_count()).map(of_handle).collect()
    }

    /// A tie: the handle, the first triangles of both pieces, the growth.
    type NamedTie = (usize, [usize; 2], f64);

    /// The ties of each handle by search over all links, sorted.
    fn searched_ties(grid: &Grid<2>, width: usize, shape: &Shape<2>) -> Vec<NamedTie> {
        let (cuts, adjacency) = (cuts(grid, shape), Adjacency::of(shape));
        let mut ties = Vec::new();
        for handle in 0..grid.handle_count() {
            let support = SupportBox::of(grid, width, handle);
            let triangles_in = |cells: Vec<usize>| -> BTreeSet<usize> {
                cuts.iter().filter(|cut| cells.contains(&cut.cell)).map(|cut| cut.triangle).collect()
            };
            let inside = triangles_in(cells_between(grid, support.cells));
            let around = triangles_in(cells_between(grid, support.grown(grid)));
            let all = (0..shape.triangles.len()).flat_map(|triangle| adjacency.from(triangle));
            let mut sets = DisjointSets::of(shape.triangles.len());
            for link in all.clone() {
                if link.triangles.iter().all(|triangle| inside.contains(triangle)) && support.connects(link) {
                    sets.join(link.triangles);
                }
            }
            let mut pieces = vec![Vec::new(); shape.triangles.len()];
            for &triangle in inside.iter().filter(|&&triangle| sets.root(triangle) == triangle) {
                pieces[triangle].push(triangle);
            }
            let among = all.filter(|link| link.triangles.iter().all(|triangle| around.contains(triangle)));
            let mut links: Vec<_> =
                among.filter_map(|link| Some((support.growth_below_one(link)?, link.triangles))).collect();
            links.sort_by(|a, b| a.0.total_cmp(&b.0));
            for (growth, pair) in links {
                let [a, b] = pair.map(|triangle| sets.root(triangle));
                if a != b {
                    let [ours, theirs] = [a, b].map(|root| std::mem::take(&mut pieces[root]));
                    let pairs =
                        ours.iter().flat_map(|&one| theirs.iter().map(move |&other| [one.min(other), one.max(other)]));
                    ties.extend(pairs.map(|pair| (handle, pair, growth)));
                    sets.join([a, b]);
                    pieces[sets.root(a)] = [ours, theirs].concat();
                }
            }
        }
        ties.sort_by(|a, b| a.partial_cmp(b).expect("no NaN"));
        ties
    }

    /// The same ties, of the copies.
    fn found_ties(grid: &Grid<2>, width: usize, shape: &Shape<2>) -> Vec<NamedTie> {
        let (cuts, adjacency) = (cuts(grid, shape), Adjacency::of(shape));
        let copies = copies(grid, width, &cuts, &CellParts::of(grid, &cuts, &adjacency));
        let named = |tie: &Tie| {
            let mut firsts = tie.copies.map(|copy| copies.first_triangles[copy]);
            firsts.sort_unstable();
            (copies.handles[tie.copies[0]], firsts, tie.growth)
        };
        let mut ties: Vec<NamedTie> = copies.ties.iter().map(named).collect();
        ties.sort_by(|a, b| a.partial_cmp(b).expect("no NaN"));
        ties
    }

    /// The same pieces, from the copies that act on the cuts.
    fn found(grid: &Grid<2>, width: usize, shape: &Shape<2>) -> Vec<Vec<Vec<usize>>> {
        let (cuts, adjacency) = (cuts(grid, shape), Adjacency::of(shape));
        let parts = CellParts::of(grid, &cuts, &adjacency);
        let copies = copies(grid, width, &cuts, &parts);
        let mut of_copies = vec![Vec::new(); copies.handles.len()];
        for (number, cut) in cuts.iter().enumerate() {
            let handles = handles_of_cell(grid, width, cut.cell);
            let own = copies.of_part(parts.of_cuts[number] as usize);
            assert!(own.iter().zip(&handles).all(|(&copy, handle)| copies.handles[copy] == *handle));
            own.iter().for_each(|&copy| of_copies[copy].push(number));
        }
        for (copy, own) in of_copies.iter().enumerate() {
            assert_eq!(own.iter().map(|&cut| cuts[cut].triangle).min(), Some(copies.first_triangles[copy]));
        }
        let of_handle = |handle: usize| {
            let own = of_copies.iter().zip(&copies.handles).filter(|(_, of)| **of == handle);
            let mut pieces: Vec<Vec<usize>> = own.map(|(cuts, _)| cuts.clone()).collect();
            pieces.sort();
            pieces
        };
        (0..grid.handle_count()).map(of_handle).collect()
    }

    /// Coordinates on borders between cells and between them.
    fn coordinate() -> impl Strategy<Value = f64> {
        prop_oneof![(0..=12_i32).prop_map(|k| f64::from(k) / 6.0 - 0.5), -0.6..1.6_f64]
    }

    proptest! {
        #[test]
        fn pieces_and_ties_are_those_of_a_search_over_all_links(
            points in prop::collection::vec([coordinate(), coordinate()], 6..24),
            corners in prop::collection::vec([0..24_usize, 0..24, 0..24], 1..14),
            across in prop::collection::vec([0..14_usize, 0..14], 0..6),
        ) {
            let corners: Vec<[u32; 3]> =
                corners.iter().map(|corners| corners.map(|corner| (corner % points.len()) as u32)).collect();
            let count = corners.len();
            let shape = Shape::of_triangles(points, corners).linked(0.0);
            let end = |triangle: usize| LinkEnd { triangle: (triangle % count) as u32, barycentric: [0.5, 0.25, 0.25] };
            let across = across.iter().filter(|[a, b]| a % count != b % count);
            let across = across.map(|&pair| Link { ends: pair.map(end), kind: LinkKind::Across });
            let links = shape.links.iter().flat_map(|links| links.iter().copied()).chain(across).collect();
            let shape = Shape { links: Some(Arc::new(links)), ..shape };
            for (basis, width, dims) in [(Basis::Bspline, 4, [9, 7]), (Basis::Bilinear, 2, [7, 4])] {
                let grid = Grid { dims, basis, lo: [0.0; 2], hi: [1.0; 2], angle: 0.0 };
                prop_assert_eq!(found(&grid, width, &shape), searched(&grid, width, &shape));
                prop_assert_eq!(found_ties(&grid, width, &shape), searched_ties(&grid, width, &shape));
            }
        }
    }
}
