//! Fields and maps: they agree with the lattice, invert each other, and neither slide nor kink around the box.

use glam::DVec2;
use pinwarp::lattice::{Basis, Grid, Lattice};
use pinwarp::plate::{Field, WarpMap};
use pinwarp::space::{FrameSize, PixelRect, ScreenPoint};

const BASES: [Basis; 4] = [Basis::Bernstein, Basis::Bspline, Basis::Bilinear, Basis::Barytri];
const FRAME: FrameSize = FrameSize { width: 160, height: 90, pixel_aspect: 1.0 };

/// A lattice whose handles are moved by `amount` of a pitch.
fn shaken(basis: Basis, amount: f64) -> Lattice<2> {
    let mut lattice = Grid { dims: [6, 7], basis, lo: [0.4, 0.2], hi: [1.3, 0.8] }.at_rest();
    let pitch = [0, 1].map(|axis| lattice.grid.pitch(axis));
    for (k, handle) in lattice.handles.iter_mut().enumerate() {
        handle[0] += amount * pitch[0] * (12.9898 * k as f64).sin();
        handle[1] += amount * pitch[1] * (78.233 * k as f64 + 1.0).sin();
    }
    lattice
}

/// Places in and around the box.
fn places() -> impl Iterator<Item = DVec2> {
    (0..40).flat_map(|j| (0..60).map(move |i| DVec2::new(-0.4 + 0.0431 * f64::from(i), -0.5 + 0.0507 * f64::from(j))))
}

#[test]
fn a_field_is_its_lattice_inside_the_box_and_a_layers_outside_too() {
    for lattice in BASES.map(|basis| shaken(basis, 0.2)) {
        let (layer, picture) = (Field::of_layer(lattice.clone()), Field::of_picture(lattice.clone()));
        for point in places().map(ScreenPoint) {
            let wanted = lattice.warp(point).0;
            assert!((layer.carry(point).0 - wanted).length() < 1e-12);
            let is_inside = lattice.grid.nearest_in_box(point.0.to_array()) == point.0.to_array();
            assert!(!is_inside || (picture.carry(point).0 - wanted).length() < 1e-12);
        }
    }
}

#[test]
fn gradients_are_slopes_and_inverses_come_back() {
    for basis in BASES {
        let (layer, picture) = (Field::of_layer(shaken(basis, 0.2)), Field::of_picture(shaken(basis, 0.2)));
        let both = Field::chain(vec![picture.clone(), layer.clone()]);
        for field in [layer, picture, both, Field::identity()] {
            for point in places() {
                let (image, gradient) = field.carry_with_gradient(ScreenPoint(point));
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
                let [a, b] = [from, to].map(|x| field.carry_with_gradient(ScreenPoint::new(x, point.y)));
                worst = worst.max((a.0.0 - b.0.0).length()).max((a.1.x_axis - b.1.x_axis).length());
                worst = worst.max((a.1.y_axis - b.1.y_axis).length());
            }
            for (from, to) in [(0.2 - 1e-7, 0.2 + 1e-7), (0.8 - 1e-7, 0.8 + 1e-7)] {
                let [a, b] = [from, to].map(|y| field.carry_with_gradient(ScreenPoint::new(point.x, y)));
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
fn back_and_forth_is_nothing() {
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
