//! Validates `transfer`: lattices from another file instead of pins.
//!
//! In: the raw table. Out: a [`Transfer`].

use super::{Check, LayerDefaults};
use crate::shot::raw::{RawFit, RawSpace, RawTransfer};
use crate::shot::{Transfer, TransferFit};
use crate::space::ScreenPoint;
use std::path::Path;

impl Check<'_> {
    /// Checks a transfer; `layer`: the key of its layer.
    pub(super) fn transfer(&mut self, raw: &RawTransfer, layer: &str, shot: &LayerDefaults) -> Transfer {
        for key in ["pin", "handle", "solve", "stiffness"].map(|other| format!("{layer}.{other}")) {
            if self.document.has(&key) {
                let what = "a layer with `transfer` takes its lattices from a file and solves nothing";
                self.fault(&key, what, "remove it or `transfer`");
            }
        }
        if shot.space == RawSpace::World {
            let what = "lattices from a file lie on the screen, this layer's lattice lies in the scene";
            self.fault(&format!("{layer}.lattice.space"), what, "remove it or `transfer`");
        }
        let folder = self.document.path.parent().unwrap_or(Path::new(""));
        Transfer {
            file: folder.join(&raw.lattice),
            layer: raw.layer.clone(),
            fit: self.fit(&raw.fit, &format!("{layer}.transfer.fit.landmarks"), shot),
            start: raw.start,
        }
    }

    fn fit(&mut self, raw: &RawFit, key: &str, shot: &LayerDefaults) -> TransferFit {
        match raw {
            RawFit::Box => TransferFit::Box,
            RawFit::AsIs => TransferFit::AsIs,
            RawFit::Landmarks(pairs) => {
                let points = pairs.iter().flatten().flatten().copied().collect::<Vec<_>>();
                self.screen_unit(&points, key, shot);
                let point = |[x, y]: [f64; 2]| ScreenPoint::new(x, y);
                TransferFit::Landmarks(pairs.iter().map(|pair| pair.map(point)).collect())
            }
        }
    }
}
