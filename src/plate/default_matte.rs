//! Default mattes of layers that specify none: by object name from a Cryptomatte of the plate, or from the coverage of
//! the rendered layer.
//!
//! In: a plate, the object names of each layer. Out: one [`Matte`] per layer; the coverage of a matte as samples.

use super::channel_table::ChannelTable;
use super::matte::{MatteRegion, matte_coverage};
use super::{Coverage, Matte, PlateError, WarpSettings};
use crate::image::Plate;
use crate::image::cryptomatte::{Manifest, MatteHeader};

/// Selects one matte per layer from a Cryptomatte of the plate that contains at least one name of every layer.
///
/// Object Cryptomattes are preferred, then assets, then others; materials do not distinguish layers. `names`: the
/// object names of each layer. Returns `None` if no such Cryptomatte exists.
#[must_use]
pub(crate) fn mattes_of_names(plate: &Plate, names: &[Vec<String>], settings: &WarpSettings) -> Option<Vec<Matte>> {
    let table = ChannelTable::of(plate, &settings.semantics);
    let there = table.matte_layers(table.entries.iter());
    let is_there = |header: &&MatteHeader| there.iter().any(|layer| layer.name == header.name);
    let mut headers: Vec<&MatteHeader> = table.mattes.iter().filter(is_there).collect();
    headers.retain(|header| !header.name.to_lowercase().contains("material"));
    headers.sort_by_key(|header| {
        let name = header.name.to_lowercase();
        [name.contains("object"), name.contains("asset")].map(|is_kind| !is_kind)
    });
    headers.into_iter().find_map(|header| {
        let matte = |names: &Vec<String>| {
            let known: Vec<String> = names.iter().filter(|name| knows(&header.manifest, name)).cloned().collect();
            (!known.is_empty()).then(|| Matte::Cryptomatte { layer: Some(header.name.clone()), names: known })
        };
        names.iter().map(matte).collect()
    })
}

/// Whether the manifest lists the name. Without a manifest nothing can be matched reliably.
fn knows(manifest: &Manifest, name: &str) -> bool {
    manifest.iter().any(|(known, _)| known == name)
}

/// Computes the coverage of a matte over the data window of the plate's first part.
///
/// # Errors
/// [`PlateError`] if the plate lacks what the matte refers to.
pub(crate) fn coverage_of(plate: &Plate, matte: &Matte, settings: &WarpSettings) -> Result<Coverage, PlateError> {
    let frame = plate.frame_size();
    let window = plate.parts.first().map_or(frame.window(), |part| plate.window_of(part));
    let table = ChannelTable::of(plate, &settings.semantics);
    let covered = matte_coverage(&table, ("", matte), MatteRegion { view: None, window })?;
    Ok(Coverage { frame, window, samples: covered.coverage.unwrap_or_else(|| vec![1.0; window.area()]) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::cryptomatte::MatteId;
    use crate::image::{Channel, PlatePart, Storage};
    use crate::space::PixelRect;
    use std::sync::Arc;

    const WINDOW: PixelRect = PixelRect { x: 0, y: 0, width: 2, height: 1 };

    /// A transparent pixel and an opaque one, each covered to 0.25 by a sword.
    fn plate() -> Plate {
        let id = MatteId::of_name("Sword").sample();
        let channel = |name: &str, samples: [f32; 2]| Channel {
            name: name.into(),
            storage: Storage::Float,
            samples: samples.into(),
        };
        let ranks = ["Material", "Object"].map(|kind| {
            [channel(&format!("Crypto{kind}00.R"), [id; 2]), channel(&format!("Crypto{kind}00.G"), [0.25; 2])]
        });
        let colors = [channel("R", [0.1, 0.9]), channel("A", [0.25, 1.0])];
        let mut part = PlatePart::new(WINDOW, colors.into_iter().chain(ranks.into_iter().flatten()).collect());
        for (key, kind) in [("1234567", "Material"), ("7654321", "Object")] {
            let manifest = Manifest::of_names(["Sword"]).to_json();
            part.set_text(&format!("cryptomatte/{key}/name"), &format!("Crypto{kind}"));
            part.set_text(&format!("cryptomatte/{key}/manifest"), &manifest);
        }
        Plate::new(WINDOW, 1.0, vec![part])
    }

    #[test]
    fn what_covers_all_that_a_pixel_shows_is_all_of_it() {
        let (plate, settings) = (plate(), WarpSettings::default());
        let share = |matte: &Matte| coverage_of(&plate, matte, &settings).expect("a matte").samples;
        assert_eq!(share(&Matte::Cryptomatte { layer: None, names: vec!["Sword".into()] }), [1.0, 0.25]);
        let drawn = Coverage { frame: plate.frame_size(), window: WINDOW, samples: vec![0.25; 2] };
        assert_eq!(share(&Matte::Drawn(Arc::new(drawn))), [1.0, 0.25]);
    }

    #[test]
    fn names_are_looked_up_among_objects() {
        let of = |names: &[&str]| {
            let names: Vec<Vec<String>> = names.iter().map(|name| vec![(*name).to_owned()]).collect();
            mattes_of_names(&plate(), &names, &WarpSettings::default())
        };
        let sword = Matte::Cryptomatte { layer: Some("CryptoObject".into()), names: vec!["Sword".into()] };
        assert_eq!(of(&["Sword"]), Some(vec![sword]));
        assert_eq!(of(&["Sword", "Helmet"]), None, "all layers are known to it or none");
    }
}
