//! Lattices: handles over a box, in screen or scene space.
//!
//! In: arrays of handles and points. Out: warped points, gradients, folds. All computation is the library's.

use super::arrays::{described, from_points, points};
use super::failure::Failure;
use super::named::named;
use crate::lattice::{self, Basis, Grid};
use numpy::ndarray::ArrayViewD;
use numpy::{AllowTypeChange, PyArray1, PyArray2, PyArray3, PyArrayDyn, PyArrayLikeDyn, PyArrayMethods};
use pyo3::prelude::*;
use rayon::prelude::*;

/// Number of points per thread batch.
const BATCH: usize = 1 << 12;

/// A lattice of the library.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Handles {
    /// In screen space.
    Screen(lattice::Lattice<2>),
    /// In scene space.
    World(lattice::Lattice<3>),
}

/// Evaluates an expression for a lattice in either space.
macro_rules! in_either {
    ($lattice:expr, $own:ident => $then:expr) => {
        match &$lattice.0 {
            Handles::Screen($own) => $then,
            Handles::World($own) => $then,
        }
    };
}

/// A grid of handles over a box, on the screen (two coordinates) or in the scene (three).
///
/// handles: array (ny, nx, 2), or (nz, ny, nx, 3) in the scene: the moved positions of the handles.
/// box: two corners, ((x0, y0), (x1, y1)), with three numbers each in the scene.
/// basis: "bspline", "bernstein", "bilinear" or "barytri".
/// angle: rotation of the box about its centre on the screen, in degrees, counter-clockwise.
///
/// Positions on the screen are in frame heights, x right, y up, from the lower left corner of the frame; in the scene in metres.
#[pyclass(frozen, from_py_object, module = "pinwarp")]
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Lattice(pub(super) Handles);

#[pymethods]
impl Lattice {
    #[new]
    #[pyo3(signature = (handles, r#box, basis="bspline", angle=0.0))]
    fn new(handles: &Bound<'_, PyAny>, r#box: [Vec<f64>; 2], basis: &str, angle: f64) -> Result<Self, Failure> {
        let basis = named("basis", basis)?;
        let given: PyArrayLikeDyn<'_, f64, AllowTypeChange> = handles.extract().map_err(|_| shape_fault(handles))?;
        let given = given.as_array();
        match given.shape() {
            [_, _, 2] => Ok(Self(Handles::Screen(moved(&given, (&r#box, angle), basis)?))),
            [_, _, _, 3] => Ok(Self(Handles::World(moved(&given, (&r#box, angle), basis)?))),
            _ => Err(shape_fault(handles)),
        }
    }

    /// Returns a lattice with all handles at rest, which displaces nothing.
    ///
    /// box: two corners.
    /// dims: number of handles along x, y (and z).
    /// angle: rotation of the box about its centre on the screen, in degrees, counter-clockwise.
    #[staticmethod]
    #[pyo3(signature = (r#box, dims, basis="bspline", angle=0.0))]
    fn rest(r#box: [Vec<f64>; 2], dims: Vec<usize>, basis: &str, angle: f64) -> Result<Self, Failure> {
        let basis = named("basis", basis)?;
        match *dims.as_slice() {
            [x, y] => Ok(Self(Handles::Screen(grid((&r#box, angle), [x, y], basis)?.at_rest()))),
            [x, y, z] => Ok(Self(Handles::World(grid((&r#box, angle), [x, y, z], basis)?.at_rest()))),
            _ => Err(Failure::argument(
                "dims",
                format!("is {dims:?}"),
                "give two numbers of handles, or three in the scene",
            )),
        }
    }

    /// The space of the lattice: "screen" or "world".
    #[getter]
    const fn space(&self) -> &'static str {
        match self.0 {
            Handles::Screen(_) => "screen",
            Handles::World(_) => "world",
        }
    }

    /// Number of handles along x, y (and z).
    #[getter]
    fn dims(&self) -> Vec<usize> {
        in_either!(self, own => own.grid.dims.to_vec())
    }

    /// Name of the basis functions that blend the handles.
    #[getter]
    fn basis(&self) -> String {
        in_either!(self, own => own.grid.basis.label().to_lowercase())
    }

    /// Lower and upper corner of the box at rest.
    #[getter]
    fn r#box(&self) -> [Vec<f64>; 2] {
        in_either!(self, own => [own.grid.lo.to_vec(), own.grid.hi.to_vec()])
    }

    /// Rotation of the box about its centre in degrees, counter-clockwise; 0 in the scene.
    #[getter]
    const fn angle(&self) -> f64 {
        in_either!(self, own => own.grid.angle.to_degrees())
    }

    /// Positions of the handles: a new array (ny, nx, 2), or (nz, ny, nx, 3).
    #[getter]
    fn handles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        in_either!(self, own => shaped(py, own.handles.clone(), own.grid.dims))
    }

    /// Rest positions of the handles, in the same shape as `handles`.
    #[getter]
    fn rest_handles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        in_either!(self, own => shaped(py, own.grid.rest_handles(), own.grid.dims))
    }

    /// Returns the warped positions of points, (N, D) to (N, D). Points outside the box are displaced like the nearest point of the box.
    fn warp<'py>(&self, py: Python<'py>, points: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        in_either!(self, own => carried(py, points, |point| own.deform(point)))
    }

    /// As `warp`, but outside the box the polynomials of the basis are extended.
    fn evaluate<'py>(&self, py: Python<'py>, points: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        in_either!(self, own => carried(py, points, |point| own.evaluate(point)))
    }

    /// Returns the gradient of the warp at points, (N, D) to (N, D, D): [n, row, column] is the derivative of coordinate `row` along axis
    /// `column`.
    fn gradient<'py>(&self, py: Python<'py>, points: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        in_either!(self, own => gradients(py, own, points))
    }

    /// Returns the cells that fold somewhere, as (column, row) or (column, row, layer).
    fn folds(&self, py: Python<'_>) -> Vec<Vec<usize>> {
        py.detach(|| in_either!(self, own => own.folded_cells().iter().map(|cell| cell.to_vec()).collect()))
    }

    /// Returns the lattice with scaled displacements: 0 is at rest, 1 is unchanged.
    fn with_strength(&self, strength: f64) -> Result<Self, Failure> {
        if !strength.is_finite() {
            return Err(Failure::argument("strength", format!("is {strength}"), "give a finite number"));
        }
        Ok(Self(match &self.0 {
            Handles::Screen(own) => Handles::Screen(own.with_strength(strength)),
            Handles::World(own) => Handles::World(own.with_strength(strength)),
        }))
    }

    fn __eq__(&self, other: &Self) -> bool {
        self == other
    }

    fn __repr__(&self) -> String {
        let dims: Vec<String> = self.dims().iter().map(ToString::to_string).collect();
        format!("<Lattice of {} handles, {}, {}>", dims.join(" x "), self.basis(), self.space())
    }
}

fn shape_fault(handles: &Bound<'_, PyAny>) -> Failure {
    let hint = "give numbers of the shape (ny, nx, 2), or (nz, ny, nx, 3) in the scene";
    Failure::argument("handles", format!("is {}", described(handles)), hint)
}

/// Creates a grid, checking its parameters.
pub(super) fn grid<const D: usize>(
    (corners, degrees): (&[Vec<f64>; 2], f64),
    dims: [usize; D],
    basis: Basis,
) -> Result<Grid<D>, Failure> {
    if !degrees.is_finite() || D > 2 && degrees != 0.0 {
        let hint = "give degrees; only boxes on the screen are rotated";
        return Err(Failure::argument("angle", format!("is {degrees}"), hint));
    }
    let corner = |side: usize| {
        <[f64; D]>::try_from(corners[side].as_slice()).map_err(|_| {
            let hint = format!("give two corners of {D} numbers");
            Failure::argument(format!("box[{side}]"), format!("is {:?}", corners[side]), hint)
        })
    };
    let grid = Grid { dims, basis, lo: corner(0)?, hi: corner(1)?, angle: degrees.to_radians() };
    grid.check()?;
    Ok(grid)
}

/// Creates a lattice from moved handles: the last axis holds coordinates, the axes before it run from z to x.
fn moved<const D: usize>(
    given: &ArrayViewD<'_, f64>,
    (corners, degrees): (&[Vec<f64>; 2], f64),
    basis: Basis,
) -> Result<lattice::Lattice<D>, Failure> {
    let shape = given.shape();
    let grid = grid((corners, degrees), std::array::from_fn(|axis| shape[D - 1 - axis]), basis)?;
    let flat: Vec<f64> = given.iter().copied().collect();
    if let Some(place) = flat.iter().position(|value| !value.is_finite()) {
        let hint = "give finite numbers";
        return Err(Failure::argument("handles", format!("has {} at handle {}", flat[place], place / D), hint));
    }
    let handles = flat.chunks_exact(D).map(|handle| std::array::from_fn(|axis| handle[axis])).collect();
    Ok(lattice::Lattice { grid, handles })
}

/// Returns handles as an array whose axes run from z to x.
fn shaped<const D: usize>(
    py: Python<'_>,
    handles: Vec<[f64; D]>,
    dims: [usize; D],
) -> PyResult<Bound<'_, PyArrayDyn<f64>>> {
    let shape: Vec<usize> = dims.iter().rev().copied().chain([D]).collect();
    PyArray1::from_vec(py, handles.into_flattened()).reshape(shape)
}

fn carried<'py, const D: usize>(
    py: Python<'py>,
    values: &Bound<'py, PyAny>,
    carry: impl Fn([f64; D]) -> [f64; D] + Sync + Send,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let points = points::<D>(values, "points")?;
    let carried = py.detach(|| points.into_par_iter().with_min_len(BATCH).map(carry).collect());
    from_points(py, carried)
}

fn gradients<'py, const D: usize>(
    py: Python<'py>,
    own: &lattice::Lattice<D>,
    values: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyArray3<f64>>> {
    let points = points::<D>(values, "points")?;
    let gradient = |point| own.evaluate_with_gradient(point).gradient;
    let gradients: Vec<[[f64; D]; D]> =
        py.detach(|| points.into_par_iter().with_min_len(BATCH).map(gradient).collect());
    let count = gradients.len();
    PyArray1::from_vec(py, gradients.into_flattened().into_flattened()).reshape([count, D, D])
}
