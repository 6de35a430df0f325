//! Resolves overlapping selections: later layers take precedence, and a layer for the rest gets what remains.
//!
//! In: how much of every part each layer selects. Out: the layers that move a part, with weights whose sum is at most 1.

use super::coverage::PartCoverage;
use super::shared_part::SharedPart;
use crate::scene::Primitive;

/// The layers that move a part.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::pipeline) enum PartLayers {
    /// One layer moves all of it, or none moves any of it.
    Whole(Option<usize>),
    /// Several layers move it, or one moves some of it.
    Shared(SharedPart),
}

/// Returns the layers of a part. `named`: layers and their selection of the part, in order of decreasing precedence.
pub(super) fn layers_of<'a>(
    named: impl Iterator<Item = (usize, &'a PartCoverage)>,
    primitive: &Primitive,
) -> PartLayers {
    let mut left = vec![1.0_f32; primitive.positions.len()];
    let mut columns: Vec<(usize, Vec<f32>)> = Vec::new();
    for (layer, coverage) in named {
        match coverage {
            PartCoverage::Nothing => {}
            PartCoverage::All if columns.is_empty() => return PartLayers::Whole(Some(layer)),
            PartCoverage::All => {
                columns.push((layer, left));
                break;
            }
            PartCoverage::Vertices(shares) => {
                columns.push((layer, left.iter().zip(shares).map(|(left, share)| left * share).collect()));
                left.iter_mut().zip(shares).for_each(|(left, share)| *left *= 1.0 - share);
            }
        }
    }
    let corners = || primitive.triangles.iter().flatten().map(|&corner| corner as usize);
    columns.retain(|(_, weights)| corners().any(|corner| weights[corner] > 0.0));
    columns.sort_by_key(|&(layer, _)| layer);
    match &columns[..] {
        [] => PartLayers::Whole(None),
        [(layer, weights)] if corners().all(|corner| weights[corner] == 1.0) => PartLayers::Whole(Some(*layer)),
        _ => PartLayers::Shared(SharedPart::new(&columns, &primitive.triangles)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn layers(named: &[(usize, PartCoverage)]) -> PartLayers {
        let primitive =
            Primitive { positions: vec![Vec3::ZERO; 4], triangles: vec![[0, 1, 2]], ..Primitive::default() };
        layers_of(named.iter().map(|(layer, coverage)| (*layer, coverage)), &primitive)
    }

    #[test]
    fn who_comes_first_takes_it_all() {
        let some = PartCoverage::Vertices(vec![0.5; 4]);
        assert_eq!(layers(&[(2, PartCoverage::All), (0, some)]), PartLayers::Whole(Some(2)));
        assert_eq!(layers(&[(2, PartCoverage::Nothing)]), PartLayers::Whole(None));
    }

    #[test]
    fn what_is_taken_is_missing_elsewhere() {
        let named = [
            (2, PartCoverage::Vertices(vec![1.0, 0.25, 0.0, 0.0])),
            (1, PartCoverage::Vertices(vec![1.0, 0.5, 0.5, 0.0])),
            (0, PartCoverage::All),
        ];
        let PartLayers::Shared(part) = layers(&named) else { panic!("it is shared") };
        assert_eq!(part.layers, [0, 1, 2]);
        assert_eq!(
            (part.at(0), part.at(1), part.at(2)),
            (&[0., 0., 1.][..], &[0.375, 0.375, 0.25][..], &[0.5, 0.5, 0.][..])
        );
    }

    #[test]
    fn vertices_without_triangles_do_not_count() {
        let named = [(1, PartCoverage::Vertices(vec![0.0, 0.0, 0.0, 1.0])), (0, PartCoverage::All)];
        assert_eq!(layers(&named), PartLayers::Whole(Some(0)));
    }
}
