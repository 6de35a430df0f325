//! Measures how thin the parts of a model are.
//!
//! In: a layer's mesh at rest. Out: [`Slenderness`].

use super::rest_mesh::RestMesh;
use crate::solve::{inner_widths, link_length, sampled_solid_links};

/// Quantile of a layer's widths that counts as its thickness; the narrower ones are corners and tips.
const THINNER: f64 = 0.15;

/// Distance of the places where the thickness of a solid is measured, as a fraction of its diagonal.
const PITCH: f64 = 1.0 / 48.0;

/// How thin a layer is at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::pipeline) enum Slenderness {
    /// It has no extent.
    Unseen,
    /// The thickness of its thinnest parts, relative to its longest side; `None` if it has no thin parts.
    Seen(Option<f64>),
}

impl Slenderness {
    pub(super) fn of(mesh: &RestMesh) -> Self {
        match longest_side(mesh) {
            Some(longest) => Self::Seen(thickness(mesh).map(|thickness| thickness / longest)),
            None => Self::Unseen,
        }
    }
}

/// Returns the thickness of a mesh: measured through a solid, or across a flat picture.
fn thickness(mesh: &RestMesh) -> Option<f64> {
    let links = sampled_solid_links(&mesh.points, &mesh.triangles, PITCH);
    let widths: Vec<f64> = if links.is_empty() {
        inner_widths(&mesh.flat(), &mesh.triangles)
    } else {
        links.iter().map(|link| link_length(link, &mesh.points, &mesh.triangles)).collect()
    };
    let mut widths: Vec<f64> = widths.into_iter().filter(|&width| width > 0.0).collect();
    widths.sort_by(f64::total_cmp);
    widths.get((THINNER * widths.len() as f64) as usize).copied()
}

fn longest_side(mesh: &RestMesh) -> Option<f64> {
    let longest = mesh.sides().into_iter().fold(0.0, f64::max);
    (longest.is_finite() && longest > 0.0).then_some(longest)
}
