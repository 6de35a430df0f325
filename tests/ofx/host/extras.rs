//! Suites that a host may leave out: messages, overlays, drawing; and the way to all suites.

use super::api::{
    DrawContextHandle, DrawSuiteV1, InteractHandle, InteractSuiteV1, MessageSuiteV1, MessageSuiteV2, ParameterSuiteV1,
    PointD, PropertySet, RgbaColour, Status, names,
};
use super::effects::{give, seen};
use super::params::suite as params;
use super::props::name_of;
use super::world::{Drawn, Said, with};
use super::{effects, props};
use std::ffi::{c_char, c_int, c_void};
use std::sync::LazyLock;

/// A message with at most one argument; see `params::variadic`.
type Message = unsafe extern "C" fn(*mut c_void, *const c_char, *const c_char, *const c_char, *const c_char) -> Status;
/// How the API declares it.
type VariadicMessage = unsafe extern "C" fn(*mut c_void, *const c_char, *const c_char, *const c_char, ...) -> Status;

static PARAMS: LazyLock<ParameterSuiteV1> = LazyLock::new(params);
static MESSAGE_1: LazyLock<MessageSuiteV1> = LazyLock::new(|| MessageSuiteV1 { message: Some(variadic(message)) });
static MESSAGE_2: LazyLock<MessageSuiteV2> = LazyLock::new(|| MessageSuiteV2 {
    message: Some(variadic(message)),
    set_persistent_message: Some(variadic(set_persistent_message)),
    clear_persistent_message: Some(clear_persistent_message),
});
static INTERACT: InteractSuiteV1 =
    InteractSuiteV1 { swap_buffers: None, redraw: Some(redraw), get_property_set: Some(interact_property_set) };
static DRAW: DrawSuiteV1 = DrawSuiteV1 {
    get_colour: Some(get_colour),
    set_colour: Some(set_colour),
    set_line_width: Some(set_line_width),
    set_line_stipple: Some(set_line_stipple),
    draw: Some(draw),
    draw_text: Some(draw_text),
};

/// The handle of where overlays are drawn.
pub(crate) const CANVAS: usize = 0xD0D0;

fn variadic(message: Message) -> VariadicMessage {
    // SAFETY: see `params::variadic`: the registers are the same.
    unsafe { std::mem::transmute::<Message, VariadicMessage>(message) }
}

/// The host's way to its suites.
pub(crate) unsafe extern "C" fn fetch_suite(host: PropertySet, name: *const c_char, version: c_int) -> *const c_void {
    let name = name_of(name);
    let asked = (name.as_c_str(), version);
    let (offered, tells_many) = with(|world| {
        if host.0 as usize != world.host_set {
            world.bad_handle(host.0 as usize, "the host");
        }
        if world.profile.fatal.contains(&asked) {
            world.fault(format!("{name:?} {version} was asked for: this host ends the program then"));
        }
        (world.profile.suites.contains(&asked), !world.profile.untold_alone.is_empty())
    });
    match asked {
        (suite, 1) if suite == names::PROPERTY_SUITE && tells_many => (&raw const props::SUITE_OF_MANY).cast(),
        (suite, 1) if suite == names::PROPERTY_SUITE => (&raw const props::SUITE).cast(),
        (suite, 1) if suite == names::IMAGE_EFFECT_SUITE => (&raw const effects::SUITE).cast(),
        (suite, 1) if suite == names::PARAMETER_SUITE => (&raw const *PARAMS).cast(),
        _ if !offered => std::ptr::null(),
        (suite, 1) if suite == names::MESSAGE_SUITE => (&raw const *MESSAGE_1).cast(),
        (suite, 2) if suite == names::MESSAGE_SUITE => (&raw const *MESSAGE_2).cast(),
        (suite, 1) if suite == names::INTERACT_SUITE => (&raw const INTERACT).cast(),
        (suite, 1) if suite == names::DRAW_SUITE => (&raw const DRAW).cast(),
        _ => std::ptr::null(),
    }
}

fn note(kind: *const c_char, format: *const c_char, lasts: bool) -> Status {
    let kind = name_of(kind).to_string_lossy().into_owned();
    let format = name_of(format).to_string_lossy().into_owned();
    let text = format.replace("%%", "\u{0}");
    if text.contains('%') {
        return with(|world| world.fault(format!("{format:?} asks for arguments: Natron shows such messages empty")));
    }
    let text = text.replace('\u{0}', "%");
    with(|world| {
        let said = Said { kind, text, lasts };
        world.heard.push(said.clone());
        world.said.push(said);
    });
    Status::OK
}

unsafe extern "C" fn message(
    _: *mut c_void,
    kind: *const c_char,
    _: *const c_char,
    format: *const c_char,
    _: *const c_char,
) -> Status {
    note(kind, format, false)
}

unsafe extern "C" fn set_persistent_message(
    effect: *mut c_void,
    kind: *const c_char,
    _: *const c_char,
    format: *const c_char,
    _: *const c_char,
) -> Status {
    with(|world| {
        if !world.effects.contains_key(&(effect as usize)) {
            world.bad_handle(effect as usize, "an effect with a message");
        }
    });
    note(kind, format, true)
}

unsafe extern "C" fn clear_persistent_message(effect: *mut c_void) -> Status {
    with(|world| {
        if !world.effects.contains_key(&(effect as usize)) {
            return world.bad_handle(effect as usize, "an effect with a message");
        }
        world.said.retain(|said| !said.lasts);
        Status::OK
    })
}

unsafe extern "C" fn redraw(overlay: InteractHandle) -> Status {
    with(|world| {
        if !world.interacts.contains_key(&(overlay.0 as usize)) {
            return world.bad_handle(overlay.0 as usize, "an overlay");
        }
        world.redraws += 1;
        Status::OK
    })
}

unsafe extern "C" fn interact_property_set(overlay: InteractHandle, to: *mut PropertySet) -> Status {
    with(|world| match world.interacts.get(&(overlay.0 as usize)) {
        Some(set) => {
            give(to, PropertySet(seen(*set)));
            Status::OK
        }
        None => world.bad_handle(overlay.0 as usize, "an overlay"),
    })
}

/// Changes the pencil of the drawing.
fn pencil(context: DrawContextHandle, change: impl FnOnce(&mut Drawn)) -> Status {
    with(|world| {
        if context.0 as usize != CANVAS {
            return world.bad_handle(context.0 as usize, "a place to draw");
        }
        change(&mut world.pencil);
        Status::OK
    })
}

unsafe extern "C" fn get_colour(context: DrawContextHandle, which: c_int, to: *mut RgbaColour) -> Status {
    let level = 0.25 * which as f32;
    give(to, RgbaColour { r: level, g: level, b: level, a: 1.0 });
    pencil(context, |_| ())
}

unsafe extern "C" fn set_colour(context: DrawContextHandle, colour: *const RgbaColour) -> Status {
    // SAFETY: the plugin points to a colour.
    let RgbaColour { r, g, b, a } = unsafe { colour.read() };
    pencil(context, |pencil| pencil.colour = [r, g, b, a])
}

unsafe extern "C" fn set_line_width(context: DrawContextHandle, width: f32) -> Status {
    pencil(context, |pencil| pencil.width = width)
}

unsafe extern "C" fn set_line_stipple(context: DrawContextHandle, _: c_int) -> Status {
    pencil(context, |_| ())
}

unsafe extern "C" fn draw(context: DrawContextHandle, figure: c_int, points: *const PointD, count: c_int) -> Status {
    let count = usize::try_from(count).expect("a number of points");
    // SAFETY: the plugin points to as many points as it says.
    let points = unsafe { std::slice::from_raw_parts(points, count) };
    let points: Vec<[f64; 2]> = points.iter().map(|point| [point.x, point.y]).collect();
    pencil(context, |pencil| (pencil.figure, pencil.points) = (figure, points));
    with(|world| {
        let drawn = world.pencil.clone();
        if drawn.points.iter().flatten().any(|place| !place.is_finite()) {
            world.fault("a figure was drawn nowhere");
        }
        world.drawn.push(drawn);
    });
    Status::OK
}

unsafe extern "C" fn draw_text(context: DrawContextHandle, text: *const c_char, at: *const PointD, _: c_int) -> Status {
    let text = name_of(text).to_string_lossy().into_owned();
    // SAFETY: the plugin points to a point.
    let at = unsafe { at.read() };
    pencil(context, |_| ());
    with(|world| world.drawn.push(Drawn { figure: -1, points: vec![[at.x, at.y]], text, ..world.pencil.clone() }));
    Status::OK
}
