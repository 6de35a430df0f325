//! Validation of problems before any computation.
//!
//! In: a problem. Out: the first fault that is found, in words; warnings about its shape.

use super::energy;
use super::error::SolveError;
use super::problem::{HandlePin, PointPin, Problem, Region, Shape};
use crate::spelling::pluralised;

/// Largest absolute coordinate, for which products of four coordinates stay finite.
const FURTHEST: f64 = 1e50;

/// Checks grid, shape, pins and handles.
pub(crate) fn problem<const D: usize>(problem: &Problem<D>) -> Result<(), SolveError> {
    problem.grid.check()?;
    shape(problem.shape)?;
    problem.pins.iter().enumerate().try_for_each(|(index, one)| pin(index, one))?;
    let count = problem.grid.handle_count();
    for (entry, handle) in problem.handles.iter().enumerate() {
        if handle.index >= count {
            return Err(invalid(
                format!("moved handle {entry} has index {}, the lattice has {count} handles", handle.index),
                format!("use an index from 0 to {}", count - 1),
            ));
        }
        finite(&handle.target, || format!("the target of moved handle {entry}"))?;
    }
    let lambdas = problem.settings.lambdas;
    for (name, value) in [
        ("shape", lambdas.shape),
        ("pins", lambdas.pins),
        ("handles", lambdas.handles),
        ("regularizer", lambdas.regularizer),
    ] {
        if !(value >= 0.0 && value.is_finite()) {
            return Err(invalid(format!("the weight `{name}` is {value}"), "use a finite number from 0".into()));
        }
    }
    let most = problem.settings.max_stretch;
    if most.is_nan() || most <= 1.0 {
        return Err(invalid(format!("`max_stretch` is {most}"), "use a number above 1".into()));
    }
    Ok(())
}

fn shape<const D: usize>(shape: &Shape<D>) -> Result<(), SolveError> {
    if let Some(bad) = shape.points.iter().position(|point| !are_places(point)) {
        return Err(invalid(
            format!("vertex {bad} of the shape is {:?}", shape.points[bad]),
            "remove vertices with infinite, NaN or huge coordinates".into(),
        ));
    }
    let count = shape.points.len();
    stiffness(shape)?;
    let is_bad = |triangle: &[u32; 3]| triangle.iter().any(|&corner| corner as usize >= count);
    if let Some(bad) = shape.triangles.iter().position(is_bad) {
        let vertices = pluralised(count, "vertex", "vertices");
        return Err(invalid(
            format!("triangle {bad} has corners {:?}, the shape has {vertices}", shape.triangles[bad]),
            "corners are vertex indices from 0".into(),
        ));
    }
    let is_beyond = |stroke: &Vec<u32>| stroke.iter().any(|&vertex| vertex as usize >= count);
    if let Some(bad) = shape.strokes.iter().position(is_beyond) {
        return Err(invalid(
            format!(
                "line {bad} has a vertex index out of range; the shape has {}",
                pluralised(count, "vertex", "vertices")
            ),
            "lines are lists of vertex indices from 0".into(),
        ));
    }
    Ok(())
}

fn stiffness<const D: usize>(shape: &Shape<D>) -> Result<(), SolveError> {
    let (found, wanted) = (shape.stiffness.len(), shape.triangles.len());
    if found != 0 && found != wanted {
        let (triangles, stiffnesses) =
            (pluralised(wanted, "triangle", "triangles"), pluralised(found, "stiffness", "stiffnesses"));
        let what = format!("the shape has {triangles} and {stiffnesses}");
        return Err(invalid(what, "give one stiffness per triangle, or none at all".into()));
    }
    match shape.stiffness.iter().position(|x| !(*x >= 0.0 && x.is_finite())) {
        Some(bad) => Err(invalid(
            format!("the stiffness of triangle {bad} is {}", shape.stiffness[bad]),
            "use a finite number from 0; 1 is the default".into(),
        )),
        None => Ok(()),
    }
}

fn region(index: usize, region: &Region) -> Result<(), SolveError> {
    let positive = |x: f64| x > 0.0 && x.is_finite();
    let faults = [
        (!positive(region.radius), "radius", region.radius, "use a number above 0"),
        (!(0.0..=1.0).contains(&region.rigidity), "rigidity", region.rigidity, "use a number from 0 to 1"),
        (
            !positive(region.stiffness),
            "stiffness",
            region.stiffness,
            "use a number above 0; 1 leaves the shape as it is",
        ),
    ];
    match faults.into_iter().find(|fault| fault.0) {
        Some((_, name, value, hint)) => {
            Err(invalid(format!("the {name} of the region of pin {index} is {value}"), hint.into()))
        }
        None => Ok(()),
    }
}

fn pin<const D: usize>(index: usize, pin: &PointPin<D>) -> Result<(), SolveError> {
    finite(&pin.at, || format!("the rest point of pin {index}"))?;
    finite(&pin.target, || format!("the target of pin {index}"))?;
    pin.gradient.iter().flatten().try_for_each(|image| finite(image, || format!("the gradient of pin {index}")))?;
    pin.region.iter().try_for_each(|one| region(index, one))?;
    if (0.0..=1.0).contains(&pin.weight) {
        return Ok(());
    }
    Err(invalid(format!("pin {index} has weight {}", pin.weight), "use a weight from 0 to 1".into()))
}

/// Checks that the pins of an update are those of the problem.
pub(crate) fn same_pins<const D: usize>(known: &[PointPin<D>], given: &[PointPin<D>]) -> Result<(), SolveError> {
    same_count(known.len(), given.len(), ["pin", "pins"])?;
    for (index, (a, b)) in known.iter().zip(given).enumerate() {
        pin(index, b)?;
        if a.at != b.at || a.weight != b.weight || a.region != b.region || a.gradient.is_some() != b.gradient.is_some()
        {
            return Err(changed(format!(
                "pin {index} has a different rest point, weight or region, or gained or lost its gradient"
            )));
        }
    }
    Ok(())
}

/// Checks that the handles of an update are those of the problem.
pub(crate) fn same_handles<const D: usize>(known: &[HandlePin<D>], given: &[HandlePin<D>]) -> Result<(), SolveError> {
    same_count(known.len(), given.len(), ["moved handle", "moved handles"])?;
    for (entry, (a, b)) in known.iter().zip(given).enumerate() {
        finite(&b.target, || format!("the target of moved handle {entry}"))?;
        if a.index != b.index {
            return Err(changed(format!("moved handle {entry} has index {}, it had {}", b.index, a.index)));
        }
    }
    Ok(())
}

fn same_count(known: usize, given: usize, [one, many]: [&str; 2]) -> Result<(), SolveError> {
    if known == given { Ok(()) } else { Err(changed(format!("{} instead of {known}", pluralised(given, one, many)))) }
}

/// Warnings about the shape of a checked problem.
pub(crate) fn shape_warnings<const D: usize>(problem: &Problem<D>) -> Vec<String> {
    let Problem { grid, shape, settings, .. } = *problem;
    let is_inside = |corner: &u32| {
        let point = shape.points[*corner as usize];
        (0..D).all(|axis| (grid.lo[axis]..=grid.hi[axis]).contains(&point[axis]))
    };
    let mut warnings: Vec<String> = energy::fitting(shape, settings).1.into_iter().collect();
    let mut corners = shape.triangles.iter().flatten().chain(shape.strokes.iter().flatten());
    let is_empty = shape.triangles.is_empty() && shape.strokes.is_empty();
    if !is_empty && !corners.any(is_inside) {
        warnings.push("no corner of the shape lies inside the lattice box; check the box".into());
    }
    warnings
}

fn finite<const D: usize>(values: &[f64; D], what: impl Fn() -> String) -> Result<(), SolveError> {
    if are_places(values) {
        return Ok(());
    }
    Err(invalid(format!("{} is {values:?}", what()), "use finite numbers up to 1e50".into()))
}

fn are_places<const D: usize>(values: &[f64; D]) -> bool {
    values.iter().all(|x| x.abs() <= FURTHEST)
}

fn invalid(what: String, hint: String) -> SolveError {
    SolveError::Invalid { what, hint }
}

fn changed(what: String) -> SolveError {
    invalid(what, "build a new solver; an update changes targets only".into())
}
