//! Cuts and joins between the parts of a layer, for branching lattices.

use super::Selection;

/// Default maximum distance between an island and the part that carries it, in diagonals of the layer at rest.
pub(super) const ISLAND_RADIUS: f64 = 0.1;

/// The connectivity of a layer's parts, in addition to their rest geometry.
#[derive(Clone, Debug, PartialEq)]
pub struct Connectivity {
    /// Cuts, in the order of the shot.
    pub cuts: Vec<Cut>,
    /// Manual joins: pairs of patterns of node names (`*` and `?`), including their subtrees.
    pub joins: Vec<[String; 2]>,
    /// Islands (eyes, buttons, hair cards) are attached to the nearest part at rest, up to this distance in diagonals
    /// of the layer at rest.
    pub island_radius: f64,
}

/// A separation within a layer.
#[derive(Clone, Debug, PartialEq)]
pub enum Cut {
    /// A stroke across a picture: a polyline in frame heights.
    Stroke(Vec<[f64; 2]>),
    /// A part of a scene, or of a picture under a mask, separated from everything else.
    Part {
        /// Patterns of node names, as in a layer; empty: all nodes of the layer.
        nodes: Vec<String>,
        /// The part of their meshes.
        selection: Selection,
        /// What happens to the surfaces of meshes of which only some is cut off.
        surface: CutSurface,
    },
}

/// The effect of a cut on the surface of a mesh of which only some is cut off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CutSurface {
    /// It stays whole: the cut separates parts that touch or are near, such as an arm and the body beside it.
    Whole,
    /// It is opened along the border of the part.
    Opened,
}

impl Cut {
    /// Returns the selection of a cut-off part.
    pub(super) const fn selection_mut(&mut self) -> Option<&mut Selection> {
        match self {
            Self::Part { selection, .. } => Some(selection),
            Self::Stroke(_) => None,
        }
    }
}

impl Default for Connectivity {
    /// No manual cuts or joins.
    fn default() -> Self {
        Self { cuts: Vec::new(), joins: Vec::new(), island_radius: ISLAND_RADIUS }
    }
}

impl Connectivity {
    /// Returns the selections of the cut-off parts.
    pub(crate) fn selections(&self) -> impl Iterator<Item = &Selection> {
        self.cuts.iter().filter_map(|cut| match cut {
            Cut::Part { selection, .. } => Some(selection),
            Cut::Stroke(_) => None,
        })
    }
}
