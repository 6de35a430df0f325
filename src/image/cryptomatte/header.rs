//! Header attributes of Cryptomattes.
//!
//! In: a name and a manifest, or the attributes of a file from another program. Out: attributes, or [`MatteHeader`].

use super::Manifest;
use super::hash::murmur3_32;
use std::collections::BTreeMap;

/// The header entry of one Cryptomatte.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MatteHeader {
    /// Name: `CryptoObject`; a prefix of the channel names.
    pub name: String,
    /// Names and ids. Empty if the header has none or refers to a side file, which `read_plate` loads if possible.
    pub manifest: Manifest,
    /// A sidecar file with the manifest; only used if the manifest is empty.
    pub side_file: Option<String>,
}

/// Hash and conversion: the only methods that exist.
const METHODS: [(&str, &str); 2] = [("hash", "MurmurHash3_32"), ("conversion", "uint32_to_float32")];

/// Prefix of attribute names; OpenImageIO and Nuke add `exr/` before it.
const PREFIX: &str = "cryptomatte/";

impl MatteHeader {
    /// Returns the key of a name: seven digits of its hash, the same for every frame and shot.
    #[must_use]
    pub(crate) fn key_of(name: &str) -> String {
        format!("{:08x}", murmur3_32(name.as_bytes()))[..7].to_owned()
    }

    /// Returns names and values of the attributes, in alphabetical order.
    #[must_use]
    pub(crate) fn attributes(&self) -> Vec<(String, String)> {
        let source = match &self.side_file {
            Some(file) => ("manif_file", file.clone()),
            None => ("manifest", self.manifest.to_json()),
        };
        let methods = METHODS.map(|(field, text)| (field, text.to_owned()));
        let fields = methods.into_iter().chain([("name", self.name.clone()), source]);
        let key = Self::key_of(&self.name);
        let mut attributes: Vec<_> = fields.map(|(field, text)| (format!("{PREFIX}{key}/{field}"), text)).collect();
        attributes.sort();
        attributes
    }

    /// Parses the Cryptomattes in a header's text attributes, sorted by name. Those without a name are skipped.
    #[must_use]
    pub(crate) fn from_attributes<'a>(attributes: impl IntoIterator<Item = (&'a str, &'a str)>) -> Vec<Self> {
        let mut by_key: BTreeMap<&str, Self> = BTreeMap::new();
        for (attribute, text) in attributes {
            let rest = attribute.strip_prefix("exr/").unwrap_or(attribute).strip_prefix(PREFIX);
            let Some((key, field)) = rest.and_then(|rest| rest.split_once('/')) else { continue };
            let header = by_key.entry(key).or_default();
            match field {
                "name" => header.name = text.to_owned(),
                "manifest" => header.manifest = Manifest::from_json(text),
                "manif_file" => header.side_file = Some(text.to_owned()),
                _ => {}
            }
        }
        let mut headers: Vec<_> = by_key.into_values().filter(|header| !header.name.is_empty()).collect();
        headers.sort_by(|a, b| a.name.cmp(&b.name));
        headers
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(name: &str) -> MatteHeader {
        MatteHeader { name: name.into(), manifest: Manifest::of_names(["bunny", "default"]), side_file: None }
    }

    /// Keys from Blender's `cryptomatte_test.cc`, and from Arnold's files in Gaffer's tests.
    #[test]
    fn keys_are_those_of_other_programs() {
        for (name, key) in [
            ("ViewLayer.CryptoMaterial", "c7dbf5e"),
            ("𝖚𝖓𝖎𝖈𝖔𝖉𝖊.CryptoMaterial", "b990b65"),
            ("viewlayername.layer1", "87f095e"),
            ("viewlayername.layer2", "c42daa7"),
            ("crypto_object", "f834d0a"),
        ] {
            assert_eq!(MatteHeader::key_of(name), key, "{name}");
        }
    }

    #[test]
    fn attributes_are_those_of_the_specification() {
        let texts: Vec<String> =
            header("CryptoObject").attributes().iter().map(|(name, text)| format!("{name} = {text}")).collect();
        assert_eq!(
            texts,
            [
                "cryptomatte/3ae39a5/conversion = uint32_to_float32",
                "cryptomatte/3ae39a5/hash = MurmurHash3_32",
                r#"cryptomatte/3ae39a5/manifest = {"bunny":"13851a76","default":"42c9679f"}"#,
                "cryptomatte/3ae39a5/name = CryptoObject",
            ]
        );
    }

    #[test]
    fn headers_come_back_from_their_attributes_with_and_without_exr_in_front() {
        let headers = [header("CryptoMaterial"), header("CryptoObject")];
        let attributes: Vec<_> = headers.iter().flat_map(MatteHeader::attributes).collect();
        let prefixed: Vec<_> = attributes.iter().map(|(name, text)| (format!("exr/{name}"), text.clone())).collect();
        for attributes in [attributes, prefixed] {
            let texts = attributes.iter().map(|(name, text)| (name.as_str(), text.as_str()));
            assert_eq!(MatteHeader::from_attributes(texts), headers);
        }
        let broken = [("cryptomatte/name", "x"), ("cryptomatte/", "y"), ("cryptomatte/abc/manifest", "{}")];
        assert_eq!(MatteHeader::from_attributes(broken), []);
    }

    #[test]
    fn a_side_file_is_named_instead_of_the_names() {
        let side_file = Some("./m.json".to_owned());
        let header = MatteHeader { manifest: Manifest::default(), side_file, ..header("CryptoObject") };
        assert!(header.attributes().contains(&("cryptomatte/3ae39a5/manif_file".into(), "./m.json".into())));
        assert!(header.attributes().iter().all(|(name, _)| !name.ends_with("/manifest")));
    }
}
