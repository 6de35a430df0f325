//! Clip preferences: what the plugin tells of its output before anything is rendered.

use crate::host::api::Status;
use crate::host::api::names::{action, image};
use crate::host::profile::BOOK;
use crate::host::{Host, Node, Pixels, Value, Which, feed};
use crate::{SIZE, pulled};
use std::ffi::CStr;

/// A property of the answers.
fn told(host: &Host, node: Node, name: &CStr) -> Option<Value> {
    let asked = (action::GET_CLIP_PREFERENCES, "GetClipPreferences");
    let (status, mut answers) = host.ask(asked, node.0, Vec::new());
    assert_eq!(status, Status::OK);
    answers.remove(name).and_then(|values| values.first().cloned())
}

fn text(text: &CStr) -> Option<Value> {
    Some(Value::Text(text.to_owned()))
}

#[test]
fn premultiplication_follows_the_source_and_opaque_pictures_get_holes() {
    let pixels = Pixels::scenery(SIZE, 4);
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &pixels);
    for (source, output) in [
        (image::PREMULTIPLIED, image::PREMULTIPLIED),
        (image::UNPREMULTIPLIED, image::UNPREMULTIPLIED),
        (image::OPAQUE, image::PREMULTIPLIED),
    ] {
        let mut form = feed(Some(pixels.clone()), pixels.bounds, 4);
        form.premultiplication = source;
        host.feed_as(node, image::SOURCE_CLIP, form);
        assert_eq!(told(&host, node, image::PREMULTIPLICATION), text(output), "{source:?}");
    }
    for name in [c"OfxImageClipPropComponents_Output", c"OfxImageClipPropDepth_Output"] {
        assert_eq!(told(&host, node, name), None, "the output is like the source");
    }
    host.finish();
}

#[test]
fn a_map_is_made_of_floats_that_are_not_multiplied() {
    let mut host = Host::start(&BOOK, Which::StMap);
    let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
    assert_eq!(told(&host, node, c"OfxImageClipPropComponents_Output"), text(image::COMPONENT_RGBA));
    assert_eq!(told(&host, node, c"OfxImageClipPropDepth_Output"), text(image::DEPTH_FLOAT));
    assert_eq!(told(&host, node, image::PREMULTIPLICATION), text(image::UNPREMULTIPLIED));
    host.finish();
}

#[test]
fn frames_vary_by_themselves_with_a_shot_only() {
    for which in [Which::PinWarp, Which::StMap] {
        let mut host = Host::start(&BOOK, which);
        let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
        for (shape, varies) in [(0, 0), (1, 0), (2, 1)] {
            host.set(node, "shape", shape);
            assert_eq!(told(&host, node, image::FRAME_VARYING), Some(Value::Int(varies)), "shape {shape}");
        }
        assert_eq!(host.described(image::CLIP_PREFERENCES_SLAVE_PARAM), ["shape"], "they are asked for again");
        host.finish();
    }
}
