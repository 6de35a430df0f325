//! The ids of a plate as labels of parts: of a Cryptomatte, of a channel of ids, or what a matte selects.
//!
//! In: a plate. Out: a [`LabelMap`] of its display window. Pixels that belong to nothing have the label of the nearest part.

use super::channel_table::{ChannelIndex, ChannelTable};
use super::matte::{find, id_of, is_named, matte_layers_of_view, select, summed_coverage};
use super::{Matte, PlateError};
use crate::image::cryptomatte::{MatteId, MatteLayer};
use crate::image::{CHOSEN, LabelMap, NO_LABEL, OTHER, Plate};
use crate::space::PixelRect;
use crate::spelling;
use std::collections::BTreeMap;

/// Returns a label for each id of a Cryptomatte: that of its largest coverage in every pixel. Of several Cryptomattes, the one named `of`,
/// else one of objects, else of assets; `None` if there is none and none is named.
///
/// # Errors
/// [`PlateError::NoCryptomatte`] if there is none of that name.
pub(crate) fn cryptomatte_labels(plate: &Plate, of: Option<&str>) -> Result<Option<LabelMap>, PlateError> {
    let table = ChannelTable::of(plate, &[]);
    let all = matte_layers_of_view(&table, first_view(&table));
    let is_wanted = |matte: &&MatteLayer<ChannelIndex>| of.is_none_or(|of| is_named(&matte.name, of));
    let by_kind = |matte: &&MatteLayer<ChannelIndex>| {
        let name = matte.name.to_lowercase();
        ["object", "asset"].map(|kind| !name.contains(kind))
    };
    match (all.iter().filter(is_wanted).min_by_key(by_kind), of) {
        (None, None) => Ok(None),
        (None, Some(of)) => {
            let hint = match all.as_slice() {
                [] => "it has no Cryptomatte".to_owned(),
                all => spelling::hint(of, all.iter().map(|matte| matte.name.as_str())),
            };
            Err(PlateError::NoCryptomatte { layer: String::new(), wanted: format!("\"{of}\""), hint })
        }
        (Some(matte), _) => {
            let window = window_of(plate);
            let largest = matte.ranks.first().map(|rank| {
                let (ids, coverage) = (table.over(rank.id, window, 0.0), table.over(rank.coverage, window, 0.0));
                ids.iter().zip(coverage.iter()).map(|(id, share)| if *share > 0.0 { id.to_bits() } else { 0 }).collect()
            });
            Ok(Some(numbered(window, largest.unwrap_or_default())))
        }
    }
}

/// Returns a label for each value of a channel of ids; 0 is the background, which is no part.
///
/// # Errors
/// [`PlateError::NoMatteChannel`] if there is no channel of that name.
pub(crate) fn channel_labels(plate: &Plate, channel: &str) -> Result<LabelMap, PlateError> {
    let table = ChannelTable::of(plate, &[]);
    let window = window_of(plate);
    Ok(numbered(window, ids_of_channel(&table, channel, window)?))
}

/// Returns two labels: one for what a matte of ids or of a Cryptomatte covers by more than half, one for all else.
///
/// # Errors
/// [`PlateError`] if the plate lacks something that the matte refers to.
pub(crate) fn chosen_labels(plate: &Plate, matte: &Matte) -> Result<LabelMap, PlateError> {
    let table = ChannelTable::of(plate, &[]);
    let window = window_of(plate);
    let labels = match matte {
        Matte::Id { channel, values } => {
            let label = |id: u32| match (values.contains(&id), id) {
                (true, _) => CHOSEN,
                (false, 0) => NO_LABEL,
                (false, _) => OTHER,
            };
            ids_of_channel(&table, channel, window)?.into_iter().map(label).collect()
        }
        Matte::Cryptomatte { layer, names } => {
            let selection = select(&table, "", (layer.as_deref(), names), first_view(&table))?;
            if !selection.unknown.is_empty() {
                let hint = format!("in {}: {}", selection.matte.name, selection.unknown.join("; "));
                return Err(PlateError::NoCryptomatte {
                    layer: String::new(),
                    wanted: "all of the names".into(),
                    hint,
                });
            }
            let chosen = summed_coverage(&table, &selection.matte, |id| selection.ids.contains(&id), window);
            let all = summed_coverage(&table, &selection.matte, |id| id != MatteId::NOTHING, window);
            let label = |(chosen, all): (f32, f32)| match (all > 0.0, 2.0 * chosen > all) {
                (false, _) => NO_LABEL,
                (true, true) => CHOSEN,
                (true, false) => OTHER,
            };
            chosen.into_iter().zip(all).map(label).collect()
        }
        Matte::Alpha | Matte::Channel(_) | Matte::Drawn(_) | Matte::Part { .. } => vec![OTHER; window.area()],
    };
    Ok(spread(window, labels))
}

fn first_view<'a>(table: &'a ChannelTable) -> Option<&'a str> {
    table.entries.first().and_then(|entry| entry.name.view.as_deref())
}

/// Returns the display window, relative to its own corner.
fn window_of(plate: &Plate) -> PixelRect {
    plate.frame_size().window()
}

fn ids_of_channel(table: &ChannelTable, channel: &str, window: PixelRect) -> Result<Vec<u32>, PlateError> {
    let index = find(table, "", channel, first_view(table))?;
    let storage = table.channel(index).storage;
    Ok(table.over(index, window, 0.0).iter().map(|&sample| id_of(sample, storage)).collect())
}

/// Labels ids 1, 2, ... in ascending order; 0 is nothing.
fn numbered(window: PixelRect, ids: Vec<u32>) -> LabelMap {
    let mut numbers: BTreeMap<u32, u32> = ids.iter().filter(|id| **id != 0).map(|&id| (id, NO_LABEL)).collect();
    (1..).zip(numbers.values_mut()).for_each(|(number, label)| *label = number);
    spread(window, ids.into_iter().map(|id| numbers.get(&id).copied().unwrap_or(NO_LABEL)).collect())
}

fn spread(window: PixelRect, labels: Vec<u32>) -> LabelMap {
    let mut map = LabelMap { size: [window.width, window.height], labels };
    map.spread(|_| true);
    map
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::cryptomatte::{Manifest, MatteHeader};
    use crate::image::{Channel, PlatePart, Storage};

    /// A row of four pixels: nothing, arm, two thirds body, body; and their ids 0, 3, 7, 7.
    fn plate() -> Plate {
        let window = PixelRect { x: 0, y: 0, width: 4, height: 1 };
        let [arm, body] = ["arm.L", "body"].map(|name| MatteId::of_name(name).sample());
        let channel = |name: &str, samples: [f32; 4]| Channel {
            name: name.into(),
            storage: Storage::Float,
            samples: samples.into(),
        };
        let channels = vec![
            channel("CryptoObject00.R", [0.0, arm, body, body]),
            channel("CryptoObject00.G", [0.0, 1.0, 0.66, 1.0]),
            channel("CryptoObject00.B", [0.0, 0.0, arm, 0.0]),
            channel("CryptoObject00.A", [0.0, 0.0, 0.33, 0.0]),
            channel("id.object", [0.0, 3.0, 7.0, 7.0]),
        ];
        let mut part = PlatePart::new(window, channels);
        let manifest = Manifest::of_names(["arm.L", "body"]);
        let header = MatteHeader { name: "CryptoObject".into(), manifest, side_file: None };
        header.attributes().iter().for_each(|(name, text)| part.set_text(name, text));
        Plate::new(window, 1.0, vec![part])
    }

    fn names(names: &[&str]) -> Matte {
        Matte::Cryptomatte { layer: None, names: names.iter().map(|&name| name.to_owned()).collect() }
    }

    #[test]
    fn every_id_is_a_label_and_nothing_belongs_to_what_is_near() {
        let found = cryptomatte_labels(&plate(), None).expect("nothing is missing").expect("it has a Cryptomatte");
        let [nothing, arm, edge, body] = found.labels[..] else { panic!("{found:?}") };
        assert!(nothing == arm && edge == body && arm != body, "{found:?}");
        assert_eq!(channel_labels(&plate(), "id.object").expect("a channel").labels, [1, 1, 2, 2]);
    }

    #[test]
    fn what_is_chosen_is_one_part() {
        for matte in [names(&["arm*"]), Matte::Id { channel: "id.object".into(), values: vec![3] }] {
            assert_eq!(chosen_labels(&plate(), &matte).expect("it is there").labels, [1, 1, 2, 2], "{matte:?}");
        }
    }

    #[test]
    fn what_is_missing_is_named() {
        let told = |error: PlateError| error.to_string();
        let wrong = chosen_labels(&plate(), &names(&["arm.L", "bodi"])).map_err(told).expect_err("bodi");
        assert!(wrong.contains("did you mean \"body\""), "{wrong}");
        let wrong = cryptomatte_labels(&plate(), Some("CryptoObjekt")).map_err(told).expect_err("no such Cryptomatte");
        assert!(wrong.contains("did you mean \"CryptoObject\""), "{wrong}");
        let wrong = channel_labels(&plate(), "id.objekt").map_err(told).expect_err("no such channel");
        assert!(wrong.contains("did you mean \"id.object\""), "{wrong}");
    }
}
