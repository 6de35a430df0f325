//! Finds meshes that are too coarse for the world lattice that bends them.
//!
//! In: a prepared shot and its first pose. Out: notes.

use super::selection::LayerShare;
use crate::lattice::{BoxFrame, Grid};
use crate::pipeline::PreparedShot;
use crate::pipeline::evaluate::lattice_box::world_grid;
use crate::pose::{Pose, PosedPart};
use crate::scene::Primitive;
use crate::screen::primitive;

/// Length of an edge, in cells, above which the mesh is reported.
const LONG_EDGE_CELLS: f64 = 2.0;

/// Returns a note for every world layer with a mesh that is too coarse for its lattice.
pub(in crate::pipeline) fn coarse_meshes(prepared: &PreparedShot, first: &Pose) -> Vec<String> {
    let frame = f64::from(prepared.shot.reference_frame());
    let note = |index: usize| {
        let (placed, grid) = world_grid(prepared, index, frame, first)?;
        let parts = prepared.assignment.parts_of_layer[index].iter();
        let longest = parts.map(|&part| {
            let source = primitive(&prepared.scene, &first.parts[part]);
            let share = prepared.assignment.share(index, part);
            (longest_edge(source, &share, &first.parts[part], &placed, &grid), part)
        });
        let (cells, part) = longest.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let layer = &prepared.shot.layers[index].name;
        let node = &prepared.scene.nodes[first.parts[part].node].name;
        (cells > LONG_EDGE_CELLS).then(|| {
            format!(
                "layer '{layer}': edges of '{node}' are up to {cells:.1} cells of its lattice long; a mesh bends at \
                 its vertices only, so subdivide it or give the lattice fewer handles"
            )
        })
    };
    (0..prepared.shot.layers.len()).filter_map(note).collect()
}

/// Returns the length of the longest edge of a layer's share of a part, in cells of a grid.
fn longest_edge(source: &Primitive, share: &LayerShare, part: &PosedPart, frame: &BoxFrame, grid: &Grid<3>) -> f64 {
    let cells = |from: u32, to: u32| {
        let [from, to] = [from, to].map(|corner| part.positions[corner as usize].0.as_dvec3());
        let edge = frame.axes().transpose() * (to - from);
        (0..3).map(|axis| edge[axis].abs() / grid.spacing(axis)).fold(0.0, f64::max)
    };
    let own = source.triangles.iter().filter(|corners| share.meets(corners));
    let edges = own.flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    edges.chain(source.segments()).map(|[from, to]| cells(from, to)).fold(0.0, f64::max)
}
