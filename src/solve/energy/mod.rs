//! Distortion energies: one per file, all behind [`Distortion`].
//!
//! In: rest grid, shape, pins and settings. Out: the energy that the settings name.

mod area;
mod area_in_space;
mod distortion;
mod edge;
mod edge_set_packets;
mod edge_sets;
mod element;
mod embedded_vertices;
mod mesh_edges;
mod one_rings;
mod packets;
mod pin_neighbourhoods;
mod polar;
mod rotation_hessian;
mod rotation_hessian_in_space;
mod rotation_response;
mod sample_tasks;
mod set_edges;
mod spokes_and_rims;
mod stroke;
mod vertex;

pub(crate) use area::Area;
pub(crate) use distortion::{Distortion, RotationHessian, ScaledDirection};
pub(crate) use mesh_edges::{HalfEdges, edges};
pub(crate) use pin_neighbourhoods::{Neighbourhood, WithPinNeighbourhoods};
pub(crate) use rotation_response::RotationResponse;

use super::cancel::{Cancel, Cancelled};
use super::merge_duplicates::merge_duplicates;
use super::problem::{PointPin, Shape};
use super::samples::{Sample, centroid_samples, subcell_samples};
use super::settings::{DuplicateVertices, Energy, Sampling, Settings};
use super::stiffness::region_stiffness_at;
use crate::lattice::Grid;
use edge_sets::{EdgeSets, MetricSource};
use embedded_vertices::EmbeddedVertices;
use set_edges::SetEdge;
use vertex::Vertex;

/// Builds the energy that the settings name, or the one that suits the shape, see [`fitting`].
pub(crate) fn build<const D: usize>(
    grid: &Grid<D>,
    shape: &Shape<D>,
    pins: &[PointPin<D>],
    settings: &Settings,
    cancel: &Cancel,
) -> Result<Box<dyn Distortion<D>>, Cancelled> {
    let mesh = || match settings.duplicate_vertices {
        DuplicateVertices::Merged => merge_duplicates(&shape.with_region_stiffness(pins)),
        DuplicateVertices::Separate => shape.with_region_stiffness(pins),
    };
    let edges = |mesh: &Shape<D>| mesh_edges::edges(mesh, settings.weights);
    let built: Box<dyn Distortion<D>> = match fitting(shape, settings).0 {
        Energy::Area => Box::new(area(grid, samples(grid, shape, settings.sampling), pins, cancel)),
        Energy::Stroke => Box::new(stroke::build(grid, shape, pins, settings, cancel)),
        Energy::Edge => {
            let mesh = mesh();
            let edges = edges(&mesh);
            Box::new(edge::build(grid, mesh, edges, cancel))
        }
        Energy::Vertex => {
            let mesh = mesh();
            let edges = edges(&mesh);
            Box::new(Vertex::new(edge::build(grid, mesh, edges.clone(), cancel), &edges))
        }
        Energy::Element => {
            let mesh = mesh();
            let members = element::members(&mesh);
            Box::new(of_triangles(grid, mesh, &members, cancel))
        }
        Energy::SpokesAndRims => {
            let mesh = mesh();
            let members = spokes_and_rims::members(&mesh);
            Box::new(of_triangles(grid, mesh, &members, cancel))
        }
    };
    cancel.check()?;
    Ok(built)
}

/// Samples a shape.
fn samples<const D: usize>(grid: &Grid<D>, shape: &Shape<D>, sampling: Sampling) -> Vec<Sample<D>> {
    match sampling {
        Sampling::Subcells => subcell_samples(grid, shape),
        Sampling::Centroids => centroid_samples(grid, shape),
    }
}

/// Builds energy `area` at samples, stiffened by the regions of pins.
fn area<const D: usize>(grid: &Grid<D>, mut samples: Vec<Sample<D>>, pins: &[PointPin<D>], cancel: &Cancel) -> Area<D> {
    samples.iter_mut().for_each(|sample| sample.stiffness *= region_stiffness_at(pins, sample.at));
    Area::new(grid, &samples, cancel)
}

/// Builds an energy of sets of triangle sides.
fn of_triangles<const D: usize>(grid: &Grid<D>, mesh: Shape<D>, members: &[SetEdge], cancel: &Cancel) -> EdgeSets<D> {
    let mean_stiffness = mesh.mean_stiffness();
    let vertices = EmbeddedVertices::new(grid, mesh.points, cancel);
    EdgeSets::new(vertices, members, MetricSource::Triangles(mesh.triangles)).with_mean_stiffness(mean_stiffness)
}

/// Returns the energy to use for a shape, and a warning if it is not the requested one: a mesh without lines cannot use `stroke`,
/// lines without triangles need it. Problem files with plain sums ([`Sampling::Centroids`]) always get the requested energy.
pub(crate) fn fitting<const D: usize>(shape: &Shape<D>, settings: &Settings) -> (Energy, Option<String>) {
    let wanted = settings.energy;
    if settings.sampling == Sampling::Centroids {
        return (wanted, None);
    }
    match (wanted, shape.triangles.is_empty(), shape.strokes.is_empty()) {
        (_, true, true) => {
            (Energy::Area, Some("the shape has no triangles and no lines: the whole box is preserved instead".into()))
        }
        (Energy::Stroke, false, true) => {
            (Energy::Edge, Some("the shape has no lines: energy `edge` is used instead of `stroke`".into()))
        }
        (Energy::Stroke, ..) | (_, false, _) => (wanted, None),
        (Energy::Area, true, false) => (Energy::Stroke, None),
        (_, true, false) => {
            (Energy::Stroke, Some("the shape has only lines: energy `stroke` is used; set energy = \"stroke\"".into()))
        }
    }
}
