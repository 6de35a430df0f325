//! A pool of sample planes, reused from frame to frame: fresh memory for a frame costs a page fault every 4 KB.
//!
//! In: planes that are no longer used. Out: planes of any length with unspecified contents.

use std::sync::{Mutex, PoisonError};

/// Maximum number of pooled samples, 256 MB: a 4K RGBA picture and the tiles it is drawn from.
const KEPT: usize = 1 << 26;

static POOL: Mutex<Vec<Vec<f32>>> = Mutex::new(Vec::new());

/// Returns `count` planes of `length` samples each, with unspecified contents.
#[must_use]
pub(crate) fn take_planes(count: usize, length: usize) -> Vec<Vec<f32>> {
    let mut planes: Vec<Vec<f32>> = {
        let mut pool = POOL.lock().unwrap_or_else(PoisonError::into_inner);
        let fit = |plane: &mut Vec<f32>| (length..=2 * length).contains(&plane.capacity());
        pool.extract_if(.., fit).take(count).collect()
    };
    planes.resize_with(count, Vec::new);
    for plane in &mut planes {
        if plane.capacity() == 0 {
            *plane = vec![0.0; length];
        }
        plane.resize(length, 0.0);
    }
    planes
}

/// Returns planes to the pool of [`take_planes`]; if there are too many, the oldest are freed.
pub(crate) fn recycle_planes(planes: impl IntoIterator<Item = Vec<f32>>) {
    let mut pool = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    pool.extend(planes.into_iter().filter(|plane| plane.capacity() > 0));
    let mut total: usize = pool.iter().map(Vec::capacity).sum();
    while total > KEPT {
        total -= pool.remove(0).capacity();
    }
}

/// Frees all pooled planes.
#[cfg(any(test, feature = "ofx"))]
pub(super) fn purge() {
    POOL.lock().unwrap_or_else(PoisonError::into_inner).clear();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_come_back_in_any_length_near_theirs() {
        // No other test requests planes of this size.
        let length = 3_000_001;
        let mut planes = take_planes(2, length);
        planes.iter_mut().for_each(|plane| plane.fill(7.0));
        let places: Vec<_> = planes.iter().map(|plane| plane.as_ptr()).collect();
        recycle_planes(planes);
        let again = take_planes(3, length - 1000);
        assert!(again.iter().all(|plane| plane.len() == length - 1000));
        assert_eq!(again.iter().filter(|plane| places.contains(&plane.as_ptr())).count(), 2);
        recycle_planes(again);
        assert!(take_planes(1, 100)[0].capacity() < length, "large memory is not spent on little");
    }
}
