//! Branching lattices: parts of a shape that are close in space but far apart along it get separate copies of the handles they share.
//!
//! In: a grid and a shape at rest. Out: a [`Branching`]: copies, the terms over them, and branches. Method: docs/METHOD.md,
//! "Branching lattices"; J. Molino et al., "A Virtual Node Algorithm for Changing Mesh Topology During Simulation", 2004; M. Nesme
//! et al., "Preserving Topology and Elasticity for Embedded Deformable Models", 2009.

mod adjacency;
mod along_shape;
mod around_pin;
mod bending;
mod branch_folds;
mod branched_lattice;
mod cell_connections;
mod cell_parts;
mod continuation;
mod copies;
mod crossings;
mod cuts;
mod far_points;
mod inner_width;
mod islands;
mod link;
mod nearest_point;
mod pieces;
mod pin_coupling;
mod ray;
mod rest_links;
mod row_shares;
mod solid_links;
mod support_box;
mod terms;
mod tie_nodes;

pub(crate) use bending::Bending;
pub(crate) use branched_lattice::BranchedLattice;
pub(crate) use continuation::continued;
pub(crate) use crossings::Crossing;
pub(crate) use far_points::{FarPoints, far_points};
pub(crate) use inner_width::inner_widths;
pub(crate) use link::Link;
pub(crate) use link::{LinkEnd, LinkKind};
pub(crate) use nearest_point::nearest_barycentric;
pub(crate) use rest_links::{link_at, nearest_link, surface_links};
pub(crate) use solid_links::{islands_of, link_length, sampled_solid_links, solid_links};
pub(crate) use terms::HeldPins;

use super::error::SolveError;
use super::problem::{HandlePin, PointPin, Problem, Shape};
use super::samples::Polygon;
use super::settings::{Settings, Topology};
use crate::lattice::{Grid, Support};
use adjacency::Adjacency;
use cell_parts::CellParts;
use copies::{Tie, copies, handles_of_cell};
use cuts::{Cut, cuts};
use nearest_point::{nearest_of_triangle, squared_distance_to_box};
use pieces::Pieces;
use std::ops::Range;
use support_box::cell_at;

/// Name of a copy of a handle that stays valid at other times, when the shape is split into other pieces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct CopyName {
    /// The handle.
    pub(crate) handle: usize,
    /// The first triangle of the piece that has the copy.
    pub(crate) triangle: usize,
}

/// The copies of a grid's handles for a shape at rest, and the branches that they form.
#[derive(Clone, Debug)]
pub(crate) struct Branching<const D: usize> {
    grid: Grid<D>,
    /// Number of handles with a non-zero weight at a coordinate, per axis.
    width: usize,
    /// Corners of all triangles at rest.
    triangles: Vec<[[f64; D]; 3]>,
    /// The parts of triangles in cells, in the order of the triangles.
    cuts: Vec<Cut<D>>,
    /// The first cut of each triangle, #triangles + 1.
    first_cuts: Vec<u32>,
    /// The handle of each copy, ascending.
    handles: Vec<usize>,
    /// The first triangle in the piece of each copy.
    first_triangles: Vec<usize>,
    ties: Vec<Tie>,
    pieces: Pieces,
    /// The branch of each piece.
    branch_of: Vec<usize>,
    /// The branch of each triangle; `None` where several meet.
    branch_of_triangles: Vec<Option<u32>>,
    /// For every branch, the copy of each handle; `None` if the branch has no copy of it.
    branches: Vec<Vec<Option<usize>>>,
}

impl<const D: usize> Branching<D> {
    /// The branching of a problem; `None` if the problem does not ask for one, or if no handle has two copies: the lattice is
    /// then a plain one.
    ///
    /// # Errors
    /// [`SolveError::Invalid`] if a setting, the basis or the shape does not support branching lattices.
    pub(crate) fn of(problem: &Problem<D>) -> Result<Option<Self>, SolveError> {
        let Problem { grid, shape, settings, .. } = *problem;
        if settings.topology == Topology::Plain {
            return Ok(None);
        }
        if let Some([what, hint]) = settings.branching_fault() {
            return Err(refusal(what, hint));
        }
        let width = checked_width(grid, shape)?;
        let branching = Self::split(grid, shape, width);
        Ok(branching.handles.windows(2).any(|pair| pair[0] == pair[1]).then_some(branching))
    }

    /// Splits the handles of a grid by the connected components of a shape in their supports.
    fn split(grid: &Grid<D>, shape: &Shape<D>, width: usize) -> Self {
        let cuts = cuts(grid, shape);
        let adjacency = Adjacency::of(shape);
        let parts = CellParts::of(grid, &cuts, &adjacency);
        let copies = copies(grid, width, &cuts, &parts);
        let pieces = Pieces::of(grid, width, &cuts, (&parts, &copies));
        let (branch_of, branches) = pieces.branches(grid, width);
        let corner = |&corner: &u32| shape.points[corner as usize];
        let (mut first_cuts, mut branch_of_triangles) = (vec![0], Vec::with_capacity(shape.triangles.len()));
        let own_branches = pieces.of_cuts.iter().map(|&piece| branch_of[piece]);
        let mut own = cuts.iter().zip(own_branches).peekable();
        for triangle in 0..shape.triangles.len() {
            let mut end = first_cuts[triangle];
            let first = own.peek().map(|(_, branch)| *branch);
            let mut is_one = true;
            while let Some((_, branch)) = own.next_if(|(cut, _)| cut.triangle == triangle) {
                end += 1;
                is_one &= first == Some(branch);
            }
            first_cuts.push(end);
            branch_of_triangles.push(first.filter(|_| is_one).map(|branch| branch as u32));
        }
        Self {
            grid: grid.clone(),
            width,
            first_cuts,
            triangles: shape.triangles.iter().map(|corners| corners.each_ref().map(corner)).collect(),
            cuts,
            handles: copies.handles,
            first_triangles: copies.first_triangles,
            ties: copies.ties,
            pieces,
            branch_of,
            branch_of_triangles,
            branches,
        }
    }

    /// The same pieces over a grid that is rotated with the shape.
    pub(crate) fn rotated(&self, grid: &Grid<D>) -> Self {
        let corners = |corners: &[[f64; D]; 3]| corners.map(|corner| grid.point_from_upright(corner));
        let cut = |cut: &Cut<D>| Cut { polygon: cut.polygon.mapped(|corner| grid.point_from_upright(corner)), ..*cut };
        Self {
            grid: grid.clone(),
            triangles: self.triangles.iter().map(corners).collect(),
            cuts: self.cuts.iter().map(cut).collect(),
            ..self.clone()
        }
    }

    /// Number of copies, which are the unknowns of a solve.
    pub(crate) fn count(&self) -> usize {
        self.handles.len()
    }

    /// Rest positions of the copies.
    pub(crate) fn rest(&self) -> Vec<[f64; D]> {
        self.handles.iter().map(|&handle| self.grid.rest_handle(handle)).collect()
    }

    /// Converts moved handles to moved copies: all copies of each handle, ascending.
    pub(crate) fn moved_copies(&self, handles: &[HandlePin<D>]) -> Vec<HandlePin<D>> {
        let copies = |pin: &HandlePin<D>| {
            let first = self.handles.partition_point(|&handle| handle < pin.index);
            let last = self.handles.partition_point(|&handle| handle <= pin.index);
            let target = pin.target;
            (first..last).map(move |index| HandlePin { index, target })
        };
        handles.iter().flat_map(copies).collect()
    }

    /// The point of the shape that a pin holds, and its piece. A pin beside the shape holds the nearest point, with the same
    /// displacement.
    pub(crate) fn snapped_pin(&self, pin: &PointPin<D>) -> (PointPin<D>, usize) {
        let (at, piece) = self.snapped_point(pin.at, pin.triangle);
        (pin.moved_to(at), piece)
    }

    /// The point of the given triangle, or else of the shape, that is nearest to a point, and its piece.
    pub(crate) fn snapped_point(&self, point: [f64; D], triangle: Option<u32>) -> ([f64; D], usize) {
        match triangle.map(|triangle| triangle as usize) {
            Some(triangle) if triangle < self.triangles.len() => {
                let at = nearest_of_triangle(&point, &self.triangles[triangle]);
                (at, self.piece_at(triangle..triangle + 1, &at))
            }
            _ => self.nearest(point),
        }
    }

    /// The point of the shape that each pin holds, and its piece.
    pub(crate) fn snapped_points(&self, pins: &[PointPin<D>]) -> Vec<([f64; D], usize)> {
        pins.iter().map(|pin| self.snapped_point(pin.at, pin.triangle)).collect()
    }

    /// The position of a handle among those of a cell, from its distance to the first of them.
    fn slot(&self, offset: usize) -> usize {
        let place = self.grid.handle_coords(offset);
        (0..D).rev().fold(0, |slot, axis| slot * self.width + place[axis])
    }

    /// The name of each copy, #copies.
    pub(crate) fn copy_names(&self) -> Vec<CopyName> {
        self.handles
            .iter()
            .zip(&self.first_triangles)
            .map(|(&handle, &triangle)| CopyName { handle, triangle })
            .collect()
    }

    /// The branch of a piece.
    pub(crate) fn branch_of(&self, piece: usize) -> usize {
        self.branch_of[piece]
    }

    /// The branch to which a point on one of these triangles belongs.
    pub(crate) fn branch_at(&self, triangles: Range<usize>, point: &[f64; D]) -> usize {
        let own = &self.branch_of_triangles[triangles.clone()];
        match own.first() {
            Some(&Some(branch)) if own.iter().all(|other| *other == Some(branch)) => branch as usize,
            _ => self.branch_of(self.piece_at(triangles, point)),
        }
    }

    /// The piece to which a point on one of these triangles belongs.
    pub(crate) fn piece_at(&self, triangles: Range<usize>, point: &[f64; D]) -> usize {
        let first = self.first_cuts[triangles.start] as usize;
        let cuts = &self.cuts[first..self.first_cuts[triangles.end] as usize];
        let point = self.grid.upright_from_point(*point);
        let own_cell = cell_at(&self.grid, &point);
        if let Some(place) = cuts.iter().position(|cut| cut.cell == own_cell) {
            return self.pieces.of_cuts[first + place];
        }
        // What lies outside the box belongs to the nearest cell.
        let point: [f64; D] = std::array::from_fn(|axis| point[axis].clamp(self.grid.lo[axis], self.grid.hi[axis]));
        let gap = |cut: &Cut<D>| {
            let place = self.grid.cell_coords(cut.cell);
            let outside = (0..D).map(|axis| {
                let low = self.grid.lo[axis] + place[axis] as f64 * self.grid.spacing(axis);
                (low - point[axis]).max(point[axis] - low - self.grid.spacing(axis)).max(0.0)
            });
            outside.fold(0.0, f64::max)
        };
        let nearest = (0..cuts.len()).min_by(|&a, &b| gap(&cuts[a]).total_cmp(&gap(&cuts[b])));
        self.pieces.of_cuts[first + nearest.unwrap_or(0)]
    }

    /// The point of the shape that is nearest to a point, and its piece.
    fn nearest(&self, point: [f64; D]) -> ([f64; D], usize) {
        let mut best = (f64::INFINITY, point, 0);
        for (triangle, corners) in self.triangles.iter().enumerate() {
            if squared_distance_to_box(&point, corners) >= best.0 {
                continue;
            }
            let on = nearest_of_triangle(&point, corners);
            let square: f64 = (0..D).map(|d| (on[d] - point[d]).powi(2)).sum();
            if square < best.0 {
                best = (square, on, triangle);
            }
        }
        let (_, on, triangle) = best;
        (on, self.piece_at(triangle..triangle + 1, &on))
    }
}

/// The parts of a shape's triangles in the cells of an upright grid, each with the index of its cell. Parts outside the box belong to the
/// nearest cell.
pub(crate) fn polygons_in_cells<const D: usize>(
    grid: &Grid<D>,
    shape: &Shape<D>,
) -> impl Iterator<Item = (usize, Polygon<D>)> {
    cuts(grid, shape).into_iter().map(|cut| (cut.cell, cut.polygon))
}

/// Number of spans per axis at which a branching lattice resists bending like a plain one.
const REFERENCE_SPANS: f64 = 7.0;

/// Settings with the radius of pin discs in proportion to the span of the grid, and the weight of bending to its square. A plain
/// lattice uses the same values for all grids; on a fine branching lattice these would keep thin parts from rotating about their
/// joints.
pub(crate) fn settings_for<const D: usize>(grid: &Grid<D>, settings: &Settings) -> Settings {
    let finer = |axis: usize| REFERENCE_SPANS / grid.basis.spans(grid.dims[axis]) as f64;
    let length = (0..D).map(finer).product::<f64>().powf(1.0 / D as f64).min(1.0);
    let mut settings = settings.clone();
    settings.disc.radius *= length;
    settings.lambdas.regularizer *= length * length;
    settings
}

/// The number of handles with a non-zero weight at a coordinate, after checking that basis and shape support branching.
fn checked_width<const D: usize>(grid: &Grid<D>, shape: &Shape<D>) -> Result<usize, SolveError> {
    let Support::Tensor { width } = grid.basis.support() else {
        return Err(refusal(&format!("the {} basis", grid.basis.label()), "use basis = \"bspline\" or \"bilinear\""));
    };
    if shape.triangles.is_empty() || !shape.strokes.is_empty() {
        return Err(refusal("lines, or without triangles", "use a shape of triangles alone"));
    }
    Ok(width)
}

fn refusal(what: &str, hint: &str) -> SolveError {
    let what = format!("a branching lattice with {what}");
    SolveError::Invalid { what, hint: format!("{hint}, or set topology = \"plain\"") }
}
