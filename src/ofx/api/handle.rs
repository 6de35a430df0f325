//! Handles: opaque pointers that the host owns, one type for each kind of thing behind them.
//!
//! In: pointers from the host. Out: pointers to the host; only the host may look behind them.

use std::ffi::c_void;

/// Declares opaque handles, each a pointer that cannot be mistaken for another kind.
macro_rules! handles {
    ($($(#[$doc:meta])* $name:ident;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(transparent)]
        pub struct $name(pub *mut c_void);

        impl $name {
            /// The handle of nothing.
            pub const NULL: Self = Self(std::ptr::null_mut());

            /// Whether there is nothing behind the handle.
            #[must_use]
            pub fn is_null(self) -> bool {
                self.0.is_null()
            }
        }
    )*};
}

handles! {
    /// A set of named properties: of the host, an effect, a clip, an image, a parameter, or the arguments of an action.
    PropertySet;
    /// An effect: its descriptor in the describing actions, an instance in all others.
    EffectHandle;
    /// A clip of an instance.
    ClipHandle;
    /// The parameters of an effect.
    ParamSetHandle;
    /// One parameter of an instance.
    ParamHandle;
    /// Memory from the host's image pool.
    MemoryHandle;
    /// An on-screen overlay: its descriptor when described, an instance in all other actions.
    InteractHandle;
    /// Where the Draw suite draws, valid while the draw action runs.
    DrawContextHandle;
}
