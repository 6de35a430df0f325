//! Memory budget of the process: the bytes that decoded pictures, scenes and frames may occupy together.
//!
//! In: a limit, and the bytes that a step will hold at once. Out: a `Reservation`, or [`OverBudget`] before anything
//! is decoded. Allocation failures cannot be used instead, because operating systems overcommit memory and then kill
//! the process.

use std::fmt;
use std::str::FromStr;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Condvar, LazyLock, Mutex, PoisonError};
use std::time::Duration;

/// Default limit, in percent of the system's memory.
const DEFAULT_PERCENT: f64 = 75.0;

/// Time that a thread waiting for memory sleeps before it polls for cancellation.
const NAP: Duration = Duration::from_millis(10);

/// The limit in bytes; 0 if not set.
static LIMIT: AtomicU64 = AtomicU64::new(0);
/// The default limit in bytes.
static DEFAULT: LazyLock<u64> = LazyLock::new(|| MemoryLimit::Percent(DEFAULT_PERCENT).bytes());
/// Sum of all [`Reservation`]s, bytes.
static RESERVED: Mutex<u64> = Mutex::new(0);
/// Notified when a reservation is dropped.
static RELEASED: Condvar = Condvar::new();

/// A memory limit as written by users: `8G`, `512M`, `50%`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum MemoryLimit {
    /// An absolute limit in bytes.
    Bytes(u64),
    /// Percent of the memory of the system, or of the part that its container may use.
    Percent(f64),
}

/// The error for a step that needs more memory than the limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OverBudget {
    /// Bytes needed.
    pub needed: u128,
    /// Bytes allowed.
    pub limit: u64,
}

/// Bytes that count as in use until this value is dropped.
#[derive(Debug)]
pub(crate) struct Reservation {
    bytes: u64,
}

/// Sets the limit of this process, which applies from the next check or reservation on.
#[cfg(any(test, feature = "cli", feature = "ofx"))]
pub(crate) fn set_limit(limit: MemoryLimit) {
    LIMIT.store(limit.bytes().max(1), Ordering::Relaxed);
}

/// Returns the limit of this process in bytes: the one set, or else three quarters of the system's memory.
#[must_use]
pub(crate) fn limit() -> u64 {
    match LIMIT.load(Ordering::Relaxed) {
        0 => *DEFAULT,
        limit => limit,
    }
}

/// Checks that the given number of bytes may be held at once.
///
/// # Errors
/// Returns [`OverBudget`] if it exceeds the limit.
pub(crate) fn check(bytes: u128) -> Result<(), OverBudget> {
    let limit = limit();
    if bytes <= u128::from(limit) { Ok(()) } else { Err(OverBudget { needed: bytes, limit }) }
}

/// Reserves bytes, waiting until other reservations leave enough room. A thread must hold at most one reservation at a time.
///
/// # Errors
/// Returns [`OverBudget`] if the bytes exceed the limit, so that no wait could help.
pub(crate) fn reserve(bytes: u128) -> Result<Reservation, OverBudget> {
    Ok(reserve_until(bytes, &|| false)?.expect("nothing gives it up"))
}

/// Reserves bytes as [`reserve`] does, and returns `None` if `stop` returns true while it waits. The calling thread
/// polls `stop` every few milliseconds.
///
/// # Errors
/// As [`reserve`].
pub(crate) fn reserve_until(bytes: u128, stop: &dyn Fn() -> bool) -> Result<Option<Reservation>, OverBudget> {
    check(bytes)?;
    let bytes = bytes as u64;
    loop {
        let mut reserved = RESERVED.lock().unwrap_or_else(PoisonError::into_inner);
        if *reserved == 0 || reserved.saturating_add(bytes) <= limit() {
            *reserved += bytes;
            return Ok(Some(Reservation { bytes }));
        }
        drop(RELEASED.wait_timeout(reserved, NAP));
        if stop() {
            return Ok(None);
        }
    }
}

impl Drop for Reservation {
    fn drop(&mut self) {
        *RESERVED.lock().unwrap_or_else(PoisonError::into_inner) -= self.bytes;
        RELEASED.notify_all();
    }
}

impl MemoryLimit {
    /// Converts the limit to bytes on this system; `u64::MAX` for a percentage if the system's memory is unknown.
    #[must_use]
    pub(crate) fn bytes(self) -> u64 {
        match self {
            Self::Bytes(bytes) => bytes,
            Self::Percent(percent) => system_bytes().map_or(u64::MAX, |all| (all as f64 * percent / 100.0) as u64),
        }
    }
}

impl FromStr for MemoryLimit {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "write bytes with a unit or a share of the memory: 8G, 512M, 50%".to_owned();
        let text = text.trim();
        let split = text.find(|letter: char| !(letter.is_ascii_digit() || letter == '.')).unwrap_or(text.len());
        let number: f64 = text[..split].parse().map_err(|_| wrong())?;
        let unit = text[split..].trim().to_ascii_uppercase();
        let scale = match unit.trim_end_matches("IB").trim_end_matches('B') {
            "%" if number > 0.0 && number <= 100.0 => return Ok(Self::Percent(number)),
            "" if number >= 1.0 => 1.0,
            "K" => 1024.0,
            "M" => 1024.0 * 1024.0,
            "G" => 1024.0 * 1024.0 * 1024.0,
            "T" => 1024.0 * 1024.0 * 1024.0 * 1024.0,
            _ => return Err(wrong()),
        };
        let bytes = number * scale;
        if bytes >= 1.0 { Ok(Self::Bytes(bytes as u64)) } else { Err(wrong()) }
    }
}

impl fmt::Display for OverBudget {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let megabytes = |bytes: u128| bytes.div_ceil(1 << 20);
        let (needed, limit) = (megabytes(self.needed), megabytes(self.limit.into()));
        write!(
            f,
            "needs about {needed} MB of memory, {limit} MB may be used; raise --max-memory (in plugins PINWARP_MAX_MEMORY) or \
             use smaller pictures (in plugins a proxy)"
        )
    }
}

impl std::error::Error for OverBudget {}

/// Returns the memory of this system in bytes, or the limit of its container if that is lower.
fn system_bytes() -> Option<u64> {
    let read = |path: &str| std::fs::read_to_string(path).ok();
    let total = read("/proc/meminfo").and_then(|text| total_of_meminfo(&text));
    let groups = ["/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"];
    let limits = groups.iter().filter_map(|path| read(path)?.trim().parse().ok());
    total.into_iter().chain(limits).min()
}

fn total_of_meminfo(text: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kilobytes * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_read_as_users_write_them() {
        let bytes = |bytes: u64| Ok(MemoryLimit::Bytes(bytes));
        assert_eq!("8G".parse(), bytes(8 << 30));
        assert_eq!(" 1.5 GiB ".parse(), bytes(3 << 29));
        assert_eq!("512mb".parse(), bytes(512 << 20));
        assert_eq!("4096".parse(), bytes(4096));
        assert_eq!("50%".parse(), Ok(MemoryLimit::Percent(50.0)));
        for wrong in ["", "G", "-1G", "0", "0%", "101%", "1.2.3G", "8X", "half", "NaN"] {
            assert!(wrong.parse::<MemoryLimit>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn the_memory_of_the_system_is_found() {
        assert_eq!(total_of_meminfo("MemFree: 1 kB\nMemTotal:       24000 kB\n"), Some(24_576_000));
        assert_eq!(total_of_meminfo("MemTotal: lots"), None);
        assert!(MemoryLimit::Percent(50.0).bytes() <= MemoryLimit::Percent(100.0).bytes());
    }

    #[test]
    fn what_is_too_large_is_refused_and_what_fits_is_given_back() {
        assert!(matches!(check(u128::MAX), Err(OverBudget { needed: u128::MAX, .. })));
        // Two reservations of more than half the budget each: the second waits for the first.
        let most = u128::from(limit() / 2 + 1);
        let first = reserve(most).expect("it fits");
        let second = std::thread::spawn(move || reserve(most).map(drop));
        drop(first);
        second.join().expect("no panic").expect("it fits when the first has ended");
        // A reservation that is cancelled stops waiting.
        let _first = reserve(most).expect("it fits");
        let asked = std::cell::Cell::new(0);
        let stop = || asked.replace(asked.get() + 1) == 2;
        assert!(reserve_until(most, &stop).expect("it would fit").is_none());
        assert_eq!(asked.get(), 3);
    }
}
