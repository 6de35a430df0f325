//! Loads lattices that were solved for other shots, and fits them to layers in every frame.
//!
//! In: the lattice files named by layers. Out: [`Loaded`] lattices, and the state of a layer at a frame.

use super::transferred_branches::SourceFrame;
use crate::export::{LatticeFile, Track};
use crate::lattice::{Folds, LatticeFit};
use crate::pipeline::evaluate::layer_pins::unmeasured;
use crate::pipeline::evaluate::part_triangle_ranges::PartTriangleRanges;
use crate::pipeline::{LayerState, PipelineError};
use crate::shot::{Layer, Shot, Transfer, TransferFit};
use crate::solve::{BranchedLattice, Shape, Solution, SolveReport, Topology};
use crate::space::RotatedBox;
use crate::spelling;
use std::collections::BTreeMap;

/// The lattices of a file, by frames of this shot.
#[derive(Clone, Debug)]
pub(in crate::pipeline) struct Loaded {
    frames: BTreeMap<i32, SourceFrame>,
    has_branches: bool,
}

/// Loads the lattice files named by layers; one entry per layer.
pub(in crate::pipeline) fn load(shot: &Shot, notes: &mut Vec<String>) -> Result<Vec<Option<Loaded>>, PipelineError> {
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
    let has_branches = !file.layers[place].branches.is_empty();
    if has_branches && shot.layers[index].settings.topology != Topology::Branching {
        let what = format!(
            "the lattice '{}' of {} branches, that of the layer does not",
            names[place],
            transfer.file.display()
        );
        return Err(PipelineError::mismatch(
            shot,
            &key,
            what,
            "add lattice = { topology = \"branching\" } to the layer",
        ));
    }
    let mut branches = std::mem::take(&mut file.layers[place].branches);
    let Track::Screen(lattices) = file.layers.swap_remove(place).track else {
        let what = format!("'{}' is a lattice of the world, this layer is warped on the screen", names[place]);
        return Err(PipelineError::mismatch(shot, &key, what, "take a layer that was solved on the screen"));
    };
    let shift = match (transfer.start, lattices.keys().next()) {
        (Some(start), Some(first)) => start - first,
        _ => 0,
    };
    let of_frame = |(frame, lattice)| (frame + shift, SourceFrame::new(lattice, branches.remove(&frame)));
    let frames: BTreeMap<i32, SourceFrame> = lattices.into_iter().map(of_frame).collect();
    if let (Some((&first, _)), Some((&last, _))) = (frames.first_key_value(), frames.last_key_value())
        && (first > shot.frames.first || last < shot.frames.last)
    {
        let name = &shot.layers[index].name;
        notes.push(format!(
            "layer '{name}': its lattices cover frames {first} to {last}; the first and last are held outside that range"
        ));
    }
    Ok(Loaded { frames, has_branches })
}

impl Loaded {
    /// Whether the lattices branch.
    pub(in crate::pipeline) const fn has_branches(&self) -> bool {
        self.has_branches
    }

    /// Returns the state of the layer at a (fractional) frame of its keys. `rest_box` computes the box over which the
    /// lattice is laid and `shape` the shape that it moves; both are called only if needed.
    pub(in crate::pipeline) fn state(
        &self,
        layer: &Layer,
        key_frame: f64,
        (rest_box, shape): (impl FnOnce() -> Option<RotatedBox>, impl FnOnce() -> (Shape<2>, Vec<PartTriangleRanges>)),
    ) -> LayerState {
        let (ends, share) = self.around(key_frame);
        let [before, after] = ends;
        let source = before.lattice.mixed(&after.lattice, share);
        let fit = match layer.transfer.as_ref().map(|transfer| &transfer.fit) {
            Some(TransferFit::AsIs) => LatticeFit::AsIs,
            Some(TransferFit::Landmarks(pairs)) => LatticeFit::Landmarks(pairs.clone()),
            Some(TransferFit::Box) | None => match rest_box() {
                Some(target) => LatticeFit::Box(target),
                None => return LayerState::default(),
            },
        };
        let lattice = source.transferred(&fit).with_strength(layer.strength);
        let mut state = LayerState::default();
        let mut warnings = Vec::new();
        let branched = self.has_branches.then(|| {
            let (shape, starts) = shape();
            let rest = BranchedLattice::at_rest(&lattice.grid, &shape);
            let moved = rest.map(|rest| {
                let moved = before.over(&rest, &fit).mixed(&after.over(&rest, &fit), share);
                rest.mixed(&moved, layer.strength)
            });
            (moved, starts)
        });
        let branches: Option<(BranchedLattice<2>, Vec<PartTriangleRanges>)> = match branched {
            Some((Ok(branches), starts)) => Some((branches, starts)),
            Some((Err(fault), _)) => {
                warnings.push(format!("only its largest branch is used: {fault}"));
                None
            }
            None => None,
        };
        let solution = match branches {
            Some((branches, starts)) => {
                state.starts = starts;
                let report = SolveReport { warnings, ..report_of(branches.folds()) };
                Solution { lattice: branches.lattice(0), branches: Some(branches), report }
            }
            None => {
                let folds = lattice.folds(&vec![true; lattice.grid.cell_count()]);
                Solution { lattice, branches: None, report: SolveReport { warnings, ..report_of(folds) } }
            }
        };
        LayerState { solution: Some(solution), ..state }
    }

    /// Returns the frames before and after a time, and its position between them, 0 to 1; beyond the ends, the nearest frame twice.
    fn around(&self, key_frame: f64) -> ([&SourceFrame; 2], f64) {
        let before = self.frames.range(..=key_frame.floor() as i32).next_back();
        let after = self.frames.range(key_frame.ceil() as i32..).next();
        match (before, after) {
            (Some((&from, low)), Some((&to, high))) if from < to => {
                ([low, high], (key_frame - f64::from(from)) / f64::from(to - from))
            }
            _ => ([before.or(after).expect("a track has frames").1; 2], 0.0),
        }
    }
}

/// Returns a report for a lattice that was not solved here: distortion is not measured.
fn report_of(folds: Folds<2>) -> SolveReport {
    SolveReport {
        folded_cells: folds.cells.len(),
        folded_model_cells: folds.active_count,
        min_cell_det: folds.min_det,
        is_converged: true,
        ..unmeasured(SolveReport::default())
    }
}
