//! Edges as members of sets that have one rotation each.
//!
//! In: edges in any order. Out: edges sorted by ends, then by set; each pair of edge and set occurs once.

use super::mesh_edges::Edge;
use crate::solve::counting_sort::counting_sort_then_by;
use std::cmp::Ordering;

/// Membership of an edge in a set; an edge in several sets has several entries.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SetEdge {
    /// Index of the set.
    pub(crate) set: u32,
    /// Vertices, the smaller index first.
    pub(crate) ends: [u32; 2],
    /// Weight w of the edge in this set.
    pub(crate) weight: f64,
}

impl SetEdge {
    /// Creates an edge between two vertices, in either order.
    pub(super) fn new(set: usize, ends: [usize; 2], weight: f64) -> Self {
        let Edge { ends, weight } = Edge::new(ends, weight);
        Self { set: set as u32, ends, weight }
    }

    /// Order by ends, then set, then weight, so that sums do not depend on the order of the triangles.
    fn order(&self, other: &Self) -> Ordering {
        let key = |edge: &Self| (edge.ends, edge.set);
        key(self).cmp(&key(other)).then_with(|| self.weight.total_cmp(&other.weight))
    }
}

/// Sorts edges between `count` vertices and merges those of equal set and ends; edges of weight 0 are dropped.
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
