//! Warps a picture in memory, by pins or by a lattice.
//!
//! In: a picture as an array or a dict of channels. Out: the same, warped, with the pixels that `pinwarp warp` writes.

use super::failure::Failure;
use super::image::{image_of, plate_of};
use super::lattice::{Handles, Lattice};
use super::named::named;
use super::options::Options;
use super::pin::{Pin, Units, pins, pins_of_picture};
use super::work::{Watch, away};
use crate::image::Plate;
use crate::lattice::ScreenLattice;
use crate::live::{self, Controls, Coverage, Moved, ShapeSource};
use crate::plate::{Field, LayerJob, Matte, PlateJob, Semantic, WarpSettings, warp_plate};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Default lattice dims over a whole picture, across and up: as in shots.
const DIMS: [usize; 2] = [16, 16];

/// Warps a picture and returns a new one of the same shape and type.
///
/// image: array (H, W) or (H, W, C) with rows from the top, or a dict of channels (H, W). float32 and float16 are scene-linear, colour
///     multiplied with alpha; uint8 is sRGB with straight alpha and has 1 to 4 channels. Channels are Y, YA, RGB or RGBA; more are
///     resampled as colours without alpha, unless names says what they are. Channels of a dict are treated by their names as in EXR
///     files: depth, ids and normals are never blended.
/// pins: (K, 4) with x, y and the target, or a list of Pin.
/// lattice: a lattice to warp with, instead of pins.
/// units: "screen" (frame heights, x right, y up, from the lower left corner) or "pixels" (x right, y down, from the upper left corner; the
///     first pixel's centre is (0.5, 0.5)).
/// dims, basis, smoothness, guard: settings of the lattice that is solved.
/// strength: scales all displacements.
/// shape: "frame" moves the whole picture and holds its border; "alpha" moves what alpha covers, without holding the border.
/// filter: "ewa", "cubic", "lanczos" or "nearest".
/// progress: called with (done, 2), for the solve and the pixels; False cancels.
#[pyfunction]
#[pyo3(
    signature = (image, pins=None, progress=None, **options),
    text_signature = "(image, pins=None, progress=None, *, lattice=None, units='screen', dims=(16, 16), basis='bspline', smoothness=1.0, strength=1.0, guard='report', shape='frame', filter='ewa', names=None, pixel_aspect=1.0)"
)]
pub(super) fn warp<'py>(
    image: &Bound<'py, PyAny>,
    pins: Option<&Bound<'py, PyAny>>,
    progress: Option<&Bound<'py, PyAny>>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    let py = image.py();
    let mut options = Options::new(options);
    let task = Task::of(pins, &mut options)?;
    let names = options.take::<Vec<String>>("names")?;
    let pixel_aspect = options.take::<f64>("pixel_aspect")?.unwrap_or(1.0);
    options.end()?;
    if !(0.1..=10.0).contains(&pixel_aspect) {
        return Err(Failure::argument("pixel_aspect", format!("is {pixel_aspect}"), "keep it within 0.1 to 10").into());
    }
    let (mut plate, form) = plate_of(image, names)?;
    plate.pixel_aspect = pixel_aspect;
    let warped = away(py, progress, |watch| task.run(&plate, watch))?;
    image_of(py, warped, &form)
}

/// The source of the displacement.
enum DisplacementSource {
    Pins(Vec<Pin>, Units),
    Lattice(ScreenLattice),
}

/// The parsed arguments.
struct Task {
    source: DisplacementSource,
    controls: Controls,
    settings: WarpSettings,
    moved: Moved,
}

impl Task {
    fn of(given: Option<&Bound<'_, PyAny>>, options: &mut Options<'_, '_>) -> PyResult<Self> {
        let units = Units::of_name(&options.take::<String>("units")?.unwrap_or_else(|| "screen".into()))?;
        let source = match (given, options.take::<Lattice>("lattice")?) {
            (Some(given), None) => DisplacementSource::Pins(pins(given)?, units),
            (None, Some(Lattice(Handles::Screen(lattice)))) => DisplacementSource::Lattice(lattice),
            (None, Some(_)) => {
                let hint = "pictures are warped by lattices of the screen";
                return Err(Failure::argument("lattice", "lies in the scene", hint).into());
            }
            (Some(_), Some(_)) => {
                return Err(Failure::argument("lattice", "is given beside pins", "give one of the two").into());
            }
            (None, None) => {
                return Err(Failure::argument("pins", "are not given, nor is a lattice", "give one of the two").into());
            }
        };
        let moved = match options.take::<String>("shape")?.as_deref() {
            None | Some("frame") => Moved::Picture,
            Some("alpha") => Moved::Masked,
            Some(other) => {
                let hint = "give \"frame\" or \"alpha\"";
                return Err(Failure::argument("shape", format!("is {other:?}"), hint).into());
            }
        };
        let filter = options.take::<String>("filter")?;
        let filter = filter.map_or_else(|| Ok(Default::default()), |name| named("filter", &name))?;
        // Numbered channels are treated as colour.
        let semantics = vec![("channel*".to_owned(), Semantic::Color)];
        let settings = WarpSettings { filter, semantics, ..WarpSettings::default() };
        Ok(Self { source, controls: controls(options, moved)?, settings, moved })
    }

    fn run(&self, plate: &Plate, watch: &Watch) -> Result<Plate, Failure> {
        watch.tell(0, 2);
        let field = self.field(plate, watch)?;
        watch.tell(1, 2);
        let matte = (self.moved == Moved::Masked).then_some(Matte::Alpha);
        let layer = LayerJob { name: "pins".to_owned(), field, previous: None, next: None, matte, front: None };
        let job = PlateJob { layers: vec![layer], settings: &self.settings, fill: None };
        let (warped, _) = warp_plate(plate, &job)?;
        watch.tell(2, 2);
        Ok(warped)
    }

    /// Returns the displacement field of the picture.
    fn field(&self, plate: &Plate, watch: &Watch) -> Result<Field, Failure> {
        let (pins, units) = match &self.source {
            DisplacementSource::Pins(pins, units) => (pins, *units),
            DisplacementSource::Lattice(lattice) => {
                let lattice = lattice.with_strength(self.controls.strength);
                return Ok(match self.moved {
                    Moved::Picture => Field::of_picture(lattice),
                    Moved::Masked => Field::of_layer(lattice),
                });
            }
        };
        let size = plate.frame_size();
        let controls = Controls { pins: pins_of_picture(pins, units, size), ..self.controls.clone() };
        let alpha = plate.parts.first().and_then(|part| part.channel("A"));
        let shape = match (self.moved, alpha) {
            (Moved::Picture, _) => ShapeSource::Frame,
            (Moved::Masked, Some(alpha)) => {
                ShapeSource::Coverage(Coverage { window: plate.display, alpha: &alpha.samples })
            }
            (Moved::Masked, None) => {
                let what = "is \"alpha\", and the picture has no alpha";
                return Err(Failure::argument("shape", what, "give a picture with alpha, or shape=\"frame\""));
            }
        };
        Ok(live::warp_until(&controls, &shape, size, &|| watch.is_stopped())?.field.clone())
    }
}

fn controls(options: &mut Options<'_, '_>, moved: Moved) -> PyResult<Controls> {
    let usual = Controls { dims: DIMS, moved, ..Controls::default() };
    let basis = options.take::<String>("basis")?;
    let guard = options.take::<String>("guard")?;
    Ok(Controls {
        dims: options.take("dims")?.unwrap_or(usual.dims),
        basis: basis.map_or(Ok(usual.basis), |name| named("basis", &name))?,
        guard: guard.map_or(Ok(usual.guard), |name| named("guard", &name))?,
        smoothness: options.take("smoothness")?.unwrap_or(usual.smoothness),
        strength: options.take("strength")?.unwrap_or(usual.strength),
        ..usual
    })
}
