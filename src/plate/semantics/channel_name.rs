//! Parses channel names.
//!
//! In: the names of the part, the views and the channels. Out: layer, view and component.

use super::word_of;

/// View names that files use without declaring them in their metadata.
const COMMON_VIEWS: [&str; 2] = ["left", "right"];

/// Names of the two screen components of a vector, in order.
pub(crate) const VECTOR_COMPONENTS: [[&str; 2]; 7] =
    [["u", "v"], ["x", "y"], ["r", "g"], ["z", "w"], ["nx", "ny"], ["red", "green"], ["horizontal", "vertical"]];

/// A parsed channel name, for example `ViewLayer.Vector.left.X` in a part `main`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ChannelName {
    /// Full name, as in the file.
    pub(crate) full: String,
    /// Name of its part.
    pub(crate) part: Option<String>,
    /// View: `left`; `None` for the only one, or for the first of several.
    pub(crate) view: Option<String>,
    /// The segments before the last dot, without the view: `ViewLayer`, `Vector`.
    pub(crate) segments: Vec<String>,
    /// The segment after the last dot: `X`.
    pub(crate) component: String,
    /// All components of the same layer, including this one, in lower case.
    pub(crate) siblings: Vec<String>,
    /// The normalised name of its layer, or of its part if the channel belongs to no layer.
    word: Option<String>,
}

impl ChannelName {
    /// Parses the names of a part's channels.
    ///
    /// `views`: the views in this part; channels that name no view belong to the first.
    pub(crate) fn of_part(part: Option<&str>, views: &[&str], channels: &[&str]) -> Vec<Self> {
        let mut names: Vec<Self> = channels.iter().map(|full| Self::apart(part, views, full)).collect();
        let layers: Vec<_> = names.iter().map(|name| (name.segments.clone(), name.view.clone())).collect();
        let components: Vec<String> = names.iter().map(|name| name.component.to_ascii_lowercase()).collect();
        for (index, name) in names.iter_mut().enumerate() {
            let same = (0..layers.len()).filter(|&other| layers[other] == layers[index]);
            name.siblings = same.map(|other| components[other].clone()).collect();
        }
        names
    }

    fn apart(part: Option<&str>, views: &[&str], full: &str) -> Self {
        let is_view = |segment: &str| views.contains(&segment) || COMMON_VIEWS.contains(&segment);
        let mut segments: Vec<String> = full.split('.').map(str::to_owned).collect();
        let component = segments.pop().unwrap_or_default();
        let in_name = segments.iter().find(|segment| is_view(segment)).cloned();
        segments.retain(|segment| !is_view(segment));
        // The view in part names such as `rgba_left` and `depth.left` says nothing about the contents.
        let part_word = part.map(|part| {
            let words = part.split(['.', '_', '-', ' ']).filter(|word| !is_view(word));
            word_of(&words.collect::<String>())
        });
        Self {
            full: full.to_owned(),
            part: part.map(str::to_owned),
            view: in_name.or_else(|| views.first().map(|&view| view.to_owned())),
            word: segments.last().map(|segment| word_of(segment)).or(part_word),
            segments,
            component,
            siblings: Vec::new(),
        }
    }

    /// Returns the normalised name of its layer, or of its part if the channel belongs to no layer.
    pub(crate) fn layer_word(&self) -> Option<&str> {
        self.word.as_deref()
    }

    /// Whether its layer also has the given component.
    pub(super) fn has_sibling(&self, component: &str) -> bool {
        self.siblings.iter().any(|sibling| sibling == component)
    }

    /// Whether its layer has vector components.
    pub(super) fn has_vector_siblings(&self) -> bool {
        [("x", "y"), ("u", "v")].iter().any(|(a, b)| self.has_sibling(a) && self.has_sibling(b))
    }

    /// Returns the name prefixed with that of the part: `mask_left.mask.A`.
    pub(crate) fn with_all_of_part(&self) -> String {
        self.part.as_ref().map_or_else(|| self.full.clone(), |part| format!("{part}.{}", self.full))
    }

    /// Returns the name for the Cryptomatte conventions: prefixed with that of the part if the channel belongs to no layer.
    pub(crate) fn with_part(&self) -> String {
        match &self.part {
            Some(part) if !self.full.contains('.') => format!("{part}.{}", self.full),
            _ => self.full.clone(),
        }
    }
}

/// Returns which of the two screen components a name denotes.
pub(crate) fn axis_of(component: &str) -> Option<usize> {
    VECTOR_COMPONENTS.iter().find_map(|pair| pair.iter().position(|name| component.eq_ignore_ascii_case(name)))
}
