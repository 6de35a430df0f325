//! What a warp does to a whole picture, measured on a dense grid and around its pins.

use super::cases::Case;
use pinwarp::live::Warp;
use pinwarp::space::{FrameSize, ScreenPoint};

/// Points of the grid, up.
const ROWS: u32 = 135;

#[derive(Clone, Copy, Debug)]
pub(crate) struct Measures {
    /// Greatest distance of a pin from its target, pixels.
    pub(crate) miss_px: f64,
    /// Furthest that a point moves, by the furthest that a pin does.
    pub(crate) ratio: f64,
    pub(crate) min_det: f64,
    /// Furthest that a point of the border moves, pixels.
    pub(crate) border_px: f64,
}

impl Default for Measures {
    fn default() -> Self {
        Self { miss_px: 0.0, ratio: 0.0, min_det: f64::INFINITY, border_px: 0.0 }
    }
}

impl Measures {
    pub(crate) fn or_worse(self, other: Self) -> Self {
        Self {
            miss_px: self.miss_px.max(other.miss_px),
            ratio: self.ratio.max(other.ratio),
            min_det: self.min_det.min(other.min_det),
            border_px: self.border_px.max(other.border_px),
        }
    }
}

pub(crate) fn measure(warp: &Warp, case: &Case) -> Measures {
    let height = f64::from(case.frame.height);
    let mut found = Measures::default();
    for pin in case.pins() {
        found.miss_px = found.miss_px.max((warp.field.carry(pin.rest).0 - pin.target.0).length() * height);
        for ring in [0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0] {
            for spoke in 0..16 {
                let (sin, cos) = (f64::from(spoke) * std::f64::consts::TAU / 16.0).sin_cos();
                let [x, y] = [pin.rest.0.x + ring / height * cos, pin.rest.0.y + ring / height * sin];
                found.look(warp, ScreenPoint::new(x, y), case);
            }
        }
    }
    let aspect = case.frame.aspect();
    for point in grid(case.frame) {
        found.look(warp, point, case);
        let is_border = [0.0, 1.0].contains(&point.0.y) || [0.0, aspect].contains(&point.0.x);
        if is_border {
            found.border_px = found.border_px.max((warp.field.carry(point).0 - point.0).length() * height);
        }
    }
    found
}

impl Measures {
    fn look(&mut self, warp: &Warp, point: ScreenPoint, case: &Case) {
        let (moved, gradient) = warp.field.evaluate_with_gradient(point);
        let far = (moved.0 - point.0).length() * f64::from(case.frame.height) / case.longest();
        self.ratio = self.ratio.max(far);
        self.min_det = self.min_det.min(gradient.determinant());
    }
}

/// The furthest that two warps take any point apart, pixels.
pub(crate) fn difference_px(a: &Warp, b: &Warp, frame: FrameSize) -> f64 {
    let apart = |point: ScreenPoint| (a.field.carry(point).0 - b.field.carry(point).0).length();
    grid(frame).map(apart).fold(0.0, f64::max) * f64::from(frame.height)
}

/// Points of a frame, its border included.
fn grid(frame: FrameSize) -> impl Iterator<Item = ScreenPoint> {
    let columns = 2 * ROWS;
    let aspect = frame.aspect();
    (0..=columns * ROWS + columns + ROWS).map(move |index| {
        let [x, y] = [index % (columns + 1), index / (columns + 1)];
        ScreenPoint::new(aspect * f64::from(x) / f64::from(columns), f64::from(y) / f64::from(ROWS))
    })
}
