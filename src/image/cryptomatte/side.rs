//! Loads manifests from sidecar files.
//!
//! In: a plate as read, and its path. Out: the plate with those manifests in its header, so that they are written with
//! it; failures are reported in [`Plate::left_out`].

use super::Manifest;
use crate::image::{Plate, PlatePart};
use std::path::Path;

/// Attribute suffix that names the sidecar file.
const SIDE_FILE: &str = "manif_file";

/// Loads all manifests of sidecar files into the header. Their paths are relative to the picture's.
pub(in crate::image) fn take_in_manifests(plate: &mut Plate, picture: &Path) {
    let faults: Vec<String> =
        plate.parts.iter_mut().flat_map(|part| take_into_part(part, picture)).filter_map(Result::err).collect();
    plate.left_out.extend(faults);
}

fn take_into_part(part: &mut PlatePart, picture: &Path) -> Vec<Result<(), String>> {
    let texts = part.texts("cryptomatte/");
    let side_files = texts.iter().filter_map(|(name, file)| Some((name.strip_suffix(SIDE_FILE)?, file)));
    let unnamed = side_files.filter(|(key, _)| !texts.contains_key(&format!("{key}manifest")));
    let take = |(key, file): (&str, &String)| {
        let manifest = read(&picture.parent().unwrap_or(Path::new("")).join(file))?;
        part.set_text(&format!("{key}manifest"), &manifest.to_json());
        part.remove_attributes(&format!("{key}{SIDE_FILE}"));
        Ok(())
    };
    unnamed.map(take).collect()
}

fn read(path: &Path) -> Result<Manifest, String> {
    let fault = |what: &str| {
        format!("the names of a Cryptomatte in {}: {what}; pick its mattes by whole names or ids", path.display())
    };
    let text = crate::files::read_text(path, crate::files::TABLE_BYTES).map_err(|error| fault(&error.to_string()))?;
    let manifest = Manifest::from_json(&text);
    if manifest.is_empty() { Err(fault("there are none")) } else { Ok(manifest) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::cryptomatte::MatteHeader;
    use crate::image::{Channel, Storage};
    use crate::space::PixelRect;

    /// A pixel whose only Cryptomatte has its manifest in a sidecar file.
    fn plate(side_file: &str) -> Plate {
        let window = PixelRect { x: 0, y: 0, width: 1, height: 1 };
        let channel = Channel { name: "A".into(), storage: Storage::Half, samples: vec![1.0] };
        let mut part = PlatePart::new(window, vec![channel]);
        let side_file = Some(side_file.to_owned());
        let header = MatteHeader { name: "CryptoObject".into(), manifest: Manifest::default(), side_file };
        header.attributes().iter().for_each(|(name, text)| part.set_text(name, text));
        Plate::new(window, 1.0, vec![part])
    }

    fn headers(plate: &Plate) -> Vec<MatteHeader> {
        let texts = plate.parts[0].texts("cryptomatte/");
        MatteHeader::from_attributes(texts.iter().map(|(name, text)| (name.as_str(), text.as_str())))
    }

    #[test]
    fn a_side_file_moves_into_the_header() {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("m.json"), r#"{"bunny": "13851a76"}"#).expect("written");
        let mut plate = plate("./m.json");
        assert_eq!(headers(&plate)[0].side_file.as_deref(), Some("./m.json"));
        take_in_manifests(&mut plate, &folder.path().join("a.exr"));
        assert_eq!(plate.left_out, Vec::<String>::new());
        let manifest = Manifest::of_names(["bunny"]);
        assert_eq!(headers(&plate), [MatteHeader { name: "CryptoObject".into(), manifest, side_file: None }]);
    }

    #[test]
    fn a_side_file_that_is_gone_or_damaged_is_told_and_nothing_changes() {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("empty.json"), "{").expect("written");
        for (file, why) in [("gone.json", "os error 2"), ("empty.json", "there are none")] {
            let mut plate = plate(file);
            take_in_manifests(&mut plate, &folder.path().join("a.exr"));
            assert_eq!(headers(&plate)[0].side_file.as_deref(), Some(file));
            let [told] = &plate.left_out[..] else { panic!("{:?}", plate.left_out) };
            assert!(told.contains(file) && told.contains(why), "{told}");
        }
    }
}
