//! The host's suites. Three are mandatory, all others optional.
//!
//! In: the structure passed to `setHost`. Out: [`Suites`], shared by all instances.

use super::error::HostError;
use super::props::Props;
use crate::ofx::api::{
    DrawSuiteV1, Host, ImageEffectSuiteV1, InteractSuiteV1, MessageSuiteV1, MessageSuiteV2, ParameterSuiteV1,
    PropertySet, PropertySuiteV1, names,
};
use std::ffi::{CStr, c_int};
use std::sync::atomic::{AtomicPtr, Ordering};
use std::sync::{Arc, PoisonError, RwLock};

/// The host passed to `setHost`; suites may be fetched from the first action on, not before.
static HOST: AtomicPtr<Host> = AtomicPtr::new(std::ptr::null_mut());
/// Names of hosts that end the process when asked for something unsupported: openfx-runner.
const FRAGILE: [&str; 1] = ["openfx-driver"];
/// The suites of that host.
static SUITES: RwLock<Option<Arc<Suites>>> = RwLock::new(None);

/// The host's functions, valid while the plugin is loaded.
pub(in crate::ofx) struct Suites {
    pub(in crate::ofx) property: &'static PropertySuiteV1,
    pub(in crate::ofx) effect: &'static ImageEffectSuiteV1,
    pub(in crate::ofx) parameter: &'static ParameterSuiteV1,
    pub(in crate::ofx) message: Option<&'static MessageSuiteV1>,
    pub(in crate::ofx) lasting_message: Option<&'static MessageSuiteV2>,
    pub(in crate::ofx) interact: Option<&'static InteractSuiteV1>,
    pub(in crate::ofx) draw: Option<&'static DrawSuiteV1>,
    properties: PropertySet,
}

// SAFETY: the API allows suites and the host's handle to be used from any thread.
unsafe impl Send for Suites {}
// SAFETY: as above.
unsafe impl Sync for Suites {}

/// A table of functions, with the name and version under which it is fetched.
///
/// # Safety
/// The layout must be that of the suite of this name and version.
unsafe trait Suite: 'static {
    /// Name and version.
    const ID: (&'static CStr, c_int);
}

// SAFETY: `crate::ofx::api` declares these layouts as the API's headers do.
unsafe impl Suite for PropertySuiteV1 {
    const ID: (&'static CStr, c_int) = (names::PROPERTY_SUITE, 1);
}
// SAFETY: as above.
unsafe impl Suite for ImageEffectSuiteV1 {
    const ID: (&'static CStr, c_int) = (names::IMAGE_EFFECT_SUITE, 1);
}
// SAFETY: as above.
unsafe impl Suite for ParameterSuiteV1 {
    const ID: (&'static CStr, c_int) = (names::PARAMETER_SUITE, 1);
}
// SAFETY: as above.
unsafe impl Suite for MessageSuiteV1 {
    const ID: (&'static CStr, c_int) = (names::MESSAGE_SUITE, 1);
}
// SAFETY: as above.
unsafe impl Suite for MessageSuiteV2 {
    const ID: (&'static CStr, c_int) = (names::MESSAGE_SUITE, 2);
}
// SAFETY: as above.
unsafe impl Suite for InteractSuiteV1 {
    const ID: (&'static CStr, c_int) = (names::INTERACT_SUITE, 1);
}
// SAFETY: as above.
unsafe impl Suite for DrawSuiteV1 {
    const ID: (&'static CStr, c_int) = (names::DRAW_SUITE, 1);
}

fn fetch<T: Suite>(host: &Host) -> Option<&'static T> {
    let (name, version) = T::ID;
    // SAFETY: the host's own function with its own handle, and a string that outlives the call.
    let suite = unsafe { (host.fetch_suite?)(host.properties, name.as_ptr(), version) };
    // SAFETY: null, or a suite of the layout that `T` declares, valid while the plugin is loaded.
    unsafe { suite.cast::<T>().as_ref() }
}

/// Stores the host; null stands for none.
pub(in crate::ofx) fn meet(host: *const Host) {
    HOST.store(host.cast_mut(), Ordering::Release);
}

/// Fetches the suites, anew at each call: a host may have changed them.
///
/// # Errors
/// [`HostError::MissingSuite`] if there is no host, or it lacks a mandatory suite.
pub(in crate::ofx) fn load() -> Result<Arc<Suites>, HostError> {
    // SAFETY: `setHost` promises a structure that is valid while the plugin is loaded.
    let host = unsafe { HOST.load(Ordering::Acquire).as_ref() }.ok_or(HostError::MissingSuite("OfxHost"))?;
    let mut suites = Suites {
        property: fetch(host).ok_or(HostError::MissingSuite("OfxPropertySuite"))?,
        effect: fetch(host).ok_or(HostError::MissingSuite("OfxImageEffectSuite"))?,
        parameter: fetch(host).ok_or(HostError::MissingSuite("OfxParameterSuite"))?,
        message: fetch(host),
        lasting_message: None,
        interact: fetch(host),
        draw: fetch(host),
        properties: host.properties,
    };
    // Version 2 came with API 1.2; an older host may end the process when asked for an unknown suite.
    let knows_them = suites.host().ints(names::prop::API_VERSION).is_some_and(|version: [i32; 2]| version >= [1, 2]);
    if knows_them && !suites.are_fragile() {
        suites.lasting_message = fetch(host);
    }
    let suites = Arc::new(suites);
    *SUITES.write().unwrap_or_else(PoisonError::into_inner) = Some(Arc::clone(&suites));
    Ok(suites)
}

/// Returns the suites, fetching them if the host skipped the load action.
pub(in crate::ofx) fn suites() -> Result<Arc<Suites>, HostError> {
    let known = SUITES.read().unwrap_or_else(PoisonError::into_inner).clone();
    known.map_or_else(load, Ok)
}

impl Suites {
    /// Returns the properties of the host.
    pub(in crate::ofx) fn host(&self) -> Props<'_> {
        Props::new(self.property, self.properties)
    }

    /// Returns whether the host ends the process when asked for something unsupported.
    pub(in crate::ofx) fn are_fragile(&self) -> bool {
        FRAGILE.iter().any(|name| self.host_is(name))
    }

    /// Returns whether the host's name contains `part`.
    pub(in crate::ofx) fn host_is(&self, part: &str) -> bool {
        self.host().text(names::prop::NAME).is_some_and(|name| name.contains(part))
    }
}
