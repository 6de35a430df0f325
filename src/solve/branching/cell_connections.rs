//! Connections of a cell beside a support: at which growth of the support its links connect the triangles that are connected beyond
//! the cell.
//!
//! In: the links inside a cell. Out: a tree over its terminals that has the same bottlenecks as all links (Kruskal's algorithm, in
//! which each component is represented by one of its terminals). The growth depends only on the side on which the cell lies, so
//! supports share the trees.

use super::adjacency::PlacedLink;
use super::cell_parts::CellParts;
use super::cuts::Cut;
use super::support_box::SupportBox;
use crate::disjoint_sets::DisjointSets;
use crate::lattice::Grid;

/// Stands for a component without terminals.
const NONE: u32 = u32::MAX;

/// The bits of a growth, 0 to 1, and two nodes that are connected from it on. The bits of numbers that are not negative have their
/// order.
pub(super) type Connection = (u64, [u32; 2]);

/// The connection by a link; `None` if it takes a growth of one or more.
pub(super) fn connection<const D: usize>(
    support: &SupportBox<D>,
    link: &PlacedLink<D>,
    nodes: [u32; 2],
) -> Option<Connection> {
    // The bits of -0 would sort behind those of all others.
    Some(((support.growth_below_one(link)? + 0.0).to_bits(), nodes))
}

/// The connections of all cells, computed when they are needed.
pub(super) struct CellConnections<'a, const D: usize> {
    grid: &'a Grid<D>,
    parts: &'a CellParts<D>,
    /// The triangles with a cut in each cell, #cells.
    triangles_of_cell: Vec<Vec<u32>>,
    /// Place of each triangle in the cell that is being processed, #triangles.
    place_of: Vec<u32>,
    /// Trees by cell and side, #cells times 3^D.
    trees: Vec<Option<Vec<Connection>>>,
}

impl<'a, const D: usize> CellConnections<'a, D> {
    pub(super) fn new(grid: &'a Grid<D>, parts: &'a CellParts<D>, cuts: &[Cut<D>]) -> Self {
        let mut triangles_of_cell = vec![Vec::new(); grid.cell_count()];
        cuts.iter().for_each(|cut| triangles_of_cell[cut.cell].push(cut.triangle as u32));
        Self {
            grid,
            parts,
            triangles_of_cell,
            place_of: vec![NONE; parts.triangle_count()],
            trees: vec![None; grid.cell_count() * 3_usize.pow(D as u32)],
        }
    }

    /// The connections between terminals of a cell beside a support, by triangles.
    pub(super) fn beside(&mut self, support: &SupportBox<D>, cell: usize) -> &[Connection] {
        let place = self.grid.cell_coords(cell);
        let side = (0..D).fold(0, |side, axis| {
            let [low, high] = support.cells[axis];
            3 * side + usize::from(place[axis] >= low) + usize::from(place[axis] > high)
        });
        let index = cell * 3_usize.pow(D as u32) + side;
        if self.trees[index].is_none() {
            self.trees[index] = Some(self.tree(support, cell));
        }
        self.trees[index].as_deref().unwrap_or_default()
    }

    fn tree(&mut self, support: &SupportBox<D>, cell: usize) -> Vec<Connection> {
        let triangles = &self.triangles_of_cell[cell];
        triangles.iter().zip(0..).for_each(|(&triangle, place)| self.place_of[triangle as usize] = place);
        let places = |link: &PlacedLink<D>| link.triangles.map(|triangle| self.place_of[triangle]);
        let links = self.parts.inside(cell).iter();
        let mut links: Vec<Connection> = links.filter_map(|link| connection(support, link, places(link))).collect();
        links.sort_unstable_by_key(|(growth, _)| *growth);
        let own = |&triangle: &u32| if self.parts.is_terminal(triangle as usize) { triangle } else { NONE };
        let mut terminal_of: Vec<u32> = triangles.iter().map(own).collect();
        let mut components = DisjointSets::of(triangles.len());
        let mut tree = Vec::new();
        for (growth, pair) in links {
            let [a, b] = pair.map(|place| components.root(place as usize));
            if a == b {
                continue;
            }
            let [one, other] = [a, b].map(|root| terminal_of[root]);
            if one != NONE && other != NONE {
                tree.push((growth, [one, other]));
            }
            components.join([a, b]);
            terminal_of[components.root(a)] = if one == NONE { other } else { one };
        }
        tree
    }
}
