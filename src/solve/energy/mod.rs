//! Distortion measures: one a file, all behind [`Distortion`].
//!
//! In: rest grid and shape. Out: the constant normal matrix, and per iteration the rotations and the right side.

mod area;
mod edge;
mod edge_packs;
mod edge_sets;
mod element;
mod fans;
mod neighbours;
mod patches;
mod quads;
mod rims;
mod stroke;
mod turns;
mod vertex;
mod vertices;

pub(crate) use area::Area;
pub(crate) use neighbours::{HalfEdges, edges};
pub(crate) use patches::Patched;

use super::matrix::Normal;
use super::samples::{Sample, centroid_samples, subcell_samples};
use super::small::{Square, area_of, determinant, dot, minus};
use super::stiffness::starch_at;
use super::weld::weld;
use super::{Energy, EqualVertices, PointPin, Sampling, Settings, Shape};
use crate::lattice::Grid;
use edge_sets::{EdgeSets, Seen, SetEdge};
use vertex::Vertex;
use vertices::Vertices;

/// A sum of squares that is quadratic in the handles once its rotations are fixed.
pub(crate) trait Distortion<const D: usize>: Send + Sync + std::fmt::Debug {
    /// What turns the sum into a mean of ‖J−R‖²: twice the area it covers.
    fn mass(&self) -> f64;

    /// How far apart handles are, by index, that meet in the matrix.
    fn reach(&self) -> usize;

    /// Adds the constant matrix.
    fn add_normal(&self, scale: f64, normal: &mut Normal);

    /// Local step: the best rotations at `handles`. Adds their right side, times `scale`; gives the energy there.
    fn local_step(&self, handles: &[[f64; D]], scale: f64, right_side: &mut [[f64; D]]) -> f64;

    /// What a local step and [`Self::subtract_turns`] cost; `None` where the latter is not known.
    fn work(&self) -> Option<Work> {
        None
    }

    /// Takes off the matrix of all coordinates (rows D·handle + coordinate) what is less because rotations follow: with
    /// that it is the second derivative at `handles`.
    fn subtract_turns(&self, _handles: &[[f64; D]], _turns: Turns, _normal: &mut Normal) {}

    /// The energy at `handles` under the rotations that are best at `turned_at`.
    fn energy(&self, handles: &[[f64; D]], turned_at: &[[f64; D]]) -> f64;

    /// How the shape fares at `handles`.
    fn quality(&self, handles: &[[f64; D]]) -> Quality;
}

/// Fused multiplications and additions.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Work {
    /// Of a local step.
    pub(crate) local_step: f64,
    /// Of the squares that turns take off the matrix.
    pub(crate) turns: f64,
}

/// What rotations that follow take off the second derivative.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turns {
    /// Factor of the energy.
    pub(crate) scale: f64,
    /// Most of 1/(s1 + s2), s1 and s2 the singular values of a sample: up to ½ every sample stays convex.
    pub(crate) limit: f64,
}

/// Area-weighted sums over samples.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Quality {
    least_det: f64,
    area: f64,
    angular_sum: f64,
    area_sum: f64,
}

impl Quality {
    pub(crate) fn new() -> Self {
        Self { least_det: f64::INFINITY, area: 0.0, angular_sum: 0.0, area_sum: 0.0 }
    }

    /// Adds a sample by its gradient.
    pub(crate) fn add<const D: usize>(&mut self, area: f64, gradient: &Square<D>) {
        let det = determinant(gradient);
        let norm: f64 = gradient.iter().flatten().map(|x| x * x).sum();
        // In the plane s1² + s2² = ‖J‖² and s1·s2 = |det J|; in space these are means over the three directions.
        self.add_measured(area, det, norm / D as f64, if D == 2 { det.abs() } else { det.abs().powf(2.0 / D as f64) });
    }

    /// Adds a triangle by its rest and moved corners; triangles without area count for nothing.
    pub(crate) fn add_triangle<const D: usize>(&mut self, rest: [&[f64; D]; 3], moved: [&[f64; D]; 3]) {
        let sides = |corners: [&[f64; D]; 3]| [minus(corners[1], corners[0]), minus(corners[2], corners[0])];
        let ([u, v], [a, b]) = (sides(rest), sides(moved));
        let doubled = area_of(&u, &v);
        if doubled <= 0.0 {
            return;
        }
        // An orthonormal frame of the rest triangle makes the map a 2 x 2 (or 3 x 2) matrix.
        let along = dot(&u, &u).sqrt();
        let (shear, height) = (dot(&u, &v) / along, doubled / along);
        let first: [f64; D] = std::array::from_fn(|d| a[d] / along);
        let second: [f64; D] = std::array::from_fn(|d| (b[d] - shear * first[d]) / height);
        let turned = if D == 2 && u[0] * v[1] - u[1] * v[0] < 0.0 { -1.0 } else { 1.0 };
        let det =
            if D == 2 { turned * (first[0] * second[1] - first[1] * second[0]) } else { area_of(&first, &second) };
        self.add_measured(0.5 * doubled, det, 0.5 * (dot(&first, &first) + dot(&second, &second)), det.abs());
    }

    /// Adds a sample by determinant, mean squared singular value, and squared geometric mean of them.
    fn add_measured(&mut self, area: f64, det: f64, power: f64, volume: f64) {
        let volume = volume.max(1e-12);
        self.least_det = self.least_det.min(det);
        self.area += area;
        self.angular_sum += area * (2.0 * power / volume - 2.0).max(0.0);
        self.area_sum += area * (volume + 1.0 / volume - 2.0);
    }

    /// Least determinant; 1 where there was nothing to see.
    pub(crate) fn least_det(&self) -> f64 {
        if self.area > 0.0 { self.least_det } else { 1.0 }
    }

    /// Mean of s1/s2 + s2/s1 − 2.
    pub(crate) fn angular(&self) -> f64 {
        if self.area > 0.0 { self.angular_sum / self.area } else { 0.0 }
    }

    /// Mean of s1·s2 + 1/(s1·s2) − 2.
    pub(crate) fn area(&self) -> f64 {
        if self.area > 0.0 { self.area_sum / self.area } else { 0.0 }
    }
}

/// Builds the measure that the settings ask for, or the one that suits the shape, see [`fitting`].
pub(crate) fn build<const D: usize>(
    grid: &Grid<D>,
    shape: &Shape<D>,
    pins: &[PointPin<D>],
    settings: &Settings,
) -> Box<dyn Distortion<D>> {
    let starched = |mut samples: Vec<Sample<D>>| {
        samples.iter_mut().for_each(|sample| sample.stiffness *= starch_at(pins, sample.at));
        samples
    };
    match (fitting(shape, settings).0, settings.sampling) {
        (Energy::Area, Sampling::Subcells) => Box::new(Area::new(grid, &starched(subcell_samples(grid, shape)))),
        (Energy::Area, Sampling::Centroids) => Box::new(Area::new(grid, &starched(centroid_samples(grid, shape)))),
        (Energy::Stroke, _) => Box::new(stroke::build(grid, shape, pins, settings)),
        (of_mesh, _) => match settings.equal_vertices {
            EqualVertices::Welded => build_of_mesh(grid, weld(&shape.starched(pins)), of_mesh, settings),
            EqualVertices::Apart => build_of_mesh(grid, shape.starched(pins), of_mesh, settings),
        },
    }
}

/// Builds a measure that looks at the edges of a mesh.
fn build_of_mesh<const D: usize>(
    grid: &Grid<D>,
    shape: Shape<D>,
    energy: Energy,
    settings: &Settings,
) -> Box<dyn Distortion<D>> {
    let of_triangles = |shape: Shape<D>, members: Vec<SetEdge>| {
        let mean_stiffness = shape.mean_stiffness();
        let sets = EdgeSets::new(Vertices::new(grid, shape.points), &members, Seen::Triangles(shape.triangles));
        Box::new(sets.of_mean_stiffness(mean_stiffness))
    };
    match energy {
        Energy::Element => {
            let members = element::members(&shape);
            of_triangles(shape, members)
        }
        Energy::Rims => {
            let members = rims::members(&shape);
            of_triangles(shape, members)
        }
        Energy::Vertex => {
            let edges = neighbours::edges(&shape, settings.weights);
            Box::new(Vertex::new(edge::build(grid, shape, edges.clone()), &edges))
        }
        _ => {
            let edges = neighbours::edges(&shape, settings.weights);
            Box::new(edge::build(grid, shape, edges))
        }
    }
}

/// The measure that suits a shape, and what to tell the user where it is not the wanted one: meshes have no lines and
/// lines no triangles. Problem files that count plain sums ([`Sampling::Centroids`]) get what they ask for.
pub(crate) fn fitting<const D: usize>(shape: &Shape<D>, settings: &Settings) -> (Energy, Option<String>) {
    let wanted = settings.energy;
    if settings.sampling == Sampling::Centroids {
        return (wanted, None);
    }
    match (wanted, shape.triangles.is_empty(), shape.strokes.is_empty()) {
        (_, true, true) => (
            Energy::Area,
            Some("the shape has no triangles and no lines: the whole box keeps its shape instead".into()),
        ),
        (Energy::Stroke, false, true) => {
            (Energy::Edge, Some("the shape has no lines: energy `edge` keeps its triangles instead of `stroke`".into()))
        }
        (Energy::Stroke, ..) | (_, false, _) => (wanted, None),
        (Energy::Area, true, false) => (Energy::Stroke, None),
        (_, true, false) => (
            Energy::Stroke,
            Some("the shape has lines only: energy `stroke` keeps them; set energy = \"stroke\"".into()),
        ),
    }
}
