//! Refusals of a scene.

use crate::error::InputError;

/// Keys that do not fit each other.
pub(super) fn inconsistent(field: String, reason: &str) -> InputError {
    InputError::Inconsistent { field, reason: reason.to_owned() }
}
