//! Fields and maps: they agree with the lattice, invert each other, and neither slide nor kink around the box.

use crate::internal::numbers::{Congruential, Random};
use glam::DVec2;
use pinwarp::lattice::{Basis, Grid, Lattice};
use pinwarp::plate::{Field, WarpMap};
use pinwarp::space::{FrameSize, PixelRect, ScreenPoint};

pub(super) const BASES: [Basis; 4] = [Basis::Bernstein, Basis::Bspline, Basis::Bilinear, Basis::Barytri];
const FRAME: FrameSize = FrameSize { width: 160, height: 90, pixel_aspect: 1.0 };

/// A lattice whose handles are moved by `amount` of a pitch.
fn shaken(basis: Basis, amount: f64) -> Lattice<2> {
    shaken_in(basis, amount, 0.0)
}

/// The same in a box that is rotated by an angle.
fn shaken_in(basis: Basis, amount: f64, angle: f64) -> Lattice<2> {
    let mut lattice = Grid { dims: [6, 7], basis, lo: [0.4, 0.2], hi: [1.3, 0.8], angle }.at_rest();
    let pitch = [0, 1].map(|axis| lattice.grid.spacing(axis));
    for (k, handle) in lattice.handles.iter_mut().enumerate() {
        handle[0] += amount * pitch[0] * (12.9898 * k as f64).sin();
        handle[1] += amount * pitch[1] * (78.233 * k as f64 + 1.0).sin();
    }
    lattice
}

/// A lattice whose handles are moved by up to `amount` of a pitch, at random.
pub(super) fn random(basis: Basis, amount: f64, seed: u32) -> Lattice<2> {
    let mut lattice = Grid { dims: [7, 6], basis, lo: [0.4, 0.2], hi: [1.3, 0.8], angle: 0.0 }.at_rest();
    let pitch = [0, 1].map(|axis| lattice.grid.spacing(axis));
    let mut random = Congruential(0x9E37_79B9_7F4A_7C15 ^ u64::from(seed));
    for handle in &mut lattice.handles {
        for (x, pitch) in handle.iter_mut().zip(pitch) {
            *x += random.within(amount * pitch);
        }
    }
    lattice
}

/// Places in and around the box.
fn places() -> impl Iterator<Item = DVec2> {
    (0..40).flat_map(|j| (0..60).map(move |i| DVec2::new(-0.4 + 0.0431 * f64::from(i), -0.5 + 0.0507 * f64::from(j))))
}

#[test]
fn a_field_is_its_lattice_inside_the_box_and_a_layers_outside_too() {
    let upright_and_rotated = BASES.into_iter().flat_map(|basis| [0.0, 0.5].map(|angle| shaken_in(basis, 0.2, angle)));
    for lattice in upright_and_rotated {
        let (layer, picture) = (Field::of_layer(lattice.clone()), Field::of_picture(lattice.clone()));
        for point in places().map(ScreenPoint) {
            let wanted = lattice.warp(point).0;
            assert!((layer.carry(point).0 - wanted).length() < 1e-12);
            let is_inside = lattice.grid.clamp_to_box(point.0.to_array()) == point.0.to_array();
            assert!(!is_inside || (picture.carry(point).0 - wanted).length() < 1e-12);
        }
    }
}

#[test]
fn gradients_are_slopes_and_inverses_come_back() {
    for (basis, angle) in BASES.into_iter().flat_map(|basis| [(basis, 0.0), (basis, 0.5)]) {
        let lattice = shaken_in(basis, 0.2, angle);
        let (layer, picture) = (Field::of_layer(lattice.clone()), Field::of_picture(lattice));
        let both = Field::chain(vec![picture.clone(), layer.clone()]);
        for field in [layer, picture, both, Field::identity()] {
            for point in places() {
                let (image, gradient) = field.evaluate_with_gradient(ScreenPoint(point));
                for (axis, column) in [(DVec2::X, gradient.x_axis), (DVec2::Y, gradient.y_axis)] {
                    let [low, high] = [-1e-6, 1e-6].map(|step| field.carry(ScreenPoint(point + axis * step)).0);
                    assert!(((high - low) / 2e-6 - column).length() < 1e-5, "{basis:?} {point}");
                }
                let back = field.inverse(image, image).expect("it does not fold");
                assert!((back.0 - point).length() < 1e-7, "{basis:?} {point} {back:?}");
            }
        }
    }
}

#[test]
fn around_the_box_of_a_picture_neither_values_nor_slopes_jump() {
    for basis in [Basis::Bernstein, Basis::Bspline] {
        let field = Field::of_picture(shaken(basis, 0.4));
        let mut worst: f64 = 0.0;
        for point in places() {
            for (from, to) in [(0.4 - 1e-7, 0.4 + 1e-7), (1.3 - 1e-7, 1.3 + 1e-7)] {
                let [a, b] = [from, to].map(|x| field.evaluate_with_gradient(ScreenPoint::new(x, point.y)));
                worst = worst.max((a.0.0 - b.0.0).length()).max((a.1.x_axis - b.1.x_axis).length());
                worst = worst.max((a.1.y_axis - b.1.y_axis).length());
            }
            for (from, to) in [(0.2 - 1e-7, 0.2 + 1e-7), (0.8 - 1e-7, 0.8 + 1e-7)] {
                let [a, b] = [from, to].map(|y| field.evaluate_with_gradient(ScreenPoint::new(point.x, y)));
                worst = worst.max((a.1.x_axis - b.1.x_axis).length()).max((a.1.y_axis - b.1.y_axis).length());
            }
        }
        assert!(worst < 1e-4, "{basis:?}: {worst}");
        let far = ScreenPoint::new(9.0, -7.0);
        assert_eq!(field.carry(far), far);
    }
}

#[test]
fn the_map_of_a_field_at_rest_is_exactly_nothing() {
    let window = PixelRect { x: -5, y: -7, width: 200, height: 110 };
    for field in [Field::identity(), Field::of_picture(shaken(Basis::Bspline, 0.0))] {
        for map in [WarpMap::backward(&field, FRAME, window), WarpMap::forward(&field, FRAME, window)] {
            assert_eq!(map, WarpMap::identity(FRAME, window));
        }
        assert_eq!(field.warped_window(FRAME, window), window);
    }
}

#[test]
fn a_warp_and_its_inverse_cancel() {
    let frame = FrameSize { pixel_aspect: 1.4, ..FRAME };
    let window = PixelRect { x: -20, y: -15, width: 180, height: 100 };
    for basis in BASES {
        for field in [Field::of_layer(shaken(basis, 0.2)), Field::of_picture(shaken(basis, 0.2))] {
            let map = WarpMap::backward(&field, frame, window);
            for y in window.y..window.y + window.height as i32 {
                for x in window.x..window.x + window.width as i32 {
                    let source = map.source(x, y).expect("every pixel comes from somewhere");
                    let screen = frame.screen_from_image(pinwarp::space::ImagePoint(DVec2::from(source)));
                    let there = frame.image_from_screen(field.carry(screen)).0;
                    let gap = (there - DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)).length();
                    assert!(gap < 1e-3, "{basis:?} {x} {y}: {gap}");
                }
            }
        }
    }
}

#[test]
fn what_no_moved_handle_reaches_stays_to_the_bit() {
    let mut lattice =
        Grid { dims: [12, 12], basis: Basis::Bspline, lo: [0.0, 0.0], hi: [1.7, 1.0], angle: 0.0 }.at_rest();
    lattice.handles[5 + 12 * 6][0] += 0.05;
    // Noise of a solver.
    lattice.handles.iter_mut().for_each(|handle| handle[1] += 1e-10);
    let map = WarpMap::backward(&Field::of_picture(lattice), FRAME, FRAME.window());
    let still = map.offsets.iter().filter(|offset| **offset == [0.0; 2]).count();
    assert!(still > FRAME.window().area() / 2 && still < FRAME.window().area(), "{still}");
}

#[test]
fn the_warped_window_is_tight() {
    for basis in BASES {
        let field = Field::of_layer(shaken(basis, 0.4));
        let window = PixelRect { x: 20, y: 5, width: 70, height: 60 };
        let found = field.warped_window(FRAME, window);
        let (mut least, mut most) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for k in 0..=280 * 240 {
            let place = DVec2::new(20.0 + 0.25 * f64::from(k % 281), 5.0 + 0.25 * f64::from(k / 281));
            let image = field.carry(FRAME.screen_from_image(pinwarp::space::ImagePoint(place)));
            let image = FRAME.image_from_screen(image).0;
            (least, most) = (least.min(image), most.max(image));
        }
        let (lo, hi) = (least.floor().as_ivec2(), most.ceil().as_ivec2());
        let right = [found.x + found.width as i32, found.y + found.height as i32];
        for (found, wanted) in [(found.x, lo.x), (found.y, lo.y), (right[0], hi.x), (right[1], hi.y)] {
            assert!((found - wanted).abs() <= 1, "{basis:?}: {found} {wanted}");
        }
    }
}

/// Catmull-Rom between the offsets of a map, at a place counted in pixels from its first pixel's centre.
fn offset_at(map: &WarpMap, at: DVec2) -> DVec2 {
    let (whole, t) = (at.floor(), at - at.floor());
    let weights = |t: f64| {
        let (a, b) = (t * t, t * t * t);
        [-0.5 * t + a - 0.5 * b, 1.0 - 2.5 * a + 1.5 * b, 0.5 * t + 2.0 * a - 1.5 * b, 0.5 * (b - a)]
    };
    let mut sum = DVec2::ZERO;
    for (j, wy) in weights(t.y).into_iter().enumerate() {
        for (i, wx) in weights(t.x).into_iter().enumerate() {
            let (x, y) = (whole.x as usize + i - 1, whole.y as usize + j - 1);
            let [dx, dy] = map.offsets[y * map.window.width as usize + x].map(f64::from);
            sum += DVec2::new(dx, dy) * (wx * wy);
        }
    }
    sum
}

#[test]
fn a_warp_undone_is_no_warp() {
    let frame = FrameSize::new(1280, 720);
    let field = Field::of_picture(shaken(Basis::Bspline, 0.3));
    let [there, back] = [WarpMap::forward, WarpMap::backward].map(|map| map(&field, frame, frame.window()));
    assert!(there.folded_pixels.is_empty() && back.folded_pixels.is_empty());
    let mut worst: f64 = 0.0;
    for (index, &[dx, dy]) in there.offsets.iter().enumerate() {
        let by = DVec2::new(dx.into(), dy.into());
        let at = DVec2::new((index % 1280) as f64, (index / 1280) as f64) + by;
        if at.cmpgt(DVec2::splat(1.0)).all() && at.cmplt(DVec2::new(1277.0, 717.0)).all() {
            worst = worst.max((offset_at(&back, at) + by).length());
        }
    }
    assert!(worst < 1e-3, "{worst} px");
}

#[test]
fn pixels_warped_and_warped_back_are_the_old_ones() {
    use pinwarp::plate::{Filter, Planes, resampled};
    let frame = FrameSize::new(320, 180);
    let field = Field::of_picture(shaken(Basis::Bspline, 0.3));
    let wave = |index: usize| ((index % 320) as f32 * 0.12).sin() * ((index / 320) as f32 * 0.09).cos();
    let picture: Vec<f32> = (0..frame.window().area()).map(wave).collect();
    let through = |map: &WarpMap, plane: &[f32]| {
        resampled(map, &Planes { window: frame.window(), planes: vec![plane] }, Filter::Cubic).remove(0)
    };
    let warped = through(&WarpMap::backward(&field, frame, frame.window()), &picture);
    let undone = through(&WarpMap::forward(&field, frame, frame.window()), &warped);
    let gap = |a: &[f32], b: &[f32]| {
        // Away from the border of the frame, where parts of the picture have left it.
        let inner =
            (0..a.len()).filter(|index| (20..300).contains(&(index % 320)) && (20..160).contains(&(index / 320)));
        inner.map(|index| (a[index] - b[index]).abs()).fold(0.0, f32::max)
    };
    assert!(gap(&undone, &picture) < 2e-2, "{}", gap(&undone, &picture));
    assert!(gap(&warped, &picture) > 0.2, "the warp does something");
}
