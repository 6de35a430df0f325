//! The FFI boundary: no panic crosses it.
//!
//! In: closures, and names from C. Out: a status for each, and panic messages.

use crate::ofx::api::Status;
use std::any::Any;
use std::ffi::{CStr, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Runs `work`, turning a panic, which must not unwind into C, into a failure status.
pub(in crate::ofx) fn guarded(work: impl FnOnce() -> Status) -> Status {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or(Status::FAILED)
}

/// Runs `work`, turning a panic into its message.
pub(in crate::ofx) fn caught<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|panic| words(&*panic))
}

/// Returns the message of a panic.
fn words(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("it did not say why").to_owned()
}

/// Returns the name of an action; `None` if null.
///
/// # Safety
/// `name` is null or a NUL-terminated string that is valid for `'a`.
pub(in crate::ofx) unsafe fn action_name<'a>(name: *const c_char) -> Option<&'a CStr> {
    // SAFETY: not null; the rest is the caller's promise.
    (!name.is_null()).then(|| unsafe { CStr::from_ptr(name) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::prelude::*;

    #[test]
    fn a_panic_ends_as_a_status() {
        assert_eq!(guarded(|| panic!("on purpose")), Status::FAILED);
    }

    #[test]
    fn a_panic_is_told_in_its_own_words_from_any_thread() {
        assert_eq!(caught(|| 7), Ok(7));
        assert_eq!(caught(|| panic!("on purpose")), Err::<(), _>("on purpose".to_owned()));
        let stumble = |row: i32| {
            if row == 40 {
                panic!("row {row}")
            }
        };
        assert_eq!(caught(|| (0..64).into_par_iter().for_each(stumble)), Err("row 40".to_owned()));
    }
}
