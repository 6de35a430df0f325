//! Finds nodes, cameras and clips by the names used in shots.
//!
//! In: a scene and a name, number or pattern. Out: indices, or an error that suggests the nearest valid name.

use super::Scene;
use crate::spelling::{self, pluralised};

/// Something that a shot names but the scene does not have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FindError {
    /// The scene has no camera; the caller may frame it automatically.
    #[error("the scene has no camera; add one to it, or place one with `camera` in the shot")]
    NoCamera,
    /// No camera of that name.
    #[error("the scene has no camera \"{name}\"; {hint}")]
    UnknownCamera {
        /// The requested name.
        name: String,
        /// The nearest valid name, or all of them.
        hint: String,
    },
    /// No clip of that name.
    #[error("the scene has no clip \"{name}\"; {hint}")]
    UnknownClip {
        /// The requested name.
        name: String,
        /// The nearest valid name, or all of them.
        hint: String,
    },
    /// A clip index out of range.
    #[error("the scene has {}, there is no clip {index} (the first is 0)", pluralised(*count, "clip", "clips"))]
    ClipOutOfRange {
        /// The requested index.
        index: usize,
        /// Number of clips.
        count: usize,
    },
}

impl Scene {
    /// Returns the first node of that name.
    #[must_use]
    pub fn node_named(&self, name: &str) -> Option<usize> {
        self.nodes.iter().position(|node| node.name == name)
    }

    /// Returns the node of a camera: by node name, then by camera name; `None`: the first in node order.
    ///
    /// ```
    /// use pinwarp::scene::{FindError, Scene};
    /// assert_eq!(Scene::default().find_camera(None), Err(FindError::NoCamera));
    /// ```
    ///
    /// # Errors
    /// [`FindError::NoCamera`] if the scene has none, [`FindError::UnknownCamera`] if none has that name.
    pub fn find_camera(&self, name: Option<&str>) -> Result<usize, FindError> {
        let cameras: Vec<(usize, &str, &str)> = self
            .nodes
            .iter()
            .enumerate()
            .filter_map(|(index, node)| {
                Some((index, node.name.as_str(), self.cameras.get(node.camera?)?.name.as_str()))
            })
            .collect();
        let Some(&(first, ..)) = cameras.first() else { return Err(FindError::NoCamera) };
        let Some(name) = name else { return Ok(first) };
        let by_node = cameras.iter().find(|(_, node, _)| *node == name);
        let found = by_node.or_else(|| cameras.iter().find(|(.., camera)| *camera == name));
        let names = || cameras.iter().flat_map(|(_, node, camera)| [*node, *camera]).filter(|name| !name.is_empty());
        found
            .map(|(index, ..)| *index)
            .ok_or_else(|| FindError::UnknownCamera { name: name.to_owned(), hint: spelling::hint(name, names()) })
    }

    /// Returns the clip of that name, else of that index, else the first; `None` only if the scene has no clips and
    /// none was requested.
    ///
    /// ```
    /// use pinwarp::scene::{Clip, Scene};
    /// let mut walk = Clip::default();
    /// walk.name = "Walk".into();
    /// let scene = Scene { clips: vec![walk], ..Scene::default() };
    /// assert_eq!(scene.find_clip(Some("Walk"), None)?, Some(0));
    /// assert!(scene.find_clip(Some("walk"), None).unwrap_err().to_string().contains("did you mean \"Walk\"?"));
    /// # Ok::<(), pinwarp::scene::FindError>(())
    /// ```
    ///
    /// # Errors
    /// [`FindError::UnknownClip`] or [`FindError::ClipOutOfRange`].
    pub fn find_clip(&self, name: Option<&str>, index: Option<usize>) -> Result<Option<usize>, FindError> {
        let count = self.clips.len();
        match (name, index) {
            (Some(name), _) => match self.clips.iter().position(|clip| clip.name == name) {
                Some(index) => Ok(Some(index)),
                None => Err(FindError::UnknownClip {
                    name: name.to_owned(),
                    hint: spelling::hint(name, self.clips.iter().map(|clip| clip.name.as_str())),
                }),
            },
            (None, Some(index)) if index >= count => Err(FindError::ClipOutOfRange { index, count }),
            (None, Some(index)) => Ok(Some(index)),
            (None, None) => Ok((count > 0).then_some(0)),
        }
    }

    /// Returns `node` and all its descendants, in node order; empty if there is no such node.
    #[must_use]
    pub(crate) fn subtree(&self, node: usize) -> Vec<usize> {
        let mut is_inside = vec![false; self.nodes.len()];
        for index in node..self.nodes.len() {
            // Parents come first, so theirs is already known.
            is_inside[index] = index == node || self.nodes[index].parent.is_some_and(|parent| is_inside[parent]);
        }
        (0..is_inside.len()).filter(|&index| is_inside[index]).collect()
    }

    /// Returns the nodes whose names match a pattern, in node order: `*` matches any characters, `?` a single one.
    ///
    /// ```
    /// use pinwarp::scene::Scene;
    /// assert!(Scene::default().matching("Teapot*").is_empty());
    /// ```
    #[must_use]
    pub fn matching(&self, pattern: &str) -> Vec<usize> {
        (0..self.nodes.len()).filter(|&index| spelling::matches_pattern(pattern, &self.nodes[index].name)).collect()
    }
}
