//! Cuts and joins between the parts of a layer, for branching lattices.

use super::Selection;
use super::order::OrderKey;
use crate::plate::Matte;
use std::path::PathBuf;

/// Default maximum distance between an island and the part that carries it, in diagonals of the layer at rest.
pub(super) const ISLAND_RADIUS: f64 = 0.1;

/// Default greatest gap in a line that still closes a region, frame heights.
pub(super) const GAP: f64 = 0.01;

/// Default greatest width of a line, frame heights.
pub(super) const LINE: f64 = 0.025;

/// Default contrast of a line with what lies beside it, as a fraction of that of black and white.
pub(super) const CONTRAST: f64 = 0.25;

/// The connectivity of a layer's parts, in addition to their rest geometry.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Connectivity {
    /// Cuts, in the order of the shot.
    pub(crate) cuts: Vec<Cut>,
    /// One per cut: the order in depth of the part that it chooses; empty: that of the part's pins.
    pub(crate) orders: Vec<Vec<OrderKey>>,
    /// Manual joins.
    pub(crate) joins: Vec<Join>,
    /// Islands (eyes, buttons, hair cards) are attached to the nearest part at rest, up to this distance in diagonals
    /// of the layer at rest.
    pub island_radius: f64,
}

/// A link between two parts of a scene at one place.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Join {
    /// Patterns of node names (`*` and `?`), including their subtrees.
    pub(crate) nodes: [String; 2],
    /// The place in the scene at rest, metres; `None`: where the parts are nearest.
    pub(crate) at: Option<[f64; 3]>,
}

/// A separation within a layer.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Cut {
    /// A stroke across a picture: a polyline in frame heights.
    Stroke(Vec<[f64; 2]>),
    /// A stroke over a scene, as the camera sees it.
    SceneStroke {
        /// A polyline in frame heights.
        points: Vec<[f64; 2]>,
        /// The frame over which it is drawn.
        frame: i32,
        /// What happens to the surfaces of meshes that it crosses.
        surface: CutSurface,
    },
    /// A part of a scene, or of a picture under a mask, separated from everything else.
    Part {
        /// Patterns of node names, as in a layer; empty: all nodes of the layer.
        nodes: Vec<String>,
        /// The part of their meshes.
        selection: Selection,
        /// What happens to the surfaces of meshes of which only some is cut off.
        surface: CutSurface,
    },
    /// Parts of a picture by the ids of another that lies over it.
    Ids(IdPicture),
    /// Parts of a drawing by its closed regions.
    Regions(LineArt),
}

/// The effect of a cut on the surface of a mesh of which only some is cut off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CutSurface {
    /// It stays whole: the cut separates parts that touch or are near, such as an arm and the body beside it.
    Whole,
    /// It is opened along the border of the part.
    Opened,
}

/// A picture of ids that lies over the picture of a layer.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct IdPicture {
    /// PNG or EXR file of the picture's shape.
    pub file: PathBuf,
    /// The ids that count.
    pub ids: IdChoice,
}

/// The ids of a picture that separate parts.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum IdChoice {
    /// Each id of a Cryptomatte is a part; in a file without one, each colour. The name of the Cryptomatte, if several are there.
    Each(Option<String>),
    /// Each value of a channel of ids is a part.
    EachOfChannel(String),
    /// What the matte covers by more than half is one part.
    Chosen(Matte),
}

/// A drawing that is divided into the regions which its lines close.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LineArt {
    /// Picture of the lines; `None`: the picture of the layer.
    pub file: Option<PathBuf>,
    /// Points in regions that together are one part, frame heights; empty: every region is a part.
    pub at: Vec<[f64; 2]>,
    /// Greatest gap in a line that still closes a region, frame heights.
    pub gap: f64,
    /// Greatest width of a line, frame heights.
    pub line: f64,
    /// Contrast of a line with what lies beside it, as a fraction of that of black and white.
    pub threshold: f64,
}

impl Cut {
    /// Whether it divides a picture into any number of parts, of which those without a pin go along with others.
    pub(crate) fn is_division(&self) -> bool {
        match self {
            Self::Ids(ids) => !matches!(ids.ids, IdChoice::Chosen(_)),
            Self::Regions(lines) => lines.at.is_empty(),
            Self::Stroke(_) | Self::SceneStroke { .. } | Self::Part { .. } => false,
        }
    }

    /// Whether it separates one part of a picture, which it chooses, from everything else.
    pub(super) fn chooses_part(&self) -> bool {
        match self {
            Self::Stroke(_) | Self::SceneStroke { .. } => false,
            Self::Part { .. } | Self::Ids(_) | Self::Regions(_) => !self.is_division(),
        }
    }

    /// Returns the file that the cut reads, with its key in the cut: `mask.file`.
    pub(crate) fn file(&self) -> Option<(&'static str, &PathBuf)> {
        match self {
            Self::Stroke(_) | Self::SceneStroke { .. } => None,
            Self::Part { selection, .. } => Some(("mask.file", &selection.mask.as_ref()?.file)),
            Self::Ids(ids) => Some(("ids.file", &ids.file)),
            Self::Regions(lines) => Some(("regions.file", lines.file.as_ref()?)),
        }
    }

    /// Returns the same file, to change its path.
    pub(super) fn file_mut(&mut self) -> Option<&mut PathBuf> {
        match self {
            Self::Stroke(_) | Self::SceneStroke { .. } => None,
            Self::Part { selection, .. } => Some(&mut selection.mask.as_mut()?.file),
            Self::Ids(ids) => Some(&mut ids.file),
            Self::Regions(lines) => lines.file.as_mut(),
        }
    }
}

impl Default for Connectivity {
    /// No manual cuts or joins.
    fn default() -> Self {
        Self { cuts: Vec::new(), orders: Vec::new(), joins: Vec::new(), island_radius: ISLAND_RADIUS }
    }
}
