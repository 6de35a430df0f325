//! Counting sort by a small integer key, such as the first vertex of an edge.
//!
//! In: items and their keys. Out: the sorted items. It is several times as fast as a comparison sort.

use std::cmp::Ordering;

/// Sorts by key (below `count`), and items of equal key by `order`.
pub(crate) fn counting_sort_then_by<T: Copy>(
    items: &mut Vec<T>,
    count: usize,
    bucket: impl Fn(&T) -> usize,
    order: impl Fn(&T, &T) -> Ordering,
) {
    let mut first = 0;
    for end in counting_sort(items, count, bucket) {
        insert_sorted(&mut items[first..end], &order);
        first = end;
    }
}

/// Sorts stably by key (below `count`); returns the end of the range of each key.
pub(crate) fn counting_sort<T: Copy>(items: &mut Vec<T>, count: usize, bucket: impl Fn(&T) -> usize) -> Vec<usize> {
    let mut ends = vec![0; count + 1];
    items.iter().for_each(|item| ends[bucket(item) + 1] += 1);
    for number in 0..count {
        ends[number + 1] += ends[number];
    }
    // While items are placed, each range start advances to the end of its range.
    let mut placed = items.clone();
    for item in items.iter() {
        let slot = &mut ends[bucket(item)];
        placed[*slot] = *item;
        *slot += 1;
    }
    *items = placed;
    ends.truncate(count);
    ends
}

/// Maximum length of slices that are sorted by insertion.
const FEW: usize = 24;

fn insert_sorted<T: Copy>(items: &mut [T], order: &impl Fn(&T, &T) -> Ordering) {
    if items.len() > FEW {
        return items.sort_by(order);
    }
    for next in 1..items.len() {
        let item = items[next];
        let mut at = next;
        while at > 0 && order(&item, &items[at - 1]) == Ordering::Less {
            items[at] = items[at - 1];
            at -= 1;
        }
        items[at] = item;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buckets_give_the_order_of_a_sort() {
        for size in [0, 1, 7, 60, 400] {
            let mut items: Vec<[usize; 2]> = (0..size).map(|k| [k * 7919 % 5, k * 104_729 % 31]).collect();
            let mut wanted = items.clone();
            wanted.sort_unstable();
            counting_sort_then_by(&mut items, 5, |item| item[0], |a, b| a[1].cmp(&b[1]));
            assert_eq!(items, wanted);
        }
    }
}
