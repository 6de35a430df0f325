//! Finds pins that share cells of the lattice although their targets move them apart, so that too few handles lie between them.
//!
//! In: a layer and its solved state. Out: a warning for the worst pair.

use crate::lattice::{Grid, MAX_HANDLES, MAX_HANDLES_IN_ALL};
use crate::pipeline::evaluate::part_triangle_ranges::held_triangle;
use crate::pipeline::evaluate::topology::branching_remedy;
use crate::pipeline::prepare::auto_dims::SCENE_HANDLES;
use crate::pipeline::{LayerState, PinAnchor, PinState, PreparedShot};
use crate::shot::{Layer, LayerSpace, Shot, Source};
use crate::solve::{BranchedLattice, SolveReport};

/// Distance of two pins, in cells, below which they share most of the handles that act on them.
const APART_CELLS: f64 = 1.0;

/// The same for branching lattices, on which pins farther apart share next to nothing.
const BRANCHING_APART_CELLS: f64 = 2.0;

/// Share of the copies acting on two pins of a branching lattice that has to act on both; on the same part of the shape, pins a
/// cell apart along one axis share about half, and along both a quarter.
const MIN_SHARE: f64 = 0.2;

/// Maximum ratio between the distances of two pins after and before the warp without a warning. The ratio ignores
/// rotation of one pin about the other.
const STRETCH: f64 = 2.5;

/// Relative displacement below which a pair is not reported, pixels.
const MIN_PX: f64 = 4.0;

/// Two pins on the screen.
struct Pair<'a> {
    pins: [&'a PinState; 2],
    /// Number of cells between the pins, along the axis with the most.
    cells: f64,
    /// Distance between the targets relative to the distance at rest.
    stretch: f64,
}

/// Returns a warning for the worst pair of pins of a screen layer that share cells and are moved apart; on branching lattices,
/// cells of parts that share copies of handles. Pairs reported as contradictions are left out.
pub(in crate::pipeline) fn warning(
    prepared: &PreparedShot,
    index: usize,
    state: &LayerState,
    solve: &SolveReport,
    height_px: f64,
) -> Option<String> {
    let (shot, anchors) = (&prepared.shot, prepared.anchors_of(index));
    let layer = &shot.layers[index];
    let LayerSpace::Screen { dims, .. } = layer.space else { return None };
    let grid = &state.solution.as_ref()?.lattice.grid;
    let branches = state.solution.as_ref().and_then(|solution| solution.branches.as_ref());
    let least_cells = if branches.is_some() { BRANCHING_APART_CELLS } else { APART_CELLS };
    let is_coupled = |pair: &Pair| branches.is_none_or(|branches| share(branches, (state, anchors), pair) >= MIN_SHARE);
    let told = pairs(state, solve, (grid, height_px)).filter(|pair| pair.cells < least_cells && is_coupled(pair));
    let worst = told.max_by(|a, b| a.stretch.total_cmp(&b.stretch))?;
    let [one, other] = worst.pins.map(|pin| &layer.pins[pin.pin].name);
    let apart_px = difference(worst.pins).length() * height_px;
    let finer = dims.map(|count| ((count as f64 * 2.0 * APART_CELLS / worst.cells).ceil() as usize).max(count + 1));
    let is_possible = finer.iter().all(|&count| count <= MAX_HANDLES) && finer[0] * finer[1] <= MAX_HANDLES_IN_ALL;
    let remedy = if is_possible {
        format!("give the lattice more handles (dims = [{}, {}])", finer[0], finer[1])
    } else {
        "move them farther apart".into()
    };
    let auto =
        if can_choose_dims(shot, layer, dims) { ", let its thinnest parts choose them (dims = \"auto\")" } else { "" };
    let branching = branching_remedy(shot, layer);
    Some(format!(
        "layer '{}': pins '{one}' and '{other}' share cells of the lattice ({:.1} cells lie between them) and are to move {apart_px:.0} px \
         apart: the area around them is distorted; {remedy}{auto}{branching}, or give each part a layer of its own (`nodes`, `select`)",
        layer.name, worst.cells
    ))
}

/// Whether `dims = "auto"` may give a layer with these dims more handles.
fn can_choose_dims(shot: &Shot, layer: &Layer, dims: [usize; 2]) -> bool {
    let is_fine = dims[0].max(dims[1]) >= SCENE_HANDLES || layer.has_auto_dims;
    !is_fine && layer.handles.is_empty() && layer.basis.can_branch() && !matches!(shot.source, Source::Frame)
}

/// The share of the copies acting on two pins that acts on both.
fn share(branches: &BranchedLattice<2>, (state, anchors): (&LayerState, &[PinAnchor]), pair: &Pair) -> f64 {
    let place = |pin: &PinState| {
        let triangle = anchors.get(pin.pin).and_then(|anchor| held_triangle(anchor, &state.starts));
        (pin.rest.0.to_array(), triangle)
    };
    branches.common_share(pair.pins.map(place))
}

/// The pairs of pins that are moved apart.
fn pairs<'a>(
    state: &'a LayerState,
    solve: &'a SolveReport,
    (grid, height_px): (&'a Grid<2>, f64),
) -> impl Iterator<Item = Pair<'a>> {
    let pins = state.pins.iter().enumerate();
    let all = pins.flat_map(move |(first, one)| {
        state.pins[first + 1..].iter().enumerate().map(move |(after, other)| ([first, first + 1 + after], [one, other]))
    });
    let is_told =
        move |pair: &[usize; 2]| solve.conflicts.iter().any(|told| told == pair || *told == [pair[1], pair[0]]);
    all.filter_map(move |(indices, pins)| {
        let between = (pins[1].rest - pins[0].rest).0;
        let along = grid.rotated_back(between.to_array());
        let cells = (0..2).map(|axis| along[axis].abs() / grid.spacing(axis)).fold(0.0, f64::max);
        let apart = difference(pins).length();
        let stretch = (pins[1].target - pins[0].target).0.length() / between.length().max(f64::MIN_POSITIVE);
        let is_meant = cells > 0.0 && stretch > STRETCH && apart * height_px > MIN_PX;
        (is_meant && !is_told(&indices)).then_some(Pair { pins, cells, stretch })
    })
}

/// Returns the difference between the displacements of two pins.
fn difference(pins: [&PinState; 2]) -> glam::DVec2 {
    let [one, other] = pins.map(|pin| (pin.target - pin.rest).0);
    one - other
}
