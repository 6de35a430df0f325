//! The memory budget: what decoded pictures, scenes and frames may take together.
//!
//! In: a limit, the bytes that a step will hold at once. Out: leave to take them, or [`OverBudget`], before anything is decoded.
//! Systems grant memory that they do not have and then end the whole program, so asking the allocator is no answer.

use std::fmt;
use std::str::FromStr;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Condvar, LazyLock, Mutex, PoisonError};
use std::time::Duration;

/// Share of the system's memory that is used unless a limit is set, in percent.
const DEFAULT_PERCENT: f64 = 75.0;

/// How long a thread that waits for memory sleeps before it asks whether that is still wanted.
const NAP: Duration = Duration::from_millis(10);

/// The limit in bytes; 0: not set.
static LIMIT: AtomicU64 = AtomicU64::new(0);
/// What the default share comes to.
static DEFAULT: LazyLock<u64> = LazyLock::new(|| MemoryLimit::Percent(DEFAULT_PERCENT).bytes());
/// Bytes of all [`Reservation`]s.
static RESERVED: Mutex<u64> = Mutex::new(0);
/// Told when a reservation ends.
static RELEASED: Condvar = Condvar::new();

/// A limit as users write it: `8G`, `512M`, `50%`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MemoryLimit {
    /// Bytes.
    Bytes(u64),
    /// Percent of the memory that the system has, or that its container may use.
    Percent(f64),
}

/// Something that needs more memory than there may be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OverBudget {
    /// Bytes that are needed.
    pub needed: u128,
    /// Bytes that may be used.
    pub limit: u64,
}

/// Bytes that are in use until this is dropped.
#[derive(Debug)]
pub struct Reservation {
    bytes: u64,
}

/// Sets the limit of this process. It counts from the next picture on.
pub fn set_limit(limit: MemoryLimit) {
    LIMIT.store(limit.bytes().max(1), Ordering::Relaxed);
}

/// The limit of this process, bytes: what was set, else three quarters of what the system has.
#[must_use]
pub fn limit() -> u64 {
    match LIMIT.load(Ordering::Relaxed) {
        0 => *DEFAULT,
        limit => limit,
    }
}

/// Whether so many bytes may be held at once.
///
/// # Errors
/// [`OverBudget`] where they are more than the limit.
pub fn check(bytes: u128) -> Result<(), OverBudget> {
    let limit = limit();
    if bytes <= u128::from(limit) { Ok(()) } else { Err(OverBudget { needed: bytes, limit }) }
}

/// Reserves bytes, and waits until other reservations leave room for them. A thread holds one reservation at a time.
///
/// # Errors
/// [`OverBudget`] where they are more than the limit, however long one waits.
pub fn reserve(bytes: u128) -> Result<Reservation, OverBudget> {
    Ok(reserve_until(bytes, &|| false)?.expect("nothing gives it up"))
}

/// As [`reserve`]; while it waits, `stop` is asked every few milliseconds whether the bytes are still wanted, by the thread
/// that called. `None`: they are not.
///
/// # Errors
/// As [`reserve`].
pub fn reserve_until(bytes: u128, stop: &dyn Fn() -> bool) -> Result<Option<Reservation>, OverBudget> {
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
    /// In bytes, of this system; no limit where its memory is not known.
    #[must_use]
    pub fn bytes(self) -> u64 {
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

/// Memory of this system in bytes, or what its container may use of it.
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
        // More than half of the budget twice, one after the other: the second waits for the first.
        let most = u128::from(limit() / 2 + 1);
        let first = reserve(most).expect("it fits");
        let second = std::thread::spawn(move || reserve(most).map(drop));
        drop(first);
        second.join().expect("no panic").expect("it fits when the first has ended");
        // And one that is no longer wanted does not wait for ever.
        let _first = reserve(most).expect("it fits");
        let asked = std::cell::Cell::new(0);
        let stop = || asked.replace(asked.get() + 1) == 2;
        assert!(reserve_until(most, &stop).expect("it would fit").is_none());
        assert_eq!(asked.get(), 3);
    }
}
