//! Keeps which points a lattice holds together that lie far apart along its picture.
//!
//! In: grids over pictures, with the links of each and what was found. Out: the same again for an equal grid and equal links.

use crate::lattice::Grid;
use crate::solve::{FarPoints, Link};
use std::collections::VecDeque;
use std::sync::Arc;

/// Number of grids that are kept: more than a refinement goes through.
const KEPT: usize = 16;

/// What was found for the last grids of a layer.
#[derive(Clone, Debug, Default)]
pub(in crate::pipeline) struct KnownFarPoints {
    grids: VecDeque<KnownGrid>,
}

#[derive(Clone, Debug)]
struct KnownGrid {
    grid: Grid<2>,
    links: Arc<Vec<Link>>,
    found: Arc<Vec<FarPoints<2>>>,
}

impl KnownFarPoints {
    /// Returns what was found for a grid over a picture with these links.
    pub(super) fn of(&self, grid: &Grid<2>, links: &Arc<Vec<Link>>) -> Option<Arc<Vec<FarPoints<2>>>> {
        let known = self.grids.iter().find(|known| known.grid == *grid && known.links == *links)?;
        Some(Arc::clone(&known.found))
    }

    /// Keeps what was found, and forgets the oldest if there is too much.
    pub(super) fn keep(&mut self, grid: Grid<2>, links: Arc<Vec<Link>>, found: &Arc<Vec<FarPoints<2>>>) {
        self.grids.push_back(KnownGrid { grid, links, found: Arc::clone(found) });
        if self.grids.len() > KEPT {
            self.grids.pop_front();
        }
    }
}
