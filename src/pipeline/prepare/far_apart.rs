//! Finds handles of a picture's lattice that act on points which lie far apart along the drawing.
//!
//! In: a [`PreparedShot`] and a layer with its dims. Out: [`FarApart`], with a note for the user.

use crate::lattice::Grid;
use crate::pipeline::PreparedShot;
use crate::pipeline::evaluate::lattice_box::screen_box;
use crate::pipeline::evaluate::screen_shape::screen_shape;
use crate::shot::{LayerSpace, Source};
use crate::solve::{FarPoints, Topology, far_points};
use crate::spelling::pluralised;
use std::sync::{Arc, PoisonError};

/// The handles of a layer that act on points far apart along its picture.
#[derive(Clone, Debug)]
pub(super) struct FarApart {
    /// One for each such copy of a handle.
    found: Arc<Vec<FarPoints<2>>>,
}

impl FarApart {
    /// Looks at the lattice of a layer at the reference frame; once for each grid and connection of the picture. `None` for scenes, whose
    /// shape changes from frame to frame, for lattices that do not branch, and where nothing is in the frame.
    pub(super) fn of(prepared: &PreparedShot, index: usize) -> Option<Self> {
        let layer = &prepared.shot.layers[index];
        let LayerSpace::Screen { dims, bounds } = layer.space else { return None };
        if matches!(prepared.shot.source, Source::Scene(_)) || layer.settings.topology != Topology::Branching {
            return None;
        }
        let sample = prepared.unsolved_at(f64::from(prepared.shot.reference_frame())).ok()?;
        let grid = Grid::over(screen_box(prepared, &sample, index, bounds)?, dims, layer.basis);
        let shape = screen_shape(prepared, &sample, index);
        let links = shape.links.clone()?;
        let known = || prepared.cache.far_points.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = known().get(&index).and_then(|known| known.of(&grid, &links)) {
            return Some(Self { found });
        }
        let found = Arc::new(far_points(&grid, &shape).ok()?);
        known().entry(index).or_default().keep(grid, links, &found);
        Some(Self { found })
    }

    pub(super) fn is_empty(&self) -> bool {
        self.found.is_empty()
    }

    /// Says which points move together and what to do; `None` if there are none.
    pub(super) fn note(&self, layer: &str) -> Option<String> {
        let farthest = self.found.iter().max_by(|a, b| a.diagonals.total_cmp(&b.diagonals))?;
        let handles = pluralised(self.found.len(), "handle moves", "handles move");
        let [from, to] = farthest.points.map(|[x, y]| format!("[{x:.3}, {y:.3}]"));
        Some(format!(
            "layer '{layer}': {handles} points together that lie far apart along the drawing, such as {from} and {to}, and no lattice may \
             be finer; draw a stroke between them or paint a mask (`cuts`), or move them in a layer of their own"
        ))
    }
}
