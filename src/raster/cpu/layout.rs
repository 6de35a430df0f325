//! Which channels a frame has and in which plane of a tile each is gathered.
//!
//! In: the channel groups wanted. Out: plane numbers; channel names and storage in the order of [`ChannelGroup`].

use crate::image::{EMPTY_DEPTH, Storage};
use crate::raster::ChannelGroup;

/// First plane of each group wanted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Layout {
    /// R G B A.
    pub(super) beauty: Option<usize>,
    /// Distance.
    pub(super) depth: Option<usize>,
    /// Forward u v, backward u v.
    pub(super) motion: Option<usize>,
    /// X Y Z.
    pub(super) normal: Option<usize>,
    /// Layer, object.
    pub(super) id: Option<usize>,
    /// Mattes are gathered, in lists beside the planes.
    pub(super) has_mattes: bool,
    /// Reversed z of the surface the data come from.
    pub(super) z: usize,
    /// Planes in all.
    pub(super) planes: usize,
}

/// A channel of the frame.
pub(super) struct ChannelPlan {
    pub(super) name: &'static str,
    pub(super) storage: Storage,
    pub(super) plane: usize,
    /// Value where nothing is.
    pub(super) empty: f32,
}

impl Layout {
    pub(super) fn of(groups: &[ChannelGroup]) -> Self {
        let mut next = 0;
        let mut take = |group: ChannelGroup, planes: usize| {
            let first = groups.contains(&group).then_some(next);
            next += first.map_or(0, |_| planes);
            first
        };
        let mut layout = Self {
            beauty: take(ChannelGroup::Beauty, 4),
            depth: take(ChannelGroup::Depth, 1),
            motion: take(ChannelGroup::Motion, 4),
            normal: take(ChannelGroup::Normal, 3),
            id: take(ChannelGroup::Id, 2),
            has_mattes: groups.contains(&ChannelGroup::Cryptomatte),
            ..Self::default()
        };
        layout.z = next;
        layout.planes = next + 1;
        layout
    }

    pub(super) fn has_data(&self) -> bool {
        self.depth.or(self.motion).or(self.normal).or(self.id).is_some()
    }

    pub(super) fn is_beauty(&self, plane: usize) -> bool {
        self.beauty.is_some_and(|first| (first..first + 4).contains(&plane))
    }

    /// Planes of data with their value where nothing is.
    pub(super) fn data_planes(&self) -> impl Iterator<Item = (usize, f32)> {
        let first = self.beauty.map_or(0, |first| first + 4);
        (first..self.planes).map(|plane| (plane, if Some(plane) == self.depth { EMPTY_DEPTH } else { 0.0 }))
    }

    /// The frame's channels, without mattes.
    pub(super) fn channels(&self) -> Vec<ChannelPlan> {
        let groups: [(Option<usize>, &[&'static str], Storage); 5] = [
            (self.beauty, &["R", "G", "B", "A"], Storage::Half),
            (self.depth, &["depth.Z"], Storage::Float),
            (self.motion, &["forward.u", "forward.v", "backward.u", "backward.v"], Storage::Float),
            (self.normal, &["N.X", "N.Y", "N.Z"], Storage::Float),
            (self.id, &["id.layer", "id.object"], Storage::Float),
        ];
        let mut plans = Vec::new();
        for (first, names, storage) in groups {
            let Some(first) = first else { continue };
            let empty = if Some(first) == self.depth { EMPTY_DEPTH } else { 0.0 };
            plans.extend(names.iter().enumerate().map(|(i, name)| ChannelPlan {
                name,
                storage,
                plane: first + i,
                empty,
            }));
        }
        plans
    }
}
