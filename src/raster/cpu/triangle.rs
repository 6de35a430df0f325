//! Triangle set-up: three window vertices become integer edge functions and interpolation planes.
//!
//! In: vertices in window pixels (y down). Out: [`Triangle`]s, culled, clipped to the guard band, bounded by the
//! window.

use crate::raster::window::{GUARD_BAND, SUBPIXELS, is_in_guard_band, snap};
use glam::{DVec2, IVec2};

/// Largest window side: with the guard band, it keeps edge values inside a tile below 2³¹.
pub(super) const MAX_SIDE: u32 = 16384;

/// A vertex in window space.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct WindowVertex {
    /// Window pixels, y down, jitter applied.
    pub(super) at: DVec2,
    /// Reversed z, 1 at the near plane.
    pub(super) z: f32,
    /// 1 / w; NaN if the vertex cannot be drawn.
    pub(super) inverse_w: f32,
}

impl WindowVertex {
    pub(super) fn is_drawable(&self) -> bool {
        self.at.is_finite() && self.z.is_finite() && self.inverse_w.is_finite() && self.inverse_w > 0.0
    }
}

/// An edge function in whole pixels: E(i, j) = a·i + b·j + c; E ≥ 0 inside and on owned edges.
///
/// ```text
///   window pixels, y down      snapped to 1/256 px            edge from p to q, inside E >= 0
///   (0,0)──▶ x                 E(x, y) = a·x + b·y + c        a = p.y − q.y, b = q.x − p.x
///     ▼ y                      pixel (i, j) sampled at (i + ½, j + ½)
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Edge {
    pub(super) a: i32,
    pub(super) b: i32,
    pub(super) c: i64,
}

/// A linear function of the pixel, relative to the triangle's first pixel: base + dx·(i − min.x) + dy·(j − min.y).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Plane {
    pub(super) base: f32,
    pub(super) dx: f32,
    pub(super) dy: f32,
}

impl Plane {
    pub(super) fn at(&self, offset: IVec2) -> f32 {
        self.base + self.dy * offset.y as f32 + self.dx * offset.x as f32
    }
}

/// A triangle ready to be rasterised.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle {
    /// Edge functions.
    pub(super) edges: [Edge; 3],
    /// First pixel whose centre may be covered.
    pub(super) min: IVec2,
    /// Last such pixel.
    pub(super) max: IVec2,
    /// Reversed z.
    pub(super) z: Plane,
    /// Screen-space barycentrics of corners 1 and 2 (not perspective-correct).
    pub(super) barycentrics: [Plane; 2],
    /// 1 / w of the corners.
    pub(super) inverse_w: [f32; 3],
    /// Vertex indices of the corners.
    pub(super) corners: [u32; 3],
    /// Index of the draw.
    pub(super) draw: u32,
    /// Whether its front is visible.
    pub(super) is_front: bool,
}

/// A triangle before its vertices are transformed to the window.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source {
    /// Vertex indices of the corners.
    pub(super) corners: [u32; 3],
    /// Index of the draw.
    pub(super) draw: u32,
    /// Whether front faces are clockwise.
    pub(super) is_mirrored: bool,
    /// Whether back faces are culled.
    pub(super) is_culled: bool,
}

/// Sets up a triangle and emits its part inside the window: nothing, one triangle, or a fan if it was clipped.
pub(super) fn set_up(source: &Source, corners: [WindowVertex; 3], window: IVec2, emit: &mut impl FnMut(Triangle)) {
    if !corners.iter().all(WindowVertex::is_drawable) {
        return;
    }
    let at = corners.map(|vertex| vertex.at);
    if lies_outside(at, window) {
        return;
    }
    if at.into_iter().all(is_in_guard_band) {
        let snapped = at.map(snap);
        let unsnapped = snapped.map(|at| at.as_dvec2() / SUBPIXELS);
        if let Some(functions) = EdgeFunctions::of(snapped, window) {
            emit_covered(source, &corners, (functions, unsnapped), emit);
        }
        return;
    }
    let rest = clip_to_guard(at);
    for pair in rest.windows(2).skip(1) {
        if let Some(functions) = EdgeFunctions::of([rest[0], pair[0], pair[1]].map(snap), window) {
            emit_covered(source, &corners, (functions, at), emit);
        }
    }
}

/// Returns whether all corners lie beyond one side of the window.
fn lies_outside(at: [DVec2; 3], window: IVec2) -> bool {
    let low = at[0].min(at[1]).min(at[2]);
    let high = at[0].max(at[1]).max(at[2]);
    high.x < 0.0 || high.y < 0.0 || low.x > f64::from(window.x) || low.y > f64::from(window.y)
}

/// The edges of a snapped triangle, and the pixels that it may cover.
struct EdgeFunctions {
    edges: [Edge; 3],
    min: IVec2,
    max: IVec2,
    /// Whether the corners are counter-clockwise as seen by the viewer.
    is_counter_clockwise: bool,
}

impl EdgeFunctions {
    /// Computes the edge functions; `None` if the triangle has no area or covers no pixel centre of the window.
    fn of(at: [IVec2; 3], window: IVec2) -> Option<Self> {
        let [p, q, r] = at.map(|at| at.as_i64vec2());
        let area = (q - p).perp_dot(r - p);
        if area == 0 {
            return None;
        }
        let low = at[0].min(at[1]).min(at[2]);
        let high = at[0].max(at[1]).max(at[2]);
        // The first pixel centre at or after low: i·256 + 128 >= low.
        let min = ((low + 127) >> IVec2::splat(8)).max(IVec2::ZERO);
        let max = ((high - 128) >> IVec2::splat(8)).min(window - 1);
        if min.x > max.x || min.y > max.y {
            return None;
        }
        let ordered = if area > 0 { at } else { [at[0], at[2], at[1]] };
        let edges = [0, 1, 2].map(|i| edge(ordered[i], ordered[(i + 1) % 3]));
        Some(Self { edges, min, max, is_counter_clockwise: area < 0 })
    }
}

/// Returns the edge function from p to q, positive inside (clockwise triangles in y-down pixels).
///
/// Top-left rule: a pixel centre exactly on an edge is inside if the edge is a left edge (a > 0) or a horizontal top
/// edge, so a shared edge is drawn by one neighbour only. Stepping by pixels changes E by multiples of 256, so the low
/// eight bits can be dropped (rounding down) without changing its sign.
fn edge(p: IVec2, q: IVec2) -> Edge {
    let (a, b) = (p.y - q.y, q.x - p.x);
    let is_owner = a > 0 || (a == 0 && b > 0);
    let (wide_a, wide_b) = (i64::from(a), i64::from(b));
    let c = wide_a * i64::from(128 - p.x) + wide_b * i64::from(128 - p.y) - i64::from(!is_owner);
    Edge { a, b, c: c >> 8 }
}

/// Adds the interpolation planes, computed from the corners before clipping (`place.1`, window pixels).
fn emit_covered(
    source: &Source,
    corners: &[WindowVertex; 3],
    place: (EdgeFunctions, [DVec2; 3]),
    emit: &mut impl FnMut(Triangle),
) {
    let (functions, [p, q, r]) = place;
    let is_front = functions.is_counter_clockwise != source.is_mirrored;
    let area = (q - p).perp_dot(r - p);
    if (source.is_culled && !is_front) || area == 0.0 {
        return;
    }
    let first = functions.min.as_dvec2() + 0.5;
    let barycentric = |from: DVec2, to: DVec2| {
        let side = (to - from) / area;
        [side.perp_dot(first - from), -side.y, side.x]
    };
    // The barycentric of a corner is the area that its opposite edge spans with the point, divided by that of the
    // triangle.
    let (second, third) = (barycentric(r, p), barycentric(p, q));
    let [z0, z1, z2] = corners.map(|vertex| f64::from(vertex.z));
    let z = [0, 1, 2].map(|i| second[i] * (z1 - z0) + third[i] * (z2 - z0));
    emit(Triangle {
        edges: functions.edges,
        min: functions.min,
        max: functions.max,
        z: plane([z[0] + z0, z[1], z[2]]),
        barycentrics: [plane(second), plane(third)],
        inverse_w: corners.map(|vertex| vertex.inverse_w),
        corners: source.corners,
        draw: source.draw,
        is_front,
    });
}

fn plane([base, dx, dy]: [f64; 3]) -> Plane {
    Plane { base: base as f32, dx: dx as f32, dy: dy as f32 }
}

/// Clips a triangle to the guard band, giving a convex polygon (Sutherland and Hodgman 1974).
///
/// Neighbours get the same new corners on a shared edge because [`cut`] always traverses it in the same direction.
fn clip_to_guard(at: [DVec2; 3]) -> Vec<DVec2> {
    let mut polygon = at.to_vec();
    for axis in 0..2 {
        for (limit, sign) in [(*GUARD_BAND.start(), 1.0), (*GUARD_BAND.end(), -1.0)] {
            let height = |point: DVec2| (point[axis] - limit) * sign;
            let mut kept = Vec::with_capacity(polygon.len() + 1);
            for (i, &from) in polygon.iter().enumerate() {
                let to = polygon[(i + 1) % polygon.len()];
                if height(from) >= 0.0 {
                    kept.push(from);
                }
                if (height(from) >= 0.0) != (height(to) >= 0.0) {
                    kept.push(cut(from, to, axis, limit));
                }
            }
            polygon = kept;
        }
    }
    polygon
}

/// Returns where the segment crosses `limit` on `axis`.
fn cut(from: DVec2, to: DVec2, axis: usize, limit: f64) -> DVec2 {
    let (low, high) = if from[axis] < to[axis] { (from, to) } else { (to, from) };
    let mut point = low.lerp(high, (limit - low[axis]) / (high[axis] - low[axis]));
    point[axis] = limit;
    point
}
