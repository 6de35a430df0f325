//! Lattices that were solved for another shot: loaded once, laid over a layer in every frame.
//!
//! In: lattice files that layers name. Out: [`Loaded`] lattices, and the layer's state at a frame.

use super::layer_pins::unmeasured;
use super::{LayerState, PipelineError};
use crate::export::{LatticeFile, Track, lattice_at};
use crate::lattice::{Lattice, LatticeFit};
use crate::shot::{Layer, Shot, Transfer, TransferFit};
use crate::solve::{Solution, SolveReport};
use crate::space::ScreenBox;
use crate::spelling;
use std::collections::BTreeMap;

/// A lattice that was turned by its landmarks is told when it is farther off than this, pixels.
const TURNED_TOLERANCE_PX: f64 = 0.1;

/// The lattices of a file, in frames of the shot that shows them.
#[derive(Clone, Debug)]
pub(super) struct Loaded {
    lattices: BTreeMap<i32, Lattice<2>>,
}

/// Loads what the layers name: one a layer.
pub(super) fn load(shot: &Shot, notes: &mut Vec<String>) -> Result<Vec<Option<Loaded>>, PipelineError> {
    let mut loaded = Vec::with_capacity(shot.layers.len());
    for (index, layer) in shot.layers.iter().enumerate() {
        loaded.push(match &layer.transfer {
            Some(transfer) => Some(load_one(shot, index, transfer, notes)?),
            None => None,
        });
    }
    Ok(loaded)
}

fn load_one(shot: &Shot, index: usize, transfer: &Transfer, notes: &mut Vec<String>) -> Result<Loaded, PipelineError> {
    let mut file = LatticeFile::read(&transfer.file)?;
    let key = format!("layer[{index}].transfer");
    let names: Vec<String> = file.layers.iter().map(|layer| layer.name.clone()).collect();
    let place = match &transfer.layer {
        Some(name) => names.iter().position(|other| other == name).ok_or_else(|| {
            let what = format!("{} has no layer '{name}'", transfer.file.display());
            let hint = spelling::hint(name, names.iter().map(String::as_str));
            PipelineError::mismatch(shot, &format!("{key}.layer"), what, hint)
        })?,
        None if names.len() == 1 => 0,
        None => {
            let what = format!("{} has {} layers", transfer.file.display(), names.len());
            let hint = format!("add `layer = ..`; {}", spelling::list(names.iter().map(String::as_str)));
            return Err(PipelineError::mismatch(shot, &key, what, hint));
        }
    };
    if !file.layers[place].branches.is_empty() {
        let what = format!("the lattice '{}' of {} branches", names[place], transfer.file.display());
        let hint = "warp the rendered frames of the new subject with it (`pinwarp warp --lattice`), or export it with \
                    topology = \"plain\"";
        return Err(PipelineError::mismatch(shot, &key, what, hint));
    }
    let Track::Screen(lattices) = file.layers.swap_remove(place).track else {
        let what = format!("'{}' is a lattice of the world, this layer is warped on the screen", names[place]);
        return Err(PipelineError::mismatch(shot, &key, what, "take a layer that was solved on the screen"));
    };
    let shift = match (transfer.start, lattices.keys().next()) {
        (Some(start), Some(first)) => start - first,
        _ => 0,
    };
    let lattices: BTreeMap<_, _> = lattices.into_iter().map(|(frame, lattice)| (frame + shift, lattice)).collect();
    if let (Some((&first, _)), Some((&last, _))) = (lattices.first_key_value(), lattices.last_key_value())
        && (first > shot.frames.first || last < shot.frames.last)
    {
        let name = &shot.layers[index].name;
        notes.push(format!("layer '{name}': its lattices cover frames {first} to {last}; beyond them the ends hold"));
    }
    Ok(Loaded { lattices })
}

impl Loaded {
    /// The layer's lattice at a (fractional) frame of its keys; `rest_box` gives the box it is laid over, where it is wanted.
    pub(super) fn state(
        &self,
        shot: &Shot,
        layer: &Layer,
        key_frame: f64,
        rest_box: impl FnOnce() -> Option<ScreenBox>,
    ) -> LayerState {
        let source = lattice_at(&self.lattices, key_frame);
        let fit = match layer.transfer.as_ref().map(|transfer| &transfer.fit) {
            Some(TransferFit::AsIs) => LatticeFit::AsIs,
            Some(TransferFit::Landmarks(pairs)) => LatticeFit::Landmarks(pairs.clone()),
            Some(TransferFit::Box) | None => match rest_box() {
                Some(target) => LatticeFit::Box(target),
                None => return LayerState::default(),
            },
        };
        let fitted = source.transferred(&fit);
        let lattice = fitted.lattice.with_strength(layer.strength);
        let mut report = report_of(&lattice);
        let error_px = fitted.error * f64::from(shot.size.height);
        if error_px > TURNED_TOLERANCE_PX {
            let text = format!("turned by its landmarks, the lattice follows its source within {error_px:.2} px only");
            report.warnings.push(text);
        }
        LayerState { solution: Some(Solution { lattice, branches: None, report }), ..LayerState::default() }
    }
}

/// What can be said of a lattice that nobody solved here: every cell counts as holding some of the model, and distortion
/// is not measured.
fn report_of(lattice: &Lattice<2>) -> SolveReport {
    let folds = lattice.folds(&vec![true; lattice.grid.cell_count()]);
    SolveReport {
        folded_cells: folds.cells.len(),
        folded_model_cells: folds.active_count,
        min_cell_det: folds.min_det,
        is_converged: true,
        ..unmeasured(SolveReport::default())
    }
}
