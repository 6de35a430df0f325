//! Validates `cuts`, `joins` and `island_radius` of a lattice.
//!
//! In: a raw lattice. Out: [`Connectivity`].

use super::{Check, Kind, LayerDefaults};
use crate::shot::connectivity::{CutSurface, ISLAND_RADIUS, Join};
use crate::shot::raw::{RawCut, RawJoin, RawLattice, RawPartCut, RawPlacedJoin};
use crate::shot::{Connectivity, Cut, OrderKey};
use crate::solve::Topology;

/// What gives a plate a shape, whose parts can move apart.
pub(super) const SHAPE_HINT: &str =
    "give a scene, or a reference frame of the plate: image = \"beauty.0001.exr\"; its alpha is the shape";

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
        let mut cuts = Vec::with_capacity(raw.cuts.len());
        let mut orders = Vec::with_capacity(raw.cuts.len());
        for (number, raw) in raw.cuts.iter().enumerate() {
            let key = format!("{key}.cuts[{number}]");
            let cut = self.cut(raw, &key, shot);
            orders.push(self.order_of_part((raw, &cut), &format!("{key}.order"), shot));
            cuts.push(cut);
        }
        let island_radius = raw.island_radius.unwrap_or(ISLAND_RADIUS);
        let joins = raw.joins.iter().enumerate();
        let joins = joins.map(|(number, raw)| self.join(raw, &format!("{key}.joins[{number}]"))).collect();
        Connectivity { cuts, orders, joins, island_radius }
    }

    fn join(&mut self, raw: &RawJoin, key: &str) -> Join {
        match raw {
            RawJoin::Nearest(nodes) => Join { nodes: nodes.clone(), at: None },
            RawJoin::At(RawPlacedJoin { nodes, at }) => {
                if !at.iter().all(|x| x.is_finite()) {
                    let hint = "give [x, y, z] in metres of the scene at rest";
                    self.fault(&format!("{key}.at"), "a place is three finite numbers", hint);
                }
                Join { nodes: nodes.clone(), at: Some(*at) }
            }
        }
    }

    /// Returns the order of the part that a cut chooses.
    fn order_of_part(&mut self, (raw, cut): (&RawCut, &Cut), key: &str, shot: &LayerDefaults) -> Vec<OrderKey> {
        let RawCut::Part(part) = raw else { return Vec::new() };
        if part.order.is_some() && shot.source == Kind::Images && !cut.chooses_part() {
            let hint = "choose a part by `mask`, by ids with `cryptomatte` or `values`, or by regions with `at`, or give pins an order";
            self.fault(key, "this cut has several parts, and none of them is chosen", hint);
        }
        self.order(part.order.as_ref(), key, shot)
    }

    fn cut(&mut self, raw: &RawCut, key: &str, shot: &LayerDefaults) -> Cut {
        match raw {
            RawCut::Stroke(stroke) => {
                match shot.source {
                    Kind::Images => {}
                    Kind::Scene => {
                        let what = "a stroke over a scene needs the frame in which it is drawn";
                        let hint = "give { stroke = [[x, y], [x, y], ..], frame = 1 }, or name a part: { joints = [..] }, { nodes = [..] }, \
                                    { materials = [..] }";
                        self.fault(key, what, hint);
                    }
                    Kind::Frame => self.fault(key, "a whole plate has no parts", SHAPE_HINT),
                }
                self.stroke(stroke, key);
                Cut::Stroke(stroke.clone())
            }
            RawCut::Part(part) => {
                let alone = self.picture_cut(part, key, shot).or_else(|| self.scene_stroke(part, key, shot));
                alone.unwrap_or_else(|| self.part_cut(part, key, shot))
            }
        }
    }

    /// Checks the points of a stroke.
    fn stroke(&mut self, stroke: &[[f64; 2]], key: &str) {
        if stroke.len() < 2 || !stroke.as_flattened().iter().all(|x| x.is_finite()) {
            let what = "a stroke has at least two points, all of them numbers";
            self.fault(key, what, "give [[x, y], [x, y], ..] in frame heights, y up");
        }
    }

    /// Returns the cut along a stroke over a scene; `None` without a stroke.
    fn scene_stroke(&mut self, raw: &RawPartCut, key: &str, shot: &LayerDefaults) -> Option<Cut> {
        let points = raw.stroke.as_ref()?;
        if shot.source != Kind::Scene {
            let hint = "give its points alone: cuts = [[[x, y], [x, y], ..]]";
            self.fault(&format!("{key}.stroke"), "only a stroke over a `scene` is drawn over a frame", hint);
        }
        if raw.frame.is_none() {
            let hint = "add the frame in which the camera sees what the stroke divides: frame = 1";
            self.fault(&format!("{key}.frame"), "is missing", hint);
        }
        self.stroke(points, &format!("{key}.stroke"));
        let others = raw.keys_beside("stroke");
        if let Some(other) = others.iter().find(|other| !["frame", "open"].contains(other)) {
            let hint = format!("make a cut for each: [{{ stroke = .., frame = .. }}, {{ {other} = .. }}]");
            self.fault(&format!("{key}.{other}"), "`stroke` stands alone", hint);
        }
        let (frame, surface) = (raw.frame.unwrap_or(shot.reference_frame), surface(raw.open));
        Some(Cut::SceneStroke { points: points.clone(), frame, surface })
    }

    fn part_cut(&mut self, raw: &RawPartCut, key: &str, shot: &LayerDefaults) -> Cut {
        let selection = self.selection(&raw.select(), key, shot);
        if raw.frame.is_some() {
            self.fault(&format!("{key}.frame"), "belongs to `stroke`", "remove it or add `stroke`");
        }
        let names = raw.nodes.is_some()
            || selection.vertex_color.is_some()
            || !selection.joints.is_empty()
            || !selection.materials.is_empty();
        match shot.source {
            Kind::Scene if raw.nodes.is_none() && selection.is_whole() => {
                let hint = "name nodes, joints, materials, vertex_color or a mask";
                self.fault(key, "a cut without a name separates nothing", hint);
            }
            Kind::Scene => {}
            Kind::Images if names || selection.mask.is_none() => {
                let hint = "draw a stroke: [[x, y], [x, y], ..], paint a mask: { mask = { file = \"arm.png\" } }, or give `ids` or \
                            `regions`";
                self.fault(key, "only a `scene` has parts with names", hint);
            }
            Kind::Images if selection.mask.as_ref().is_some_and(|mask| mask.uv_set != 0) => {
                self.fault(&format!("{key}.mask.texcoord"), "a picture has no UVs", "remove `texcoord`");
            }
            Kind::Images => {}
            Kind::Frame => self.fault(key, "a whole plate has no parts", SHAPE_HINT),
        }
        // The parts of a drawing hang together by its surface alone.
        let surface = surface(raw.open || shot.source == Kind::Images);
        Cut::Part { nodes: raw.nodes.clone().unwrap_or_default(), selection, surface }
    }
}

const fn surface(is_open: bool) -> CutSurface {
    if is_open { CutSurface::Opened } else { CutSurface::Whole }
}
