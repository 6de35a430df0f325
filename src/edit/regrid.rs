//! Transfers manually moved handles to a lattice of other dims.
//!
//! In: tracks of handles, dims before and after. Out: tracks of the nearest handles of the new lattice, by rest
//! position.

use crate::lattice::{Basis, Grid};
use crate::shot::HandleTrack;
use std::collections::BTreeMap;

/// Returns the tracks in a lattice of other dims over the same box. If two map to the same handle, the nearer one is
/// kept.
#[must_use]
pub(in crate::edit) fn regridded<const D: usize>(
    tracks: &[HandleTrack],
    basis: Basis,
    (old, new): ([usize; D], [usize; D]),
) -> Vec<HandleTrack> {
    let grid = |dims: [usize; D]| Grid { dims, basis, lo: [0.0; D], hi: [1.0; D], angle: 0.0 };
    let (old, new) = (grid(old), grid(new));
    let mut found: BTreeMap<usize, (f64, HandleTrack)> = BTreeMap::new();
    for track in tracks {
        let place = old.rest_handle((0..D).map(|axis| track.index[axis] * old.stride(axis)).sum());
        let far = |handle: usize| {
            let rest = new.rest_handle(handle);
            (0..D).map(|axis| (rest[axis] - place[axis]).powi(2)).sum::<f64>().sqrt()
        };
        let nearest = (0..new.handle_count()).map(|handle| (far(handle), handle)).min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((far, handle)) = nearest else { continue };
        let coords = new.handle_coords(handle);
        let index = std::array::from_fn(|axis| coords.get(axis).copied().unwrap_or(0));
        let moved = HandleTrack { index, keys: track.keys.clone() };
        if found.get(&handle).is_none_or(|(other, _)| far < *other) {
            found.insert(handle, (far, moved));
        }
    }
    found.into_values().map(|(_, track)| track).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shot::{Ease, HandleKey};

    fn track(column: usize, row: usize, x: f64) -> HandleTrack {
        let key = HandleKey { frame: 1.0, offset: [x, 0.0, 0.0], ease: Ease::Smooth };
        HandleTrack { index: [column, row, 0], keys: vec![key] }
    }

    #[test]
    fn handles_stay_where_they_are_and_keep_their_keys() {
        let tracks = [track(2, 3, 0.1), track(6, 6, 0.2)];
        // Twice as many spans: each old handle coincides with a new one.
        let finer = regridded(&tracks, Basis::Bilinear, ([7, 7], [13, 13]));
        assert_eq!(finer.iter().map(|track| track.index).collect::<Vec<_>>(), [[4, 6, 0], [12, 12, 0]]);
        assert_eq!(finer[0].keys, tracks[0].keys);
        assert_eq!(regridded(&finer, Basis::Bilinear, ([13, 13], [7, 7])), tracks);
    }

    #[test]
    fn handles_of_lattices_in_the_scene_are_transferred_too() {
        let key = HandleKey { frame: 1.0, offset: [0.1, 0.2, 0.3], ease: Ease::Smooth };
        let tracks = [HandleTrack { index: [1, 2, 3], keys: vec![key] }];
        let finer = regridded(&tracks, Basis::Bilinear, ([4, 4, 4], [7, 7, 7]));
        assert_eq!((finer[0].index, &finer[0].keys), ([2, 4, 6], &tracks[0].keys));
    }

    #[test]
    fn of_two_handles_at_one_place_the_nearer_stays() {
        let tracks = [track(4, 4, 0.1), track(5, 4, 0.2)];
        let coarser = regridded(&tracks, Basis::Bilinear, ([13, 13], [4, 4]));
        assert_eq!(coarser.len(), 1);
        assert_eq!((coarser[0].index, coarser[0].keys[0].offset[0]), ([1, 1, 0], 0.1));
    }
}
