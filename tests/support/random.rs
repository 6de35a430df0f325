//! Random cases that can be repeated.
//!
//! A failing test prints its seed with its other output; `PROPTEST_RNG_SEED=<seed>` runs the same cases again.

use proptest::test_runner::{Config, RngSeed};

/// So many cases of a seed of their own, which is printed.
pub(crate) fn config(cases: u32) -> Config {
    let config = Config { cases, failure_persistence: None, ..Config::default() };
    let seed = match config.rng_seed {
        RngSeed::Fixed(seed) => seed,
        RngSeed::Random => std::hash::BuildHasher::hash_one(&std::collections::hash_map::RandomState::new(), cases),
    };
    eprintln!("random cases: repeat them with PROPTEST_RNG_SEED={seed}");
    Config { rng_seed: RngSeed::Fixed(seed), ..config }
}
