//! Polylines from the line modes of glTF.
//!
//! In: corners in drawing order. Out: lists of vertices; a closed line repeats its first. Loose segments, which
//! exporters write in any order, are joined where exactly two of them meet.

use gltf::json::mesh::Mode;
use std::collections::BTreeMap;

/// Returns the lines of a primitive (glTF 2.0, §3.7.2.1); degenerate segments are omitted.
pub(super) fn polylines(mode: Mode, corners: &[u32]) -> Vec<Vec<u32>> {
    match mode {
        Mode::Lines => joined(corners.as_chunks::<2>().0),
        Mode::LineLoop => {
            let ring = corners.iter().chain(corners.first()).copied();
            long_enough(ring.collect())
        }
        _ => long_enough(corners.to_vec()),
    }
}

fn long_enough(mut line: Vec<u32>) -> Vec<Vec<u32>> {
    line.dedup();
    if line.len() > 1 { vec![line] } else { Vec::new() }
}

/// Joins segments to lines of maximum length without passing through junctions.
fn joined(segments: &[[u32; 2]]) -> Vec<Vec<u32>> {
    let mut walk = Walk { at: BTreeMap::new(), is_used: vec![false; segments.len()], segments };
    for (number, [a, b]) in segments.iter().enumerate() {
        walk.is_used[number] = a == b;
        for end in [a, b].into_iter().filter(|_| a != b) {
            walk.at.entry(*end).or_default().push(number);
        }
    }
    let ends: Vec<u32> = walk.at.iter().filter(|(_, around)| around.len() != 2).map(|(&vertex, _)| vertex).collect();
    let mut lines = Vec::new();
    for start in ends {
        while let Some(line) = walk.line_from(start) {
            lines.push(line);
        }
    }
    // The remaining segments form closed rings.
    for [start, _] in segments {
        lines.extend(walk.line_from(*start));
    }
    lines
}

/// The segments not yet joined.
struct Walk<'a> {
    segments: &'a [[u32; 2]],
    /// Segments at each vertex.
    at: BTreeMap<u32, Vec<usize>>,
    is_used: Vec<bool>,
}

impl Walk<'_> {
    /// Returns the line from a vertex to the next end or junction, or back to the vertex; `None` if no segment is left
    /// there.
    fn line_from(&mut self, start: u32) -> Option<Vec<u32>> {
        let mut line = vec![start];
        let mut here = start;
        while let Some(number) = self.free_segment(here) {
            self.is_used[number] = true;
            let [a, b] = self.segments[number];
            here = if a == here { b } else { a };
            line.push(here);
            if here == start || self.at[&here].len() != 2 {
                break;
            }
        }
        (line.len() > 1).then_some(line)
    }

    fn free_segment(&self, vertex: u32) -> Option<usize> {
        self.at.get(&vertex)?.iter().copied().find(|&number| !self.is_used[number])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_in_any_order_become_lines() {
        assert_eq!(polylines(Mode::Lines, &[2, 3, 1, 0, 1, 2]), [[0, 1, 2, 3]]);
        assert_eq!(polylines(Mode::Lines, &[4, 5, 6, 4, 5, 6]), [[4, 5, 6, 4]]);
        assert_eq!(polylines(Mode::Lines, &[7, 7, 8]), Vec::<Vec<u32>>::new());
    }

    #[test]
    fn lines_end_at_junctions() {
        let lines = polylines(Mode::Lines, &[0, 1, 1, 2, 1, 3, 3, 4]);
        assert_eq!(lines, [vec![0, 1], vec![1, 2], vec![1, 3, 4]]);
    }

    #[test]
    fn strips_and_loops_are_one_line() {
        assert_eq!(polylines(Mode::LineStrip, &[3, 1, 1, 2]), [[3, 1, 2]]);
        assert_eq!(polylines(Mode::LineLoop, &[3, 1, 2]), [[3, 1, 2, 3]]);
        assert_eq!(polylines(Mode::LineStrip, &[3]), Vec::<Vec<u32>>::new());
    }
}
