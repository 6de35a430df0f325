//! Which overlapping part of a picture lies in front, with stepped keys.
//!
//! In: keys of a pin or of a part, a frame. Out: the order in that frame.

/// A key of the order of a pin or of a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct OrderKey {
    /// Its frame.
    pub frame: f64,
    /// The order from this frame on.
    pub value: i32,
}

/// Returns the order at a (fractional) frame; `None` without keys. The first key also holds before its frame.
pub(crate) fn order_at(keys: &[OrderKey], frame: f64) -> Option<i32> {
    let before = keys.partition_point(|key| key.frame <= frame);
    keys.get(before.saturating_sub(1)).map(|key| key.value)
}
