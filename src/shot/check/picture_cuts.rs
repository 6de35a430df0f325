//! Validates the cuts of a picture by ids and by closed regions.
//!
//! In: raw tables. Out: [`Cut`].

use super::connectivity::SHAPE_HINT;
use super::{Check, Kind, LayerDefaults};
use crate::plate::Matte;
use crate::shot::connectivity::{CONTRAST, GAP, LINE};
use crate::shot::raw::{RawIds, RawPartCut, RawRegions};
use crate::shot::{Cut, IdChoice, IdPicture, LineArt};

impl Check<'_> {
    /// Returns the cut that `ids` or `regions` asks for; `None` if neither is there.
    pub(super) fn picture_cut(&mut self, raw: &RawPartCut, key: &str, shot: &LayerDefaults) -> Option<Cut> {
        let (name, cut) = match (&raw.ids, &raw.regions) {
            (Some(ids), _) => ("ids", self.ids(ids, &format!("{key}.ids"))),
            (None, Some(regions)) => ("regions", self.regions(regions, &format!("{key}.regions"))),
            (None, None) => return None,
        };
        let others = raw.keys_beside(name);
        if let [other, ..] = others.as_slice() {
            let hint = format!("make a cut for each: [{{ {name} = .. }}, {{ {other} = .. }}]");
            self.fault(&format!("{key}.{other}"), format!("`{name}` stands alone"), hint);
        }
        match shot.source {
            Kind::Images => {}
            Kind::Scene => {
                let what = format!("`{name}` divides pictures, and this shot has a `scene`");
                let hint = "name a part instead: { joints = [..] }, { nodes = [..] }, { materials = [..] }, { mask = { file = .. } }";
                self.fault(&format!("{key}.{name}"), what, hint);
            }
            Kind::Frame => self.fault(key, "a whole plate has no parts", SHAPE_HINT),
        }
        Some(cut)
    }

    fn ids(&mut self, raw: &RawIds, key: &str) -> Cut {
        let RawIds { file, id, values, cryptomatte, of } = raw.clone();
        if values.is_some() && id.is_none() {
            self.fault(&format!("{key}.values"), "belongs to `id`", "remove it or add `id`");
        }
        let lonely = [("cryptomatte", cryptomatte.is_some()), ("of", of.is_some())];
        for (name, _) in lonely.iter().filter(|(_, is_given)| *is_given && id.is_some()) {
            let hint = "keep one of them, and make a cut for each";
            self.fault(&format!("{key}.{name}"), "a channel of ids is no Cryptomatte", hint);
        }
        let ids = match (id, values, cryptomatte) {
            (Some(channel), Some(values), _) => IdChoice::Chosen(Matte::Id { channel, values }),
            (Some(channel), None, _) => IdChoice::EachOfChannel(channel),
            (None, _, Some(names)) => IdChoice::Chosen(Matte::Cryptomatte { layer: of, names }),
            (None, _, None) => IdChoice::Each(of),
        };
        Cut::Ids(IdPicture { file: self.folder().join(file), ids })
    }

    fn regions(&mut self, raw: &RawRegions, key: &str) -> Cut {
        let at = raw.at.clone().unwrap_or_default();
        if !at.as_flattened().iter().all(|x| x.is_finite()) {
            self.fault(&format!("{key}.at"), "points are numbers", "give [[x, y], ..] in frame heights, y up");
        }
        Cut::Regions(LineArt {
            file: raw.file.as_ref().map(|file| self.folder().join(file)),
            at,
            gap: raw.gap.unwrap_or(GAP),
            line: raw.line.unwrap_or(LINE),
            threshold: raw.threshold.unwrap_or(CONTRAST),
        })
    }
}
