//! Validates `[[layer]]`: names, lattice, solver settings.
//!
//! In: raw layers. Out: [`Layer`]s, with the shot's step and strength applied.

use super::connectivity::SHAPE_HINT;
use super::select::nodes;
use super::{Check, Kind, LayerDefaults};
use crate::lattice::MAX_HANDLES_IN_ALL;
use crate::shot::raw::{
    RawAuto, RawAxis, RawBox, RawDims, RawLambdas, RawLattice, RawLayer, RawMatte, RawNamedMatte, RawPreset, RawSolve,
    RawSpace,
};
use crate::shot::{BoxOrientation, BoxRule, Layer, LayerSpace, Selection, Unmatted, WorldBoxRule};
use crate::solve::{Guard, Lambdas, Minima, OutsidePins, Regularizer, Sampling, Settings, Topology};
use crate::space::{ScreenBox, ScreenPoint};

/// Returns whether a layer moves a whole plate, not a part of it.
fn is_whole(layer: &RawLayer) -> bool {
    matches!(layer.matte, None | Some(RawMatte::Named(RawNamedMatte::None)))
}

impl Check<'_> {
    pub(super) fn layers(&mut self, raw: Vec<RawLayer>, shot: &LayerDefaults) -> Vec<Layer> {
        let of_layer = |raw: &RawLayer| raw.pin.iter().map(|pin| pin.mirror.clone()).collect();
        let followed = raw.iter().map(of_layer).collect();
        let mut layers: Vec<Layer> = raw.into_iter().enumerate().map(|(i, raw)| self.layer(raw, i, shot)).collect();
        self.mirrored_pins(&mut layers, &followed);
        let names = layers.iter().enumerate().map(|(i, layer)| (format!("layer[{i}].name"), layer.name.as_str()));
        self.unique(names, "layer");
        self.rest_layers(&layers);
        layers
    }

    fn layer(&mut self, raw: RawLayer, index: usize, shot: &LayerDefaults) -> Layer {
        let key = format!("layer[{index}]");
        let shot = &LayerDefaults { space: raw.lattice.space, ..*shot };
        let space = self.lattice(&raw, &format!("{key}.lattice"), shot);
        self.plate_layer(&raw, &key, shot);
        let transfer = raw.transfer.as_ref().map(|transfer| self.transfer(transfer, &key, shot));
        let settings = self.settings((&raw.solve, &raw.lattice), &format!("{key}.solve"));
        let topology = self.topology(&raw, (&settings, shot), &key);
        let settings = Settings { topology, ..settings };
        let (nodes, is_rest) = nodes(raw.nodes);
        let selection = Selection { is_rest, ..self.selection(&raw.select, &key, shot) };
        let handles = self.handles(raw.handle, &key, space.dims(), shot);
        let pins = self.pins(raw.pin, &key, shot);
        let (stiffness, strokes) = self.stiffness(raw.stiffness, &key);
        if let Some(pin) = pins.iter().position(|pin| !pin.order.is_empty())
            && topology == Topology::Plain
            && shot.source == Kind::Images
        {
            let hint = "add topology = \"branching\" to `lattice`";
            self.fault(&format!("{key}.pin[{pin}].order"), "it acts on branching lattices only", hint);
        }
        Layer {
            nodes,
            selection,
            transfer,
            unmatted: match raw.matte {
                Some(RawMatte::Named(RawNamedMatte::None)) => Unmatted::Picture,
                Some(RawMatte::Named(RawNamedMatte::Nodes)) => Unmatted::Nodes,
                _ => Unmatted::OwnNodes,
            },
            matte: raw.matte.as_ref().and_then(|matte| self.matte(matte, &format!("{key}.matte"), shot)),
            name: raw.name.unwrap_or_else(|| format!("layer{}", index + 1)),
            space,
            orientation: self.orientation(&raw.lattice, &key, shot),
            has_auto_dims: self.has_auto_dims(&raw.lattice, !handles.is_empty(), &key),
            has_auto_topology: raw.lattice.topology.is_none(),
            connectivity: self.connectivity(&raw.lattice, topology, (&key, shot)),
            basis: raw.lattice.basis,
            settings,
            step: raw.step.unwrap_or(shot.step),
            strength: if raw.mute { 0.0 } else { shot.strength * raw.strength },
            is_muted: raw.mute,
            stiffness,
            strokes,
            symmetry: raw.symmetry.map(|raw| self.symmetry(raw, &key, shot)),
            pins,
            handles,
        }
    }

    fn lattice(&mut self, layer: &RawLayer, key: &str, shot: &LayerDefaults) -> LayerSpace {
        let raw = &layer.lattice;
        let default = match raw.space {
            // The border of a whole picture is fixed, so a finer grid gives the interior the usual freedom.
            RawSpace::Screen if shot.source == Kind::Frame && is_whole(layer) => [16, 16, 1],
            RawSpace::Screen => [10, 10, 1],
            RawSpace::World => [5, 5, 5],
        };
        let dims = self.dims(raw, &format!("{key}.dims"), default);
        match shot.space {
            RawSpace::Screen => {
                LayerSpace::Screen { dims: [dims[0], dims[1]], bounds: self.screen_box(raw, key, shot) }
            }
            RawSpace::World => LayerSpace::World { dims, bounds: self.world_box(raw, key) },
        }
    }

    /// Returns whether the dims are chosen automatically.
    fn has_auto_dims(&mut self, raw: &RawLattice, has_handles: bool, key: &str) -> bool {
        let is_auto = matches!(raw.dims, Some(RawDims::Auto(RawAuto::Auto)));
        let faults = [
            (raw.space == RawSpace::World, "chooses handles of the screen only"),
            (has_handles, "cannot be used where handles are moved one by one"),
            (!raw.basis.can_branch(), "needs basis = \"bspline\" or \"bilinear\""),
        ];
        for (_, what) in faults.iter().filter(|(is_fault, _)| is_auto && *is_fault) {
            self.fault(&format!("{key}.lattice.dims"), format!("dims = \"auto\" {what}"), "give numbers");
        }
        is_auto
    }

    /// Returns the handle counts along x, y and z; 1 along an axis that the lattice lacks.
    fn dims(&mut self, raw: &RawLattice, key: &str, default: [usize; 3]) -> [usize; 3] {
        let axes = match raw.space {
            RawSpace::Screen => 2,
            RawSpace::World => 3,
        };
        let Some(RawDims::Counts(given)) = &raw.dims else { return default };
        if given.len() != axes {
            let (what, hint) = match raw.space {
                RawSpace::Screen => {
                    ("three axes need a lattice in the scene", "add space = \"world\", or give [across, up]")
                }
                RawSpace::World => ("a lattice in the scene has three axes", "give [x, y, z], for example [5, 5, 5]"),
            };
            self.fault(key, what, hint);
            return default;
        }
        let least = given.iter().copied().min().unwrap_or(0);
        if least < raw.basis.min_handles() {
            let needed = raw.basis.min_handles();
            let what = format!("the {} basis needs at least {needed} handles a side, found {least}", raw.basis.label());
            self.fault(key, what, format!("give {needed} or more, or basis = \"bernstein\""));
        }
        let count = given.iter().copied().fold(1, usize::saturating_mul);
        if count > MAX_HANDLES_IN_ALL {
            let what = format!("a lattice of {count} handles is too large to solve");
            self.fault(key, what, format!("keep the product of all sides within {MAX_HANDLES_IN_ALL}"));
        }
        std::array::from_fn(|axis| given.get(axis).copied().unwrap_or(1))
    }

    fn screen_box(&mut self, raw: &RawLattice, key: &str, shot: &LayerDefaults) -> BoxRule {
        match &raw.bounds {
            // A plate has no moving geometry that a box could follow.
            RawBox::Follow if shot.source == Kind::Frame => BoxRule::Frame,
            RawBox::Follow => BoxRule::Follow,
            RawBox::Frame => BoxRule::Frame,
            RawBox::Fixed(corners) => self.fixed_box(corners, &format!("{key}.box.fixed"), shot),
        }
    }

    /// Returns the orientation of the box.
    fn orientation(&mut self, raw: &RawLattice, layer: &str, shot: &LayerDefaults) -> BoxOrientation {
        let Some(frame) = &raw.frame else { return BoxOrientation::default() };
        let key = format!("{layer}.lattice.frame");
        let is_world = raw.space == RawSpace::World;
        let is_whole_frame = match raw.bounds {
            RawBox::Frame => true,
            RawBox::Follow => shot.source == Kind::Frame,
            RawBox::Fixed(_) => false,
        };
        let faults = [
            (frame.node.is_none() && frame.angle.is_none(), "names no node and no angle", "add `node` or `angle`"),
            (frame.node.is_none() && frame.axis.is_some(), "has an axis, but no node", "add `node`, or remove `axis`"),
            (
                frame.node.is_some() && shot.source != Kind::Scene,
                "needs the nodes of a `scene`",
                "give an angle instead",
            ),
            (is_whole_frame && !is_world, "cannot turn the box of the whole frame", "give box = { fixed = [..] }"),
            (is_world && frame.angle.is_some(), "has an angle, which the screen alone has", "remove `angle`"),
            (is_world && frame.axis.is_some(), "has an axis; boxes in the scene take all three", "remove `axis`"),
            (is_world && matches!(raw.bounds, RawBox::Fixed(_)), "cannot turn a fixed box", "remove `box`"),
        ];
        if let Some((_, what, hint)) = faults.into_iter().find(|(is_fault, ..)| *is_fault) {
            self.fault(&key, what, hint);
        }
        let axis = frame.axis.unwrap_or(RawAxis::Y).index();
        let node = frame.node.clone().map(|node| (node, axis));
        BoxOrientation { node, angle: frame.angle.unwrap_or(0.0).to_radians() }
    }

    fn fixed_box(&mut self, corners: &[f64], key: &str, shot: &LayerDefaults) -> BoxRule {
        let &[x0, y0, x1, y1] = corners else {
            let what = format!("a box on the screen has 4 numbers, found {}", corners.len());
            self.fault(key, what, "give [left, bottom, right, top], or lattice = { space = \"world\", .. }");
            return BoxRule::Follow;
        };
        self.screen_unit(corners, key, shot);
        let (min, max) = (ScreenPoint::new(x0, y0), ScreenPoint::new(x1, y1));
        if x0 >= x1 || y0 >= y1 {
            let what = format!("the box from ({x0}, {y0}) to ({x1}, {y1}) is empty");
            self.fault(key, what, "give [left, bottom, right, top] with left < right and bottom < top, y up");
        }
        BoxRule::Fixed(ScreenBox::new(min, max))
    }

    fn world_box(&mut self, raw: &RawLattice, key: &str) -> WorldBoxRule {
        let corners = match &raw.bounds {
            RawBox::Follow => return WorldBoxRule::Follow,
            RawBox::Frame => {
                let hint = "give box = \"follow\" or { fixed = [x0, y0, z0, x1, y1, z1] }";
                self.fault(&format!("{key}.box"), "the frame is no box of the scene", hint);
                return WorldBoxRule::Follow;
            }
            RawBox::Fixed(corners) => corners,
        };
        let (key, order) =
            (format!("{key}.box.fixed"), "give [x0, y0, z0, x1, y1, z1], the lower corner first, metres");
        let &[x0, y0, z0, x1, y1, z1] = corners.as_slice() else {
            self.fault(&key, format!("a box of the scene has 6 numbers, found {}", corners.len()), order);
            return WorldBoxRule::Follow;
        };
        let (lo, hi) = ([x0, y0, z0], [x1, y1, z1]);
        if lo.iter().zip(hi).any(|(lo, hi)| *lo >= hi) {
            self.fault(&key, format!("the box from {lo:?} to {hi:?} is empty"), order);
        }
        WorldBoxRule::Fixed([lo, hi])
    }

    /// Returns the topology of a layer's lattice. Unless the shot says otherwise, lattices on the screen over pictures
    /// and scenes branch where they can.
    fn topology(&mut self, raw: &RawLayer, (settings, shot): (&Settings, &LayerDefaults), key: &str) -> Topology {
        let faults = [
            (shot.source == Kind::Frame, "needs a shape", SHAPE_HINT),
            (
                !raw.lattice.basis.can_branch(),
                "needs a basis with local support and no diagonals",
                "use basis = \"bspline\" or \"bilinear\"",
            ),
        ];
        let faults =
            faults.into_iter().filter(|(is_fault, ..)| *is_fault).map(|(_, what, hint)| (what.to_owned(), hint));
        let of_solver = settings.branching_fault().map(|[what, hint]| (format!("cannot have {what}"), hint));
        let mut faults = faults.chain(of_solver).peekable();
        let branches = matches!(shot.space, RawSpace::Screen) && faults.peek().is_none();
        let default = if branches { Topology::Branching } else { Topology::Plain };
        let topology = raw.lattice.topology.unwrap_or(default);
        if topology == Topology::Branching {
            for (what, hint) in faults {
                let hint = format!("{hint}, or set topology = \"plain\"");
                self.fault(&format!("{key}.lattice.topology"), format!("a branching lattice {what}"), hint);
            }
        }
        topology
    }

    fn settings(&mut self, (raw, lattice): (&RawSolve, &RawLattice), key: &str) -> Settings {
        let parts = [
            ("energy", raw.energy.is_some()),
            ("regularizer", raw.regularizer.is_some()),
            ("weights", raw.weights.is_some()),
            ("lambdas", raw.lambdas.is_some()),
            ("iterations", raw.iterations.is_some()),
        ];
        if raw.preset.is_some() {
            for (part, _) in parts.iter().filter(|(_, is_given)| *is_given) {
                let what = "is already set by the preset";
                self.fault(&format!("{key}.{part}"), what, format!("remove `preset` or `{part}`"));
            }
        }
        let mut settings = match raw.preset {
            Some(RawPreset::Paper) => Settings::paper(),
            Some(RawPreset::Default) | None => Settings { temporal: Settings::TEMPORAL, ..Settings::default() },
        };
        // Frames solved individually use the minimum that the rigid fit leads to, which varies continuously from frame
        // to frame. In a solve over time, the first knot searches for the lowest minimum, and the others follow it.
        settings.minima = Minima::Nearest;
        settings.energy = raw.energy.unwrap_or(settings.energy);
        if let Some(lambdas) = raw.lambdas {
            settings = weighted(settings, (lambdas, raw.regularizer));
        } else if let Some(regularizer) = raw.regularizer {
            settings = settings.with_regularizer(regularizer);
        }
        if let Some(iterations) = raw.iterations {
            (settings.iteration_limit, settings.acceleration, settings.tolerance) = (iterations as usize, 0, -1.0);
        }
        settings.weights = raw.weights.unwrap_or(settings.weights);
        settings.guard = raw.guard.unwrap_or(default_guard(raw, lattice));
        if raw.weights.is_some() && !settings.energy.has_edge_weights() {
            let hint = "add energy = \"edge\" or remove `weights`";
            self.fault(&format!("{key}.weights"), "only the energies \"edge\" and \"vertex\" have edge weights", hint);
        }
        settings.max_stretch = raw.max_stretch.unwrap_or(settings.max_stretch);
        settings.temporal = raw.temporal.unwrap_or(settings.temporal);
        settings.with_smoothness(raw.smoothness.unwrap_or(1.0))
    }
}

/// Returns the guard of a layer that names none: folds are prevented on the screen. They are reported in space and with Bernstein
/// polynomials, where preventing them takes long, and with the published method, the weights of problem files or a fixed number of
/// iterations.
fn default_guard(raw: &RawSolve, lattice: &RawLattice) -> Guard {
    let is_reference =
        matches!(raw.preset, Some(RawPreset::Paper)) || raw.lambdas.is_some() || raw.iterations.is_some();
    match lattice.space {
        RawSpace::Screen if !is_reference && lattice.basis.is_local() => Guard::Limit,
        RawSpace::Screen | RawSpace::World => Guard::Report,
    }
}

/// Returns settings with the terms weighted as in problem files: plain sums, and pins that are held by their weight.
fn weighted(settings: Settings, (raw, regularizer): (RawLambdas, Option<Regularizer>)) -> Settings {
    let paper = Settings::paper();
    let settings = Settings {
        scaling: paper.scaling,
        sampling: Sampling::Centroids,
        start: paper.start,
        pin_hold: paper.pin_hold,
        disc: paper.disc,
        outside_pins: OutsidePins::Extended,
        lambdas: paper.lambdas,
        // Sums grow with the model, so a weight between frames would mean another thing for each.
        temporal: paper.temporal,
        ..settings
    };
    let settings = settings.clone().with_regularizer(regularizer.unwrap_or(settings.regularizer));
    let usual = settings.lambdas;
    let lambdas = Lambdas {
        shape: raw.ml.unwrap_or(usual.shape),
        pins: raw.mp.unwrap_or(usual.pins),
        handles: raw.gp.unwrap_or(usual.handles),
        regularizer: raw.gr.unwrap_or(usual.regularizer),
    };
    Settings { lambdas, ..settings }
}
