//! Hashes names to the ids that are stored in pixels.
//!
//! In: a name. Out: [`MatteId`].

/// The id of a name: a hash whose bits are those of a normal 32-bit float, never 0, infinite, subnormal or NaN.
/// 0 marks the absence of objects. Two different names collide with a probability of about 1 in 4e9.
///
/// ```
/// use pinwarp::image::cryptomatte::MatteId;
/// assert_eq!(MatteId::of_name("hello").to_string(), "248bfa47");
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct MatteId(u32);

impl MatteId {
    /// No object.
    pub(crate) const NOTHING: Self = Self(0);

    /// Returns the id of a name. If all bits of the exponent are equal, its lowest is flipped (section "Floating point
    /// conversion"), so that no program mistakes the id for infinity or zero.
    #[must_use]
    pub fn of_name(name: &str) -> Self {
        let hash = murmur3_32(name.as_bytes());
        let exponent = (hash >> 23) & 0xff;
        Self(if matches!(exponent, 0 | 0xff) { hash ^ (1 << 23) } else { hash })
    }

    /// Returns the id of a sample from a rank's id channel; 0 and −0 mean no object.
    #[must_use]
    pub fn from_sample(sample: f32) -> Self {
        Self(if sample == 0.0 { 0 } else { sample.to_bits() })
    }

    /// Returns the sample that represents the id.
    #[must_use]
    pub(crate) const fn sample(self) -> f32 {
        f32::from_bits(self.0)
    }

    /// Parses eight hexadecimal digits, the format of ids in manifests; `None` for anything else.
    #[must_use]
    pub(crate) fn from_hex(digits: &str) -> Option<Self> {
        let is_hex = digits.len() == 8 && digits.bytes().all(|digit| digit.is_ascii_hexdigit());
        is_hex.then(|| u32::from_str_radix(digits, 16).ok().map(Self)).flatten()
    }
}

/// Eight hexadecimal digits, the format of ids in manifests.
impl std::fmt::Display for MatteId {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "{:08x}", self.0)
    }
}

/// MurmurHash3_x86_32 by Austin Appleby (public domain), seed 0: github.com/aappleby/smhasher.
pub(super) fn murmur3_32(bytes: &[u8]) -> u32 {
    let blocks = bytes.chunks_exact(4);
    let tail = blocks.remainder();
    let mut hash = blocks.fold(0_u32, |hash, block| {
        let word = block.iter().rev().fold(0, |word, &byte| (word << 8) | u32::from(byte));
        (hash ^ scrambled(word)).rotate_left(13).wrapping_mul(5).wrapping_add(0xe654_6b64)
    });
    hash ^= scrambled(tail.iter().rev().fold(0, |word, &byte| (word << 8) | u32::from(byte)));
    // The specification of the hash counts bytes modulo 2^32.
    hash ^= bytes.len() as u32;
    hash = (hash ^ (hash >> 16)).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ (hash >> 13)).wrapping_mul(0xc2b2_ae35);
    hash ^ (hash >> 16)
}

fn scrambled(word: u32) -> u32 {
    word.wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Published test vectors of the hash, with tails of zero to three bytes.
    #[test]
    fn the_hash_is_murmur_hash_3() {
        assert_eq!(murmur3_32(b""), 0);
        assert_eq!(murmur3_32(b"The quick brown fox jumps over the lazy dog"), 0x2e4f_f723);
        assert_eq!(murmur3_32(&[0xff; 4]), 0x7629_3b50);
        assert_eq!(murmur3_32(&[0x21, 0x43, 0x65, 0x87]), 0xf55b_516b);
        assert_eq!(murmur3_32(&[0x21, 0x43, 0x65]), 0x7e4a_8634);
        assert_eq!(murmur3_32(&[0x21, 0x43]), 0xa0f7_b07a);
        assert_eq!(murmur3_32(&[0x21]), 0x7266_1cf4);
        assert_eq!(murmur3_32(b"hello world"), 1_586_663_183);
    }

    /// Test values of `nuke/cryptomatte_utilities_tests.py` in github.com/Psyop/Cryptomatte.
    #[test]
    fn ids_are_those_of_the_reference_implementation() {
        for (name, sample) in [("hello", 6.070_563e-17_f32), ("равнина", -1.319_263_1e-25), ("mädchen", 6.236_13e25)]
        {
            assert_eq!(MatteId::of_name(name).sample(), sample, "{name}");
        }
    }

    /// Pairs from the specification's example, Psyop's `multilayer.exr` and Gaffer's tests.
    #[test]
    fn ids_are_those_of_other_renderers() {
        for (name, hex) in [
            ("bunny", "13851a76"),
            ("default", "42c9679f"),
            ("/obj/instance1:instances:0", "0d54c6cc"),
            ("/obj/box:polygons:1", "9d416418"),
            ("/GAFFERBOT/C_torso_GRP/C_head_GRP/C_head_CPT/C_head001_REN", "fbf2e1a5"),
        ] {
            assert_eq!(MatteId::of_name(name).to_string(), hex, "{name}");
            assert_eq!(MatteId::from_hex(hex), Some(MatteId::of_name(name)));
        }
    }

    #[test]
    fn no_id_is_a_number_that_programs_treat_specially() {
        // The empty name hashes to 0; among 4,000 names about 31 have an exponent of 0 or 255.
        let names = (0..4000).map(|index| if index == 0 { String::new() } else { format!("node{index}") });
        let mut moved = 0;
        for name in names {
            let id = MatteId::of_name(&name);
            assert!(id.sample().is_normal(), "{name}");
            moved += usize::from(id.0 != murmur3_32(name.as_bytes()));
        }
        assert!((10..80).contains(&moved), "{moved}");
    }

    #[test]
    fn only_eight_digits_are_an_id() {
        for wrong in ["", "248bfa4", "248bfa477", "248bfa4g", "+48bfa47"] {
            assert_eq!(MatteId::from_hex(wrong), None, "{wrong}");
        }
        assert_eq!(MatteId::from_sample(-0.0), MatteId::NOTHING);
    }
}
