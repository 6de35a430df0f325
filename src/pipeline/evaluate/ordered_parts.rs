//! The parts of a branching layer, with their order where they overlap. Plain data, decided by [`super::part_order`].

/// The pieces of a branch that have the same order and level. Sorts by order, then by level, then by branch with the largest branch
/// first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::pipeline) struct OrderedPart {
    /// Order of the part that a cut chooses, or of the pin nearest along the shape; 0 if neither has one.
    pub(in crate::pipeline) order: i32,
    /// Above 0 for what lies in front where limbs of one order cross.
    pub(in crate::pipeline) level: u32,
    pub(in crate::pipeline) branch: usize,
}

/// The parts of a layer.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(in crate::pipeline) struct OrderedParts {
    /// From back to front, as far as order and size of the branches determine it.
    pub(in crate::pipeline) list: Vec<OrderedPart>,
    /// Index into the list for each polygon, in the order of [`BranchedLattice::pieces`](crate::solve::BranchedLattice::pieces).
    pub(in crate::pipeline) of_pieces: Vec<u32>,
    /// Indices of pins at the limbs of one order that cross most: in front, behind.
    pub(in crate::pipeline) crossing_pins: Option<[usize; 2]>,
}
