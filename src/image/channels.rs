//! The channels of a render: a single table of names, order, pixel types and empty values.
//!
//! In: nothing. Out: [`ChannelGroup`]s and their [`ChannelSpec`]s, shared by the rasterisers, the shot file and the plates.

use super::{EMPTY_DEPTH, Storage};

/// A group of channels that is requested as a unit, in the order of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ChannelGroup {
    /// R G B A: half, scene-linear, associated alpha.
    Beauty,
    /// `depth.Z`: float, distance along the view axis, metres; 1e10 where there is no surface.
    Depth,
    /// `forward.u` `forward.v` `backward.u` `backward.v`: float, pixels, x right, y up; 0 where there is no surface.
    Motion,
    /// `N.X` `N.Y` `N.Z`: float, scene space, unit length, facing the viewer; 0 where there is no surface.
    Normal,
    /// `id.layer` and `id.object`: float; 0 where there is no surface.
    Id,
    /// Six ranks of each Cryptomatte: float. Their names depend on the layer
    /// (`rank_channel_names`), so they are not in the table.
    Cryptomatte,
}

/// One channel of a group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelSpec {
    /// Name in the EXR file.
    pub name: &'static str,
    /// Pixel type.
    pub storage: Storage,
    /// Value where there is no surface.
    pub empty: f32,
}

const fn spec(name: &'static str, storage: Storage, empty: f32) -> ChannelSpec {
    ChannelSpec { name, storage, empty }
}

const fn color(name: &'static str) -> ChannelSpec {
    spec(name, Storage::Half, 0.0)
}

const fn data(name: &'static str) -> ChannelSpec {
    spec(name, Storage::Float, 0.0)
}

impl ChannelGroup {
    /// The groups with a fixed number of channels, in the order of a frame.
    pub(crate) const PLANAR: [Self; 5] = [Self::Beauty, Self::Depth, Self::Motion, Self::Normal, Self::Id];

    /// Returns the channels of the group, in order.
    ///
    /// ```
    /// use pinwarp::image::ChannelGroup;
    /// assert_eq!(ChannelGroup::Depth.channels()[0].name, "depth.Z");
    /// ```
    #[must_use]
    pub const fn channels(self) -> &'static [ChannelSpec] {
        match self {
            Self::Beauty => &const { [color("R"), color("G"), color("B"), color("A")] },
            Self::Depth => &const { [spec("depth.Z", Storage::Float, EMPTY_DEPTH)] },
            Self::Motion => &const { [data("forward.u"), data("forward.v"), data("backward.u"), data("backward.v")] },
            Self::Normal => &const { [data("N.X"), data("N.Y"), data("N.Z")] },
            Self::Id => &const { [data("id.layer"), data("id.object")] },
            Self::Cryptomatte => &[],
        }
    }

    /// Whether the group holds one exact sample per pixel instead of a filtered mean.
    #[must_use]
    pub(crate) const fn is_data(self) -> bool {
        matches!(self, Self::Depth | Self::Motion | Self::Normal | Self::Id)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Channel;
    use std::collections::BTreeSet;

    #[test]
    fn names_are_unique_and_empty_values_are_those_of_the_names() {
        let all: Vec<&ChannelSpec> = ChannelGroup::PLANAR.iter().flat_map(|group| group.channels()).collect();
        assert_eq!(all.iter().map(|spec| spec.name).collect::<BTreeSet<_>>().len(), 14);
        for spec in all {
            let channel = Channel { name: spec.name.into(), storage: spec.storage, samples: Vec::new() };
            assert_eq!(spec.empty, channel.empty_value(), "{}", spec.name);
        }
    }

    #[test]
    fn colour_is_half_and_data_are_float() {
        for group in ChannelGroup::PLANAR {
            let storage = if group.is_data() { Storage::Float } else { Storage::Half };
            assert!(group.channels().iter().all(|spec| spec.storage == storage), "{group:?}");
        }
    }
}
