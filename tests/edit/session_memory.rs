//! The memory of a long session stays flat.

use super::endurance::{Endurance, resident_bytes};
use std::process::Command;
use std::time::{Duration, Instant};

/// Names the seconds of [`a_long_session`]. An hour: `PINWARP_SOAK_SECS=3600 cargo test --release --lib -- --ignored
/// a_long_session --nocapture`.
const SECS: &str = "PINWARP_SOAK_SECS";

/// Number of times that the memory is looked at in a session, about.
const REPORTS: u64 = 60;

/// Number of edits that a session makes on the slowest machine.
const LEAST_EDITS: usize = 200;

/// A session of its own length, in a process of its own: other tests would blur its memory.
#[test]
#[ignore = "needs a process of its own, in which memory_stays_flat starts it"]
fn a_long_session() {
    let secs = std::env::var(SECS).ok().and_then(|secs| secs.parse().ok()).unwrap_or(10);
    let mut endurance = Endurance::begin();
    let begun = Instant::now();
    // About twenty edits a second.
    let between = (20 * secs / REPORTS) as usize;
    let growth = endurance.run(between, |edits| edits < LEAST_EDITS || begun.elapsed() < Duration::from_secs(secs));
    let Some(slope) = growth.slope() else {
        return assert!(resident_bytes().is_none(), "too few edits to tell");
    };
    println!("slope after the warm-up: {slope:.0} bytes per edit, {:.0} allowed", growth.bound());
    assert!(slope < growth.bound(), "the memory grows by {slope:.0} bytes per edit");
}

#[test]
fn memory_stays_flat() {
    let mut program = Command::new(std::env::current_exe().expect("this program"));
    // One heap that returns what is free: the figures then tell what is in use.
    program.envs([("MALLOC_ARENA_MAX", "1"), ("MALLOC_TRIM_THRESHOLD_", "65536"), (SECS, "10")]);
    let output = program
        .args(["--exact", "internal::edit::session_memory::a_long_session", "--ignored", "--nocapture"])
        .output();
    let output = output.expect("it runs");
    let told = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{told}{}", String::from_utf8_lossy(&output.stderr));
    assert!(told.contains("1 passed"), "it ran: {told}");
    println!("{told}");
}
