//! Exports the scene of a shot as a file, and prepares shots of single layers for other programs.
//!
//! In: a [`PreparedShot`]. Out: a packed glTF file, with textured cards if the shot has pictures; a shot of one layer.

use super::Gallery;
use crate::export::gltf::packed_cards;
use crate::image::{png_bytes, preview};
use crate::pipeline::{PipelineError, PreparedShot};
use crate::scene::{FileAccess, Packed, pack};
use crate::shot::Shot;
use std::path::PathBuf;

impl PreparedShot {
    /// Returns the scene as an editable glTF file.
    ///
    /// # Errors
    /// [`PipelineError`] if the scene file cannot be read, or the shot has neither a scene nor pictures.
    pub(crate) fn packed(&self) -> Result<Packed, PipelineError> {
        if let Some(gallery) = &self.gallery {
            return Ok(packed_cards(&self.scene, self.shot.size.aspect(), &gallery.png_files()?));
        }
        let Some(scene) = self.shot.scene() else {
            return Err(PipelineError::Unusable {
                what: "the shot has no scene and no pictures that could be exported".into(),
                hint: "give `scene`, a .gltf or .glb file, or `image`".into(),
            });
        };
        let access = if self.shot.allow_outside { FileAccess::Anywhere } else { FileAccess::SceneFolder };
        let mut packed = pack(scene, access)?;
        for &node in &self.draw_inputs.hidden_nodes {
            let node = &mut packed.json["nodes"][self.scene.file_from_scene[node]];
            node.as_object_mut().and_then(|node| node.remove("mesh"));
        }
        Ok(packed)
    }

    /// Returns the shot with the pictures of one layer only, at rest; `None` if it is not a shot of pictures.
    ///
    /// # Errors
    /// As [`PreparedShot::new`].
    pub(crate) fn pictures_of(&self, layer: usize, output: PathBuf) -> Result<Option<Self>, PipelineError> {
        if self.gallery.is_none() {
            return Ok(None);
        }
        let mut shot = Shot { layers: Vec::new(), ..self.shot.clone() };
        shot.output.path = output;
        let mut alone = Self::new(shot)?;
        if let Some(gallery) = &mut alone.gallery {
            gallery.blank_all_but(&self.assignment.parts_of_layer[layer]);
        }
        Ok(Some(alone))
    }
}

impl Gallery {
    /// Encodes each picture as an 8-bit sRGB PNG of the frame's size.
    fn png_files(&self) -> Result<Vec<Vec<u8>>, PipelineError> {
        let file = |flat_picture: &super::FlatPicture| {
            png_bytes(&flat_picture.path, &preview(&flat_picture.plate.clone().into_frame()))
        };
        Ok(self.flat_pictures.iter().map(file).collect::<Result<_, _>>()?)
    }

    fn blank_all_but(&mut self, shown: &[usize]) {
        let hidden = self.flat_pictures.iter_mut().enumerate().filter(|(index, _)| !shown.contains(index));
        hidden.for_each(|(_, flat_picture)| *flat_picture = flat_picture.blank());
    }
}
