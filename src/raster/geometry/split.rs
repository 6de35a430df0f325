//! Clips triangles at the near plane and splits edges that the warp would bend, without opening cracks.
//!
//! In: the vertices and triangles of a part. Out: the refined vertices and triangles. Whether and where an edge is
//! split depends on the edge alone, so the triangles on both sides agree, also across seams with duplicated vertices.

use super::edge_bends::EdgeBends;
use super::vertex::VertexList;
use crate::scene::Primitive;
use crate::screen::{Corner, clip_near};
use foldhash::fast::FixedState;
use rayon::prelude::*;
use std::collections::HashMap;

/// Maximum number of times an edge is halved: the longest edge on screen is then shorter than half a pixel at 4K.
const MAX_HALVINGS: u32 = 11;

/// Least number of triangles per thread.
const MIN_TRIANGLES: usize = 4096;

/// Collects the triangles of one part.
pub(super) struct Splitter<'a> {
    vertices: VertexList<'a>,
    triangles: Vec<[u32; 3]>,
    bends: &'a EdgeBends<'a>,
    /// The current triangle of the source mesh.
    triangle: u32,
    /// Vertices created on edges, by the edge's ends and the reason.
    made: HashMap<(u32, u32, EdgeVertex), u32, FixedState>,
}

/// The reason for a vertex on an edge.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum EdgeVertex {
    Cut,
    Half,
}

impl<'a> Splitter<'a> {
    /// Reserves space for `triangles` triangles, which most parts do not exceed.
    pub(super) fn new(vertices: VertexList<'a>, triangles: usize, bends: &'a EdgeBends<'a>) -> Self {
        Self { vertices, triangles: Vec::with_capacity(triangles), bends, triangle: 0, made: HashMap::default() }
    }

    /// Adds triangles of the source mesh by their numbers; `None`: all.
    pub(super) fn add_all(&mut self, source: &Primitive, numbers: Option<&[u32]>, near: f64) {
        let count = numbers.map_or(source.triangles.len(), <[u32]>::len);
        let numbered = |index: usize| {
            let number = numbers.map_or(index as u32, |numbers| numbers[index]);
            (number, source.triangles[number as usize])
        };
        // Nearly all triangles stay as they are, which each tells by itself.
        let stays = |index: usize| self.stays(numbered(index).1, near);
        let is_whole: Vec<bool> = (0..count).into_par_iter().with_min_len(MIN_TRIANGLES).map(stays).collect();
        for (index, is_whole) in is_whole.into_iter().enumerate() {
            let (number, corners) = numbered(index);
            if is_whole { self.triangles.push(corners) } else { self.add((number, corners), near) }
        }
    }

    /// Whether a triangle of the source mesh is neither clipped nor split.
    fn stays(&self, corners: [u32; 3], near: f64) -> bool {
        let [a, b, c] = corners;
        let (cut, count) = clip_near(corners.map(|corner| self.vertices.projected(corner)), near);
        let is_kept = count == 1 && cut[0].iter().all(|corner| corner.from == corner.to);
        is_kept && ![[a, b], [b, c], [c, a]].into_iter().any(|[from, to]| self.is_bent(from, to))
    }

    /// Adds one triangle of the source mesh.
    fn add(&mut self, (number, corners): (u32, [u32; 3]), near: f64) {
        self.triangle = number;
        let places = corners.map(|corner| self.vertices.projected(corner));
        let (cut, count) = clip_near(places, near);
        for cut in &cut[..count] {
            let corners = cut.map(|corner| self.on_edge(corners, corner));
            self.split(corners, 0);
        }
    }

    /// Returns the number of triangles so far.
    pub(super) fn count(&self) -> usize {
        self.triangles.len()
    }

    /// Returns all vertices and triangles.
    pub(super) fn finish(self) -> (VertexList<'a>, Vec<[u32; 3]>) {
        (self.vertices, self.triangles)
    }

    /// Returns the vertex of a corner kept or created by near-plane clipping.
    fn on_edge(&mut self, corners: [u32; 3], corner: Corner) -> u32 {
        let (from, to) = (corners[corner.from], corners[corner.to]);
        if from == to { from } else { self.between((from, to), corner.t, EdgeVertex::Cut) }
    }

    /// Returns the vertex at a fraction of an edge, created once.
    fn between(&mut self, (from, to): (u32, u32), t: f64, made: EdgeVertex) -> u32 {
        let key = match made {
            EdgeVertex::Cut => (from, to, made),
            EdgeVertex::Half => (from.min(to), from.max(to), made),
        };
        if let Some(&vertex) = self.made.get(&key) {
            return vertex;
        }
        let index = self.vertices.add_between((from, to), t, self.triangle);
        self.made.insert(key, index);
        index
    }

    /// Returns the midpoint of an edge that must be split; otherwise `None`.
    fn middle(&mut self, a: u32, b: u32) -> Option<u32> {
        self.is_bent(a, b).then(|| self.between((a, b), 0.5, EdgeVertex::Half))
    }

    /// Whether an edge must be split.
    fn is_bent(&self, a: u32, b: u32) -> bool {
        let place = |vertex: u32| self.vertices.projected(vertex).point().0;
        let on = [a, b].map(|vertex| self.vertices.on_part(vertex));
        self.bends.bends([place(a), place(b)], on)
    }

    /// Adds a triangle, or its pieces that are flat enough. Every curved edge is halved at every step, so an edge
    /// shared by two triangles is at the same step in both.
    fn split(&mut self, [a, b, c]: [u32; 3], halvings: u32) {
        let middles =
            if halvings < MAX_HALVINGS { [self.middle(a, b), self.middle(b, c), self.middle(c, a)] } else { [None; 3] };
        let pieces: &[[u32; 3]] = match middles {
            [None, None, None] => {
                self.triangles.push([a, b, c]);
                return;
            }
            [Some(ab), None, None] => &[[a, ab, c], [ab, b, c]],
            [None, Some(bc), None] => &[[a, b, bc], [a, bc, c]],
            [None, None, Some(ca)] => &[[a, b, ca], [ca, b, c]],
            [Some(ab), Some(bc), None] => &[[ab, b, bc], [a, ab, bc], [a, bc, c]],
            [None, Some(bc), Some(ca)] => &[[bc, c, ca], [a, b, bc], [a, bc, ca]],
            [Some(ab), None, Some(ca)] => &[[a, ab, ca], [ab, b, c], [ab, c, ca]],
            [Some(ab), Some(bc), Some(ca)] => &[[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]],
        };
        for &piece in pieces {
            self.split(piece, halvings + 1);
        }
    }
}
