//! Edges as members of sets that have one rotation each.
//!
//! In: edges in any order. Out: edges sorted by their ends and sets, each set of an edge once.

use super::mesh_edges::Edge;
use crate::solve::counting_sort::counting_sort_then_by;
use std::cmp::Ordering;

/// An edge of a set; an edge in several sets has several entries.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SetEdge {
    /// The set.
    pub(crate) set: u32,
    /// Vertices, the smaller index first.
    pub(crate) ends: [u32; 2],
    /// w.
    pub(crate) weight: f64,
}

impl SetEdge {
    /// An edge between two vertices.
    pub(super) fn new(set: usize, ends: [usize; 2], weight: f64) -> Self {
        let Edge { ends, weight } = Edge::new(ends, weight);
        Self { set: set as u32, ends, weight }
    }

    /// By ends and set; equal ones by weight, so that sums do not depend on the order of triangles.
    fn order(&self, other: &Self) -> Ordering {
        let key = |edge: &Self| (edge.ends, edge.set);
        key(self).cmp(&key(other)).then_with(|| self.weight.total_cmp(&other.weight))
    }
}

/// Sorts edges between `count` vertices and merges those with the same set and ends; edges without weight are dropped.
pub(super) fn sorted(mut members: Vec<SetEdge>, count: usize) -> Vec<SetEdge> {
    members.retain(|member| member.weight != 0.0 && member.ends[0] != member.ends[1]);
    counting_sort_then_by(&mut members, count, |member| member.ends[0] as usize, SetEdge::order);
    members.dedup_by(|next, member| {
        let is_same = (next.ends, next.set) == (member.ends, member.set);
        if is_same {
            member.weight += next.weight;
        }
        is_same
    });
    members
}
