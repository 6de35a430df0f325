//! Content hashes: equal inputs have equal keys, different inputs almost certainly different ones.
//!
//! In: words and samples. Out: a 128-bit [`Key`].

use rayon::prelude::*;
use twox_hash::XxHash3_128;

/// Samples per hashing task.
const CHUNK: usize = 1 << 16;

/// The hash of some content.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Key(u128);

/// Collects content.
#[derive(Clone, Debug)]
pub(super) struct KeyWriter(Vec<u8>);

impl KeyWriter {
    pub(super) const fn new() -> Self {
        Self(Vec::new())
    }

    /// Continues from a key.
    pub(super) fn after(key: Key) -> Self {
        Self(key.0.to_le_bytes().to_vec())
    }

    pub(super) fn word(&mut self, word: u64) -> &mut Self {
        self.0.extend(word.to_le_bytes());
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
        self.0.extend(text.as_bytes());
        self
    }

    /// Hashes samples in parallel; the result does not depend on the number of threads.
    pub(super) fn samples(&mut self, samples: &[f32]) -> &mut Self {
        let chunks = samples.par_chunks(CHUNK).map(|chunk| XxHash3_128::oneshot(bytemuck::cast_slice(chunk)));
        let chunks: Vec<u128> = chunks.collect();
        self.0.extend(chunks.iter().flat_map(|hash| hash.to_le_bytes()));
        self.word(samples.len() as u64)
    }

    pub(super) fn finish(&self) -> Key {
        Key(XxHash3_128::oneshot(&self.0))
    }
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
