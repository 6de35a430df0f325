//! What a file's header says about its Cryptomattes.
//!
//! In: a name and a manifest, or attributes of a foreign header. Out: attributes, or [`MatteHeader`].

use super::Manifest;
use super::hash::murmur3_32;
use std::collections::BTreeMap;

/// One Cryptomatte of a header.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MatteHeader {
    /// Its name: `CryptoObject`; the channels begin with it.
    pub name: String,
    /// Names and ids; empty where the header has none, or a side file holds it, which `read_plate` takes in where it can.
    pub manifest: Manifest,
    /// A file with the manifest, beside the picture; empty manifests only.
    pub side_file: Option<String>,
}

/// Hash and conversion: the only ones there are.
const METHODS: [(&str, &str); 2] = [("hash", "MurmurHash3_32"), ("conversion", "uint32_to_float32")];

/// Attributes begin with this; OpenImageIO and Nuke put `exr/` in front of it.
const PREFIX: &str = "cryptomatte/";

impl MatteHeader {
    /// The key of a name: seven digits of its hash, the same for every frame and shot.
    ///
    /// ```
    /// use pinwarp::image::cryptomatte::MatteHeader;
    /// assert_eq!(MatteHeader::key_of("ViewLayer.CryptoMaterial"), "c7dbf5e");
    /// ```
    #[must_use]
    pub fn key_of(name: &str) -> String {
        format!("{:08x}", murmur3_32(name.as_bytes()))[..7].to_owned()
    }

    /// Names and texts of the attributes, in alphabetical order.
    #[must_use]
    pub fn attributes(&self) -> Vec<(String, String)> {
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

    /// The Cryptomattes that a header's text attributes tell of, by name. Those without a name are left out.
    #[must_use]
    pub fn from_attributes<'a>(attributes: impl IntoIterator<Item = (&'a str, &'a str)>) -> Vec<Self> {
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

    /// Keys of Blender's `cryptomatte_test.cc`, and of Arnold's files in Gaffer's tests.
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
