//! Shared by benches: a stopwatch.

use std::hint::black_box;
use std::sync::Once;
use std::time::Instant;

/// Raises glibc's threshold for returning memory to the system by freeing a large block once. Below it the memory of each
/// run would be returned and faulted in again page by page, which takes as long as a solve. Programs that read pictures have
/// freed such blocks.
static KEEP_MEMORY: Once = Once::new();

/// Time of the fastest run in milliseconds (other load only adds to it), and the result of the last run.
pub(crate) fn fastest<T>(mut run: impl FnMut() -> T) -> (f64, T) {
    KEEP_MEMORY.call_once(|| drop(black_box(vec![1_u8; 24 << 20])));
    let mut last = run();
    let mut times = Vec::new();
    let begin = Instant::now();
    while times.len() < 5 || (begin.elapsed().as_secs_f64() < 0.5 && times.len() < 400) {
        let start = Instant::now();
        last = black_box(run());
        times.push(start.elapsed().as_secs_f64() * 1e3);
    }
    (times.into_iter().fold(f64::INFINITY, f64::min), last)
}
