//! Attaches the pieces of a branching layer's shape to the model, and labels each with its branch.
//!
//! In: a solved [`TimeSample`] and its neighbours. Out: [`LabelledPieces`].

use crate::pipeline::evaluate::ordered_parts::{OrderedPart, OrderedParts};
use crate::pipeline::evaluate::part_order::ordered_parts;
use crate::pipeline::evaluate::part_triangle_ranges::PartTriangleRanges;
use crate::pipeline::{PreparedShot, TimeSample};
use crate::screen::{Projected, ScreenMesh, clip_near, primitive};
use crate::solve::BranchedLattice;
use std::collections::BTreeMap;

/// A set of pieces that move together in a frame, and also in the neighbouring frames if those are considered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Label {
    /// The branch in this frame, and its order among overlapping parts.
    pub(super) now: OrderedPart,
    /// The branches in the previous and the next frame; `None` if the lattice does not branch there or the frame is not considered.
    pub(super) around: [Option<usize>; 2],
}

/// A convex piece of a triangle of the model.
#[derive(Clone, Debug)]
pub(super) struct LabelledPiece {
    /// Index into the list of labels.
    pub(super) label: u32,
    /// Index into the pose's parts.
    pub(super) part: usize,
    /// Vertex indices of the triangle.
    pub(super) corners: [u32; 3],
    /// Barycentric coordinates of the corners of the piece.
    pub(super) outline: Vec<[f64; 3]>,
}

/// The pieces of a layer and their labels.
pub(super) struct LabelledPieces {
    /// All labels that occur, sorted by order, then by branch with the largest branch first.
    pub(super) labels: Vec<Label>,
    pub(super) pieces: Vec<LabelledPiece>,
}

/// A triangle of the model after clipping at the near plane.
struct CutTriangle {
    part: usize,
    /// Index of the triangle in its part.
    number: usize,
    corners: [u32; 3],
    /// Barycentric coordinates of the clipped corners in the triangle of the model; their homogeneous w and screen
    /// positions follow.
    weights: [[f64; 3]; 3],
    w: [f64; 3],
    at: [[f64; 2]; 3],
}

impl LabelledPieces {
    pub(super) fn of(
        prepared: &PreparedShot,
        layer: usize,
        now: &TimeSample,
        around: Option<[&TimeSample; 2]>,
    ) -> Option<Self> {
        let (branches, OrderedParts { list: parts, of_pieces, .. }) = ordered_parts(prepared, layer, now)?;
        let triangles = cut_triangles(prepared, now, &now.layers[layer].starts);
        let others = around.map(|samples| samples.map(|sample| Other::of(sample, layer)));
        let mut list: BTreeMap<Label, u32> = BTreeMap::new();
        let mut found = Vec::new();
        for (&part, (triangle, _, corners)) in of_pieces.iter().zip(branches.pieces_of_triangles()) {
            let Some(source) = triangles.get(&triangle) else { continue };
            let Some(outline) = corners.iter().map(|&corner| source.barycentric(corner)).collect::<Option<Vec<_>>>()
            else {
                continue;
            };
            let count = outline.len() as f64;
            let middle = std::array::from_fn(|k| outline.iter().map(|weights| weights[k]).sum::<f64>() / count);
            let branch_in = |other: &Option<Other>| other.as_ref().and_then(|other| other.branch(source, middle));
            let label = Label {
                now: parts[part as usize],
                around: others.as_ref().map_or([None; 2], |others| others.each_ref().map(branch_in)),
            };
            list.insert(label, 0);
            found.push((label, source, outline));
        }
        (0..).zip(list.values_mut()).for_each(|(number, place)| *place = number);
        let piece = |(label, source, outline): (Label, &CutTriangle, Vec<[f64; 3]>)| LabelledPiece {
            label: list[&label],
            part: source.part,
            corners: source.corners,
            outline,
        };
        let pieces = found.into_iter().map(piece).collect();
        Some(Self { labels: list.into_keys().collect(), pieces })
    }
}

/// Returns the clipped triangles that make up a layer's shape, by their index in the shape.
fn cut_triangles(
    prepared: &PreparedShot,
    now: &TimeSample,
    starts: &[PartTriangleRanges],
) -> BTreeMap<usize, CutTriangle> {
    let (mesh, near) = (now.mesh(), now.camera.near());
    let mut all = BTreeMap::new();
    for PartTriangleRanges { part, starts } in starts {
        let source = primitive(&prepared.scene, &now.pose.parts[*part]);
        let vertices = &mesh.parts[*part].vertices;
        for (number, (&corners, run)) in source.triangles.iter().zip(starts.windows(2)).enumerate() {
            if run[0] == run[1] {
                continue;
            }
            let ends: [Projected; 3] = corners.map(|corner| vertices[corner as usize]);
            let (cut, count) = clip_near(ends, near);
            for (index, cut) in (run[0]..run[1]).zip(&cut[..count]) {
                let weights = cut.map(|corner| corner.barycentric());
                let places = weights.map(|weights| interpolated(&ends, weights));
                let triangle = CutTriangle {
                    part: *part,
                    number,
                    corners,
                    weights,
                    w: places.map(|place| place.w),
                    at: places.map(|place| place.point().0.to_array()),
                };
                all.insert(index as usize, triangle);
            }
        }
    }
    all
}

/// Interpolates the projected corners of a triangle with barycentric weights, in homogeneous coordinates.
pub(super) fn interpolated(ends: &[Projected; 3], weights: [f64; 3]) -> Projected {
    let sum = |of: fn(&Projected) -> f64| (0..3).map(|k| weights[k] * of(&ends[k])).sum::<f64>();
    Projected { h: (0..3).map(|k| ends[k].h * weights[k]).sum(), w: sum(|end| end.w), depth: sum(|end| end.depth) }
}

impl CutTriangle {
    /// Returns the barycentric coordinates of a screen point in the triangle of the model; `None` if the clipped
    /// triangle has no area on the screen.
    fn barycentric(&self, [x, y]: [f64; 2]) -> Option<[f64; 3]> {
        let [a, b, c] = self.at;
        let cross =
            |p: [f64; 2], q: [f64; 2], r: [f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
        let whole = cross(a, b, c);
        if whole == 0.0 {
            return None;
        }
        let point = [x, y];
        // Perspective correction: weights on the screen are divided by w.
        let shares = [cross(point, b, c) / whole, cross(a, point, c) / whole, cross(a, b, point) / whole];
        let shares: [f64; 3] = std::array::from_fn(|k| shares[k] / self.w[k]);
        let sum: f64 = shares.iter().sum();
        let weights = std::array::from_fn(|k| (0..3).map(|j| shares[j] / sum * self.weights[j][k]).sum());
        (sum != 0.0).then_some(weights)
    }
}

/// The branches of a neighbouring frame.
struct Other<'a> {
    branches: &'a BranchedLattice<2>,
    starts: &'a [PartTriangleRanges],
    mesh: std::borrow::Cow<'a, ScreenMesh>,
}

impl<'a> Other<'a> {
    /// Returns `None` if the layer's lattice does not branch in that frame.
    fn of(sample: &'a TimeSample, layer: usize) -> Option<Self> {
        let state = &sample.layers[layer];
        let branches = state.solution.as_ref()?.branches.as_ref()?;
        Some(Self { branches, starts: &state.starts, mesh: sample.mesh() })
    }

    /// Returns the branch at a point of a triangle; `None` if the camera does not see it.
    fn branch(&self, triangle: &CutTriangle, weights: [f64; 3]) -> Option<usize> {
        let starts = &self.starts.iter().find(|own| own.part == triangle.part)?.starts;
        let [start, end] =
            [triangle.number, triangle.number + 1].map(|k| starts.get(k).map_or(0, |&start| start as usize));
        let vertices = &self.mesh.parts[triangle.part].vertices;
        let place = interpolated(&triangle.corners.map(|corner| vertices[corner as usize]), weights);
        (start < end && place.w > 0.0).then(|| self.branches.branch_within(start..end, place.point().0.to_array()))
    }
}
