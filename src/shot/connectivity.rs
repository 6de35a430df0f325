//! What separates and joins the parts of a layer, for lattices that branch.

use super::Selection;

/// How far loose pieces may lie from what carries them where the shot does not say it, diagonals of the layer at rest.
pub(super) const ISLAND_RADIUS: f64 = 0.1;

/// How the parts of a layer hang together, beside how they lie at rest.
#[derive(Clone, Debug, PartialEq)]
pub struct Connectivity {
    /// What separates, in the order of the shot.
    pub cuts: Vec<Cut>,
    /// What is joined by hand: two patterns of node names each (`*` and `?`), with their subtrees.
    pub joins: Vec<[String; 2]>,
    /// Islands (eyes, buttons, hair cards) hang on what is nearest at rest, but no farther than this, diagonals of the layer at rest.
    pub island_radius: f64,
}

/// Where a layer comes apart.
#[derive(Clone, Debug, PartialEq)]
pub enum Cut {
    /// A stroke across a picture: points in frame heights.
    Stroke(Vec<[f64; 2]>),
    /// A part of a scene, which hangs on nothing else.
    Part {
        /// Patterns of node names, as of a layer; none: all nodes of the layer.
        nodes: Vec<String>,
        /// Which part of their meshes.
        selection: Selection,
    },
}

impl Cut {
    /// The selection of a part.
    pub(super) const fn selection_mut(&mut self) -> Option<&mut Selection> {
        match self {
            Self::Part { selection, .. } => Some(selection),
            Self::Stroke(_) => None,
        }
    }
}

impl Default for Connectivity {
    /// Nothing is cut or joined by hand.
    fn default() -> Self {
        Self { cuts: Vec::new(), joins: Vec::new(), island_radius: ISLAND_RADIUS }
    }
}

impl Connectivity {
    /// The selections of parts that are cut off.
    pub(crate) fn selections(&self) -> impl Iterator<Item = &Selection> {
        self.cuts.iter().filter_map(|cut| match cut {
            Cut::Part { selection, .. } => Some(selection),
            Cut::Stroke(_) => None,
        })
    }
}
