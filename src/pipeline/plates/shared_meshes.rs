//! Warps the layers that share meshes as one: their warps blend along the surface, which no matte can express.
//!
//! In: a [`PreparedShot`] with such layers. Out: the [`LayerJob`] that moves all of them, from the scene drawn before
//! and after the warp.

use super::SurfaceMaps;
use super::at_rest::SceneAtRest;
use crate::image::Plate;
use crate::image::cryptomatte::clean_name;
use crate::pipeline::{PipelineError, PreparedShot};
use crate::plate::{Field, LayerJob, WarpSettings, has_motion, mattes_of_names};
use crate::raster::{DeviceChoice, MATTE_LAYERS};
use crate::space::FrameWindow;
use std::collections::BTreeSet;

/// The layers of a shot that share meshes, and all that they move.
#[derive(Debug)]
pub(super) struct SharedGroup {
    /// Indices of the layers.
    pub(super) layers: Vec<usize>,
    /// Indices of the nodes with their meshes.
    pub(super) nodes: BTreeSet<usize>,
    /// Names of the nodes, as in Cryptomattes.
    names: Vec<String>,
}

/// Warps the layers of a group.
pub(super) struct SharedMeshes<'a> {
    prepared: &'a PreparedShot,
    device: &'a DeviceChoice,
    group: &'a SharedGroup,
    /// Opened for the size of the first plate, and again for plates of another size.
    maps: Option<SurfaceMaps<'a>>,
    scene: Option<SceneAtRest<'a>>,
}

impl SharedGroup {
    /// Finds the layers; `None` if there are none, if not all of them are among the `chosen` ones, if another layer
    /// bends the whole picture, or if the names of their nodes do not identify what they move.
    pub(super) fn of(prepared: &PreparedShot, chosen: &[usize]) -> Option<Self> {
        let (assignment, shot) = (&prepared.assignment, &prepared.shot);
        let layers: Vec<usize> = (0..shot.layers.len()).filter(|&layer| assignment.is_sharing[layer]).collect();
        let is_moved = |layer: &&usize| shot.layers[**layer].is_moved();
        let moved: Vec<usize> = layers.iter().filter(is_moved).copied().collect();
        let are_chosen = moved.iter().all(|layer| chosen.contains(layer) && prepared.moves_own_nodes(*layer));
        let bends_all = |&layer: &usize| shot.layers[layer].matte.is_none() && !prepared.moves_own_nodes(layer);
        if moved.is_empty() || !are_chosen || chosen.iter().filter(is_moved).any(bends_all) {
            return None;
        }
        let in_group = |part: &usize| {
            assignment.shared_parts[*part].is_some()
                || assignment.layer_of_part[*part].is_some_and(|layer| layers.contains(&layer))
        };
        let parts = 0..assignment.node_of_part.len();
        let nodes: BTreeSet<usize> = parts.clone().filter(in_group).map(|part| assignment.node_of_part[part]).collect();
        let name_of = |node: usize| clean_name(&prepared.scene.nodes[node].name);
        let names: BTreeSet<String> = nodes.iter().map(|&node| name_of(node)).collect();
        let others = parts.map(|part| assignment.node_of_part[part]).filter(|node| !nodes.contains(node));
        let is_known = others.map(name_of).all(|name| !names.contains(&name));
        let names = names.into_iter().collect();
        is_known.then_some(Self { layers, nodes, names })
    }
}

impl<'a> SharedMeshes<'a> {
    /// Creates the warp of a group.
    pub(super) const fn new(prepared: &'a PreparedShot, device: &'a DeviceChoice, group: &'a SharedGroup) -> Self {
        Self { prepared, device, group, maps: None, scene: None }
    }

    /// Indices of the layers.
    pub(super) fn layers(&self) -> &[usize] {
        &self.group.layers
    }

    /// Returns the job that moves all of them in a frame's plate.
    pub(super) fn job(
        &mut self,
        frame: i32,
        (plate, settings): (&Plate, &WarpSettings),
    ) -> Result<LayerJob, PipelineError> {
        let [previous, next] = if has_motion(plate, settings) {
            [Some(self.field(frame - 1, plate)?), Some(self.field(frame + 1, plate)?)]
        } else {
            [None, None]
        };
        let field = self.field(frame, plate)?;
        let names: Vec<&str> =
            self.group.layers.iter().map(|&layer| self.prepared.shot.layers[layer].name.as_str()).collect();
        let of_nodes = std::slice::from_ref(&self.group.names);
        let mattes = match mattes_of_names(plate, of_nodes, settings) {
            Some(mattes) => mattes,
            None => {
                let scene = self.scene.get_or_insert_with(|| SceneAtRest::new(self.prepared, self.device, Vec::new()));
                scene.mattes(frame, plate, (MATTE_LAYERS[0], of_nodes))?
            }
        };
        Ok(LayerJob { name: names.join(", "), field, previous, next, matte: mattes.into_iter().next(), front: None })
    }

    /// Returns the warp of a frame, at the pixels of a plate and of its display window.
    fn field(&mut self, frame: i32, plate: &Plate) -> Result<Field, PipelineError> {
        let size = plate.frame_size();
        let place = FrameWindow { frame: size, window: size.window().union(plate.reach()) };
        let mut maps = match self.maps.take().filter(|maps| maps.place() == place) {
            Some(maps) => maps,
            None => SurfaceMaps::new(self.prepared, place)?.of_nodes(self.group.nodes.clone()),
        };
        let pictures = maps.pictures(self.prepared.mid_exposure_time(f64::from(frame)));
        self.maps = Some(maps);
        Ok(Field::of_surfaces(pictures?, size))
    }
}
