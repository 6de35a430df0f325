//! Registration: solves for the lattice that maps landmarks of one picture or pose onto those of another.
//!
//! In: a shape and pairs of points. Out: a lattice, its report, and the residual distances.
//!
//! The solve is the regular one: every landmark is a hard pin, and the shape is distorted as little as possible
//! (docs/METHOD.md), so a picture bends between landmarks as softly as under pins dragged by hand.

use crate::lattice::{Basis, Grid, Lattice};
use crate::pipeline::evaluate::screen_shape::screen_shape;
use crate::pipeline::{PipelineError, PreparedShot};
use crate::scene::{Picture, picture_cards};
use crate::solve::{PointPin, Problem, Settings, Shape, SolveError, SolveReport, solve};
use crate::space::{FrameWindow, ScreenBox, ScreenPoint};
use glam::DVec2;
use std::path::Path;

/// Padding around shape and landmarks on each side, relative to the box.
const PADDING: f64 = 0.1;

/// Minimum side of a box, in frame heights.
const MIN_SIDE: f64 = 0.01;

/// A lattice that maps landmarks.
#[derive(Clone, Debug)]
pub struct Registration {
    /// The lattice.
    pub lattice: Lattice<2>,
    /// The solver's report.
    pub report: SolveReport,
    /// #pairs: distance of the mapped point from its target, in frame heights.
    pub residuals: Vec<f64>,
}

/// Solves for the lattice that maps the first point of each pair to the second. Its box contains the shape and all first points.
///
/// # Errors
/// [`SolveError`] if there are too few or too many handles, or if numbers are not finite.
pub fn register(
    shape: &Shape<2>,
    pairs: &[[ScreenPoint; 2]],
    dims: [usize; 2],
    basis: Basis,
) -> Result<Registration, SolveError> {
    let corners = shape.triangles.iter().flatten().map(|&corner| ScreenPoint(shape.points[corner as usize].into()));
    let points = corners.chain(pairs.iter().map(|[from, _]| *from));
    let bounds =
        ScreenBox::around(points).unwrap_or(ScreenBox::new(ScreenPoint::default(), ScreenPoint::new(1.0, 1.0)));
    let grid = Grid::over(padded(bounds), dims, basis);
    let pins: Vec<PointPin<2>> =
        pairs.iter().map(|[from, to]| PointPin::new(from.0.to_array(), to.0.to_array())).collect();
    let settings = Settings::default();
    let solution = solve(&Problem { grid: &grid, shape, pins: &pins, handles: &[], settings: &settings })?;
    let residuals = pairs.iter().map(|[from, to]| (solution.lattice.warp(*from) - *to).0.length()).collect();
    Ok(Registration { lattice: solution.lattice, report: solution.report, residuals })
}

fn padded(bounds: ScreenBox) -> ScreenBox {
    let half = (bounds.size() * (0.5 + PADDING)).max(DVec2::splat(0.5 * MIN_SIDE));
    let middle = bounds.center().0;
    ScreenBox::new(ScreenPoint(middle - half), ScreenPoint(middle + half))
}

/// Returns the shape of a picture: the area where its alpha is not zero, or the whole picture.
///
/// # Errors
/// [`PipelineError::Scene`] if the picture is fully transparent.
pub fn picture_shape(
    path: &Path,
    FrameWindow { frame, window }: FrameWindow,
    alpha: Option<&[f32]>,
) -> Result<Shape<2>, PipelineError> {
    let picture = Picture { path: path.to_owned(), name: "picture".into(), window, alpha };
    let scene = picture_cards(frame, &[picture])?;
    let mut shape = Shape::default();
    for primitive in scene.meshes.iter().flat_map(|mesh| &mesh.primitives) {
        let base = shape.points.len() as u32;
        // Cards lie in the screen plane: their x and y are screen coordinates.
        shape.points.extend(primitive.positions.iter().map(|point| [f64::from(point.x), f64::from(point.y)]));
        shape.triangles.extend(primitive.triangles.iter().map(|corners| corners.map(|corner| corner + base)));
    }
    Ok(shape)
}

/// Returns what the camera sees of a layer in a frame, before any screen layer warps it.
///
/// # Errors
/// [`PipelineError::Solve`] if a layer cannot be solved.
#[cfg_attr(not(any(test, feature = "cli")), expect(dead_code, reason = "only commands call it"))]
pub(crate) fn layer_shape(prepared: &PreparedShot, layer: usize, frame: i32) -> Result<Shape<2>, PipelineError> {
    let sample = prepared.sample_at(f64::from(frame))?;
    Ok(screen_shape(prepared, &sample, layer))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Shape<2> {
        let points = vec![[0.2, 0.2], [0.8, 0.2], [0.8, 0.8], [0.2, 0.8]];
        Shape::of_triangles(points, vec![[0, 1, 2], [0, 2, 3]])
    }

    fn pairs(list: &[[f64; 4]]) -> Vec<[ScreenPoint; 2]> {
        list.iter().map(|&[ax, ay, bx, by]| [ScreenPoint::new(ax, ay), ScreenPoint::new(bx, by)]).collect()
    }

    #[test]
    fn landmarks_are_met_exactly_and_the_box_holds_them() {
        let list = pairs(&[
            [0.2, 0.2, 0.25, 0.15],
            [0.8, 0.2, 0.9, 0.3],
            [0.8, 0.8, 0.7, 0.85],
            [0.2, 0.8, 0.2, 0.7],
            [0.9, 0.5, 0.95, 0.6],
        ]);
        let found = register(&square(), &list, [10, 10], Basis::Bspline).expect("a right problem");
        assert!(found.residuals.iter().all(|&left| left < 1e-7), "{:?}", found.residuals);
        assert_eq!(found.report.folded_model_cells, 0);
        assert!(found.lattice.grid.hi[0] > 0.95 && found.lattice.grid.lo[1] < 0.15, "{:?}", found.lattice.grid);
    }

    #[test]
    fn one_landmark_shifts_and_contradictions_are_told() {
        let found = register(&square(), &pairs(&[[0.5, 0.5, 0.6, 0.4]]), [8, 8], Basis::Bspline).expect("solved");
        let moved = found.lattice.warp(ScreenPoint::new(0.3, 0.7));
        assert!((moved.0 - DVec2::new(0.4, 0.6)).length() < 1e-6, "{moved:?}");
        let rivals = pairs(&[[0.5, 0.5, 0.6, 0.5], [0.5, 0.5, 0.4, 0.5]]);
        let found = register(&square(), &rivals, [8, 8], Basis::Bspline).expect("solved");
        assert_eq!(found.report.conflicts, [[0, 1]]);
        assert!(found.residuals.iter().all(|&left| (left - 0.1).abs() < 1e-6), "{:?}", found.residuals);
    }

    #[test]
    fn landmarks_that_cross_fold_and_are_told() {
        let crossing = pairs(&[[0.3, 0.5, 0.7, 0.5], [0.7, 0.5, 0.3, 0.5], [0.5, 0.2, 0.5, 0.2], [0.5, 0.8, 0.5, 0.8]]);
        let found = register(&square(), &crossing, [10, 10], Basis::Bspline).expect("solved");
        assert!(found.report.folded_model_cells > 0);
        assert!(register(&square(), &crossing, [3, 10], Basis::Bspline).is_err());
    }
}
