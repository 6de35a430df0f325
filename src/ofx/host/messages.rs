//! Messages to the user: each is shown once and cleared when it no longer applies.
//!
//! In: errors, warnings about a frame, information. Out: persistent messages if the host has message suite 2, else
//! transient ones. Warnings differ from frame to frame: one that was shown is shown again only after an edit.

use super::effect::Effect;
use super::kept::Kept;
use super::props::c_text;
use crate::ofx::api::names::{MESSAGE_ERROR, MESSAGE_MESSAGE, MESSAGE_WARNING};
use crate::ofx::api::{EffectHandle, Message};
use std::ffi::CStr;

/// Maximum number of distinct warnings remembered per effect.
const MAX_WARNINGS: usize = 64;

/// The messages of each effect, by its handle.
static GIVEN: Kept<Given> = Kept::new();

/// Messages that an effect has shown.
#[derive(Clone, Default)]
struct Given {
    /// The persistent message at the effect.
    shown: Option<Shown>,
    /// Subjects of the warnings shown since the last edit.
    warned_of: Vec<String>,
}

/// A persistent message.
#[derive(Clone, PartialEq)]
enum Shown {
    Error(String),
    /// A warning about the frame at this time.
    Warning(f64),
}

/// A warning about one frame.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::ofx) struct FrameWarning {
    /// The frame's time.
    pub(in crate::ofx) time: f64,
    /// Its subject; warnings with the same subject are shown once.
    pub(in crate::ofx) subject: String,
    /// The text shown to the user.
    pub(in crate::ofx) text: String,
}

/// Forgets all messages of a handle, when it is created or destroyed.
pub(super) fn forget(handle: EffectHandle) {
    GIVEN.remove(handle.0 as usize);
}

impl Effect<'_> {
    /// Returns the key under which this effect's messages are stored. MLT creates a new instance for every frame; these
    /// share one key.
    fn messages_key(self) -> usize {
        if self.suites.host_is("MLT") { 0 } else { self.key() }
    }

    /// Shows an error, once as long as it stays the same.
    pub(in crate::ofx) fn show_error(self, text: &str) {
        let error = Shown::Error(text.to_owned());
        let is_new = GIVEN.update(self.messages_key(), |given| given.shown.replace(error.clone()) != Some(error));
        if is_new {
            self.post(self.lasting(), MESSAGE_ERROR, text);
        }
    }

    /// Shows a warning, unless one with its subject was shown since the last edit.
    pub(in crate::ofx) fn warn(self, warning: &FrameWarning) {
        let is_new = GIVEN.update(self.messages_key(), |given| {
            if given.warned_of.contains(&warning.subject) {
                return false;
            }
            if given.warned_of.len() == MAX_WARNINGS {
                given.warned_of.remove(0);
            }
            given.warned_of.push(warning.subject.clone());
            given.shown = Some(Shown::Warning(warning.time));
            true
        });
        if is_new {
            self.post(self.lasting(), MESSAGE_WARNING, &warning.text);
        }
    }

    /// Records a successful frame: clears errors, and the warning about this frame if it no longer applies.
    pub(in crate::ofx) fn frame_succeeded(self, time: f64, has_warning: bool) {
        let is_over = GIVEN.update(self.messages_key(), |given| {
            let is_over = match given.shown {
                Some(Shown::Error(_)) => true,
                Some(Shown::Warning(of)) => of == time && !has_warning,
                None => false,
            };
            given.shown.take_if(|_| is_over).is_some()
        });
        if is_over {
            self.clear_persistent();
        }
    }

    /// Clears all messages after an edit, so that they may be shown again.
    pub(in crate::ofx) fn clear_messages(self) {
        if GIVEN.remove(self.messages_key()).is_some_and(|given| given.shown.is_some()) {
            self.clear_persistent();
        }
    }

    /// Shows information once, as a transient message.
    pub(in crate::ofx) fn inform(self, text: &str) {
        self.post(self.transient(), MESSAGE_MESSAGE, text);
    }

    fn transient(self) -> Message {
        self.suites.message.and_then(|suite| suite.message)
    }

    /// Returns the persistent message function if there is one, else the transient one.
    fn lasting(self) -> Message {
        let lasting = self.suites.lasting_message.and_then(|suite| suite.set_persistent_message);
        lasting.or(self.transient())
    }

    fn post(self, message: Message, kind: &CStr, text: &str) {
        let Some(message) = message else { return };
        // The text itself is the format: Natron 2.5 shows ("%s", text) as an empty message.
        let format = c_text(&text.replace('%', "%%"));
        // SAFETY: the host's `printf`-style function; the format takes no arguments and outlives the call.
        let _cannot_be_shown = unsafe { message(self.handle.0, kind.as_ptr(), c"".as_ptr(), format.as_ptr()) };
    }

    fn clear_persistent(self) {
        if let Some(clear) = self.suites.lasting_message.and_then(|suite| suite.clear_persistent_message) {
            // SAFETY: the host's function with its own handle.
            let _stays_shown = unsafe { clear(self.handle.0) };
        }
    }
}
