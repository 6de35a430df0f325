//! Rows of pins of which some pairs give way.
//!
//! In: rows, pins, pairs with their compliances k. Out: rows that are combinations of those of the pins.
//! With K = Σ k (e_i − e_j)(e_i − e_j)ᵀ over the pairs, W the weights of the pins and w the stiffness of a pin that holds
//! exactly, pins act with the stiffness w M, M = (W⁻¹ + w K)⁻¹: the mean of two rows stays as stiff as before, and their
//! difference yields.

use super::least_squares::LeastSquaresRows;
use super::problem::PointPin;
use super::yielding::YieldingPair;
use std::collections::BTreeMap;

/// Entries and target of a linear combination of rows.
type Combination<const D: usize> = (Vec<(usize, f64)>, [f64; D]);

/// Rows of pins, combined by the pairs that yield.
#[derive(Clone, Debug)]
pub(crate) struct YieldingRows<const D: usize> {
    /// Rows for the energy: those of all pins, of which the yielding ones are the combinations G C with GᵀG = M.
    pub(crate) rows: LeastSquaresRows<D>,
    /// Rows M C of the hard pins that yield, with their targets M d.
    held: LeastSquaresRows<D>,
    /// Index in `held` for each pin row that is there.
    places: BTreeMap<usize, usize>,
    /// Entries of Z = (I − M)/w for pairs of rows of hard pins.
    compliance: Vec<([usize; 2], f64)>,
}

impl<const D: usize> YieldingRows<D> {
    /// Combines the rows of pins. `stiffness` is w, that of a pin that holds exactly.
    pub(crate) fn new(
        rows: &LeastSquaresRows<D>,
        pins: &[PointPin<D>],
        pairs: &[YieldingPair],
        stiffness: f64,
    ) -> Self {
        let firsts = first_rows(pins);
        let mut mixed: BTreeMap<usize, Combination<D>> = BTreeMap::new();
        let (mut held, mut places, mut compliance) = (LeastSquaresRows::new(), BTreeMap::new(), Vec::new());
        for members in groups(pairs) {
            let root = root(&members, pins, pairs);
            let own: Vec<usize> = members.iter().map(|&pin| firsts[pin]).collect();
            own.iter().zip(&root).for_each(|(&row, shares)| {
                mixed.insert(row, combined(rows, &own, shares));
            });
            let hard: Vec<usize> = (0..own.len()).filter(|&k| pins[members[k]].weight >= 1.0).collect();
            let inverse = |a: usize, b: usize| root.iter().map(|row| row[a] * row[b]).sum::<f64>();
            for &k in &hard {
                places.insert(own[k], held.len());
                let shares: Vec<f64> = (0..own.len()).map(|other| inverse(k, other)).collect();
                let (entries, target) = combined(rows, &own, &shares);
                held.push(1.0, entries, target);
                let entry = |other: usize| (f64::from(u8::from(other == k)) - shares[other]) / stiffness;
                compliance.extend(hard.iter().map(|&other| ([own[k], own[other]], entry(other))));
            }
        }
        let mut all = LeastSquaresRows::new();
        for row in 0..rows.len() {
            match mixed.remove(&row) {
                Some((entries, target)) => all.push(1.0, entries, target),
                None => all.push(rows.weight(row), rows.row(row).iter().copied(), rows.target(row)),
            }
        }
        Self { rows: all, held, places, compliance }
    }

    /// Returns the set of the rows M C with targets M d, and the index in it for a pin row; `None` if the pin is not a hard pin
    /// that yields.
    pub(crate) fn held(&self, row: usize) -> Option<(&LeastSquaresRows<D>, usize)> {
        Some((&self.held, *self.places.get(&row)?))
    }

    /// Entries of Z = (I − M)/w for pairs of rows of hard pins.
    pub(crate) fn compliance(&self) -> &[([usize; 2], f64)] {
        &self.compliance
    }
}

/// Returns the position row of each pin. A pin that prescribes a gradient has one additional row per axis.
fn first_rows<const D: usize>(pins: &[PointPin<D>]) -> Vec<usize> {
    let mut next = 0;
    let mut first = |pin: &PointPin<D>| {
        let row = next;
        next += 1 + pin.gradient.map_or(0, |_| D);
        row
    };
    pins.iter().map(&mut first).collect()
}

/// Returns Σ share · row, with entries in ascending order, and Σ share · target.
fn combined<const D: usize>(rows: &LeastSquaresRows<D>, own: &[usize], shares: &[f64]) -> Combination<D> {
    let (mut entries, mut target) = (BTreeMap::new(), [0.0; D]);
    for (&row, share) in own.iter().zip(shares).filter(|(_, share)| **share != 0.0) {
        for &(handle, coefficient) in rows.row(row) {
            *entries.entry(handle).or_insert(0.0) += share * coefficient;
        }
        (0..D).for_each(|d| target[d] += share * rows.target(row)[d]);
    }
    (entries.into_iter().collect(), target)
}

/// Returns groups of pins that are connected by pairs, each in ascending order.
fn groups(pairs: &[YieldingPair]) -> Vec<Vec<usize>> {
    let mut group_of: BTreeMap<usize, usize> = BTreeMap::new();
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for pair in pairs {
        let mut joined: Vec<usize> = pair.pins.to_vec();
        let old: Vec<usize> = pair.pins.iter().filter_map(|pin| group_of.get(pin).copied()).collect();
        old.iter().for_each(|&group| joined.append(&mut groups[group]));
        joined.sort_unstable();
        joined.dedup();
        joined.iter().for_each(|&pin| {
            group_of.insert(pin, groups.len());
        });
        groups.push(joined);
    }
    groups.retain(|group| !group.is_empty());
    groups
}

/// Returns G for a group, #members²: L⁻¹ where M⁻¹ = L Lᵀ.
fn root<const D: usize>(members: &[usize], pins: &[PointPin<D>], pairs: &[YieldingPair]) -> Vec<Vec<f64>> {
    let count = members.len();
    let mut lower = vec![vec![0.0; count]; count];
    members.iter().enumerate().for_each(|(k, &pin)| lower[k][k] = 1.0 / pins[pin].weight.min(1.0));
    for pair in pairs {
        let [Ok(a), Ok(b)] = pair.pins.map(|pin| members.binary_search(&pin)) else { continue };
        lower[a][a] += pair.compliance;
        lower[b][b] += pair.compliance;
        lower[a.max(b)][a.min(b)] -= pair.compliance;
    }
    for j in 0..count {
        for i in j..count {
            let left = lower[i][j] - (0..j).map(|k| lower[i][k] * lower[j][k]).sum::<f64>();
            lower[i][j] = if i == j { left.sqrt() } else { left / lower[j][j] };
        }
    }
    let mut root = vec![vec![0.0; count]; count];
    for (i, row) in lower.iter().enumerate() {
        let solved = (0..=i).map(|column| {
            let known: f64 = (column..i).map(|k| row[k] * root[k][column]).sum();
            (f64::from(u8::from(i == column)) - known) / row[i]
        });
        let solved: Vec<f64> = solved.collect();
        root[i][..=i].copy_from_slice(&solved);
    }
    root
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_of_two_pins_stays_firm_and_their_difference_yields() {
        let pins = [0.0, 0.1, 0.9].map(|x| PointPin::new([x, 0.0], [x, 0.0]));
        let mut rows: LeastSquaresRows<2> = LeastSquaresRows::new();
        (0..3).for_each(|k| rows.push(1.0, [(k, 1.0)], [k as f64, 0.0]));
        let mixed = YieldingRows::new(&rows, &pins, &[YieldingPair { pins: [0, 1], compliance: 2.0 }], 1.0);
        let energy = |x: [f64; 3]| mixed.rows.energy(&x.map(|x| [x, 0.0]));
        // The mean of the targets is ½; the stiffness of the difference is 1/(1 + 2·2) of the former one.
        assert!((energy([1.5, 2.5, 2.0]) - 4.5).abs() < 1e-12, "{}", energy([1.5, 2.5, 2.0]));
        assert!((energy([0.5, 0.5, 2.0]) - 0.5 / 5.0).abs() < 1e-12, "{}", energy([0.5, 0.5, 2.0]));
        assert!((energy([0.0, 1.0, 5.0]) - 9.0).abs() < 1e-12);
        assert!(mixed.held(2).is_none() && mixed.held(1).is_some_and(|(held, _)| held.len() == 2));
        let trace: f64 = mixed.compliance().iter().filter(|([a, b], _)| a == b).map(|(_, entry)| entry).sum();
        assert!((trace - 0.8).abs() < 1e-12, "{trace}");
    }

    #[test]
    fn pairs_that_share_a_pin_are_one_group() {
        let pair = |a: usize, b: usize| YieldingPair { pins: [a, b], compliance: 1.0 };
        assert_eq!(groups(&[pair(0, 4), pair(2, 3), pair(3, 4), pair(5, 6)]), [vec![0, 2, 3, 4], vec![5, 6]]);
    }
}
