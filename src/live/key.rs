//! Content hashes: equal inputs have equal keys, different inputs almost certainly different ones.
//!
//! In: words and samples. Out: a 128-bit [`Key`].
//!
//! Four lanes of multiply and rotate, as in Y. Collet, "xxHash fast digest algorithm",
//! <https://github.com/Cyan4973/xxHash/blob/dev/doc/xxhash_spec.md>; the constants are its primes, the rest is our own.

use rayon::prelude::*;

const PRIMES: [u64; 3] = [0x9E37_79B1_85EB_CA87, 0xC2B2_AE3D_27D4_EB4F, 0x1656_67B1_9E37_79F9];

/// Samples per hashing task.
const CHUNK: usize = 1 << 16;

/// Number of parallel lanes.
const LANES: usize = 4;

/// The hash of some content.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Key([u64; 2]);

/// Incremental hasher.
#[derive(Clone, Debug)]
pub(super) struct KeyWriter([u64; 2]);

impl KeyWriter {
    pub(super) fn new() -> Self {
        Self([PRIMES[2], PRIMES[0]])
    }

    /// Continues from a key.
    pub(super) fn after(key: Key) -> Self {
        Self(key.0)
    }

    pub(super) fn word(&mut self, word: u64) -> &mut Self {
        let [a, b] = &mut self.0;
        *a = round(*a, word, 0);
        *b = round(*b, word ^ *a, 1);
        self
    }

    pub(super) fn words(&mut self, words: &[u64]) -> &mut Self {
        words.iter().for_each(|&word| _ = self.word(word));
        self
    }

    pub(super) fn float(&mut self, value: f64) -> &mut Self {
        // -0 and 0 are equal.
        self.word((value + 0.0).to_bits())
    }

    /// `None` and `Some(0)` have different hashes.
    pub(super) fn option(&mut self, value: Option<f64>) -> &mut Self {
        self.word(value.is_some().into()).float(value.unwrap_or(0.0))
    }

    pub(super) fn text(&mut self, text: &str) -> &mut Self {
        self.word(text.len() as u64);
        let (words, rest) = text.as_bytes().as_chunks::<8>();
        words.iter().for_each(|word| _ = self.word(u64::from_le_bytes(*word)));
        self.word(rest.iter().fold(0, |word, &byte| word << 8 | u64::from(byte)))
    }

    /// Hashes samples in parallel; the result does not depend on the number of threads.
    pub(super) fn samples(&mut self, samples: &[f32]) -> &mut Self {
        let chunks: Vec<[u64; 2]> = samples.par_chunks(CHUNK).map(digest).collect();
        chunks.iter().for_each(|chunk| _ = self.words(chunk));
        self.word(samples.len() as u64)
    }

    pub(super) fn finish(&self) -> Key {
        let [a, b] = self.0;
        Key([avalanche(a), avalanche(b ^ a.rotate_left(32))])
    }
}

fn round(lane: u64, word: u64, prime: usize) -> u64 {
    lane.wrapping_add(word.wrapping_mul(PRIMES[prime])).rotate_left(31).wrapping_mul(PRIMES[prime + 1])
}

/// Makes every output bit depend on every input bit.
fn avalanche(mut word: u64) -> u64 {
    for prime in [PRIMES[1], PRIMES[2]] {
        word = (word ^ word >> 31).wrapping_mul(prime);
    }
    word ^ word >> 32
}

/// Hashes a chunk of samples to two words.
fn digest(samples: &[f32]) -> [u64; 2] {
    let mut lanes: [u64; LANES] = std::array::from_fn(|lane| PRIMES[lane % 3].wrapping_add(lane as u64));
    let (packs, rest) = samples.as_chunks::<{ 2 * LANES }>();
    for pack in packs {
        for (lane, pair) in lanes.iter_mut().zip(pack.as_chunks::<2>().0) {
            *lane = round(*lane, u64::from(pair[0].to_bits()) << 32 | u64::from(pair[1].to_bits()), 0);
        }
    }
    let mut end = KeyWriter::new();
    end.words(&lanes);
    rest.iter().for_each(|sample| _ = end.word(sample.to_bits().into()));
    end.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(samples: &[f32]) -> Key {
        KeyWriter::new().samples(samples).finish()
    }

    #[test]
    fn every_sample_counts_wherever_it_stands() {
        let mut samples: Vec<f32> = (0..CHUNK + 77).map(|k| k as f32).collect();
        let whole = key(&samples);
        assert_eq!(whole, key(&samples.clone()));
        for at in [0, 1, 7, 8, CHUNK - 1, CHUNK, CHUNK + 76] {
            samples[at] += 0.5;
            assert_ne!(whole, key(&samples), "sample {at}");
            samples[at] -= 0.5;
        }
        samples.swap(3, 11);
        assert_ne!(whole, key(&samples), "two samples changed places");
    }

    #[test]
    fn nothing_is_not_zero() {
        let of = |value| KeyWriter::new().option(value).finish();
        assert_ne!(of(None), of(Some(0.0)));
        assert_eq!(of(Some(-0.0)), of(Some(0.0)));
    }

    #[test]
    fn texts_do_not_run_into_each_other() {
        let of = |a: &str, b: &str| KeyWriter::new().text(a).text(b).finish();
        assert_ne!(of("camera", ""), of("", "camera"));
        assert_ne!(of("ab", "c"), of("a", "bc"));
    }
}
