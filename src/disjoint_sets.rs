//! Disjoint sets, the union-find structure (R. Tarjan, "Efficiency of a Good But Not Linear Set Union Algorithm", 1975).
//!
//! In: pairs to unite. Out: the smallest member of any set.

/// A partition of the numbers below a count.
pub(crate) struct DisjointSets {
    parents: Vec<usize>,
}

impl DisjointSets {
    /// Creates one set per number.
    pub(crate) fn of(count: usize) -> Self {
        Self { parents: (0..count).collect() }
    }

    /// The smallest member of the set that contains a number.
    pub(crate) fn root(&mut self, mut number: usize) -> usize {
        while self.parents[number] != number {
            self.parents[number] = self.parents[self.parents[number]];
            number = self.parents[number];
        }
        number
    }

    /// Unites the sets of two numbers.
    pub(crate) fn join(&mut self, [a, b]: [usize; 2]) {
        let (a, b) = (self.root(a), self.root(b));
        self.parents[a.max(b)] = a.min(b);
    }
}
