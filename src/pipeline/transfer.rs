//! Lattices that were solved for another shot: loaded once, laid over a layer in every frame; and the way out again.
//!
//! In: lattice files that layers name; or a [`Setup`] and frames. Out: layer states; or a [`LatticeFile`].

use super::layer_pins::unmeasured;
use super::{LayerState, Moment, PipelineError, Setup};
use crate::export::{LatticeFile, LatticeTrack, Track, lattice_at};
use crate::lattice::{BoxFrame, Lattice, LatticeFit};
use crate::plate::WholeWarp;
use crate::shot::{BoxRule, Shot, Transfer, TransferFit};
use crate::solve::{Solution, SolveReport};
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

impl Setup {
    /// The layer's lattice at a moment, from its file.
    pub(super) fn transferred(&self, moment: &Moment, (index, bounds): (usize, BoxRule), from: &Loaded) -> LayerState {
        let layer = &self.shot.layers[index];
        let source = lattice_at(&from.lattices, self.key_frame(layer, moment.frame));
        let fit = match layer.transfer.as_ref().map(|transfer| &transfer.fit) {
            Some(TransferFit::AsIs) => LatticeFit::AsIs,
            Some(TransferFit::Landmarks(pairs)) => LatticeFit::Landmarks(pairs.clone()),
            Some(TransferFit::Box) | None => match self.lattice_box(moment, index, bounds) {
                Some(target) => LatticeFit::Box(target),
                None => return LayerState::default(),
            },
        };
        let fitted = source.transferred(&fit);
        let lattice = fitted.lattice.with_strength(layer.strength);
        let mut report = report_of(&lattice);
        let error_px = fitted.error * f64::from(self.shot.size.height);
        if error_px > TURNED_TOLERANCE_PX {
            let text = format!("turned by its landmarks, the lattice follows its source within {error_px:.2} px only");
            report.warnings.push(text);
        }
        LayerState { solution: Some(Solution { lattice, report }), ..LayerState::default() }
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

/// The lattices of a layer, by frame: on the screen or in the scene.
#[derive(Clone, Default)]
struct Solved {
    screen: BTreeMap<i32, Lattice<2>>,
    world: BTreeMap<i32, Lattice<3>>,
    placements: BTreeMap<i32, BoxFrame>,
    wholes: BTreeMap<i32, WholeWarp>,
}

impl Solved {
    fn add(&mut self, frame: i32, state: &LayerState) {
        self.screen.extend(state.solution.as_ref().map(|solution| (frame, solution.lattice.clone())));
        self.wholes.extend(state.whole.as_ref().map(|whole| (frame, whole.clone())));
        let world = state.world.as_ref().map(|world| &world.lattice);
        self.world.extend(world.map(|placed| (frame, placed.lattice.clone())));
        self.placements.extend(world.map(|placed| (frame, placed.frame)));
    }

    /// `None` where the layer is never warped.
    fn track(self, name: &str) -> Option<LatticeTrack> {
        let Self { screen, world, placements, wholes } = self;
        let track = match (screen.is_empty(), world.is_empty()) {
            (true, true) => return None,
            (_, true) => Track::Screen(screen),
            (_, false) => Track::World(world),
        };
        Some(LatticeTrack { name: name.to_owned(), track, placements, wholes })
    }
}

/// The solved lattices of some frames, each at the frame's own time, for other shots and programs; layers that are never
/// warped are left out.
///
/// # Errors
/// [`PipelineError::Solve`] where a layer cannot be solved; where no layer is warped at all, a mismatch.
pub fn lattices(setup: &Setup, frames: &[i32], mut tell: impl FnMut(i32)) -> Result<LatticeFile, PipelineError> {
    let shot = &setup.shot;
    let mut solved = vec![Solved::default(); shot.layers.len()];
    for &frame in frames {
        // Not in the middle of its exposure: whoever lays a lattice over a moment asks for the time of that moment.
        let moment = setup.moment(f64::from(frame))?;
        for (solved, state) in solved.iter_mut().zip(&moment.layers) {
            solved.add(frame, state);
        }
        tell(frame);
    }
    let tracks = shot.layers.iter().zip(solved);
    let layers: Vec<LatticeTrack> = tracks.filter_map(|(layer, solved)| solved.track(&layer.name)).collect();
    if layers.is_empty() {
        let what = "no layer is warped in these frames: there is nothing to export";
        return Err(PipelineError::mismatch(shot, "layer", what, "add pins, or choose other frames"));
    }
    Ok(LatticeFile { frame_aspect: shot.size.aspect(), rate: shot.frames.rate, layers })
}
