//! The warp of a whole screen: a lattice inside its box, and what happens around it.
//!
//! In: a lattice of the screen. Out: where any point of the screen goes.

use crate::lattice::ScreenLattice;
use crate::space::ScreenPoint;

/// Where every point of the screen goes.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    lattice: ScreenLattice,
}

impl Field {
    /// The warp of a layer that stands alone (geometry, matted plates): around the box a point moves as the nearest box
    /// point does.
    #[must_use]
    pub const fn of_layer(lattice: ScreenLattice) -> Self {
        Self { lattice }
    }

    /// Where a point goes.
    #[must_use]
    pub fn carry(&self, point: ScreenPoint) -> ScreenPoint {
        self.lattice.warp(point)
    }
}
