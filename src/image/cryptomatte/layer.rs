//! Finds the channels of a file that are ranks of Cryptomattes.
//!
//! In: channel names of any program. Out: [`MatteLayer`]; the names that we write.

use std::collections::BTreeMap;

/// A Cryptomatte of a file with its rank channels. `K` identifies a channel: its index in a part, or part and index.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MatteLayer<K> {
    /// Name, as in the manifest: `CryptoObject`, `ViewLayer.CryptoObject`.
    pub name: String,
    /// Channels of the ranks, in rank order.
    pub ranks: Vec<RankChannels<K>>,
}

/// The two channels of a rank.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RankChannels<K> {
    /// Channel of ids.
    pub id: K,
    /// Channel of coverage, 0 to 1.
    pub coverage: K,
}

/// Suffixes of the four channels of a layer, in the order of their ranks.
const SUFFIXES: [[&str; 2]; 4] = [["r", "red"], ["g", "green"], ["b", "blue"], ["a", "alpha"]];

/// Finds the Cryptomattes among channels: `<name>NN.R`, also `.r` or `.red`.
///
/// A name counts if the headers of the file declare it (`known`) or it contains `crypto`; `diffuse00.R` of a renderer without Cryptomatte
/// thus stays colour. If a file has one part per layer with plain `R G B A` channels, prefix them with the part's name and a dot.
///
/// ```
/// use pinwarp::image::cryptomatte::matte_layers;
/// let names = ["R", "CryptoObject00.A", "CryptoObject00.B", "CryptoObject00.G", "CryptoObject00.R"];
/// let layers = matte_layers(names.into_iter().enumerate(), &[]);
/// assert_eq!((layers[0].name.as_str(), layers[0].ranks[1].coverage), ("CryptoObject", 1));
/// ```
#[must_use]
pub fn matte_layers<'a, K: Copy>(
    channels: impl IntoIterator<Item = (K, &'a str)>,
    known: &[String],
) -> Vec<MatteLayer<K>> {
    let mut layers: BTreeMap<&str, BTreeMap<u32, [Option<K>; 4]>> = BTreeMap::new();
    for (place, channel) in channels {
        let Some((name, number, suffix)) = rank_channel(channel) else { continue };
        if known.iter().any(|known| known == name) || name.to_ascii_lowercase().contains("crypto") {
            layers.entry(name).or_default().entry(number).or_default()[suffix] = Some(place);
        }
    }
    let layer = |(name, numbers): (&str, BTreeMap<u32, [Option<K>; 4]>)| {
        let ranks: Vec<_> = numbers.into_values().flat_map(pairs).collect();
        (!ranks.is_empty()).then(|| MatteLayer { name: name.to_owned(), ranks })
    };
    layers.into_iter().filter_map(layer).collect()
}

/// Returns the one or two complete ranks of an RGBA layer.
fn pairs<K: Copy>([r, g, b, a]: [Option<K>; 4]) -> impl Iterator<Item = RankChannels<K>> {
    [r.zip(g), b.zip(a)].into_iter().flatten().map(|(id, coverage)| RankChannels { id, coverage })
}

/// Splits a channel name into layer, number and suffix index: `a.CryptoObject01.G` becomes (`a.CryptoObject`, 1, 1). As
/// in Blender and Nuke, the layer name ends before all trailing digits.
fn rank_channel(channel: &str) -> Option<(&str, u32, usize)> {
    let (layer, suffix) = channel.rsplit_once('.')?;
    let suffix = SUFFIXES.iter().position(|names| names.iter().any(|name| suffix.eq_ignore_ascii_case(name)))?;
    let name = layer.trim_end_matches(|letter: char| letter.is_ascii_digit());
    let digits = &layer[name.len()..];
    if name.is_empty() || digits.len() < 2 {
        return None;
    }
    Some((name, digits.parse().ok()?, suffix))
}

/// Returns the channel names of a number of ranks, two for each: `CryptoObject00.R`, `.G`, `.B`, `.A`,
/// `CryptoObject01.R`. An odd count is rounded up to full RGBA layers.
#[must_use]
pub(crate) fn rank_channel_names(layer: &str, ranks: usize) -> Vec<String> {
    let numbers = 0..ranks.div_ceil(2);
    numbers.flat_map(|number| ["R", "G", "B", "A"].map(|suffix| format!("{layer}{number:02}.{suffix}"))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(channels: &[&str], known: &[&str]) -> Vec<(String, Vec<[usize; 2]>)> {
        let known: Vec<String> = known.iter().map(|&name| name.to_owned()).collect();
        let layers = matte_layers(channels.iter().copied().enumerate(), &known);
        let ranks = |layer: &MatteLayer<usize>| layer.ranks.iter().map(|rank| [rank.id, rank.coverage]).collect();
        layers.iter().map(|layer| (layer.name.clone(), ranks(layer))).collect()
    }

    #[test]
    fn suffixes_of_all_programs_are_understood() {
        for suffixes in [["R", "G", "B", "A"], ["r", "g", "b", "a"], ["red", "green", "blue", "alpha"]] {
            let names: Vec<String> =
                suffixes.iter().map(|suffix| format!("ViewLayer.CryptoObject00.{suffix}")).collect();
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            assert_eq!(found(&names, &[]), [("ViewLayer.CryptoObject".to_owned(), vec![[0, 1], [2, 3]])]);
        }
    }

    #[test]
    fn layers_come_in_the_order_of_their_numbers_whatever_the_order_of_channels() {
        let names =
            ["CryptoA01.R", "CryptoA00.R", "CryptoA01.G", "CryptoA00.G", "CryptoA10.G", "CryptoA10.R", "CryptoA10.B"];
        assert_eq!(
            found(&names, &[]),
            [("CryptoA".to_owned(), vec![[1, 3], [0, 2], [5, 4]])],
            "B without A is no rank"
        );
    }

    #[test]
    fn only_what_headers_know_or_names_say_is_a_cryptomatte() {
        let names =
            ["diffuse00.R", "diffuse00.G", "uCryptoAsset.R", "uCryptoAsset.G", "R", "G", "depth.Z", "00.R", "00.G"];
        assert_eq!(found(&names, &[]), []);
        assert_eq!(found(&names, &["diffuse"]), [("diffuse".to_owned(), vec![[0, 1]])]);
    }

    #[test]
    fn our_own_names_are_found_again() {
        let names = rank_channel_names("CryptoLayer", 6);
        assert_eq!((names.len(), names[5].as_str()), (12, "CryptoLayer01.G"));
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        assert_eq!(found(&names, &[])[0].1.len(), 6);
    }
}
