//! Anti-aliased drawing on a preview, for overlays.
//!
//! In: shapes in image space (pixels, y down, origin at the upper left corner of the picture). Out: pixels blended over
//! the picture. Shapes are clipped; those with coordinates that are not finite or beyond [`FARTHEST_PX`] are skipped,
//! so that no input can panic or take unbounded time.

use super::Preview;
use super::font;
use crate::space::ImagePoint;
use glam::DVec2;
use std::ops::Range;

/// Larger than any picture; beyond it, differences of coordinates lose pixel precision.
const FARTHEST_PX: f64 = 1e9;

/// Scan lines per pixel row for polygon filling; coverage along a scan line is exact.
const SUB_LINES: usize = 4;

/// An sRGB colour with straight alpha.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rgba8(pub [u8; 4]);

/// A canvas over a picture; later shapes cover earlier ones.
///
/// ```
/// use pinwarp::image::{Canvas, Preview, Rgba8};
/// use pinwarp::space::ImagePoint;
///
/// let mut picture = Preview::transparent(16, 16);
/// Canvas::new(&mut picture).disc(ImagePoint::new(8.0, 8.0), 4.0, Rgba8([255, 0, 0, 255]));
/// assert_eq!(picture.pixel(8, 8), Some([255, 0, 0, 255]));
/// ```
#[derive(Debug)]
pub struct Canvas<'a> {
    picture: &'a mut Preview,
}

impl<'a> Canvas<'a> {
    /// Creates a canvas over `picture`.
    pub fn new(picture: &'a mut Preview) -> Self {
        Self { picture }
    }

    /// Draws a line with round caps; below a width of one pixel, it fades instead of getting thinner.
    pub fn line(&mut self, a: ImagePoint, b: ImagePoint, width_px: f64, color: Rgba8) {
        if !is_drawable(&[a, b]) || !is_length(width_px) {
            return;
        }
        let stroke = Stroke { from: a.0, along: b.0 - a.0, width: width_px };
        let reach = width_px / 2.0 + 1.0;
        for row in self.rows(a.0.y.min(b.0.y) - reach, a.0.y.max(b.0.y) + reach) {
            let y = f64::from(row) + 0.5;
            let span = stroke.columns_near(y, reach);
            self.blend_row(row, span, color, |x| stroke.coverage(DVec2::new(x, y)));
        }
    }

    /// Draws a filled circle.
    pub fn disc(&mut self, center: ImagePoint, radius_px: f64, color: Rgba8) {
        self.round(center, radius_px + 1.0, color, |distance| radius_px + 0.5 - distance);
    }

    /// Draws the outline of a circle, centred on the stroke.
    pub(crate) fn ring(&mut self, center: ImagePoint, radius_px: f64, width_px: f64, color: Rgba8) {
        if !is_length(width_px) {
            return;
        }
        let reach = radius_px + width_px / 2.0 + 1.0;
        let coverage = |distance: f64| stroke_coverage((distance - radius_px).abs(), width_px);
        self.round(center, reach, color, coverage);
    }

    fn round(&mut self, center: ImagePoint, reach: f64, color: Rgba8, coverage: impl Fn(f64) -> f64) {
        if !is_drawable(&[center]) || !is_length(reach) {
            return;
        }
        let center = center.0;
        for row in self.rows(center.y - reach, center.y + reach) {
            let y = f64::from(row) + 0.5;
            let span = center.x - reach..center.x + reach;
            self.blend_row(row, span, color, |x| coverage(DVec2::new(x, y).distance(center)));
        }
    }

    /// Draws a filled polygon by the even-odd rule.
    pub(crate) fn fill_polygon(&mut self, corners: &[ImagePoint], color: Rgba8) {
        if corners.len() < 3 || !is_drawable(corners) {
            return;
        }
        let bounds = |pick: fn(DVec2) -> f64| {
            let values = corners.iter().map(|corner| pick(corner.0));
            values.clone().fold(f64::INFINITY, f64::min)..values.fold(f64::NEG_INFINITY, f64::max)
        };
        let (span, height) = (bounds(|corner| corner.x), bounds(|corner| corner.y));
        for row in self.rows(height.start, height.end) {
            let inside: [_; SUB_LINES] = std::array::from_fn(|sub| {
                let y = f64::from(row) + (sub as f64 + 0.5) / SUB_LINES as f64;
                crossings(corners, y)
            });
            self.blend_row(row, span.clone(), color, |x| polygon_coverage(&inside, x));
        }
    }

    /// Draws a line of text with a dark outline, `at` its upper left corner. Each cell of the 5x9 glyphs is `scale`
    /// pixels wide and high. Non-ASCII characters are shown as boxes.
    pub(crate) fn text(&mut self, at: ImagePoint, text: &str, scale: u32, color: Rgba8) {
        if !is_drawable(&[at]) || scale == 0 {
            return;
        }
        let characters: Vec<char> = text.chars().collect();
        let rim = Rgba8([0, 0, 0, color.0[3]]);
        let columns = (characters.len() * (font::COLUMNS + 1)) as i64;
        for row in -1..=font::ROWS as i64 {
            for column in -1..=columns {
                let color = if has_ink(&characters, column, row) {
                    color
                } else if is_beside_ink(&characters, column, row) {
                    rim
                } else {
                    continue;
                };
                self.cell(at.0.round() + DVec2::new(column as f64, row as f64) * f64::from(scale), scale, color);
            }
        }
    }

    /// Draws a pixel-aligned square.
    fn cell(&mut self, corner: DVec2, side: u32, color: Rgba8) {
        let end = corner + f64::from(side);
        for row in self.rows(corner.y, end.y) {
            self.blend_row(row, corner.x..end.x, color, |_| 1.0);
        }
    }

    /// Returns the rows of the picture between two heights.
    fn rows(&self, top: f64, bottom: f64) -> Range<u32> {
        clipped(top..bottom, self.picture.height)
    }

    /// Blends the colour over the pixels of a row; `coverage` is evaluated at their centres and clamped to 0..=1.
    fn blend_row(&mut self, row: u32, span: Range<f64>, color: Rgba8, coverage: impl Fn(f64) -> f64) {
        for column in clipped(span, self.picture.width) {
            let coverage = coverage(f64::from(column) + 0.5).clamp(0.0, 1.0) as f32;
            let Some(pixel) = self.picture.pixel_mut(column, row) else { continue };
            if coverage > 0.0 {
                *pixel = over(color.0, coverage, *pixel);
            }
        }
    }
}

/// A thick line segment.
struct Stroke {
    from: DVec2,
    along: DVec2,
    width: f64,
}

impl Stroke {
    fn coverage(&self, point: DVec2) -> f64 {
        let length_squared = self.along.length_squared();
        let t = if length_squared > 0.0 { (point - self.from).dot(self.along) / length_squared } else { 0.0 };
        stroke_coverage(point.distance(self.from + self.along * t.clamp(0.0, 1.0)), self.width)
    }

    /// Returns the columns where the segment is within `reach` of the height `y`, so that long lines cost only the pixels they cover.
    fn columns_near(&self, y: f64, reach: f64) -> Range<f64> {
        let t_at = |height: f64| ((height - self.from.y) / self.along.y).clamp(0.0, 1.0);
        let is_level = self.along.y.abs() < 1e-9;
        let (t0, t1) = if is_level { (0.0, 1.0) } else { (t_at(y - reach), t_at(y + reach)) };
        let (x0, x1) = (self.from.x + t0 * self.along.x, self.from.x + t1 * self.along.x);
        x0.min(x1) - reach..x0.max(x1) + reach
    }
}

/// Returns the coverage of a pixel whose centre is `distance` away from the centre line of a stroke.
fn stroke_coverage(distance: f64, width: f64) -> f64 {
    (width / 2.0 + 0.5 - distance).min(width)
}

/// Returns the intersections of the outline with the height `y`, from the left; an even number.
fn crossings(corners: &[ImagePoint], y: f64) -> Vec<f64> {
    let nexts = corners.iter().cycle().skip(1);
    let edges = corners.iter().zip(nexts).map(|(a, b)| (a.0, b.0));
    let crossed = edges.filter(|(a, b)| (a.y <= y) != (b.y <= y));
    let mut at: Vec<f64> = crossed.map(|(a, b)| a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y))).collect();
    at.sort_by(f64::total_cmp);
    at
}

/// Returns the fraction of the pixel centred at `x` between pairs of intersections.
fn polygon_coverage(inside: &[Vec<f64>; SUB_LINES], x: f64) -> f64 {
    let covered = |pair: &[f64]| ((x + 0.5).min(pair[1]) - (x - 0.5).max(pair[0])).max(0.0);
    let sum: f64 = inside.iter().flat_map(|line| line.chunks_exact(2)).map(covered).sum();
    sum / SUB_LINES as f64
}

fn has_ink(text: &[char], column: i64, row: i64) -> bool {
    let (Ok(column), Ok(row)) = (usize::try_from(column), usize::try_from(row)) else { return false };
    let (index, column) = (column / (font::COLUMNS + 1), column % (font::COLUMNS + 1));
    text.get(index).is_some_and(|&character| font::has_ink(character, column, row))
}

fn is_beside_ink(text: &[char], column: i64, row: i64) -> bool {
    (-1..=1).any(|down| (-1..=1).any(|right| has_ink(text, column + right, row + down)))
}

/// Returns the pixels in 0..`limit` that overlap a range.
fn clipped(range: Range<f64>, limit: u32) -> Range<u32> {
    // Float-to-integer casts saturate, and NaN becomes 0: at worst an empty range.
    (range.start.floor() as u32).min(limit)..(range.end.ceil() as u32).min(limit)
}

fn is_drawable(points: &[ImagePoint]) -> bool {
    points.iter().all(|point| point.0.is_finite() && point.0.abs().max_element() <= FARTHEST_PX)
}

fn is_length(pixels: f64) -> bool {
    pixels > 0.0 && pixels <= FARTHEST_PX
}

/// Porter and Duff's over for straight alpha, blended in sRGB values as painting programs do.
fn over(source: [u8; 4], coverage: f32, below: [u8; 4]) -> [u8; 4] {
    let source_alpha = f32::from(source[3]) / 255.0 * coverage;
    let below_alpha = f32::from(below[3]) / 255.0 * (1.0 - source_alpha);
    let alpha = source_alpha + below_alpha;
    if alpha <= 0.0 {
        return below;
    }
    let mix = |c: usize| (f32::from(source[c]) * source_alpha + f32::from(below[c]) * below_alpha) / alpha;
    [mix(0), mix(1), mix(2), alpha * 255.0].map(|value| value.round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const WHITE: Rgba8 = Rgba8([255; 4]);

    fn at(x: f64, y: f64) -> ImagePoint {
        ImagePoint::new(x, y)
    }

    fn drawn(draw: impl FnOnce(&mut Canvas)) -> Preview {
        let mut picture = Preview::transparent(32, 24);
        draw(&mut Canvas::new(&mut picture));
        picture
    }

    /// Returns the sum of all alphas, in pixels.
    fn area(picture: &Preview) -> f64 {
        picture.rgba.chunks_exact(4).map(|pixel| f64::from(pixel[3]) / 255.0).sum()
    }

    #[test]
    fn shapes_cover_their_area() {
        let near = |picture: Preview, expected: f64| {
            let covered = area(&picture);
            assert!((covered - expected).abs() < 0.03 * expected, "{covered} for {expected}");
        };
        let pi = std::f64::consts::PI;
        near(drawn(|canvas| canvas.disc(at(16.3, 11.8), 8.0, WHITE)), pi * 64.0);
        near(drawn(|canvas| canvas.ring(at(16.3, 11.8), 8.0, 2.0, WHITE)), pi * 32.0);
        near(drawn(|canvas| canvas.line(at(4.2, 3.1), at(27.9, 19.4), 3.0, WHITE)), 28.763 * 3.0 + pi * 1.5 * 1.5);
        near(drawn(|canvas| canvas.line(at(4.2, 3.1), at(27.9, 19.4), 0.5, WHITE)), 28.763 * 0.5);
        let triangle = [at(2.5, 2.25), at(30.1, 8.0), at(9.0, 22.6)];
        near(drawn(|canvas| canvas.fill_polygon(&triangle, WHITE)), 262.1875);
        let turned = triangle.map(|corner| at(corner.0.x, 24.0 - corner.0.y));
        near(drawn(|canvas| canvas.fill_polygon(&turned, WHITE)), 262.1875);
        let bow_tie = [at(4.0, 4.0), at(20.0, 4.0), at(4.0, 20.0), at(20.0, 20.0)];
        near(drawn(|canvas| canvas.fill_polygon(&bow_tie, WHITE)), 128.0);
    }

    #[test]
    fn polygons_that_share_an_edge_leave_no_seam() {
        let picture = drawn(|canvas| {
            canvas.fill_polygon(&[at(0.0, 0.0), at(10.0, 0.0), at(10.0, 24.0), at(0.0, 24.0)], WHITE);
            canvas.fill_polygon(&[at(10.0, 0.0), at(32.0, 0.0), at(32.0, 24.0), at(10.0, 24.0)], WHITE);
        });
        assert!(picture.rgba.iter().all(|&byte| byte == 255));
    }

    #[test]
    fn colours_blend_over_what_is_there() {
        let full = [at(-1.0, -1.0), at(33.0, -1.0), at(33.0, 25.0), at(-1.0, 25.0)];
        let picture = drawn(|canvas| {
            canvas.fill_polygon(&full, Rgba8([0, 0, 255, 255]));
            canvas.fill_polygon(&full, Rgba8([255, 0, 0, 51]));
        });
        assert_eq!(picture.pixel(5, 5), Some([51, 0, 204, 255]));
        let glass = drawn(|canvas| canvas.fill_polygon(&full, Rgba8([255, 0, 0, 51])));
        assert_eq!(glass.pixel(5, 5), Some([255, 0, 0, 51]));
    }

    #[test]
    fn text_stands_where_it_was_put() {
        let picture = drawn(|canvas| canvas.text(at(3.0, 4.0), "L", 2, WHITE));
        assert_eq!(picture.pixel(3, 4), Some([255; 4]));
        assert_eq!(picture.pixel(4, 17), Some([255; 4]), "the stroke is 2 wide and 14 high");
        assert_eq!(picture.pixel(12, 17), Some([255; 4]), "the foot is 10 wide");
        assert_eq!(picture.pixel(2, 3), Some([0, 0, 0, 255]), "the rim");
        assert_eq!(picture.pixel(12, 4), Some([0; 4]));
    }

    /// Arbitrary floats, with problematic ones overrepresented.
    fn hostile() -> impl Strategy<Value = f64> {
        prop_oneof![
            -40.0..80.0,
            any::<f64>(),
            prop::sample::select(vec![f64::NAN, f64::INFINITY, -1e9, 1e9, f64::MAX, 0.0, -0.0, f64::MIN_POSITIVE]),
        ]
    }

    proptest! {
        #[test]
        fn no_coordinates_break_a_shape(numbers in prop::array::uniform8(hostile()), scale in any::<u32>()) {
            let [a, b, c, d, e, f, g, h] = numbers;
            let picture = drawn(|canvas| {
                canvas.line(at(a, b), at(c, d), e, WHITE);
                canvas.disc(at(a, b), c, WHITE);
                canvas.ring(at(a, b), c, d, WHITE);
                canvas.fill_polygon(&[at(a, b), at(c, d), at(e, f), at(g, h)], WHITE);
                canvas.text(at(a, b), "pin", scale, WHITE);
            });
            prop_assert_eq!(picture.rgba.len(), 4 * 32 * 24);
        }

        #[test]
        fn a_line_over_the_edge_is_the_part_of_it_inside(x in 40.0..1e7_f64, y in -1e5..1e5_f64) {
            // The same ray, ending elsewhere outside of the picture.
            let start = at(3.0, 12.0);
            let far = at(3.0 + x, 12.0 + y);
            let nearer = at(3.0 + x * 0.99, 12.0 + y * 0.99);
            let (one, other) = (drawn(|c| c.line(start, far, 2.0, WHITE)), drawn(|c| c.line(start, nearer, 2.0, WHITE)));
            let worst = one.rgba.iter().zip(&other.rgba).map(|(a, b)| a.abs_diff(*b)).max();
            prop_assert!(worst <= Some(1), "{:?}", worst);
        }
    }
}
