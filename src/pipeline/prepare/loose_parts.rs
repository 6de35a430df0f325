//! Joins parts of a drawing that no pin holds to their neighbours: an eye goes along with the face around it.
//!
//! In: the part of every triangle, links, the triangles with pins. Out: the pinned part that each triangle goes along with.

use crate::solve::Link;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};

/// Returns the label of every triangle, where parts without a pin have that of a part with one: of the neighbour with which they share the
/// most links, directly or through others. Parts that hang together with no pinned part stay as they are, and so do all without any pin.
pub(super) fn joined_to_pinned(labels: &[u32], links: &[Link], pinned: &[usize]) -> Vec<u32> {
    let mut borders: BTreeMap<u32, BTreeMap<u32, usize>> = BTreeMap::new();
    for link in links {
        let [from, to] = link.ends.map(|end| labels[end.triangle as usize]);
        if from != to {
            *borders.entry(from).or_default().entry(to).or_default() += 1;
            *borders.entry(to).or_default().entry(from).or_default() += 1;
        }
    }
    let held: BTreeSet<u32> = pinned.iter().map(|&triangle| labels[triangle]).collect();
    let mut carriers: BTreeMap<u32, u32> = held.iter().map(|&part| (part, part)).collect();
    let mut open = BinaryHeap::new();
    let around = |part: u32| borders.get(&part).into_iter().flatten().map(move |(&next, &length)| (length, next, part));
    held.iter().for_each(|&part| open.extend(around(part)));
    while let Some((_, part, neighbour)) = open.pop() {
        if !carriers.contains_key(&part) {
            carriers.insert(part, carriers[&neighbour]);
            open.extend(around(part));
        }
    }
    labels.iter().map(|label| carriers.get(label).copied().unwrap_or(*label)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solve::{LinkEnd, LinkKind};

    #[test]
    fn parts_without_a_pin_go_along_with_the_longest_border() {
        // Two pinned parts, 1 and 2; 3 shares two links with 1 and one with 2; 4 touches only 3, 5 nothing.
        let labels = [1, 2, 3, 4, 5];
        let link = |from: usize, to: usize| Link {
            ends: [from, to].map(|triangle| LinkEnd::corner(triangle, 0)),
            kind: LinkKind::Edge,
        };
        let links = [link(1, 2), link(0, 2), link(2, 0), link(2, 3), link(0, 1)];
        assert_eq!(joined_to_pinned(&labels, &links, &[0, 1]), [1, 2, 1, 1, 5]);
        assert_eq!(joined_to_pinned(&labels, &links, &[1]), [2, 2, 2, 2, 5]);
        assert_eq!(joined_to_pinned(&labels, &links, &[]), labels);
    }
}
