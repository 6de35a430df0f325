//! The three functions that hosts look up in the library, and the dispatch of actions to their functions.
//!
//! In: C calls, valid or not. Out: a status for each; no panic crosses the FFI boundary.

use super::api::names::action;
use super::api::{EffectHandle, Host, Plugin, PropertySet, Status, names};
use super::call::{Action, Call, PluginKind};
use super::fault::Fault;
use super::host::{self, Effect, Props, action_name, caught, guarded};
use super::{budget, changed, describe, pen, regions, render};
use crate::spelling::escaped;
use std::ffi::{CStr, c_char, c_int, c_void};

/// Actions on effects. All others return `REPLY_DEFAULT`.
const ACTIONS: &[(&CStr, Action)] = &[
    (action::DESCRIBE, describe::describe),
    (action::DESCRIBE_IN_CONTEXT, describe::describe_in_context),
    (action::CREATE_INSTANCE, changed::created),
    (action::INSTANCE_CHANGED, changed::changed),
    (action::GET_REGION_OF_DEFINITION, regions::definition),
    (action::GET_REGIONS_OF_INTEREST, regions::interest),
    (action::IS_IDENTITY, regions::is_identity),
    (action::GET_CLIP_PREFERENCES, regions::clip_preferences),
    (action::RENDER, render::render),
    (action::PURGE_CACHES, changed::purged),
    // All state is in parameters, so there is nothing to write back.
    (action::SYNC_PRIVATE_DATA, |_| Ok(Status::OK)),
    (action::BEGIN_SEQUENCE_RENDER, |_| Ok(Status::OK)),
    (action::END_SEQUENCE_RENDER, |_| Ok(Status::OK)),
];

/// Actions that begin the life of a handle; hosts reuse the addresses of destroyed ones.
const BEGINNINGS: [&CStr; 3] = [action::DESCRIBE, action::DESCRIBE_IN_CONTEXT, action::CREATE_INSTANCE];

/// A plugin structure shared with the host; its raw string pointers make it `!Sync`, though it is constant.
struct Shared(Plugin);

// SAFETY: the strings are constants and nobody writes to a plugin's structure.
unsafe impl Sync for Shared {}

/// The plugins, in the order of their index.
static PLUGINS: [Shared; 2] =
    [plugin_of(c"io.github.pinwarp.PinWarp", pin_warp), plugin_of(c"io.github.pinwarp.PinWarpST", st_map)];

const fn plugin_of(identifier: &'static CStr, main_entry: super::api::EntryPoint) -> Shared {
    Shared(Plugin {
        api: names::IMAGE_EFFECT_API.as_ptr(),
        api_version: 1,
        identifier: identifier.as_ptr(),
        version_major: 1,
        version_minor: 0,
        set_host: Some(meet_host),
        main_entry: Some(main_entry),
    })
}

/// Returns the number of plugins in the library.
#[unsafe(export_name = "OfxGetNumberOfPlugins")]
pub extern "C" fn number_of_plugins() -> c_int {
    2
}

/// Returns the nth plugin, or null if there is none.
#[unsafe(export_name = "OfxGetPlugin")]
pub extern "C" fn plugin(nth: c_int) -> *const Plugin {
    let plugin = usize::try_from(nth).ok().and_then(|nth| PLUGINS.get(nth));
    plugin.map_or(std::ptr::null(), |plugin| &raw const plugin.0)
}

/// Receives the host before anything else (API 1.4); few hosts call it.
///
/// # Safety
/// `host` is null or stays valid while the library is loaded.
#[unsafe(export_name = "OfxSetHost")]
pub unsafe extern "C" fn set_host(host: *const Host) -> Status {
    guarded(|| {
        host::meet(host);
        Status::OK
    })
}

/// Receives the host; this is the plugins' `setHost`.
unsafe extern "C" fn meet_host(host: *const Host) {
    let _nobody_to_tell = guarded(|| {
        host::meet(host);
        Status::OK
    });
}

unsafe extern "C" fn pin_warp(
    name: *const c_char,
    handle: *const c_void,
    args: PropertySet,
    out: PropertySet,
) -> Status {
    guarded(|| act(PluginKind::PinWarp, name, handle, [args, out]))
}

unsafe extern "C" fn st_map(name: *const c_char, handle: *const c_void, args: PropertySet, out: PropertySet) -> Status {
    guarded(|| act(PluginKind::StMap, name, handle, [args, out]))
}

fn act(kind: PluginKind, name: *const c_char, handle: *const c_void, [args, out]: [PropertySet; 2]) -> Status {
    // SAFETY: the host passes action names as NUL-terminated strings.
    let Some(name) = (unsafe { action_name(name) }) else { return Status::ERR_UNKNOWN };
    // Load returns OK, never `REPLY_DEFAULT`: MLT treats any other status as a failure.
    if name == action::LOAD {
        budget::read_limit();
        return host::load().map_or_else(|error| Fault::from(error).status(), |_| Status::OK);
    }
    let handle = EffectHandle(handle.cast_mut());
    if name == action::DESTROY_INSTANCE {
        // The host may have destroyed parts of the instance already, so it is not accessed from here on.
        host::end_effect(handle);
        pen::forget(handle.0 as usize);
        return Status::OK;
    }
    let Some((_, work)) = ACTIONS.iter().find(|(known, _)| *known == name) else { return Status::REPLY_DEFAULT };
    if BEGINNINGS.contains(&name) {
        host::begin_effect(handle);
    }
    if handle.is_null() || host::has_ended(handle) {
        return Status::ERR_BAD_HANDLE;
    }
    let Ok(suites) = host::suites() else { return Status::ERR_MISSING_HOST_FEATURE };
    let effect = Effect { suites: &suites, handle };
    let call = Call { kind, effect, args: Props::new(suites.property, args), out: Props::new(suites.property, out) };
    caught(|| work(call)).unwrap_or_else(|words| Err(Fault::Panic(words))).unwrap_or_else(|fault| {
        if !fault.is_abort() {
            effect.show_error(&escaped(&fault.to_string()));
        }
        fault.status()
    })
}
