//! A part of the scene that several layers move, with weights per vertex.
//!
//! In: weights. Out: the layer of each triangle, and how much of it a layer moves.

/// A part that several layers move, or of which one layer moves a portion.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SharedPart {
    /// Indices of the layers in the shot, in increasing order.
    pub layers: Vec<usize>,
    /// #vertices x #layers, row by row, 0 to 1: how much a layer moves a vertex. The remainder of a row to 1 is at rest.
    pub weights: Vec<f32>,
    /// #triangles: the layer that moves most of the triangle; `None` where most of it is at rest.
    pub layer_of_triangle: Vec<Option<usize>>,
}

impl SharedPart {
    /// Creates the part. `columns`: layers in increasing order, with their weights of all vertices.
    pub(crate) fn new(columns: &[(usize, Vec<f32>)], triangles: &[[u32; 3]]) -> Self {
        let vertices = columns.first().map_or(0, |(_, weights)| weights.len());
        let weights = (0..vertices).flat_map(|vertex| columns.iter().map(move |(_, weights)| weights[vertex]));
        let mut part = Self {
            layers: columns.iter().map(|&(layer, _)| layer).collect(),
            weights: weights.collect(),
            layer_of_triangle: Vec::new(),
        };
        part.layer_of_triangle = triangles.iter().map(|corners| part.owner(corners)).collect();
        part
    }

    /// Returns the weights of all layers at a vertex.
    #[must_use]
    pub(crate) fn at(&self, vertex: u32) -> &[f32] {
        let count = self.layers.len();
        &self.weights[vertex as usize * count..][..count]
    }

    /// Returns how much of a triangle a layer moves: the mean over its corners; 0 for layers that do not move the part.
    #[must_use]
    pub(crate) fn of_triangle(&self, layer: usize, corners: &[u32; 3]) -> f64 {
        let Some(column) = self.layers.iter().position(|&own| own == layer) else { return 0.0 };
        corners.iter().map(|&corner| f64::from(self.at(corner)[column])).sum::<f64>() / 3.0
    }

    /// Returns the layer that moves the most triangles of the part; `None` if most triangles are at rest.
    #[must_use]
    pub(crate) fn most(&self) -> Option<usize> {
        let count = |layer: Option<usize>| self.layer_of_triangle.iter().filter(|owner| **owner == layer).count();
        let candidates = std::iter::once(None).chain(self.layers.iter().copied().map(Some));
        candidates.max_by_key(|&layer| count(layer)).flatten()
    }

    fn owner(&self, corners: &[u32; 3]) -> Option<usize> {
        let shares = self.layers.iter().map(|&layer| (Some(layer), self.of_triangle(layer, corners)));
        let moved: f64 = shares.clone().map(|(_, share)| share).sum();
        let greatest = std::iter::once((None, 1.0 - moved)).chain(shares).max_by(|a, b| a.1.total_cmp(&b.1));
        greatest.and_then(|(layer, _)| layer)
    }
}

/// How much of a part a layer moves.
#[derive(Clone, Copy, Debug)]
pub(crate) enum LayerShare<'a> {
    /// The whole part.
    Whole,
    /// Each vertex by its weight; holds the part and the layer's index.
    Shared(&'a SharedPart, usize),
}

impl LayerShare<'_> {
    /// Returns how much of a triangle the layer moves, 0 to 1.
    #[must_use]
    pub(crate) fn of(&self, corners: &[u32; 3]) -> f64 {
        match self {
            Self::Whole => 1.0,
            Self::Shared(part, layer) => part.of_triangle(*layer, corners),
        }
    }

    /// Returns how much of a vertex the layer moves, 0 to 1.
    #[must_use]
    pub(crate) fn at(&self, vertex: u32) -> f64 {
        self.of(&[vertex; 3])
    }

    /// Whether the layer moves some of a triangle.
    #[must_use]
    pub(crate) fn meets(&self, corners: &[u32; 3]) -> bool {
        self.of(corners) > 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangle_is_of_the_layer_that_moves_most_of_it() {
        let columns = [(1, vec![1.0, 0.6, 0.0, 0.0]), (4, vec![0.0, 0.4, 0.3, 0.0])];
        let part = SharedPart::new(&columns, &[[0, 0, 1], [1, 2, 3], [1, 1, 2], [0, 2, 2]]);
        assert_eq!(part.layer_of_triangle, [Some(1), None, Some(1), None]);
        assert_eq!(part.at(1), [0.6, 0.4]);
        assert_eq!(part.most(), Some(1));
        assert!((LayerShare::Shared(&part, 4).of(&[1, 2, 3]) - 0.7 / 3.0).abs() < 1e-6);
        assert!(!LayerShare::Shared(&part, 4).meets(&[0, 0, 3]) && LayerShare::Whole.meets(&[0, 0, 3]));
    }
}
