//! What every method asks of its context, worked out once: on a long log, where the unseen part meets the mapped places takes seconds.

use crate::error::Result;
use std::{ops::Range, sync::OnceLock};

/// Of one context, whose places and labels stay.
#[derive(Debug, Clone, Default)]
pub(super) struct Once {
    /// Unseen snapshots at places that training saw.
    pub covered: OnceLock<Vec<usize>>,
    /// Snapshots of the validation part that constants of single snapshots are settled by.
    pub validated: OnceLock<Vec<usize>>,
    /// Stretches of the unseen part that lead through such places.
    pub unseen_stretches: OnceLock<Vec<Range<usize>>>,
    /// The same of the validation part.
    pub validation_stretches: OnceLock<Vec<Range<usize>>>,
}

/// What is kept; made first, where it is not.
///
/// # Errors
/// Where it can't be made; it is tried again when it is asked for again.
pub(super) fn kept<T>(
    once: &OnceLock<Vec<T>>,
    make: impl FnOnce() -> Result<Vec<T>>,
) -> Result<&[T]> {
    if once.get().is_none() {
        let _ = once.set(make()?); // whoever was first, made the same
    }
    Ok(once.get().map_or(&[], Vec::as_slice))
}
