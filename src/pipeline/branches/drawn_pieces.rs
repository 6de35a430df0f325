//! Rasterises the pieces of a layer: finds the piece that each pixel of the unwarped picture shows.
//!
//! In: [`LabelledPiece`]s and a time. Out: a label and a nearness per pixel. Transparent surfaces count as opaque.

use super::labels::{LabelledPiece, interpolated};
use crate::image::convex_spans;
use crate::pipeline::{PreparedShot, TimeSample};
use crate::screen::{primitive, project};
use crate::space::{FrameSize, PixelRect, ScreenPoint};
use glam::Vec2;

/// Label of pixels that show no piece.
pub(super) const NO_LABEL: u32 = u32::MAX;

/// The front-most surface at a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FrontSurface {
    /// [`NO_LABEL`], or an index into the list of labels.
    pub(super) label: u32,
    /// Larger is nearer; linear on the screen.
    pub(super) nearness: f64,
}

/// The pieces of a layer, with the scene that they are part of.
pub(super) struct DrawnPieces<'a> {
    pub(super) prepared: &'a PreparedShot,
    pub(super) now: &'a TimeSample,
    pub(super) pieces: &'a [LabelledPiece],
    pub(super) size: FrameSize,
}

/// A convex polygon in pixels of the frame.
struct Polygon {
    label: u32,
    /// Each corner: x to the right, y down, nearness.
    corners: Vec<[f64; 3]>,
}

/// The pieces projected at one time.
pub(super) struct PlacedPieces {
    time: f64,
    polygons: Vec<Polygon>,
}

impl DrawnPieces<'_> {
    /// Projects the pieces at a time, without those that reach in front of the near plane and single-sided ones that face away.
    pub(super) fn at(&self, time: f64) -> PlacedPieces {
        let (pose, camera) = self.prepared.view(time);
        let mesh = project(&pose, &camera);
        let near = camera.near();
        let polygon = |piece: &LabelledPiece| {
            let vertices = &mesh.parts[piece.part].vertices;
            let ends = piece.corners.map(|corner| vertices[corner as usize]);
            let places: Vec<_> = piece.outline.iter().map(|&weights| interpolated(&ends, weights)).collect();
            let is_seen =
                places.iter().all(|place| place.w > 0.0 && place.depth >= near * 0.999 && place.h.is_finite());
            if !is_seen {
                return None;
            }
            let posed = &self.now.pose.parts[piece.part];
            let source = primitive(&self.prepared.scene, posed);
            let [a, b, c] = ends.map(|end| end.point().0);
            let is_front = ((b - a).perp_dot(c - a) > 0.0) != posed.is_mirrored;
            let all_seen = ends.iter().all(|end| end.w > 0.0);
            if all_seen && !is_front && !self.prepared.scene.materials[source.material].double_sided {
                return None;
            }
            let corner = |place: &crate::screen::Projected| {
                let at = self.size.image_from_screen(place.point()).0;
                let nearness = if camera.is_parallel() { -place.depth } else { 1.0 / place.w };
                [at.x, at.y, nearness]
            };
            Some(Polygon { label: piece.label, corners: places.iter().map(corner).collect() })
        };
        PlacedPieces { time, polygons: self.pieces.iter().filter_map(polygon).collect() }
    }
}

impl PlacedPieces {
    /// Creates the pieces from polygons on the screen: label, nearness, corners.
    pub(super) fn of_screen(polygons: impl Iterator<Item = (u32, f64, Vec<[f64; 2]>)>, size: FrameSize) -> Self {
        let polygon = |(label, nearness, corners): (u32, f64, Vec<[f64; 2]>)| {
            let corner = |[x, y]: [f64; 2]| {
                let at = size.image_from_screen(ScreenPoint::new(x, y)).0;
                [at.x, at.y, nearness]
            };
            Polygon { label, corners: corners.into_iter().map(corner).collect() }
        };
        Self { time: 0.0, polygons: polygons.map(polygon).collect() }
    }

    pub(super) const fn time(&self) -> f64 {
        self.time
    }

    /// Returns the pixels that the pieces may cover, with a margin of two pixels for jitter.
    pub(super) fn window(&self) -> PixelRect {
        let corners = self.polygons.iter().flat_map(|polygon| &polygon.corners);
        let start = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let (low, high) = corners.fold(start, |(low, high), corner| {
            (std::array::from_fn(|d| low[d].min(corner[d])), std::array::from_fn(|d| high[d].max(corner[d])))
        });
        if low[0] > high[0] {
            return PixelRect::default();
        }
        let limit = |x: f64| x.clamp(-1e6, 1e6);
        let (low, high) = (low.map(|x| limit(x.floor() - 2.0) as i32), high.map(|x| limit(x.ceil() + 2.0) as i32));
        PixelRect { x: low[0], y: low[1], width: (high[0] - low[0]) as u32, height: (high[1] - low[1]) as u32 }
    }

    /// Returns the label of every pixel of a window, with the picture shifted by `shift` pixels.
    pub(super) fn labels(&self, window: PixelRect, shift: Vec2) -> Vec<u32> {
        self.front(window, shift).into_iter().map(|front| front.label).collect()
    }

    /// Returns what the centre of every pixel of a window shows, with the picture shifted by `shift` pixels, x right, y down.
    pub(super) fn front(&self, window: PixelRect, shift: Vec2) -> Vec<FrontSurface> {
        let mut seen = vec![FrontSurface { label: NO_LABEL, nearness: f64::NEG_INFINITY }; window.area()];
        let origin = [f64::from(window.x) + 0.5 - f64::from(shift.x), f64::from(window.y) + 0.5 - f64::from(shift.y)];
        let (width, height) = (window.width as usize, window.height as usize);
        for Polygon { label, corners } in &self.polygons {
            let corners: Vec<[f64; 3]> = corners.iter().map(|&[x, y, z]| [x - origin[0], y - origin[1], z]).collect();
            let Some(plane) = plane(&corners) else { continue };
            for (row, columns) in convex_spans(&corners, [width, height]) {
                for column in columns {
                    let nearness = plane[0] + plane[1] * column as f64 + plane[2] * row as f64;
                    let seen = &mut seen[row * width + column];
                    if nearness > seen.nearness {
                        *seen = FrontSurface { label: *label, nearness };
                    }
                }
            }
        }
        seen
    }
}

/// Returns the nearness over a polygon as constant and slopes in x and y, from the largest triangle of its fan.
fn plane(corners: &[[f64; 3]]) -> Option<[f64; 3]> {
    let first = corners.first()?;
    let fan = corners.windows(2).skip(1).map(|pair| {
        let [[ax, ay, az], [bx, by, bz]] =
            [pair[0], pair[1]].map(|corner| std::array::from_fn(|d| corner[d] - first[d]));
        let area: f64 = ax * by - ay * bx;
        (area, [(az * by - bz * ay) / area, (bz * ax - az * bx) / area])
    });
    let (area, [across, down]) = fan.max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))?;
    (area != 0.0).then(|| [first[2] - across * first[0] - down * first[1], across, down])
}
