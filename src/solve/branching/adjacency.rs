//! Adjacency of the triangles of a shape, with the positions of the links between them.
//!
//! In: a shape. Out: its links, sorted by their first triangle.

use super::link::LinkKind;
use super::rest_links::surface_links;
use crate::solve::counting_sort::counting_sort_then_by;
use crate::solve::problem::Shape;
use std::borrow::Cow;

/// A link between two triangles, with its position.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlacedLink<const D: usize> {
    /// The indices of the two triangles, the smaller one first.
    pub(super) triangles: [usize; 2],
    /// Positions of the ends of the link, in the order of the triangles.
    pub(super) ends: [[f64; D]; 2],
    pub(super) kind: LinkKind,
}

/// All links of a shape, sorted by their first triangle.
#[derive(Clone, Debug)]
pub(super) struct Adjacency<const D: usize> {
    links: Vec<PlacedLink<D>>,
    /// End of each triangle's range in `links`, #triangles.
    ends: Vec<usize>,
}

impl<const D: usize> Adjacency<D> {
    /// The links of the shape; if it names none, those of its surface in its present position.
    pub(super) fn of(shape: &Shape<D>) -> Self {
        let links = match &shape.links {
            Some(links) => Cow::Borrowed(links.as_slice()),
            None => Cow::Owned(surface_links(&shape.points, &shape.triangles, f64::INFINITY)),
        };
        let placed = |link: &super::Link| {
            let mut ends = link.ends;
            if ends[1].triangle < ends[0].triangle {
                ends.swap(0, 1);
            }
            let places = ends.map(|end| end.point(&shape.points, &shape.triangles));
            PlacedLink { triangles: ends.map(|end| end.triangle as usize), ends: places, kind: link.kind }
        };
        let mut links: Vec<PlacedLink<D>> = links.iter().map(placed).collect();
        counting_sort_then_by(
            &mut links,
            shape.triangles.len(),
            |link| link.triangles[0],
            |a, b| a.triangles[1].cmp(&b.triangles[1]),
        );
        let mut ends = vec![0; shape.triangles.len()];
        links.iter().for_each(|link| ends[link.triangles[0]] += 1);
        for number in 1..ends.len() {
            ends[number] += ends[number - 1];
        }
        Self { ends, links }
    }

    /// The links between a triangle and those with a larger index.
    pub(super) fn from(&self, triangle: usize) -> &[PlacedLink<D>] {
        let start = if triangle == 0 { 0 } else { self.ends[triangle - 1] };
        &self.links[start..self.ends[triangle]]
    }
}
