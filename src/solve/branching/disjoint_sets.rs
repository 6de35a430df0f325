//! Disjoint sets (R. Tarjan, "Efficiency of a Good But Not Linear Set Union Algorithm", 1975).
//!
//! In: pairs that belong together. Out: the smallest member of any set.

/// Sets of the numbers below a count.
pub(super) struct DisjointSets {
    parents: Vec<usize>,
}

impl DisjointSets {
    /// Every number alone.
    pub(super) fn of(count: usize) -> Self {
        Self { parents: (0..count).collect() }
    }

    /// The smallest number of a set.
    pub(super) fn root(&mut self, mut number: usize) -> usize {
        while self.parents[number] != number {
            self.parents[number] = self.parents[self.parents[number]];
            number = self.parents[number];
        }
        number
    }

    /// Makes one set of two.
    pub(super) fn join(&mut self, [a, b]: [usize; 2]) {
        let (a, b) = (self.root(a), self.root(b));
        self.parents[a.max(b)] = a.min(b);
    }
}
