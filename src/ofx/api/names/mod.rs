//! The strings of the API: suites, actions, properties and the values that properties take.
//!
//! In: nothing. Out: C strings, exactly as hosts spell them, oddities included.

/// Declares C strings with a line on what each is for.
macro_rules! names {
    ($($(#[$doc:meta])* $name:ident = $text:literal;)*) => {$(
        $(#[$doc])*
        pub const $name: &std::ffi::CStr = $text;
    )*};
}

pub mod action;
pub mod draw;
pub mod image;
pub mod interact;
pub mod param;
pub mod prop;

names! {
    /// The API of image effects, in `Plugin::api`.
    IMAGE_EFFECT_API = c"OfxImageEffectPluginAPI";
    /// Suite of properties.
    PROPERTY_SUITE = c"OfxPropertySuite";
    /// Suite of effects, clips and images.
    IMAGE_EFFECT_SUITE = c"OfxImageEffectSuite";
    /// Suite of parameters.
    PARAMETER_SUITE = c"OfxParameterSuite";
    /// Suite of messages.
    MESSAGE_SUITE = c"OfxMessageSuite";
    /// Suite of memory.
    MEMORY_SUITE = c"OfxMemorySuite";
    /// Suite of threads.
    MULTI_THREAD_SUITE = c"OfxMultiThreadSuite";
    /// Suite of overlays.
    INTERACT_SUITE = c"OfxInteractSuite";
    /// Suite of drawing.
    DRAW_SUITE = c"OfxDrawSuite";
    /// Kind of message: an error that the user can mend.
    MESSAGE_ERROR = c"OfxMessageError";
    /// Kind of message: it works, though not as well as it might.
    MESSAGE_WARNING = c"OfxMessageWarning";
    /// Kind of message: plain news.
    MESSAGE_MESSAGE = c"OfxMessageMessage";
    /// Kind of message: for the log only.
    MESSAGE_LOG = c"OfxMessageLog";
}
