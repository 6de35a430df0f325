//! Distances, and random numbers that are the same everywhere from the same seed.

/// Distance of two points.
pub(crate) fn distance<const D: usize>(a: [f64; D], b: [f64; D]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a - b).fold(0.0, f64::hypot)
}

/// A source of random numbers.
pub(crate) trait Random {
    /// From 0 to 1.
    fn unit(&mut self) -> f64;

    /// Between two numbers.
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Between -`most` and `most`.
    fn within(&mut self, most: f64) -> f64 {
        (2.0 * self.unit() - 1.0) * most
    }

    /// A whole number below a limit.
    fn below(&mut self, limit: usize) -> usize {
        (self.unit() * limit as f64) as usize
    }
}

/// G. Steele et al., "Fast Splittable Pseudorandom Number Generators", 2014.
pub(crate) struct SplitMix(pub(crate) u64);

impl Random for SplitMix {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        unit_of(z ^ (z >> 31))
    }
}

/// D. Knuth's linear congruential generator modulo 2^64, which the seeds of some tests belong to.
pub(crate) struct Congruential(pub(crate) u64);

impl Random for Congruential {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        unit_of(self.0)
    }
}

/// The upper 53 bits as a number from 0 to 1.
fn unit_of(word: u64) -> f64 {
    (word >> 11) as f64 / (1_u64 << 53) as f64
}
