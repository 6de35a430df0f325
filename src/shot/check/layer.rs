//! Rules of `[[layer]]`: names, lattice, solver settings.
//!
//! In: raw layers. Out: [`Layer`]s, step and strength of the shot applied.

use super::{Check, LayerDefaults};
use crate::lattice::Basis;
use crate::shot::raw::{RawBox, RawLattice, RawLayer, RawPreset, RawSolve};
use crate::shot::{BoxRule, Layer};
use crate::solve::{Energy, Settings};
use crate::space::{ScreenBox, ScreenPoint};

impl Check<'_> {
    pub(super) fn layers(&mut self, raw: Vec<RawLayer>, shot: &LayerDefaults) -> Vec<Layer> {
        let layers: Vec<Layer> = raw.into_iter().enumerate().map(|(i, raw)| self.layer(raw, i, shot)).collect();
        let names = layers.iter().enumerate().map(|(i, layer)| (format!("layer[{i}].name"), layer.name.as_str()));
        self.unique(names, "layer");
        layers
    }

    fn layer(&mut self, raw: RawLayer, index: usize, shot: &LayerDefaults) -> Layer {
        let key = format!("layer[{index}]");
        let bounds = self.lattice(&raw.lattice, &format!("{key}.lattice"), shot);
        let transfer = raw.transfer.as_ref().map(|transfer| self.transfer(transfer, &key, shot));
        Layer {
            transfer,
            name: raw.name.unwrap_or_else(|| format!("layer{}", index + 1)),
            nodes: raw.nodes.unwrap_or_default(),
            dims: raw.lattice.dims,
            basis: raw.lattice.basis,
            bounds,
            settings: self.settings(&raw.solve, &format!("{key}.solve")),
            step: raw.step.unwrap_or(shot.step),
            strength: shot.strength * raw.strength,
            pins: self.pins(raw.pin, &key, shot),
            handles: self.handles(raw.handle, &key, raw.lattice.dims, shot),
        }
    }

    fn lattice(&mut self, raw: &RawLattice, key: &str, shot: &LayerDefaults) -> BoxRule {
        let least = raw.dims[0].min(raw.dims[1]);
        if raw.basis == Basis::Bspline && least < raw.basis.least_handles() {
            let needed = raw.basis.least_handles();
            let what = format!("a B-spline needs at least {needed} handles a side, found {least}");
            self.fault(&format!("{key}.dims"), what, "give 4 or more, or basis = \"bernstein\"");
        }
        match raw.bounds {
            RawBox::Follow => BoxRule::Follow,
            RawBox::Frame => BoxRule::Frame,
            RawBox::Fixed(corners) => self.fixed_box(corners, &format!("{key}.box.fixed"), shot),
        }
    }

    fn fixed_box(&mut self, [x0, y0, x1, y1]: [f64; 4], key: &str, shot: &LayerDefaults) -> BoxRule {
        self.screen_unit(&[x0, y0, x1, y1], key, shot);
        let (min, max) = (ScreenPoint::new(x0, y0), ScreenPoint::new(x1, y1));
        if x0 >= x1 || y0 >= y1 {
            let what = format!("the box from ({x0}, {y0}) to ({x1}, {y1}) is empty");
            self.fault(key, what, "give [left, bottom, right, top] with left < right and bottom < top, y up");
        }
        BoxRule::Fixed(ScreenBox::new(min, max))
    }

    fn settings(&mut self, raw: &RawSolve, key: &str) -> Settings {
        let parts = [
            ("energy", raw.energy.is_some()),
            ("regularizer", raw.regularizer.is_some()),
            ("weights", raw.weights.is_some()),
        ];
        if raw.preset.is_some() {
            for (part, _) in parts.iter().filter(|(_, is_given)| *is_given) {
                let what = "a preset decides this already";
                self.fault(&format!("{key}.{part}"), what, format!("remove `preset` or `{part}`"));
            }
        }
        let mut settings = match raw.preset {
            Some(RawPreset::Paper) => Settings::paper(),
            Some(RawPreset::Default) | None => Settings::default(),
        };
        settings.energy = raw.energy.unwrap_or(settings.energy);
        if let Some(regularizer) = raw.regularizer {
            settings = settings.with_regularizer(regularizer);
        }
        settings.weights = raw.weights.unwrap_or(settings.weights);
        if raw.weights.is_some() && !matches!(settings.energy, Energy::Edge | Energy::Vertex) {
            let hint = "add energy = \"edge\" or remove `weights`";
            self.fault(&format!("{key}.weights"), "only the energies \"edge\" and \"vertex\" have edge weights", hint);
        }
        settings
    }
}
