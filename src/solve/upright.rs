//! Problems over a rotated box, rotated back: they are solved as if the box were upright.
//!
//! In: shapes, pins and targets over a rotated grid. Out: the same, rotated back about the centre of the box. Handles, cells and samples
//! are those of the upright grid, so a figure that rotates with its box has the same solution.

use super::problem::{HandlePin, ModelPoint, PointPin, Shape};
use super::targets::Targets;
use super::trajectory::TimedProblem;
use crate::lattice::Grid;
use std::borrow::Cow;

/// Rotates shapes, pins and targets back about the centre of a grid's box. Borrows what a box without rotation leaves as it is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Upright<'a, const D: usize> {
    grid: &'a Grid<D>,
}

impl<'a, const D: usize> Upright<'a, D> {
    /// The rotation of this grid.
    pub(crate) const fn of(grid: &'a Grid<D>) -> Self {
        Self { grid }
    }

    fn is_identity(self) -> bool {
        self.grid.angle == 0.0
    }

    /// The shape.
    pub(crate) fn shape(self, shape: &Shape<D>) -> Cow<'_, Shape<D>> {
        if self.is_identity() {
            return Cow::Borrowed(shape);
        }
        let points = shape.points.iter().map(|&point| self.grid.upright_from_point(point)).collect();
        Cow::Owned(Shape { points, ..shape.clone() })
    }

    /// The pins with their targets and gradients.
    pub(crate) fn pins(self, pins: &[PointPin<D>]) -> Cow<'_, [PointPin<D>]> {
        if self.is_identity() { Cow::Borrowed(pins) } else { pins.iter().map(|pin| self.pin(pin)).collect() }
    }

    fn pin(self, pin: &PointPin<D>) -> PointPin<D> {
        PointPin {
            at: self.grid.upright_from_point(pin.at),
            target: self.grid.upright_from_point(pin.target),
            gradient: pin.gradient.map(|columns| {
                // R⁻¹ G R
                std::array::from_fn(|column| {
                    let axis = self.grid.rotated(std::array::from_fn(|d| f64::from(u8::from(d == column))));
                    let image = std::array::from_fn(|row| (0..D).map(|k| columns[k][row] * axis[k]).sum());
                    self.grid.rotated_back(image)
                })
            }),
            ..*pin
        }
    }

    /// The moved handles.
    pub(crate) fn handles(self, handles: &[HandlePin<D>]) -> Cow<'_, [HandlePin<D>]> {
        if self.is_identity() {
            return Cow::Borrowed(handles);
        }
        let upright =
            |handle: &HandlePin<D>| HandlePin { target: self.grid.upright_from_point(handle.target), ..*handle };
        handles.iter().map(upright).collect()
    }

    /// The targets of pins and moved handles.
    pub(crate) fn targets(self, pins: &[PointPin<D>], handles: &[HandlePin<D>]) -> Targets<D> {
        Targets { pins: self.pins(pins).into_owned(), handles: self.handles(handles).into_owned() }
    }

    /// The targets along a path.
    pub(crate) fn path(self, path: &[Targets<D>]) -> Cow<'_, [Targets<D>]> {
        if self.is_identity() {
            return Cow::Borrowed(path);
        }
        path.iter().map(|targets| self.targets(&targets.pins, &targets.handles)).collect()
    }

    /// Positions of handles or copies of handles.
    pub(crate) fn points(self, points: &[[f64; D]]) -> Vec<[f64; D]> {
        points.iter().map(|&point| self.grid.upright_from_point(point)).collect()
    }

    /// The problem of one time.
    pub(crate) fn problem(self, problem: TimedProblem<D>) -> TimedProblem<D> {
        if self.is_identity() {
            return problem;
        }
        let TimedProblem { shape, path, points, drawing, take, .. } = problem;
        let point = |point: &ModelPoint<D>| ModelPoint { at: self.grid.upright_from_point(point.at), ..*point };
        TimedProblem {
            grid: self.grid.upright(),
            shape: self.shape(&shape).into_owned(),
            path: self.path(&path).into_owned(),
            points: points.iter().map(point).collect(),
            drawing,
            take,
        }
    }
}
