//! What the plugin warns of: pins that miss, folds; once, in pixels, and taken back when it is over.

use crate::host::api::names::{MESSAGE_MESSAGE, MESSAGE_WARNING};
use crate::host::profile::{ALL, BOOK, RESOLVE};
use crate::host::{Frame, Host, Node, Pixels, Which};
use crate::{SIZE, pulled};

/// 16 pins in a small square, pulled by five pixels this way and that: more than a lattice can do.
fn torn(host: &Host, node: Node) {
    for pin in 0..16_usize {
        let rest = [60.0 + 2.0 * (pin % 4) as f64, 40.0 + 2.0 * (pin / 4) as f64];
        let by = [[5.0, -5.0], [-5.0, 5.0], [5.0, 5.0], [-5.0, -5.0]][(pin * 7 + pin / 4) % 4];
        host.pin(node, pin + 1, rest, [rest[0] + by[0], rest[1] + by[1]]);
    }
}

fn at(time: f64) -> Frame {
    Frame { time, ..Frame::default() }
}

#[test]
fn pins_that_miss_are_warned_of_once_in_every_host() {
    for profile in ALL {
        let mut host = Host::start(profile, Which::PinWarp);
        let node = host.node();
        host.through(node, &Pixels::scenery(SIZE, 4));
        torn(&host, node);
        // In MLT all instances count as one: an edit lets them speak again.
        host.press(node, "strength");
        for time in 0..4 {
            host.render(node, at(f64::from(time))).unwrap_or_else(|status| panic!("{}: {status:?}", profile.name));
        }
        let heard = host.heard();
        if profile.suites.is_empty() {
            assert!(heard.is_empty(), "{}", profile.name);
        } else {
            assert_eq!(heard.len(), 1, "{}: {heard:?}", profile.name);
            let text = &heard[0].text;
            assert!(text.contains("miss") && text.contains(" px") && text.contains("pin 1"), "{text}");
            assert_eq!(heard[0].kind.as_bytes(), MESSAGE_WARNING.to_bytes());
        }
        host.finish();
    }
}

#[test]
fn a_warning_is_taken_back_by_its_frame_and_given_again_after_an_edit() {
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = host.node();
    host.through(node, &Pixels::scenery(SIZE, 4));
    torn(&host, node);
    host.render(node, at(3.0)).expect("it renders");
    assert_eq!(host.said().len(), 1, "{:?}", host.said());
    assert!(host.said()[0].lasts && host.said()[0].text.starts_with("Frame 3"), "{:?}", host.said());
    // Another frame of the animation is fine; that of the warning is not.
    host.set(node, "strength", 0.0);
    host.render(node, at(9.0)).expect("it renders");
    assert_eq!(host.said().len(), 1, "{:?}", host.said());
    host.render(node, at(3.0)).expect("it renders");
    assert!(host.said().is_empty(), "{:?}", host.said());
    host.set(node, "strength", 1.0);
    host.press(node, "strength");
    host.render(node, at(3.0)).expect("it renders");
    assert_eq!((host.said().len(), host.heard().len()), (1, 2), "{:?}", host.heard());
    host.finish();
}

#[test]
fn a_picture_without_faults_gives_no_messages() {
    for profile in ALL {
        for which in [Which::PinWarp, Which::StMap] {
            let mut host = Host::start(profile, which);
            let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
            host.render(node, Frame::default()).expect("it renders");
            assert!(host.heard().is_empty(), "{}: {:?}", profile.name, host.heard());
            host.finish();
        }
    }
}

/// Two pins that change places.
fn crossed(host: &Host, node: Node) {
    host.pin(node, 1, [60.0, 45.0], [100.0, 45.0]);
    host.pin(node, 2, [100.0, 45.0], [60.0, 45.0]);
    host.pin(node, 3, [80.0, 20.0], [80.0, 20.0]);
}

#[test]
fn folds_are_warned_of_and_can_be_kept_away() {
    // The guard finds a way to change places around each other.
    for (guard, word) in [(0, Some("over")), (1, None)] {
        let mut host = Host::start(&BOOK, Which::PinWarp);
        let node = host.node();
        host.through(node, &Pixels::scenery(SIZE, 4));
        crossed(&host, node);
        // Where the border is held nothing folds.
        host.set(node, "holdBorder", 0);
        host.set(node, "guard", guard);
        host.render(node, Frame::default()).expect("it renders");
        let said = host.said();
        assert_eq!(said.len(), usize::from(word.is_some()), "guard {guard}: {said:?}");
        assert!(said.iter().all(|said| word.is_some_and(|word| said.text.contains(word))), "guard {guard}: {said:?}");
        host.finish();
    }
}

#[test]
fn pins_are_named_by_their_numbers_and_names() {
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = host.node();
    host.through(node, &Pixels::scenery(SIZE, 4));
    host.pin(node, 4, [80.0, 45.0], [90.0, 45.0]);
    host.pin(node, 9, [80.0, 45.0], [70.0, 45.0]);
    host.set(node, "pin9Name", "100% nose");
    host.render(node, Frame::default()).expect("it renders");
    let said = host.said();
    assert!(said.len() == 1 && said[0].text.contains("4") && said[0].text.contains("9 '100% nose'"), "{said:?}");
    assert!(said[0].text.contains("10 px"), "it goes between them: {said:?}");
    host.finish();
}

#[test]
fn implausible_pins_are_reported_in_pixels() {
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
    host.pin(node, 7, [60.0, 40.0], [1e7, 40.0]);
    assert!(host.render(node, Frame::default()).is_err());
    let said = host.said();
    assert!(said.len() == 1 && said[0].text.contains("pin 7") && said[0].text.contains("10000000, 40 px"), "{said:?}");
    host.finish();
}

#[test]
fn nothing_in_a_name_drives_a_terminal_or_breaks_a_line() {
    let nasty = "no\u{1b}[31mse\n\u{202e}gpj";
    let is_plain = |text: &str| !text.contains(|letter: char| letter.is_control() || letter == '\u{202e}');
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = host.node();
    host.through(node, &Pixels::scenery(SIZE, 4));
    host.pin(node, 1, [80.0, 45.0], [90.0, 45.0]);
    host.pin(node, 2, [80.0, 45.0], [70.0, 45.0]);
    host.set(node, "pin2Name", nasty);
    host.render(node, Frame::default()).expect("it renders");
    host.set(node, "shape", 2);
    host.set(node, "shotFile", format!("/nowhere/{nasty}.toml").as_str());
    host.press(node, "readShot");
    host.set(node, "stmapFolder", "/nowhere");
    host.set(node, "stmapName", format!("{nasty}/").as_str());
    host.set(node, "shape", 0);
    host.press(node, "writeStmaps");
    let heard = host.heard();
    assert_eq!(heard.len(), 3, "{heard:?}");
    for said in heard {
        assert!(is_plain(&said.text) && said.text.contains(r"no\u{1b}[31mse\n\u{202e}gpj"), "{said:?}");
    }
    host.finish();
}

#[test]
fn messages_are_not_format_strings() {
    let folder = tempfile::Builder::new().prefix("100% sure").tempdir().expect("a folder");
    let mut host = Host::start(&RESOLVE, Which::PinWarp);
    let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
    host.set(node, "writePath", folder.path().join("pins.toml").to_str().expect("plain letters"));
    host.press(node, "writeShot");
    let said = host.said();
    assert!(said.len() == 1 && said[0].text.contains("100% sure"), "{said:?}");
    assert_eq!(said[0].kind.as_bytes(), MESSAGE_MESSAGE.to_bytes());
    host.finish();
}
