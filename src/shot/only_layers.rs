//! Restricts a shot to some of its layers.
//!
//! In: a [`Shot`], names. Out: the same shot, in which all other layers rest.

use super::{Layer, Shot};

impl Shot {
    /// Returns the same shot in which only the named layers are warped. The others keep their parts of the scene.
    #[must_use]
    pub(crate) fn with_only_layers(mut self, names: &[String]) -> Self {
        let is_wanted = |layer: &Layer| names.contains(&layer.name);
        let followed: Vec<usize> = self
            .layers
            .iter()
            .filter(|layer| is_wanted(layer))
            .flat_map(|layer| layer.pins.iter().filter_map(|pin| pin.mirror.map(|mirror| mirror.layer)))
            .collect();
        for (index, layer) in self.layers.iter_mut().enumerate().filter(|(_, layer)| !is_wanted(layer)) {
            // Mirrored pins of another layer still need the pins that they follow.
            layer.strength = 0.0;
            if !followed.contains(&index) {
                layer.pins.clear();
                layer.handles.clear();
                layer.transfer = None;
            }
        }
        self
    }
}
