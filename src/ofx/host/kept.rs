//! Data stored per handle of the host, bounded so that a host that never destroys its handles cannot make it grow.
//!
//! In: handles as numbers. Out: values; the oldest are dropped beyond the limit.

use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Maximum number of values.
const MAX_VALUES: usize = 1024;

/// Values by handle, oldest first.
pub(in crate::ofx) struct Kept<T>(Mutex<VecDeque<(usize, T)>>);

impl<T> Kept<T> {
    /// Creates an empty store.
    pub(in crate::ofx) const fn new() -> Self {
        Self(Mutex::new(VecDeque::new()))
    }

    fn locked(&self) -> MutexGuard<'_, VecDeque<(usize, T)>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Stores a value; returns the previous one.
    pub(in crate::ofx) fn insert(&self, handle: usize, value: T) -> Option<T> {
        let before = self.remove(handle);
        let mut values = self.locked();
        values.push_back((handle, value));
        if values.len() > MAX_VALUES {
            values.pop_front();
        }
        before
    }

    /// Removes and returns a value.
    pub(in crate::ofx) fn remove(&self, handle: usize) -> Option<T> {
        let mut values = self.locked();
        let place = values.iter().position(|(other, _)| *other == handle)?;
        values.remove(place).map(|(_, value)| value)
    }

    /// Returns a copy of a value.
    pub(in crate::ofx) fn get(&self, handle: usize) -> Option<T>
    where
        T: Clone,
    {
        self.locked().iter().find(|(other, _)| *other == handle).map(|(_, value)| value.clone())
    }

    /// Modifies a value under the lock, inserting the default if there is none.
    pub(in crate::ofx) fn update<R>(&self, handle: usize, change: impl FnOnce(&mut T) -> R) -> R
    where
        T: Default,
    {
        let mut values = self.locked();
        let place = values.iter().position(|(other, _)| *other == handle);
        let mut value = place.and_then(|place| values.remove(place)).map(|(_, value)| value).unwrap_or_default();
        let result = change(&mut value);
        values.push_back((handle, value));
        if values.len() > MAX_VALUES {
            values.pop_front();
        }
        result
    }

    /// Drops all values except those that `is_wanted` accepts.
    pub(in crate::ofx) fn retain(&self, is_wanted: impl Fn(&T) -> bool) {
        self.locked().retain(|(_, value)| is_wanted(value));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_oldest_goes_where_a_host_never_ends_anything() {
        let kept = Kept::new();
        (0..2 * MAX_VALUES).for_each(|handle| assert_eq!(kept.insert(handle, handle), None));
        assert_eq!(kept.locked().len(), MAX_VALUES);
        assert_eq!([kept.get(MAX_VALUES - 1), kept.get(MAX_VALUES)], [None, Some(MAX_VALUES)]);
        assert_eq!(
            [kept.insert(MAX_VALUES, 7), kept.remove(MAX_VALUES), kept.remove(MAX_VALUES)],
            [Some(MAX_VALUES), Some(7), None]
        );
        kept.retain(|value| value % 2 == 0);
        assert_eq!([kept.get(MAX_VALUES + 1), kept.get(MAX_VALUES + 2)], [None, Some(MAX_VALUES + 2)]);
    }
}
