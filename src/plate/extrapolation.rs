//! Extends the displacement of one lattice beyond its box to the whole plane.
//!
//! In: a screen lattice. Out: displacement and gradient at any point, in frame heights. Handles are stored as
//! displacements, so that points that do not move get exactly 0.

use super::ramp::Ramp;
use crate::lattice::{AxisTerms, Grid, MAX_HANDLES, ScreenLattice, Support};
use crate::smoothstep::smoothstep;
use crate::space::{ScreenBox, ScreenPoint};
use glam::{DMat2, DVec2};

/// Border samples per span, to bound the displacement.
const SAMPLES: usize = 4;

/// A handle that moved less than this, in frame heights, counts as at rest: a fifty-thousandth of a pixel at 4K.
/// Solvers leave such noise, and what does not move must keep its place exactly.
const STILL: f64 = 1e-8;

/// A lattice whose displacement is extrapolated beyond its box.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ExtrapolatedLattice {
    grid: Grid<2>,
    /// Displacement of each handle: #handles, x fastest.
    moved: Vec<DVec2>,
    extrapolation: Extrapolation,
}

/// Behaviour outside the box.
#[derive(Clone, Debug, PartialEq)]
enum Extrapolation {
    /// A point moves as the nearest point of the box does.
    Nearest,
    /// Continues along the normal of the border with the value and slope there, fading to zero:
    ///
    /// ```text
    /// d(q + n) = [ d + d_x c(n_x) + d_y c(n_y) + d_xy c(n_x) c(n_y) ](q) · f(|n_x|/margin) · f(|n_y|/margin)
    /// c(0) = 0, c'(0) = 1, constant from `bend` on;  f(0) = 1, f'(0) = 0, f(1) = 0, f'(1) = 0
    /// ```
    ///
    /// C1 across the border, across the extensions of its sides, and at the end of the margin.
    Fade {
        /// Distance per axis after which the slope has faded out.
        bend: DVec2,
        /// Distance after which the displacement has faded out.
        margin: f64,
    },
    /// A ramp takes the displacement to zero at the border; nothing moves outside.
    Rests(Ramp),
}

/// Displacement at a point of the box, and its derivatives.
#[derive(Clone, Copy, Debug, Default)]
struct Jet {
    d: DVec2,
    dx: DVec2,
    dy: DVec2,
    dxy: DVec2,
}

/// Extrapolation factors along one axis: c, c', f, f'.
#[derive(Clone, Copy, Debug)]
struct AxisExtrapolation {
    c: f64,
    c_slope: f64,
    f: f64,
    f_slope: f64,
}

impl AxisExtrapolation {
    const INSIDE: Self = Self { c: 0.0, c_slope: 1.0, f: 1.0, f_slope: 0.0 };
    const HELD: Self = Self { c: 0.0, c_slope: 0.0, f: 1.0, f_slope: 0.0 };
}

impl ExtrapolatedLattice {
    /// Creates an extrapolation under which a point outside the box moves as the nearest point of the box does.
    pub(super) fn clamped(lattice: &ScreenLattice) -> Self {
        let rest = lattice.grid.rest_handles();
        let moved = lattice.handles.iter().zip(rest).map(|(&to, from)| {
            let moved = DVec2::from(to) - DVec2::from(from);
            if moved.length() < STILL { DVec2::ZERO } else { moved }
        });
        Self { grid: lattice.grid.clone(), moved: moved.collect(), extrapolation: Extrapolation::Nearest }
    }

    /// Creates an extrapolation that multiplies the displacement by a ramp that is 0 from the border outwards.
    pub(super) fn resting(lattice: &ScreenLattice, ramp: Ramp) -> Self {
        Self { extrapolation: Extrapolation::Rests(ramp), ..Self::clamped(lattice) }
    }

    /// Whether the warp is known to be one-to-one.
    pub(super) fn is_one_to_one(&self) -> bool {
        matches!(self.extrapolation, Extrapolation::Rests(_))
    }

    /// Creates an extrapolation that continues smoothly and fades to zero outside the box.
    pub(super) fn fading(lattice: &ScreenLattice) -> Self {
        let mut lattice = Self::clamped(lattice);
        let grid = &lattice.grid;
        let side = DVec2::new(grid.size(0), grid.size(1));
        let spacing = DVec2::new(grid.spacing(0), grid.spacing(1));
        // Slopes of barycentric cells jump along the border; continuing them would tear the picture.
        let bend = if grid.basis.support() == Support::Simplex { DVec2::ZERO } else { spacing.min(side * 0.25) };
        // f falls by at most 1.5/margin: a margin of four times the greatest displacement of the border prevents folds,
        // see docs/PLATES.md.
        let margin = 0.25 * side.min_element() + 4.0 * lattice.max_border_displacement(bend);
        lattice.extrapolation = Extrapolation::Fade { bend, margin };
        lattice
    }

    /// Returns the greatest displacement that the border reaches when its slopes are continued.
    fn max_border_displacement(&self, bend: DVec2) -> f64 {
        let counts = [0, 1].map(|axis| SAMPLES * self.grid.basis.spans(self.grid.dims[axis]));
        let half = bend * 0.5;
        let reached = |unit: DVec2, is_end: [bool; 2]| {
            let jet = self.jet(unit);
            let [cx, cy] = [half.x * f64::from(u8::from(is_end[0])), half.y * f64::from(u8::from(is_end[1]))];
            jet.d.length() + cx * jet.dx.length() + cy * jet.dy.length() + cx * cy * jet.dxy.length()
        };
        let side = |axis: usize, end: f64| {
            (0..=counts[1 - axis]).map(move |k| {
                let t = k as f64 / counts[1 - axis] as f64;
                let is_corner = k == 0 || k == counts[1 - axis];
                if axis == 0 {
                    (DVec2::new(end, t), [true, is_corner])
                } else {
                    (DVec2::new(t, end), [is_corner, true])
                }
            })
        };
        let border = [0, 1].into_iter().flat_map(|axis| [0.0, 1.0].into_iter().flat_map(move |end| side(axis, end)));
        border.map(|(unit, is_end)| reached(unit, is_end)).fold(0.0, f64::max)
    }

    pub(super) fn is_at_rest(&self) -> bool {
        self.moved.iter().all(|moved| *moved == DVec2::ZERO)
    }

    /// Upper bound of the displacement, in frame heights.
    pub(super) fn max_displacement(&self) -> f64 {
        let inside = self.moved.iter().map(|moved| moved.length()).fold(0.0, f64::max);
        match self.extrapolation {
            Extrapolation::Nearest | Extrapolation::Rests(_) => inside,
            Extrapolation::Fade { bend, .. } => inside.max(self.max_border_displacement(bend)),
        }
    }

    /// Distance between rest handles along each axis.
    pub(super) fn spacing(&self) -> DVec2 {
        DVec2::new(self.grid.spacing(0), self.grid.spacing(1))
    }

    /// Whether the displacement is smooth within a box less than half a cell wide: neither a crease of the basis nor a
    /// creased border crosses it.
    pub(super) fn is_smooth_within(&self, lo: DVec2, hi: DVec2) -> bool {
        let [lo, hi] = self.upright_around(lo, hi);
        let is_small = (hi - lo).cmple(self.spacing() * 0.5).all() && self.is_ramp_smooth_within(lo, hi);
        let has_cells = self.grid.basis.is_piecewise_linear();
        if !is_small || (self.extrapolation != Extrapolation::Nearest && !has_cells) {
            return is_small;
        }
        let upright = self.grid.upright();
        let ends = [lo, hi].map(|point| upright.unit_from_point(point.to_array()));
        let cell = |end: usize, axis: usize| {
            let spans = if has_cells { self.grid.basis.spans(self.grid.dims[axis]) as f64 } else { 1.0 };
            (ends[end][axis] * spans).floor().clamp(-1.0, spans)
        };
        let is_one_cell = (0..2).all(|axis| cell(0, axis) == cell(1, axis));
        is_one_cell && (self.grid.basis.support() != Support::Simplex || self.is_off_diagonal(ends))
    }

    /// Returns a box that contains another one after the rotation of the lattice's box is taken back.
    fn upright_around(&self, lo: DVec2, hi: DVec2) -> [DVec2; 2] {
        if self.grid.angle == 0.0 {
            return [lo, hi];
        }
        let upright = |ScreenPoint(point)| ScreenPoint(self.grid.upright_from_point(point.to_array()).into());
        let around = ScreenBox::new(ScreenPoint(lo), ScreenPoint(hi)).around_moved(upright);
        [around.min.0, around.max.0]
    }

    fn is_ramp_smooth_within(&self, lo: DVec2, hi: DVec2) -> bool {
        if let Extrapolation::Rests(ramp) = &self.extrapolation { ramp.is_smooth_within(lo, hi) } else { true }
    }

    /// Whether a box within a cell avoids the diagonal that splits the cell.
    fn is_off_diagonal(&self, ends: [[f64; 2]; 2]) -> bool {
        let place = |end: usize, axis: usize| {
            (ends[end][axis].clamp(0.0, 1.0) * self.grid.basis.spans(self.grid.dims[axis]) as f64).fract()
        };
        place(0, 0) > place(1, 1) || place(1, 0) < place(0, 1)
    }

    /// Returns the displacement of a point and its gradient (column = derivative along x, y).
    pub(super) fn displace(&self, point: DVec2) -> (DVec2, DMat2) {
        if self.grid.angle == 0.0 {
            return self.displace_upright(point);
        }
        let upright = self.grid.upright_from_point(point.to_array());
        let (by, slope) = self.displace_upright(upright.into());
        (by, slope * DMat2::from_angle(-self.grid.angle))
    }

    /// Returns the displacement of a point, given before the rotation of the box, and its derivatives along the axes of
    /// the box.
    fn displace_upright(&self, point: DVec2) -> (DVec2, DMat2) {
        let (lo, hi) = (DVec2::from(self.grid.lo), DVec2::from(self.grid.hi));
        let inside = point.max(lo).min(hi);
        let size = hi - lo;
        let Jet { d, dx, dy, dxy } = self.jet((inside - lo) / size);
        let [x, y] = [0, 1].map(|axis| self.along(axis, point[axis] - inside[axis]));
        let value = d + dx * x.c + dy * y.c + dxy * (x.c * y.c);
        let fade = x.f * y.f;
        let slope_x = (dx + dxy * y.c) * (x.c_slope * fade) + value * (x.f_slope * y.f);
        let slope_y = (dy + dxy * x.c) * (y.c_slope * fade) + value * (x.f * y.f_slope);
        let Extrapolation::Rests(ramp) = &self.extrapolation else {
            return (value * fade, DMat2::from_cols(slope_x, slope_y));
        };
        let (factor, fall) = ramp.at(point);
        (value * factor, DMat2::from_cols(slope_x * factor + value * fall.x, slope_y * factor + value * fall.y))
    }

    /// Returns the extrapolation factors at distance `out` from the box.
    fn along(&self, axis: usize, out: f64) -> AxisExtrapolation {
        if out == 0.0 {
            return AxisExtrapolation::INSIDE;
        }
        let Extrapolation::Fade { bend, margin } = self.extrapolation else { return AxisExtrapolation::HELD };
        let (bend, t) = (bend[axis], out.abs() / margin);
        // Nothing moves beyond the margin; NaN propagates.
        if t >= 1.0 {
            return AxisExtrapolation { c: 0.0, c_slope: 0.0, f: 0.0, f_slope: 0.0 };
        }
        let s = if bend > 0.0 { (out.abs() / bend).min(1.0) } else { 1.0 };
        AxisExtrapolation {
            c: bend * s * (1.0 - s * s * (1.0 - 0.5 * s)) * out.signum(),
            c_slope: 1.0 - smoothstep(s),
            f: 1.0 - smoothstep(t),
            f_slope: -6.0 * t * (1.0 - t) / margin * out.signum(),
        }
    }

    /// Returns the displacement and its derivatives at a position of the box, 0 to 1 per axis.
    fn jet(&self, unit: DVec2) -> Jet {
        match self.grid.basis.support() {
            Support::Simplex => self.simplex_jet(unit),
            Support::Tensor { .. } => self.tensor_jet::<4>(unit),
            Support::Global => self.tensor_jet::<MAX_HANDLES>(unit),
        }
    }

    fn tensor_jet<const N: usize>(&self, unit: DVec2) -> Jet {
        let Grid { dims, basis, .. } = self.grid;
        let (x, y) = (AxisTerms::<N>::at(basis, dims[0], unit.x), AxisTerms::<N>::at(basis, dims[1], unit.y));
        let mut jet = Jet::default();
        for (row, (value, slope)) in y.values().iter().zip(y.slopes()).enumerate() {
            let start = (y.first + row) * dims[0] + x.first;
            let (mut sum, mut slant) = (DVec2::ZERO, DVec2::ZERO);
            let handles = &self.moved[start..start + x.values().len()];
            for ((moved, value), slope) in handles.iter().zip(x.values()).zip(x.slopes()) {
                sum += *moved * *value;
                slant += *moved * *slope;
            }
            jet.d += sum * *value;
            jet.dx += slant * *value;
            jet.dy += sum * *slope;
            jet.dxy += slant * *slope;
        }
        let [width, height] = [self.grid.size(0), self.grid.size(1)];
        Jet { d: jet.d, dx: jet.dx / width, dy: jet.dy / height, dxy: jet.dxy / (width * height) }
    }

    fn simplex_jet(&self, unit: DVec2) -> Jet {
        let upright = self.grid.upright();
        let mut jet = Jet::default();
        upright.for_each_weight(upright.point_from_unit(unit.to_array()), |term| {
            let moved = self.moved[term.handle];
            jet.d += moved * term.weight;
            jet.dx += moved * term.gradient[0];
            jet.dy += moved * term.gradient[1];
        });
        jet
    }
}
