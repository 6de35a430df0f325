//! Finds meshes that are too coarse for the lattice of the scene that bends them.
//!
//! In: a shot made ready and its first pose. Out: notes.

use super::Setup;
use crate::lattice::{BoxFrame, Grid};
use crate::pose::{Pose, PosedPart};
use crate::screen::primitive;

/// Edges longer than this many cells are told to the user.
const LONG_EDGE_CELLS: f64 = 2.0;

impl Setup {
    /// Says where a mesh is too coarse for the lattice that bends it.
    pub(super) fn note_coarse(&mut self, first: &Pose) {
        let frame = f64::from(self.shot.frames.first);
        for index in 0..self.shot.layers.len() {
            let Some((placed, grid)) = self.world_grid(index, frame, first) else { continue };
            let parts = self.parts_of_layer[index].iter();
            let longest = parts.map(|&part| (self.longest_edge(&first.parts[part], (&placed, &grid)), part));
            let Some((cells, part)) = longest.max_by(|a, b| a.0.total_cmp(&b.0)) else { continue };
            if cells > LONG_EDGE_CELLS {
                let (layer, node) = (&self.shot.layers[index].name, &self.scene.nodes[first.parts[part].node].name);
                self.notes.push(format!(
                    "layer '{layer}': edges of '{node}' are up to {cells:.1} cells of its lattice long; a mesh bends at \
                     its vertices only, so subdivide it or give the lattice fewer handles"
                ));
            }
        }
    }

    /// Length of a part's longest edge, in cells of a grid.
    fn longest_edge(&self, part: &PosedPart, (frame, grid): (&BoxFrame, &Grid<3>)) -> f64 {
        let cells = |from: u32, to: u32| {
            let [from, to] = [from, to].map(|corner| part.positions[corner as usize].0.as_dvec3());
            let edge = frame.axes().transpose() * (to - from);
            (0..3).map(|axis| edge[axis].abs() / grid.spacing(axis)).fold(0.0, f64::max)
        };
        let source = primitive(&self.scene, part);
        let edges = source.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        edges.chain(source.segments()).map(|[from, to]| cells(from, to)).fold(0.0, f64::max)
    }
}
