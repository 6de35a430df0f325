//! Every action in every host; the words of the descriptions; wrong calls.

use crate::host::api::names::{action, image, param};
use crate::host::api::{PropertySet, Status};
use crate::host::profile::{ALL, BOOK, RESOLVE};
use crate::host::{Frame, Host, Pixels, Which, declared};
use crate::{SIZE, pulled};
use pinwarp::ofx::{number_of_plugins, plugin};

#[test]
fn every_action_is_answered_in_every_host() {
    for profile in ALL {
        for which in [Which::PinWarp, Which::StMap] {
            let mut host = Host::start(profile, which);
            let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
            for (name, short) in [
                (action::BEGIN_SEQUENCE_RENDER, "BeginSequenceRender"),
                (action::GET_CLIP_PREFERENCES, "GetClipPreferences"),
                (action::GET_TIME_DOMAIN, "GetTimeDomain"),
                (action::GET_FRAMES_NEEDED, "GetFramesNeeded"),
                (action::BEGIN_INSTANCE_EDIT, "BeginInstanceEdit"),
                (action::END_INSTANCE_EDIT, "EndInstanceEdit"),
                (action::BEGIN_INSTANCE_CHANGED, "BeginInstanceChanged"),
                (action::END_INSTANCE_CHANGED, "EndInstanceChanged"),
                (action::SYNC_PRIVATE_DATA, "SyncPrivateData"),
                (action::PURGE_CACHES, "PurgeCaches"),
                (action::END_SEQUENCE_RENDER, "EndSequenceRender"),
                (c"OfxActionOfTheFuture", "unknown"),
            ] {
                let (status, _) = host.ask((name, short), node.0, Vec::new());
                assert!(
                    [Status::OK, Status::REPLY_DEFAULT].contains(&status),
                    "{}: {name:?}: {status:?}",
                    profile.name
                );
            }
            host.region(node, [1.0, 1.0]);
            host.interest(node, [10.0, 10.0, 60.0, 50.0]);
            host.is_identity(node);
            host.render(node, Frame::default()).unwrap_or_else(|status| panic!("{}: {status:?}", profile.name));
            host.finish();
        }
    }
}

#[test]
fn the_description_says_what_hosts_look_for() {
    let host = Host::start(&BOOK, Which::PinWarp);
    assert_eq!(host.described(image::SUPPORTED_CONTEXTS).len(), 2);
    let depths = host.described(image::SUPPORTED_PIXEL_DEPTHS);
    let all = [image::DEPTH_FLOAT, image::DEPTH_HALF, image::DEPTH_SHORT, image::DEPTH_BYTE];
    assert!(all.iter().all(|depth| depths.iter().any(|known| known.as_bytes() == depth.to_bytes())), "{depths:?}");
    assert_eq!(host.described(image::RENDER_THREAD_SAFETY), ["OfxImageEffectRenderFullySafe"]);
    let parameters = host.parameters();
    let count = |kind: &std::ffi::CStr| parameters.iter().filter(|(_, of, _)| of.as_bytes() == kind.to_bytes()).count();
    assert_eq!(count(param::TYPE_DOUBLE_2D), 64, "rest and target of 32 pins");
    assert!(count(param::TYPE_PUSH_BUTTON) >= 3, "reading and writing shots, writing maps");
    host.finish();
}

#[test]
fn hosts_that_crash_on_some_parameters_or_want_limits_get_them_right() {
    let host = Host::start(&RESOLVE, Which::PinWarp);
    for (id, kind, has_limits) in host.parameters() {
        let is = |known: &std::ffi::CStr| kind.as_bytes() == known.to_bytes();
        assert!(!kind.contains("Integer2D") && !kind.contains("Bytes") && !kind.contains("Custom"), "{id}: {kind}");
        let is_number = is(param::TYPE_INTEGER) || is(param::TYPE_DOUBLE) || is(param::TYPE_DOUBLE_2D);
        assert!(has_limits || !is_number, "{id} needs a range and a display range: Resolve hides it without");
    }
    host.finish();
}

#[test]
fn calls_that_make_no_sense_are_answered_with_a_status() {
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = host.node();
    for nth in [-1, number_of_plugins(), i32::MAX, i32::MIN] {
        assert!(plugin(nth).is_null(), "there is no plugin {nth}");
    }
    let entry = declared(0).main_entry.expect("it takes actions");
    let none = PropertySet::NULL;
    // SAFETY: the entry takes null for all.
    let unnamed = unsafe { entry(std::ptr::null(), std::ptr::null(), none, none) };
    assert!(![Status::OK, Status::REPLY_DEFAULT].contains(&unnamed), "{unnamed:?}");
    for name in [action::DESCRIBE, action::DESCRIBE_IN_CONTEXT, action::RENDER, action::CREATE_INSTANCE] {
        // SAFETY: as above.
        let status = unsafe { entry(name.as_ptr(), std::ptr::null(), none, none) };
        assert!(!status.is_ok(), "{name:?} of nothing: {status:?}");
    }
    // A render without clips and arguments.
    let (status, _) = host.ask((action::RENDER, "Render"), node.0, Vec::new());
    assert!(!status.is_ok(), "{status:?}");
    let (status, _) = host.ask((action::INSTANCE_CHANGED, "InstanceChanged"), node.0, Vec::new());
    assert!([Status::OK, Status::REPLY_DEFAULT].contains(&status), "{status:?}");
    host.take_faults();
    host.finish();
}

#[test]
fn the_host_notices_what_is_wrong() {
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = host.node();
    host.destroy(node);
    // The plugin is handed an effect that is gone, and can but use it.
    host.ask((action::CREATE_INSTANCE, "CreateInstance"), node.0, Vec::new());
    let faults = host.take_faults();
    assert!(faults.iter().any(|fault| fault.contains("after its end")), "{faults:?}");
    host.finish();
}
