//! Validates `region` of a pin and `[[layer.stiffness]]`: each entry sets exactly one part, completely.
//!
//! In: raw tables. Out: [`PinRegion`]s and [`StiffnessRule`]s.

use super::{Check, LayerDefaults};
use crate::shot::raw::{RawRegion, RawSpace, RawStiffness};
use crate::shot::{OffsetUnit, PinRegion, StiffPart, StiffnessRule};

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

    pub(super) fn stiffness(&mut self, raw: Vec<RawStiffness>, layer: &str) -> Vec<StiffnessRule> {
        let rules = raw.into_iter().enumerate();
        rules.filter_map(|(index, raw)| self.stiffness_rule(raw, &format!("{layer}.stiffness[{index}]"))).collect()
    }

    fn stiffness_rule(&mut self, raw: RawStiffness, key: &str) -> Option<StiffnessRule> {
        let part = match (raw.nodes, raw.material, raw.vertex_color) {
            (Some(nodes), None, None) => StiffPart::Nodes(nodes),
            (None, Some(material), None) => StiffPart::Material(material),
            (None, None, Some(channel)) => StiffPart::VertexColor(channel),
            (None, None, None) => {
                let hint = "give one of nodes = [\"Head*\"], material = \"Metal\", vertex_color = \"r\"";
                self.fault(key, "does not say what is stiff", hint);
                return None;
            }
            _ => {
                let hint = "make an entry of each; where they meet, their values multiply";
                self.fault(key, "names nodes, material and vertex_color, or two of them", hint);
                return None;
            }
        };
        Some(StiffnessRule { part, value: raw.value })
    }
}
