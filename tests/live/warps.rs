//! Warps from controls: pins arrive, the engine's own solve is met to the bit, what is kept is kept by content.

use super::support::{HD, eight_pins};
use pinwarp::live::{Controls, Coverage, LiveError, Moved, Pin, ShapeSource, Warning, Warp, last_of_alpha, warp};
use pinwarp::pipeline::PreparedShot;
use pinwarp::shot::Shot;
use pinwarp::space::{FrameSize, PixelRect, ScreenPoint};
use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;

/// The same warp as text.
fn as_shot(controls: &Controls) -> String {
    let [nx, ny] = controls.dims;
    let mut text = format!(
        "plate = 'a.####.exr'\nframes = {{ first = 1, last = 1 }}\nsize = [1920, 1080]\n[[layer]]\nlattice.dims = [{nx}, {ny}]\n"
    );
    for pin in &controls.pins {
        let ([x, y], [u, v]) = (pin.rest.0.to_array(), (pin.target.0 - pin.rest.0).to_array());
        let rotate = pin.rotation.map(|angle| format!(", rotate = {:?}", angle.to_degrees())).unwrap_or_default();
        let keys = format!("[ {{ frame = 0, offset = [0, 0] }}, {{ frame = 1, offset = [{u:?}, {v:?}]{rotate} }} ]");
        write!(text, "[[layer.pin]]\nanchor = {{ screen = [{x:?}, {y:?}] }}\nkeys = {keys}\n").expect("text grows");
    }
    text
}

#[test]
fn pins_arrive_and_the_border_stays() {
    let controls = eight_pins();
    let warp = warp(&controls, &ShapeSource::Frame, HD).expect("solves");
    for (pin, place) in controls.pins.iter().zip(&warp.pins) {
        assert!((place.moved.0 - pin.target.0).length() * 1080.0 < 0.05, "{pin:?} went to {:?}", place.moved);
        assert_eq!((place.rest, place.target), (pin.rest, pin.target));
    }
    for corner in [[0.0, 0.0], [0.5, 0.0], [1920.0 / 1080.0, 1.0], [0.0, 0.7]] {
        let corner = ScreenPoint::new(corner[0], corner[1]);
        assert!((warp.field.carry(corner).0 - corner.0).length() < 1e-9, "the border moved at {corner:?}");
    }
    assert!(!warp.is_identity() && warp.pin_error() < 1e-5);
}

#[test]
fn a_shot_file_that_says_the_same_has_the_same_bits() {
    let mut controls = eight_pins();
    controls.pins[2].rotation = Some(0.3);
    let shot = Shot::parse(&as_shot(&controls), Path::new("a.toml")).expect("a good shot");
    let cold = PreparedShot::new(shot).expect("fits").mid_exposure(1).expect("solves");
    let cold = &cold.layers[0].solution.as_ref().expect("pins act").lattice;
    // Something else first: what was solved before must not matter.
    let mut other = controls.clone();
    other.pins.iter_mut().for_each(|pin| pin.target.0.x += 0.05);
    warp(&other, &ShapeSource::Frame, HD).expect("solves");
    let live = warp(&controls, &ShapeSource::Frame, HD).expect("solves");
    let live = live.lattice.as_ref().expect("a lattice");
    assert_eq!((&cold.grid, &cold.handles), (&live.grid, &live.handles));
}

#[test]
fn nothing_moves_without_a_reason() {
    let still = Controls {
        pins: eight_pins().pins.iter().map(|pin| Pin::new(pin.rest, pin.rest)).collect(),
        ..Controls::default()
    };
    let weak = Controls { strength: 0.0, ..eight_pins() };
    for controls in [Controls::default(), still, weak] {
        let warp = warp(&controls, &ShapeSource::Frame, HD).expect("solves");
        assert!(warp.is_identity(), "{controls:?}");
        assert_eq!((warp.handles().len(), warp.grid_lines(4).len()), (100, 16));
    }
}

#[test]
fn equal_content_is_one_warp() {
    let (controls, shape) = (eight_pins(), ShapeSource::Frame);
    let first = warp(&controls, &shape, HD).expect("solves");
    assert!(Arc::ptr_eq(&first, &warp(&controls.clone(), &shape, HD).expect("solves")));
    // A proxy of the same shape has the same warp.
    assert!(Arc::ptr_eq(&first, &warp(&controls, &shape, FrameSize::new(960, 540)).expect("solves")));
    for change in [
        |controls: &mut Controls| controls.pins[3].target.0.y += 1e-6,
        |controls: &mut Controls| controls.smoothness = 2.0,
        |controls: &mut Controls| controls.strength = 0.5,
        |controls: &mut Controls| controls.dims = [11, 10],
        |controls: &mut Controls| controls.moved = Moved::Masked,
        |controls: &mut Controls| controls.pins[1].rotation = Some(0.0),
    ] {
        let mut other = controls.clone();
        change(&mut other);
        let other = warp(&other, &shape, HD).expect("solves");
        assert!(first.lattice != other.lattice || first.field != other.field, "a change was not seen");
    }
}

/// Mean square of the second differences of a row's handles, frame heights.
fn bending(warp: &Warp) -> f64 {
    let handles = warp.handles();
    let by = |index: usize| handles[index][1].0 - handles[index][0].0;
    let along =
        |index: usize, step: usize| (by(index) - 2.0 * by(index + step) + by(index + 2 * step)).length_squared();
    let rows = (0..10).flat_map(|row| (0..8).map(move |column| row * 10 + column));
    rows.map(|index| along(index, 1)).sum::<f64>() / 80.0
}

#[test]
fn a_stiffer_lattice_bends_less() {
    let pins = [[0.5, 0.5, 0.0], [0.9, 0.5, 0.1], [1.3, 0.5, 0.0]];
    let pins = pins.map(|[x, y, up]| Pin::new(ScreenPoint::new(x, y), ScreenPoint::new(x, y + up)));
    let bent = [0.1, 1.0, 3.0, 10.0].map(|smoothness| {
        let controls = Controls { pins: pins.to_vec(), smoothness, moved: Moved::Masked, ..Controls::default() };
        bending(&warp(&controls, &ShapeSource::Frame, HD).expect("solves"))
    });
    println!("bending at 0.1, 1, 3, 10: {bent:?}");
    assert!(bent.windows(2).all(|pair| pair[0] >= 0.999 * pair[1]), "{bent:?}");
    assert!(bent[3] < 0.5 * bent[1], "the slider does something: {bent:?}");
}

#[test]
fn an_outline_follows_the_alpha() {
    let frame = FrameSize::new(320, 180);
    let window = frame.window();
    let disc = |x: f64| -> Vec<f32> {
        let place = |k: usize| ((k % 320) as f64 + 0.5, (k / 320) as f64 + 0.5);
        (0..window.area()).map(|k| f32::from(u8::from((place(k).0 - x).hypot(place(k).1 - 90.0) < 50.0))).collect()
    };
    let (left, right) = (disc(100.0), disc(200.0));
    let controls = Controls { pins: eight_pins().pins[..2].to_vec(), ..Controls::default() };
    let of =
        |alpha: &[f32]| warp(&controls, &ShapeSource::Coverage(Coverage { window, alpha }), frame).expect("solves");
    let center = |warp: &Warp| {
        let grid = &warp.lattice.as_ref().expect("a lattice").grid;
        0.5 * (grid.lo[0] + grid.hi[0]) * 180.0
    };
    assert!((center(&of(&left)) - 100.0).abs() < 2.0 && (center(&of(&right)) - 200.0).abs() < 2.0);
    assert!(Arc::ptr_eq(&of(&left), &of(&left.clone())), "equal alpha in another place in memory");
    let nothing = of(&vec![0.0; window.area()]);
    let is_told = |warning: &Warning| matches!(warning, Warning::Text(text) if text.contains("alpha is 0"));
    assert!(nothing.is_identity() && nothing.warnings.iter().any(is_told), "{:?}", nothing.warnings);
    let short = Coverage { window: PixelRect { height: 100, ..window }, alpha: &left };
    assert!(matches!(warp(&controls, &ShapeSource::Coverage(short), frame), Err(LiveError::Planes { .. })));
}

#[test]
fn the_last_warp_over_an_alpha_can_be_shown_without_its_pixels() {
    let frame = FrameSize::new(64, 36);
    let pin = Pin::new(ScreenPoint::new(0.61, 0.5), ScreenPoint::new(0.73, 0.5));
    let controls = Controls { pins: vec![pin], ..Controls::default() };
    assert!(last_of_alpha(&controls).is_none(), "nothing was solved yet");
    warp(&controls, &ShapeSource::Frame, frame).expect("solves");
    assert!(last_of_alpha(&controls).is_none(), "only alpha is remembered");
    for samples in [&[1.0; 64 * 36], &[0.5; 64 * 36]] {
        let shape = ShapeSource::Coverage(Coverage { window: frame.window(), alpha: samples });
        let solved = warp(&controls, &shape, frame).expect("solves");
        assert!(last_of_alpha(&controls).is_some_and(|last| Arc::ptr_eq(&last, &solved)), "the last one");
    }
    let other = Controls { strength: 0.5, ..controls };
    assert!(last_of_alpha(&other).is_none(), "other controls have their own");
}

#[test]
fn faults_are_reported() {
    let told = |change: fn(&mut Controls)| {
        let mut controls = eight_pins();
        change(&mut controls);
        warp(&controls, &ShapeSource::Frame, HD).expect_err("a fault").to_string()
    };
    assert!(told(|c| c.smoothness = 0.0).contains("smoothness of 0"));
    assert!(told(|c| c.strength = f64::NAN).contains("strength"));
    assert!(told(|c| c.pins[4].target.0.x = f64::NAN).contains("pin 5"));
    assert!(told(|c| c.pins[4].scale = Some(0.0)).contains("pin 5"));
    assert!(told(|c| c.dims = [3, 10]).contains('3'));
}
