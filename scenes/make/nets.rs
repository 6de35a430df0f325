//! Smooth closed surfaces from distance fields, and surfaces of revolution.
//!
//! In: a function that is negative inside. Out: triangles with shared vertices and the gradient of the field as
//! normals. Method: S. F. F. Gibson, "Constrained elastic surface nets", 1998, in its naive form (one vertex per cell,
//! at the mean of its edge crossings), followed by a projection of the vertices onto the surface along the gradient.

use super::glb::Surface;
use glam::{DVec2, DVec3, IVec3};
use std::collections::HashMap;

/// The box in which the surface is searched, and the size of the cells.
pub(crate) struct Region {
    /// Lower corner.
    pub(crate) lo: DVec3,
    /// Upper corner.
    pub(crate) hi: DVec3,
    /// Side of a cell, metres.
    pub(crate) cell: f64,
}

/// Direction of steepest ascent of a field, unit length.
fn normal(field: &impl Fn(DVec3) -> f64, at: DVec3) -> DVec3 {
    const STEP: f64 = 1e-4;
    let slope = |axis: DVec3| field(at + axis * STEP) - field(at - axis * STEP);
    DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z)).normalize_or(DVec3::Y)
}

/// The surface on which the field vanishes.
pub(crate) fn skin_of(field: impl Fn(DVec3) -> f64, region: &Region) -> Surface {
    let counts = ((region.hi - region.lo) / region.cell).ceil().as_ivec3();
    let corner = |at: IVec3| region.lo + at.as_dvec3() * region.cell;
    let mut values = HashMap::new();
    for at in cells(counts + 1) {
        values.insert(at, field(corner(at)));
    }
    let mut surface = Surface::default();
    let mut vertex_of = HashMap::new();
    for at in cells(counts) {
        if let Some(middle) = crossing_mean(|offset| values[&(at + offset)]) {
            vertex_of.insert(at, surface.positions.len() as u32);
            surface.positions.push(corner(at) + middle * region.cell);
        }
    }
    for at in cells(counts) {
        for axis in [IVec3::X, IVec3::Y, IVec3::Z] {
            let (here, there) = (values[&at], values[&(at + axis)]);
            let (u, v) = (IVec3::new(axis.z, axis.x, axis.y), IVec3::new(axis.y, axis.z, axis.x));
            let ring = [at - u - v, at - v, at, at - u].map(|cell| vertex_of.get(&cell).copied());
            let (true, [Some(a), Some(b), Some(c), Some(d)]) = ((here < 0.0) != (there < 0.0), ring) else {
                continue;
            };
            let quad = if here < 0.0 { [a, b, c, d] } else { [d, c, b, a] };
            surface.triangles.extend([[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]]);
        }
    }
    for position in &mut surface.positions {
        for _ in 0..4 {
            let value = field(*position);
            *position -= normal(&field, *position) * value.clamp(-0.5 * region.cell, 0.5 * region.cell) * 0.9;
        }
        surface.normals.push(normal(&field, *position));
    }
    surface
}

/// All integer points from zero up to, but not including, `counts`.
fn cells(counts: IVec3) -> impl Iterator<Item = IVec3> {
    (0..counts.z).flat_map(move |z| (0..counts.y).flat_map(move |y| (0..counts.x).map(move |x| IVec3::new(x, y, z))))
}

/// Mean of the points where the surface crosses the edges of a cell, in units of the cell.
fn crossing_mean(value_at: impl Fn(IVec3) -> f64) -> Option<DVec3> {
    let mut sum = DVec3::ZERO;
    let mut count = 0.0;
    for from in cells(IVec3::splat(2)) {
        for axis in [IVec3::X, IVec3::Y, IVec3::Z].into_iter().filter(|axis| (from * *axis) == IVec3::ZERO) {
            let (a, b) = (value_at(from), value_at(from + axis));
            if (a < 0.0) != (b < 0.0) {
                sum += from.as_dvec3() + axis.as_dvec3() * (a / (a - b));
                count += 1.0;
            }
        }
    }
    (count > 0.0).then(|| sum / count)
}

/// Rotates a profile of (radius, height), given from top to bottom along the outside, around the y axis. u runs around
/// the axis, v along the profile.
pub(crate) fn lathe(profile: &[DVec2], around: u32) -> Surface {
    let mut surface = Surface::default();
    let rows = profile.len() as u32;
    for (row, point) in profile.iter().enumerate() {
        let along = profile[(row + 1).min(profile.len() - 1)] - profile[row.saturating_sub(1)];
        let outwards = DVec2::new(-along.y, along.x).normalize_or(DVec2::Y);
        for step in 0..=around {
            let u = f64::from(step) / f64::from(around);
            let (sin, cos) = (u * std::f64::consts::TAU).sin_cos();
            surface.positions.push(DVec3::new(point.x * sin, point.y, point.x * cos));
            surface.normals.push(DVec3::new(outwards.x * sin, outwards.y, outwards.x * cos));
            surface.uvs.push(DVec2::new(u, row as f64 / f64::from(rows - 1)));
        }
    }
    let stride = around + 1;
    for (row, step) in (0..rows - 1).flat_map(|row| (0..around).map(move |step| (row, step))) {
        let at = row * stride + step;
        surface.triangles.extend([[at, at + stride, at + stride + 1], [at, at + stride + 1, at + 1]]);
    }
    surface
}
