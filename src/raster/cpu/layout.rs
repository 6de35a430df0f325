//! The channels of a frame, and the planes of a tile that accumulate them.
//!
//! In: the requested channel groups. Out: plane numbers in the order of the channel table.

use crate::image::{ChannelGroup, ChannelSpec};

/// First plane of each requested group.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Layout {
    /// In the order of [`ChannelGroup::PLANAR`].
    first: [Option<usize>; ChannelGroup::PLANAR.len()],
    /// Whether mattes are accumulated, in lists beside the planes.
    pub(super) has_mattes: bool,
    /// Total number of planes.
    pub(super) planes: usize,
}

impl Layout {
    pub(super) fn of(groups: &[ChannelGroup]) -> Self {
        let mut planes = 0;
        let first = ChannelGroup::PLANAR.map(|group| {
            let first = groups.contains(&group).then_some(planes);
            planes += first.map_or(0, |_| group.channels().len());
            first
        });
        Self { first, has_mattes: groups.contains(&ChannelGroup::Cryptomatte), planes }
    }

    /// Returns the group's first plane, if it is requested.
    pub(super) fn first(&self, group: ChannelGroup) -> Option<usize> {
        let at = ChannelGroup::PLANAR.iter().position(|&planar| planar == group)?;
        self.first[at]
    }

    pub(super) fn has_data(&self) -> bool {
        ChannelGroup::PLANAR.iter().any(|group| group.is_data() && self.first(*group).is_some())
    }

    /// Returns every channel with its group and plane, without mattes.
    pub(super) fn channels(&self) -> impl Iterator<Item = (ChannelGroup, &'static ChannelSpec, usize)> {
        let wanted = ChannelGroup::PLANAR.into_iter().zip(self.first);
        wanted.filter_map(|(group, first)| Some((group, first?))).flat_map(|(group, first)| {
            group.channels().iter().enumerate().map(move |(at, spec)| (group, spec, first + at))
        })
    }
}
