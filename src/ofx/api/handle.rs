//! Handles: opaque pointers owned by the host, with a distinct type for each kind of object.
//!
//! In: pointers from the host. Out: the same pointers, passed back to the host; the plugin never dereferences them.

use std::ffi::c_void;

/// Declares opaque handle types, so that handles of different kinds cannot be mixed up.
macro_rules! handles {
    ($($(#[$doc:meta])* $name:ident;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(transparent)]
        pub(crate) struct $name(pub *mut c_void);

        impl $name {
            /// The null handle.
            pub(crate) const NULL: Self = Self(std::ptr::null_mut());

            /// Returns whether the handle is null.
            #[must_use]
            pub(crate) fn is_null(self) -> bool {
                self.0.is_null()
            }
        }
    )*};
}

handles! {
    /// A property set: of the host, an effect, a clip, an image, a parameter, or the arguments of an action.
    PropertySet;
    /// An effect: a descriptor in the describe actions, an instance in all others.
    EffectHandle;
    /// A clip of an instance.
    ClipHandle;
    /// The parameter set of an effect.
    ParamSetHandle;
    /// One parameter of an instance.
    ParamHandle;
    /// Memory allocated from the host's image pool.
    MemoryHandle;
    /// An overlay interact: a descriptor in the describe action, an instance in all others.
    InteractHandle;
    /// The drawing context of the Draw suite, valid during the draw action.
    DrawContextHandle;
}
