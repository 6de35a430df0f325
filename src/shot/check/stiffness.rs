//! Validates `region` of a pin and `[[layer.stiffness]]`: each entry sets exactly one part, completely.
//!
//! In: raw tables. Out: [`PinRegion`]s, [`StiffnessRule`]s and [`BrushStroke`]s.

use super::{Check, LayerDefaults};
use crate::shot::raw::{RawRegion, RawSpace, RawStiffness, RawStroke};
use crate::shot::{BrushStroke, OffsetUnit, PinRegion, StiffPart, StiffnessRule};

impl Check<'_> {
    pub(super) fn region(
        &mut self,
        raw: &RawRegion,
        key: &str,
        (unit, shot): (OffsetUnit, &LayerDefaults),
    ) -> PinRegion {
        if unit == OffsetUnit::Frame && shot.space == RawSpace::Screen {
            self.screen_unit(&[raw.radius], &format!("{key}.radius"), shot);
        }
        if raw.rigidity == 0.0 && raw.stiffness == 1.0 {
            let hint = "add rigidity = 1.0 to move it as one piece, or stiffness = 5.0 to make it stiffer";
            self.fault(key, "does nothing", hint);
        }
        PinRegion { radius: raw.radius, rigidity: raw.rigidity, stiffness: raw.stiffness }
    }

    /// Returns the rules and the brush strokes, each in the order of the file.
    pub(super) fn stiffness(&mut self, raw: Vec<RawStiffness>, layer: &str) -> (Vec<StiffnessRule>, Vec<BrushStroke>) {
        let (mut rules, mut strokes) = (Vec::new(), Vec::new());
        for (index, raw) in raw.into_iter().enumerate() {
            let value = raw.value;
            match self.stiff_part(raw, &format!("{layer}.stiffness[{index}]")) {
                Some(Painted::Part(part)) => rules.push(StiffnessRule { part, value }),
                Some(Painted::Stroke(RawStroke { nodes, radius, points })) => {
                    strokes.push(BrushStroke { nodes, points, radius, value });
                }
                None => {}
            }
        }
        (rules, strokes)
    }

    fn stiff_part(&mut self, raw: RawStiffness, key: &str) -> Option<Painted> {
        let given = [
            raw.nodes.map(|nodes| Painted::Part(StiffPart::Nodes(nodes))),
            raw.material.map(|material| Painted::Part(StiffPart::Material(material))),
            raw.vertex_color.map(|channel| Painted::Part(StiffPart::VertexColor(channel))),
            raw.stroke.map(Painted::Stroke),
        ];
        let mut given = given.into_iter().flatten();
        match (given.next(), given.next()) {
            (Some(part), None) => Some(part),
            (None, _) => {
                let hint = "give one of nodes = [\"Head*\"], material = \"Metal\", vertex_color = \"r\", or a stroke";
                self.fault(key, "does not say what is stiff", hint);
                None
            }
            (Some(_), Some(_)) => {
                let hint = "make an entry of each; where they meet, their values multiply";
                self.fault(key, "names nodes, material, vertex_color and stroke, or two of them", hint);
                None
            }
        }
    }
}

/// What an entry applies to.
enum Painted {
    Part(StiffPart),
    Stroke(RawStroke),
}
