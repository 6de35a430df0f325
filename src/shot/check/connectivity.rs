//! Validates `cuts`, `joins` and `island_radius` of a lattice.
//!
//! In: a raw lattice. Out: [`Connectivity`].

use super::{Check, Kind, LayerDefaults};
use crate::shot::connectivity::{CutSurface, ISLAND_RADIUS};
use crate::shot::raw::{RawCut, RawLattice, RawPartCut};
use crate::shot::{Connectivity, Cut};
use crate::solve::Topology;

impl Check<'_> {
    pub(super) fn connectivity(
        &mut self,
        raw: &RawLattice,
        topology: Topology,
        (layer, shot): (&str, &LayerDefaults),
    ) -> Connectivity {
        let key = format!("{layer}.lattice");
        for name in ["cuts", "joins", "island_radius"] {
            let key = format!("{key}.{name}");
            if topology == Topology::Plain && self.document.has(&key) {
                self.fault(&key, "it acts on branching lattices only", "add topology = \"branching\" to `lattice`");
            }
        }
        if shot.source != Kind::Scene && !raw.joins.is_empty() {
            let what = "only a `scene` has nodes that can be joined";
            self.fault(&format!("{key}.joins"), what, "remove `joins`; a picture hangs together where it is painted");
        }
        let cuts = raw.cuts.iter().enumerate();
        let cuts = cuts.map(|(number, cut)| self.cut(cut, &format!("{key}.cuts[{number}]"), shot)).collect();
        Connectivity { cuts, joins: raw.joins.clone(), island_radius: raw.island_radius.unwrap_or(ISLAND_RADIUS) }
    }

    fn cut(&mut self, raw: &RawCut, key: &str, shot: &LayerDefaults) -> Cut {
        match raw {
            RawCut::Stroke(stroke) => {
                if shot.source != Kind::Images {
                    let hint =
                        "give an `image`, or name a part: { joints = [..] }, { nodes = [..] }, { materials = [..] }";
                    self.fault(key, "strokes cut pictures only", hint);
                }
                if stroke.len() < 2 || !stroke.as_flattened().iter().all(|x| x.is_finite()) {
                    let what = "a stroke has at least two points, all of them numbers";
                    self.fault(key, what, "give [[x, y], [x, y], ..] in frame heights, y up");
                }
                Cut::Stroke(stroke.clone())
            }
            RawCut::Part(part) => self.part_cut(part, key, shot),
        }
    }

    fn part_cut(&mut self, raw: &RawPartCut, key: &str, shot: &LayerDefaults) -> Cut {
        let selection = self.selection(&raw.select(), key, shot);
        if shot.source != Kind::Scene {
            self.fault(key, "only a `scene` has parts with names", "draw a stroke: [[x, y], [x, y], ..]");
        } else if raw.nodes.is_none() && selection.is_whole() {
            let hint = "name nodes, joints, materials, vertex_color or a mask";
            self.fault(key, "a cut without a name separates nothing", hint);
        }
        let surface = if raw.open { CutSurface::Opened } else { CutSurface::Whole };
        Cut::Part { nodes: raw.nodes.clone().unwrap_or_default(), selection, surface }
    }
}
