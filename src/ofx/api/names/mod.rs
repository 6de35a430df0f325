//! The strings of the API: suites, actions, properties and property values.
//!
//! In: nothing. Out: C strings, exactly as hosts spell them, irregularities included.

/// Declares documented C string constants.
macro_rules! names {
    ($($(#[$doc:meta])* $name:ident = $text:literal;)*) => {$(
        $(#[$doc])*
        pub(crate) const $name: &std::ffi::CStr = $text;
    )*};
}

pub(crate) mod action;
pub(crate) mod draw;
pub(crate) mod image;
pub(crate) mod interact;
pub(crate) mod param;
pub(crate) mod prop;

names! {
    /// The image effect API, as in `Plugin::api`.
    IMAGE_EFFECT_API = c"OfxImageEffectPluginAPI";
    /// The Property suite.
    PROPERTY_SUITE = c"OfxPropertySuite";
    /// The Image Effect suite: effects, clips and images.
    IMAGE_EFFECT_SUITE = c"OfxImageEffectSuite";
    /// The Parameter suite.
    PARAMETER_SUITE = c"OfxParameterSuite";
    /// The Message suite.
    MESSAGE_SUITE = c"OfxMessageSuite";
    /// The Memory suite.
    MEMORY_SUITE = c"OfxMemorySuite";
    /// The Multi Thread suite.
    MULTI_THREAD_SUITE = c"OfxMultiThreadSuite";
    /// The Interact suite: overlays.
    INTERACT_SUITE = c"OfxInteractSuite";
    /// The Draw suite.
    DRAW_SUITE = c"OfxDrawSuite";
    /// Message type: an error that the user can fix.
    MESSAGE_ERROR = c"OfxMessageError";
    /// Message type: a warning.
    MESSAGE_WARNING = c"OfxMessageWarning";
    /// Message type: information.
    MESSAGE_MESSAGE = c"OfxMessageMessage";
    /// Message type: written to the log only.
    MESSAGE_LOG = c"OfxMessageLog";
}
