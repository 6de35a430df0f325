//! Divides the shape of a branching layer into parts that move as one, with their order where they overlap.
//!
//! In: a [`PreparedShot`], a solved [`TimeSample`], and a layer whose lattice branches. Out: [`OrderedParts`].

use super::part_triangle_ranges::{PartTriangleRanges, held_triangle};
use crate::pipeline::{PreparedShot, TimeSample};
use crate::shot::order_at;
use crate::solve::BranchedLattice;
use std::collections::BTreeMap;

/// The pieces of a branch that have the same order. Sorts by order, then by branch with the largest branch first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::pipeline) struct OrderedPart {
    /// Order of the part that a cut chooses, or of the pin nearest along the shape; 0 if neither has one.
    pub(in crate::pipeline) order: i32,
    pub(in crate::pipeline) branch: usize,
}

/// The parts of a layer.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(in crate::pipeline) struct OrderedParts {
    /// From back to front, as far as order and size of the branches determine it.
    pub(in crate::pipeline) list: Vec<OrderedPart>,
    /// Index into the list for each piece, in the order of [`BranchedLattice::pieces`].
    pub(in crate::pipeline) of_pieces: Vec<u32>,
}

impl OrderedParts {
    pub(in crate::pipeline) fn of(
        prepared: &PreparedShot,
        layer: usize,
        (now, branches): (&TimeSample, &BranchedLattice<2>),
    ) -> Self {
        let orders = orders(prepared, layer, (now, branches));
        let order_of = |piece: usize| orders.as_ref().map_or(0, |orders| orders[piece]);
        let parts: Vec<OrderedPart> = (branches.pieces().enumerate())
            .map(|(piece, (branch, _))| OrderedPart { order: order_of(piece), branch })
            .collect();
        let mut places: BTreeMap<OrderedPart, u32> = parts.iter().map(|&part| (part, 0)).collect();
        (0..).zip(places.values_mut()).for_each(|(number, place)| *place = number);
        Self { of_pieces: parts.iter().map(|part| places[part]).collect(), list: places.into_keys().collect() }
    }
}

/// Returns the order of each piece; `None` if neither a pin nor a part has an order.
fn orders(
    prepared: &PreparedShot,
    index: usize,
    (now, branches): (&TimeSample, &BranchedLattice<2>),
) -> Option<Vec<i32>> {
    let (layer, starts) = (&prepared.shot.layers[index], &now.layers[index].starts);
    let parts = prepared.ordered_parts_of(index);
    let has_ordered_pins = layer.pins.iter().any(|pin| !pin.is_muted && !pin.order.is_empty());
    if parts.is_empty() && !has_ordered_pins {
        return None;
    }
    let key_frame = prepared.key_frame(layer, now.frame);
    let part_of = parts_of_shape(parts, starts);
    let triangles: Vec<usize> = branches.pieces_of_triangles().map(|(triangle, ..)| triangle).collect();
    let mut orders: Vec<Option<i32>> = triangles
        .iter()
        .map(|&triangle| order_at(&layer.connectivity.orders[parts[part_of(triangle)?].0], key_frame))
        .collect();
    if has_ordered_pins {
        // The pins of the shot, also where a host program moves others in their place.
        let mesh = now.mesh();
        let pins = layer.pins.iter().zip(prepared.anchors_of(index)).filter(|(pin, _)| !pin.is_muted);
        let held = pins.filter_map(|(pin, anchor)| {
            let rest = anchor.rest(&mesh, &now.camera);
            let at = rest.point.0.to_array();
            let place = (at, held_triangle(anchor, starts).or_else(|| triangle_at(branches, at)));
            (rest.presence > 0.0).then(|| (place, order_at(&pin.order, key_frame)))
        });
        let (places, of_pins): (Vec<_>, Vec<_>) = held.unzip();
        let nearest = if places.is_empty() { Vec::new() } else { branches.nearest_along_shape(&places) };
        for ((order, &triangle), pin) in orders.iter_mut().zip(&triangles).zip(nearest) {
            // A part keeps its order against pins beside it.
            let is_beside = |held: u32| part_of(held as usize) != part_of(triangle);
            if order.is_none() || !places[pin].1.is_none_or(is_beside) {
                *order = of_pins[pin].or(*order);
            }
        }
    }
    Some(orders.into_iter().map(Option::unwrap_or_default).collect())
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

/// Returns a function from the triangles of a shape to the last of some parts that has them. `parts`: with one flag for every triangle at
/// rest.
fn parts_of_shape(parts: &[(usize, Vec<bool>)], starts: &[PartTriangleRanges]) -> impl Fn(usize) -> Option<usize> {
    let runs = starts.iter().flat_map(|part| part.starts.windows(2));
    let part_at_rest = |triangle: usize| parts.iter().rposition(|(_, is_in)| is_in.get(triangle) == Some(&true));
    let of_run = |(number, run): (usize, &[u32])| {
        let part = part_at_rest(number);
        (run[0]..run[1]).map(move |_| part)
    };
    let list: Vec<Option<usize>> =
        if parts.is_empty() { Vec::new() } else { runs.enumerate().flat_map(of_run).collect() };
    move |triangle| list.get(triangle).copied().flatten()
}
