//! Pins that were never placed, and what is drawn over a picture whose alpha is the shape.
use crate::host::profile::{BOOK, MLT};
use crate::host::{Frame, Host, Pixels, Which};
use crate::{SIZE, pulled};

#[test]
fn a_pin_that_was_never_placed_does_nothing() {
    let mut host = Host::start(&MLT, Which::PinWarp);
    let pixels = Pixels::scenery(SIZE, 4);
    let node = pulled(&mut host, &pixels);
    let without = host.render(node, Frame::default()).expect("it renders");
    host.set(node, "holdBorder", 0);
    let free = host.render(node, Frame::default()).expect("it renders");
    host.set(node, "pin3On", 1);
    let with = host.render(node, Frame::default()).expect("it renders");
    assert!(free == with, "the pin is not there");
    assert!(without != free);
    host.finish();
}

#[test]
fn over_alpha_the_lattice_is_drawn_as_it_was_rendered() {
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
    host.set(node, "shape", 1);
    host.set(node, "smoothness", 1.25);
    let overlay = host.overlay(node, 1.0).expect("there is one");
    let lines = |drawn: &[_]| drawn.len();
    let before = lines(&overlay.draw());
    host.render(node, Frame::default()).expect("it renders");
    let after = lines(&overlay.draw());
    assert!(after >= before + 14, "{before} {after}");
    overlay.close();
    host.finish();
}
