//! Places the pins of a layer on its shape.
//!
//! In: a [`PreparedShot`], a solved [`TimeSample`], and a layer whose lattice branches. Out: [`PinPlace`]s.

use super::part_triangle_ranges::held_triangle;
use crate::pipeline::{PreparedShot, TimeSample};
use crate::solve::BranchedLattice;

/// Where a pin holds the shape at rest.
#[derive(Clone, Copy, Debug)]
pub(super) struct PinPlace {
    /// Index of the pin in the layer.
    pub(super) pin: usize,
    pub(super) at: [f64; 2],
    /// The triangle of the shape that the pin lies on; `None` beside the shape.
    pub(super) triangle: Option<u32>,
}

/// Returns the places of the active pins of the shot, also where a host program moves others in their place.
pub(super) fn pin_places(
    prepared: &PreparedShot,
    layer: usize,
    (now, branches): (&TimeSample, &BranchedLattice<2>),
) -> Vec<PinPlace> {
    let mesh = now.mesh();
    let starts = &now.layers[layer].starts;
    let pins = prepared.shot.layers[layer].pins.iter().zip(prepared.anchors_of(layer)).enumerate();
    let active = pins.filter(|(_, (pin, _))| !pin.is_muted);
    let place = |(pin, (_, anchor)): (usize, (_, &crate::pipeline::PinAnchor))| {
        let rest = anchor.rest(&mesh, &now.camera);
        let at = rest.point.0.to_array();
        let triangle = held_triangle(anchor, starts).or_else(|| triangle_at(branches, at));
        (rest.presence > 0.0).then_some(PinPlace { pin, at, triangle })
    };
    active.filter_map(place).collect()
}

/// Returns the triangle of a shape at rest that a point lies on; `None` beside the shape.
fn triangle_at(branches: &BranchedLattice<2>, at: [f64; 2]) -> Option<u32> {
    let holds = |corners: &[[f64; 2]]| {
        let sides = corners.iter().zip(corners.iter().cycle().skip(1));
        let crosses = sides.map(|(a, b)| (b[0] - a[0]) * (at[1] - a[1]) - (b[1] - a[1]) * (at[0] - a[0]));
        let (least, most) =
            crosses.fold((0.0_f64, 0.0_f64), |(least, most), cross| (least.min(cross), most.max(cross)));
        least >= 0.0 || most <= 0.0
    };
    let mut pieces = branches.pieces_of_triangles();
    pieces.find(|(.., corners)| holds(corners)).map(|(triangle, ..)| triangle as u32)
}
