//! Effects that end: whatever a host still sends, nothing of it is touched.

use crate::host::api::names::{action, image, interact};
use crate::host::api::{PropertySet, Status};
use crate::host::profile::{ALL, BOOK, NATRON};
use crate::host::{Frame, Host, Pixels, Which, declared};
use crate::{SIZE, pulled};
use std::ffi::CStr;

/// Every action of the API on effects, but those that begin a life.
const ACTIONS: &[&CStr] = &[
    action::DESTROY_INSTANCE,
    action::BEGIN_INSTANCE_CHANGED,
    action::INSTANCE_CHANGED,
    action::END_INSTANCE_CHANGED,
    action::BEGIN_INSTANCE_EDIT,
    action::END_INSTANCE_EDIT,
    action::GET_REGION_OF_DEFINITION,
    action::GET_REGIONS_OF_INTEREST,
    action::GET_FRAMES_NEEDED,
    action::GET_CLIP_PREFERENCES,
    action::GET_TIME_DOMAIN,
    action::IS_IDENTITY,
    action::BEGIN_SEQUENCE_RENDER,
    action::RENDER,
    action::END_SEQUENCE_RENDER,
    action::PURGE_CACHES,
    action::SYNC_PRIVATE_DATA,
];

/// Every action of overlays.
const OVERLAY_ACTIONS: &[&CStr] = &[
    interact::LOSE_FOCUS,
    interact::PEN_UP,
    interact::DRAW,
    interact::PEN_MOTION,
    interact::PEN_DOWN,
    interact::KEY_DOWN,
    interact::KEY_UP,
    interact::KEY_REPEAT,
    interact::GAIN_FOCUS,
];

#[test]
fn no_action_on_an_ended_effect_touches_the_host() {
    for profile in ALL {
        for which in [Which::PinWarp, Which::StMap] {
            let mut host = Host::start(profile, which);
            let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
            host.render(node, Frame::default()).unwrap_or_else(|status| panic!("{}: {status:?}", profile.name));
            host.destroy(node);
            for name in ACTIONS.iter().chain(ACTIONS.iter().rev()) {
                let (status, _) = host.ask((name, "of an ended effect"), node.0, Vec::new());
                assert!(status != Status::FAILED, "{}: {name:?}", profile.name);
            }
            // Every handle that was used after its end is a fault, and fails `finish`.
            host.finish();
        }
    }
}

#[test]
fn an_effect_that_ends_with_its_message_up_does_not_clear_it() {
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
    host.set(node, "shape", 2);
    assert!(host.render(node, Frame::default()).is_err());
    // The host's side is gone before the plugin hears of it.
    host.break_off(node);
    assert_eq!(host.ask((action::DESTROY_INSTANCE, "DestroyInstance"), node.0, Vec::new()).0, Status::OK);
    host.finish();
}

#[test]
fn destroying_needs_no_host_at_all() {
    let host = Host::start(&BOOK, Which::PinWarp);
    let entry = declared(0).main_entry.expect("it takes actions");
    let (name, none) = (action::DESTROY_INSTANCE, PropertySet::NULL);
    // SAFETY: the handle points nowhere; nothing may look behind it.
    let status = unsafe { entry(name.as_ptr(), 0x10 as *const _, none, none) };
    assert_eq!(status, Status::OK);
    host.finish();
}

#[test]
fn overlays_of_ended_effects_touch_nothing_in_any_order() {
    for profile in [&BOOK, &NATRON] {
        for is_dragging in [false, true] {
            let mut host = Host::start(profile, Which::PinWarp);
            let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
            let overlay = host.overlay(node, 1.0).expect("there is one").detached();
            if is_dragging {
                overlay.pen(interact::PEN_DOWN, "PenDown", [96.0, 54.0]);
                overlay.pen(interact::PEN_MOTION, "PenMotion", [99.0, 58.0]);
            }
            host.destroy(node);
            for name in OVERLAY_ACTIONS {
                overlay.pen(name, "of an ended effect", [96.0, 54.0]);
            }
            overlay.close();
            host.forgive_open_edits();
            host.finish();
        }
    }
}

#[test]
fn actions_of_ended_effects_and_their_overlays_touch_nothing_in_any_order() {
    let mut order: u64 = 0x9E37_79B9_7F4A_7C15;
    let mut draw = |count: usize| {
        order = order.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (order >> 33) as usize % count
    };
    for round in 0..12 {
        let mut host = Host::start(if round % 2 == 0 { &BOOK } else { &NATRON }, Which::PinWarp);
        // Another instance lives on meanwhile.
        let [node, living] = [0, 1].map(|_| pulled(&mut host, &Pixels::scenery(SIZE, 4)));
        let before = host.render(living, Frame::default()).expect("it renders");
        let overlay = host.overlay(node, 1.0).expect("there is one").detached();
        if draw(2) == 0 {
            overlay.pen(interact::PEN_DOWN, "PenDown", [96.0, 54.0]);
        }
        host.destroy(node);
        for _ in 0..40 {
            let name = draw(ACTIONS.len() + OVERLAY_ACTIONS.len());
            match ACTIONS.get(name) {
                Some(name) => _ = host.ask((name, "of an ended effect"), node.0, Vec::new()),
                None => _ = overlay.pen(OVERLAY_ACTIONS[name - ACTIONS.len()], "of an ended effect", [96.0, 54.0]),
            }
        }
        assert!(host.render(living, Frame::default()).expect("it renders") == before, "round {round}");
        overlay.close();
        host.forgive_open_edits();
        host.finish();
    }
}

#[test]
fn an_overlay_closes_while_its_effect_and_itself_are_half_gone() {
    for is_dragging in [false, true] {
        let mut host = Host::start(&NATRON, Which::PinWarp);
        let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
        let overlay = host.overlay(node, 1.0).expect("there is one").detached();
        if is_dragging {
            overlay.pen(interact::PEN_DOWN, "PenDown", [96.0, 54.0]);
        } else {
            overlay.pen(interact::PEN_MOTION, "PenMotion", [10.0, 10.0]);
        }
        // Natron: the effect's own DestroyInstance comes last, when nothing is left of it.
        host.break_off(node);
        overlay.close_half_gone();
        assert_eq!(host.ask((action::DESTROY_INSTANCE, "DestroyInstance"), node.0, Vec::new()).0, Status::OK);
        host.forgive_open_edits();
        host.finish();
    }
}

#[test]
fn a_handle_that_is_used_again_begins_anew() {
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
    let before = host.render(node, Frame::default()).expect("it renders");
    let asked = (action::DESTROY_INSTANCE, "DestroyInstance");
    assert_eq!(host.ask(asked, node.0, Vec::new()).0, Status::OK);
    assert!(host.render(node, Frame::default()).is_err(), "it has ended");
    assert_eq!(host.ask((action::CREATE_INSTANCE, "CreateInstance"), node.0, Vec::new()).0, Status::OK);
    assert!(host.render(node, Frame::default()).expect("it renders") == before);
    assert_eq!(host.described(image::SUPPORTED_CONTEXTS).len(), 2);
    host.finish();
}
