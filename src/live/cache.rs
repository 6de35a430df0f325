//! A process-wide cache of computed values, keyed by content, with LRU eviction.
//!
//! In: keys and functions. Out: shared values. Threads that request the same value compute it once; requests for
//! different values do not block each other. The latest value stays even if it weighs more than all may together, as
//! a map of an 8K frame does; crates that weigh values (quick_cache, moka) refuse to hold such a value.

use super::key::Key;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError, TryLockError};
use std::time::Duration;

/// Polling interval of a thread that waits for another's result.
const NAP: Duration = Duration::from_millis(1);

/// Values by key, up to a total weight.
pub(super) struct Cache<V> {
    budget: usize,
    weigh: fn(&V) -> usize,
    state: Mutex<State<V>>,
}

struct State<V> {
    slots: HashMap<Key, Slot<V>>,
    /// Use counter for LRU eviction.
    clock: u64,
}

struct Slot<V> {
    /// Locked while the value is being computed.
    value: SharedValue<V>,
    weight: usize,
    used: u64,
}

/// Guard of a value that is being computed: removes its slot on error or panic.
struct Pending<'a, V> {
    cache: &'a Cache<V>,
    key: Key,
    place: &'a SharedValue<V>,
}

impl<V> Drop for Pending<'_, V> {
    fn drop(&mut self) {
        let mut state = self.cache.locked();
        if state.slots.get(&self.key).is_some_and(|slot| Arc::ptr_eq(&slot.value, self.place)) {
            state.slots.remove(&self.key);
        }
    }
}

/// A slot for a value that is present or being computed.
type SharedValue<V> = Arc<Mutex<Option<Arc<V>>>>;

impl<V> Cache<V> {
    /// Creates a cache that holds values up to a total weight, and always the latest one.
    pub(super) fn new(budget: usize, weigh: fn(&V) -> usize) -> Self {
        Self { budget, weigh, state: Mutex::new(State { slots: HashMap::new(), clock: 0 }) }
    }

    /// Returns the value of a key, computing it if it is not cached. Errors are not cached.
    ///
    /// Rayon worker threads never wait for other threads, which could be waiting for them.
    pub(super) fn get<E>(&self, key: Key, compute: impl FnOnce() -> Result<V, E>) -> Result<Arc<V>, E> {
        self.get_until(key, &|| None, compute)
    }

    /// Like [`Self::get`]; a thread that waits for another's value regularly asks `stop` for a reason to give up.
    pub(super) fn get_until<E>(
        &self,
        key: Key,
        stop: &dyn Fn() -> Option<E>,
        compute: impl FnOnce() -> Result<V, E>,
    ) -> Result<Arc<V>, E> {
        let place = self.place(key);
        let guard = loop {
            match place.try_lock() {
                Ok(guard) => break Some(guard),
                Err(TryLockError::Poisoned(poisoned)) => break Some(poisoned.into_inner()),
                Err(TryLockError::WouldBlock) if rayon::current_thread_index().is_some() => break None,
                Err(TryLockError::WouldBlock) => {}
            }
            if let Some(reason) = stop() {
                return Err(reason);
            }
            std::thread::sleep(NAP);
        };
        let Some(mut guard) = guard else { return compute().map(Arc::new) };
        if let Some(value) = guard.as_ref() {
            return Ok(Arc::clone(value));
        }
        let pending = Pending { cache: self, key, place: &place };
        let value = Arc::new(compute()?);
        std::mem::forget(pending);
        *guard = Some(Arc::clone(&value));
        drop(guard);
        self.settle(key, (self.weigh)(&value));
        Ok(value)
    }

    /// Stores a value under another key, replacing any previous value.
    pub(super) fn put(&self, key: Key, value: Arc<V>) {
        let weight = (self.weigh)(&value);
        let place = Arc::new(Mutex::new(Some(value)));
        let mut state = self.locked();
        state.clock += 1;
        let used = state.clock;
        state.slots.insert(key, Slot { value: place, weight, used });
        drop(state);
        self.settle(key, weight);
    }

    /// Removes all values. Values that are still being computed will not be cached.
    #[cfg(any(test, feature = "ofx"))]
    pub(super) fn clear(&self) {
        self.locked().slots.clear();
    }

    /// Returns the value of a key if it is cached and ready.
    #[cfg(any(test, feature = "ofx"))]
    pub(super) fn peek(&self, key: Key) -> Option<Arc<V>> {
        let place = self.locked().slots.get(&key).map(|slot| Arc::clone(&slot.value))?;
        place.try_lock().ok()?.clone()
    }

    /// Number of cached values.
    #[cfg(test)]
    fn count(&self) -> usize {
        self.locked().slots.len()
    }

    fn locked(&self) -> std::sync::MutexGuard<'_, State<V>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn place(&self, key: Key) -> SharedValue<V> {
        let mut state = self.locked();
        state.clock += 1;
        let used = state.clock;
        let slot = state.slots.entry(key).or_insert_with(|| Slot { value: Arc::default(), weight: 0, used });
        slot.used = used;
        Arc::clone(&slot.value)
    }

    /// Sets the weight of a new value, and evicts the least recently used values until all fit.
    fn settle(&self, key: Key, weight: usize) {
        let mut state = self.locked();
        if let Some(slot) = state.slots.get_mut(&key) {
            slot.weight = weight;
        }
        let mut total: usize = state.slots.values().map(|slot| slot.weight).sum();
        while total > self.budget && state.slots.len() > 1 {
            let others = state.slots.iter().filter(|(other, _)| **other != key);
            let Some(oldest) = others.min_by_key(|(_, slot)| slot.used).map(|(key, _)| *key) else { return };
            total -= state.slots.remove(&oldest).map_or(0, |slot| slot.weight);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::key::KeyWriter;
    use super::*;
    use std::convert::Infallible;
    use std::sync::atomic::{AtomicUsize, Ordering};

    fn key(word: u64) -> Key {
        KeyWriter::new().word(word).finish()
    }

    #[test]
    fn threads_compute_a_value_once() {
        let (cache, count) = (Cache::new(8, |_| 1), AtomicUsize::new(0));
        let compute = || {
            std::thread::sleep(std::time::Duration::from_millis(20));
            Ok::<_, Infallible>(count.fetch_add(1, Ordering::Relaxed))
        };
        std::thread::scope(|scope| {
            (0..8).for_each(|_| _ = scope.spawn(|| assert_eq!(cache.get(key(1), compute).map(|value| *value), Ok(0))));
        });
        assert_eq!(count.into_inner(), 1);
    }

    #[test]
    fn what_was_not_used_for_longest_goes_first() {
        let cache = Cache::new(3, |weight: &usize| *weight);
        let get = |word, weight| cache.get(key(word), || Ok::<_, Infallible>(weight)).map(|value| *value);
        assert_eq!([get(1, 1), get(2, 1), get(3, 1)], [Ok(1), Ok(1), Ok(1)]);
        assert_eq!(get(1, 99), Ok(1), "kept");
        assert_eq!(get(4, 1), Ok(1));
        assert_eq!(get(2, 7), Ok(7), "2 was the oldest, and is computed anew");
        assert_eq!(cache.count(), 1, "it weighs more than all may, so it is alone");
    }

    #[test]
    fn failures_are_not_kept() {
        let cache = Cache::new(3, |_: &u32| 1);
        assert_eq!(cache.get(key(1), || Err("no")).unwrap_err(), "no");
        assert_eq!(cache.count(), 0);
        assert_eq!(cache.get(key(1), || Ok::<_, &str>(5)).map(|value| *value), Ok(5));
    }

    #[test]
    fn a_panic_leaves_nothing_behind() {
        let cache = Cache::new(3, |_: &u32| 1);
        let stumble = || cache.get(key(1), || -> Result<u32, &str> { panic!("on purpose") });
        assert!(std::panic::catch_unwind(std::panic::AssertUnwindSafe(stumble)).is_err());
        assert_eq!(cache.count(), 0);
        assert_eq!(cache.get(key(1), || Ok::<_, &str>(5)).map(|value| *value), Ok(5));
    }

    #[test]
    fn what_was_put_is_there_in_place_of_what_was() {
        let cache = Cache::new(2, |_: &u32| 1);
        assert_eq!(cache.peek(key(1)), None);
        (1..5).for_each(|value| cache.put(key(1), Arc::new(value)));
        assert_eq!((cache.peek(key(1)).as_deref(), cache.count()), (Some(&4), 1));
        [2, 3].into_iter().for_each(|word| cache.put(key(word), Arc::new(0)));
        assert_eq!(cache.peek(key(1)), None, "the oldest goes");
        cache.clear();
        assert_eq!((cache.peek(key(2)), cache.count()), (None, 0));
        assert_eq!(cache.get(key(2), || Ok::<_, &str>(6)).map(|value| *value), Ok(6), "and is computed anew");
    }
}
