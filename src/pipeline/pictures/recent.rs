//! The values made last, kept for those who ask for them again.
//!
//! In: keys, and how to make the value of each. Out: shared values.

use std::collections::VecDeque;
#[cfg(any(test, feature = "editor"))]
use std::convert::Infallible;
use std::sync::{Arc, Mutex, PoisonError};

/// Number of values that are kept: the sizes between which drafts of a frame change.
#[cfg(any(test, feature = "editor"))]
const KEPT: usize = 3;

/// The values made last, by their keys, newest first.
#[derive(Debug)]
pub(super) struct Recent<K, V>(Mutex<VecDeque<(K, Arc<V>)>>);

impl<K, V> Default for Recent<K, V> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<K: Clone, V> Clone for Recent<K, V> {
    fn clone(&self) -> Self {
        Self(Mutex::new(self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()))
    }
}

#[cfg(any(test, feature = "editor"))]
impl<K: PartialEq, V> Recent<K, V> {
    /// Returns the value of a key, which is made unless it is kept.
    pub(super) fn of(&self, key: K, make: impl FnOnce() -> V) -> Arc<V> {
        let Ok(value) = self.try_of(key, || Ok::<V, Infallible>(make()));
        value
    }

    /// As [`Self::of`], where the value may fail to be made.
    ///
    /// # Errors
    /// That of `make`.
    pub(super) fn try_of<E>(&self, key: K, make: impl FnOnce() -> Result<V, E>) -> Result<Arc<V>, E> {
        let known = |(other, value): &(K, Arc<V>)| (*other == key).then(|| Arc::clone(value));
        if let Some(value) = self.0.lock().unwrap_or_else(PoisonError::into_inner).iter().find_map(known) {
            return Ok(value);
        }
        let value = Arc::new(make()?);
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        kept.truncate(KEPT - 1);
        kept.push_front((key, Arc::clone(&value)));
        Ok(value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_three_are_kept_and_failures_are_not() {
        let recent = Recent::default();
        let made = |key: i32| {
            let mut is_made = false;
            let value = recent.of(key, || {
                is_made = true;
                10 * key
            });
            assert_eq!(*value, 10 * key);
            is_made
        };
        assert_eq!([1, 2, 3, 1, 2, 3].map(made), [true, true, true, false, false, false]);
        assert_eq!([4, 2, 3, 1, 4].map(made), [true, false, false, true, false]);
        assert_eq!(recent.try_of(5, || Err("lost")), Err("lost"));
        assert!(made(5) && !made(4));
        assert_eq!(*recent.clone().of(5, || 0), 50);
    }
}
