//! Hosts that the plugin has to live with, as data: what they offer, leave out and do their own way.
//!
//! In: nothing. Out: one profile a host. What was seen in a host's own code or documentation stands beside it.

use super::api::names::{self, image, param, prop};
use super::pixels::Rows;
use std::ffi::CStr;

/// Where a host says that a clip has pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Regions {
    /// In canonical coordinates, as the API wants it.
    Canonical,
    /// In pixels of the scale that is rendered.
    Pixels,
    /// It answers OK and writes nothing.
    Unwritten,
    /// It does not say.
    Refused,
    /// Everywhere: Natron's generators, and whatever follows them.
    Endless,
}

/// What a host knows of keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Keys {
    /// All there is to know.
    Known,
    /// It ends the program when asked.
    Fatal,
}

/// Where a host writes the two numbers of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Points {
    /// Each at its place.
    Apart,
    /// The second one behind the first, whatever place was given for it.
    InARow,
}

/// What a host answers when asked for a clip that is not there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NoClip {
    /// A status that says so.
    Refused,
    /// OK, and null.
    Null,
}

/// A host.
#[derive(Clone, Debug)]
pub(crate) struct Profile {
    pub(crate) name: &'static str,
    /// Version of the API; `None`: it does not say, which means 1.0.
    pub(crate) api: Option<[i32; 2]>,
    /// It calls `OfxSetHost` first.
    pub(crate) sets_host: bool,
    /// Suites beside the three that every host has.
    pub(crate) suites: &'static [(&'static CStr, i32)],
    /// Suites for which it ends the program.
    pub(crate) fatal: &'static [(&'static CStr, i32)],
    /// Properties it does not know.
    pub(crate) refuses: &'static [&'static CStr],
    /// Types of parameters it refuses to define.
    pub(crate) no_params: &'static [&'static CStr],
    pub(crate) context: &'static CStr,
    pub(crate) rows: Rows,
    pub(crate) regions: Regions,
    pub(crate) no_clip: NoClip,
    pub(crate) keys: Keys,
    pub(crate) points: Points,
    /// Ints that it tells all at once only; one alone is answered with OK, and not written.
    pub(crate) untold_alone: &'static [&'static CStr],
    /// It tells the plugin at once of what the plugin itself changes.
    pub(crate) echoes: bool,
    pub(crate) overlays: i32,
}

/// A host that does everything as the API has it, and offers all.
pub(crate) const BOOK: Profile = Profile {
    name: "pinwarp.test.book",
    api: Some([1, 5]),
    sets_host: true,
    suites: &[(names::MESSAGE_SUITE, 1), (names::MESSAGE_SUITE, 2), (names::INTERACT_SUITE, 1), (names::DRAW_SUITE, 1)],
    fatal: &[],
    refuses: &[],
    no_params: &[],
    context: image::CONTEXT_GENERAL,
    rows: Rows::Padded,
    regions: Regions::Canonical,
    no_clip: NoClip::Refused,
    keys: Keys::Known,
    points: Points::Apart,
    untold_alone: &[],
    echoes: true,
    overlays: 1,
};

/// A host that offers what it must and nothing else.
pub(crate) const BARE: Profile = Profile {
    name: "pinwarp.test.bare",
    api: None,
    sets_host: false,
    suites: &[],
    fatal: &[(names::MESSAGE_SUITE, 2)],
    refuses: &[
        prop::API_VERSION,
        image::PROJECT_SIZE,
        image::PROJECT_EXTENT,
        image::PROJECT_OFFSET,
        image::PREMULTIPLICATION,
        image::PIXEL_ASPECT,
        image::UNIQUE_IDENTIFIER,
        prop::SHORT_LABEL,
        prop::LONG_LABEL,
        prop::PLUGIN_DESCRIPTION,
        param::ENABLED,
        param::SECRET,
        param::USE_HOST_OVERLAY_HANDLE,
        param::DEFAULT_COORDINATES,
        param::SCRIPT_NAME,
        param::HINT,
    ],
    context: image::CONTEXT_FILTER,
    rows: Rows::Up,
    echoes: false,
    overlays: 0,
    ..BOOK
};

/// MLT (Kdenlive, Shotcut), `src/modules/openfx/`: new instances for every frame; a project size that plugins cannot see;
/// regions in pixels of the preview; null for clips that are not there; rows from above. Before 7.40 it refused buttons
/// and pages.
pub(crate) const MLT: Profile = Profile {
    name: "MLT",
    api: None,
    sets_host: true,
    suites: &[
        (names::MESSAGE_SUITE, 1),
        (names::MESSAGE_SUITE, 2),
        (names::INTERACT_SUITE, 1),
        (names::DRAW_SUITE, 1),
        (names::MEMORY_SUITE, 1),
    ],
    refuses: &[image::PROJECT_SIZE, image::PROJECT_EXTENT, image::PROJECT_OFFSET, prop::API_VERSION],
    no_params: &[param::TYPE_PAGE, param::TYPE_PUSH_BUTTON],
    context: image::CONTEXT_FILTER,
    rows: Rows::Down,
    regions: Regions::Pixels,
    no_clip: NoClip::Null,
    echoes: false,
    overlays: 0,
    ..BOOK
};

/// MLT before 7.40, which left regions unwritten.
pub(crate) const OLD_MLT: Profile = Profile { regions: Regions::Unwritten, ..MLT };

/// Natron, on the HostSupport library of the OpenFX project: everything of 1.4; overlays by OpenGL. Its sources may be
/// endless, and a region that is large and has an end is taken at its word.
pub(crate) const NATRON: Profile = Profile {
    name: "fr.inria.Natron",
    api: Some([1, 4]),
    sets_host: false,
    suites: &[(names::MESSAGE_SUITE, 1), (names::MESSAGE_SUITE, 2), (names::INTERACT_SUITE, 1)],
    refuses: &[param::USE_HOST_OVERLAY_HANDLE, param::PAGE_ORDER],
    rows: Rows::Up,
    ..BOOK
};

/// DaVinci Resolve: no tiles, few properties, no persistent messages.
pub(crate) const RESOLVE: Profile = Profile {
    name: "DaVinciResolve",
    api: Some([1, 4]),
    sets_host: false,
    suites: &[(names::MESSAGE_SUITE, 1), (names::INTERACT_SUITE, 1)],
    refuses: &[param::DEFAULT_COORDINATES],
    context: image::CONTEXT_FILTER,
    rows: Rows::Up,
    ..BOOK
};

/// Nuke: floats only, general context.
pub(crate) const NUKE: Profile = Profile {
    name: "uk.co.thefoundry.nuke",
    api: Some([1, 3]),
    sets_host: false,
    suites: &[(names::MESSAGE_SUITE, 1), (names::MESSAGE_SUITE, 2), (names::INTERACT_SUITE, 1)],
    rows: Rows::Padded,
    ..BOOK
};

/// openfx-runner, a scripted host, `src/main.rs` and `src/suite_impls.rs`: it speaks 1.4 and ends the program when asked for
/// version 2 of a suite, or for keys; parameters say nothing of whether they are animated.
pub(crate) const RUNNER: Profile = Profile {
    name: "openfx-driver",
    api: Some([1, 4]),
    sets_host: false,
    suites: &[(names::MESSAGE_SUITE, 1), (names::MEMORY_SUITE, 1)],
    fatal: &[(names::MESSAGE_SUITE, 2), (names::PROPERTY_SUITE, 2), (names::PARAMETER_SUITE, 2)],
    refuses: &[param::IS_ANIMATING, image::PROJECT_PIXEL_ASPECT],
    context: image::CONTEXT_FILTER,
    rows: Rows::Up,
    keys: Keys::Fatal,
    echoes: false,
    overlays: 0,
    ..BOOK
};

/// pyofx, a host in Python: its functions take a fixed number of arguments, so a point's numbers go where the first belongs;
/// windows are kept as doubles, which a question for one int leaves unwritten; it knows no regions, and no clip is null.
pub(crate) const PYOFX: Profile = Profile {
    name: "pyOfx",
    api: Some([1, 4]),
    sets_host: false,
    suites: &[(names::MESSAGE_SUITE, 1), (names::MESSAGE_SUITE, 2), (names::MEMORY_SUITE, 1)],
    rows: Rows::Up,
    regions: Regions::Refused,
    no_clip: NoClip::Null,
    points: Points::InARow,
    untold_alone: &[image::RENDER_WINDOW],
    echoes: false,
    overlays: 0,
    ..BOOK
};

/// All of them.
pub(crate) const ALL: &[&Profile] = &[&BOOK, &BARE, &MLT, &OLD_MLT, &NATRON, &RESOLVE, &NUKE, &RUNNER, &PYOFX];
