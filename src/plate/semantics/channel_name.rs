//! The name of a channel, taken apart.
//!
//! In: names of the part, the view and the channel. Out: layer, view and component.

use super::word_of;

/// Views that files name without saying so in their metadata.
const COMMON_VIEWS: [&str; 2] = ["left", "right"];

/// Names of the two components of a vector on the screen, in their order.
pub(crate) const VECTOR_COMPONENTS: [[&str; 2]; 7] =
    [["u", "v"], ["x", "y"], ["r", "g"], ["z", "w"], ["nx", "ny"], ["red", "green"], ["horizontal", "vertical"]];

/// The name of a channel: `ViewLayer.Vector.left.X` in a part `main`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ChannelName {
    /// As in the file.
    pub(crate) full: String,
    /// Name of its part.
    pub(crate) part: Option<String>,
    /// The view it shows: `left`; `None` for the only one, or for the first of several.
    pub(crate) view: Option<String>,
    /// What stands before the last dot, without the view: `ViewLayer`, `Vector`.
    pub(crate) segments: Vec<String>,
    /// What stands after the last dot: `X`.
    pub(crate) component: String,
    /// Components of the same layer, this one included, in lower case.
    pub(crate) siblings: Vec<String>,
    /// Its layer as one word, or its part's where it stands in none.
    word: Option<String>,
}

impl ChannelName {
    /// Takes the names of a part's channels apart.
    ///
    /// `views` are those that share the part, the first of them being that of channels which name none.
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
        // Of `rgba_left` and `depth.left` in a part's name the view says nothing about the channels either.
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

    /// Its layer as one word, or its part's where it stands in none.
    pub(crate) fn layer_word(&self) -> Option<&str> {
        self.word.as_deref()
    }

    /// Whether its layer has such a component too.
    pub(super) fn has_sibling(&self, component: &str) -> bool {
        self.siblings.iter().any(|sibling| sibling == component)
    }

    /// Whether its layer holds vectors.
    pub(super) fn has_vector_siblings(&self) -> bool {
        [("x", "y"), ("u", "v")].iter().any(|(a, b)| self.has_sibling(a) && self.has_sibling(b))
    }

    /// The name with its part's in front: `mask_left.mask.A`.
    pub(crate) fn with_all_of_part(&self) -> String {
        self.part.as_ref().map_or_else(|| self.full.clone(), |part| format!("{part}.{}", self.full))
    }

    /// The name as Cryptomatte's rules read it: with the part's in front where it stands in no layer.
    pub(crate) fn with_part(&self) -> String {
        match &self.part {
            Some(part) if !self.full.contains('.') => format!("{part}.{}", self.full),
            _ => self.full.clone(),
        }
    }
}

/// Which of the two components on the screen a name means.
pub(crate) fn axis_of(component: &str) -> Option<usize> {
    VECTOR_COMPONENTS.iter().find_map(|pair| pair.iter().position(|name| component.eq_ignore_ascii_case(name)))
}
