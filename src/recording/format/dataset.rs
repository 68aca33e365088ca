//! A dataset as a log: its maximum may be set anew, and several can be joined.

use crate::{
    error::{Error, Result},
    recording::{
        import_report::ImportReport,
        imported_log::{ImportedLog, OdometrySource},
        log_options::LogOptions,
        npz, ranges,
    },
};
use std::path::Path;

/// Are these the first bytes of a zip archive?
pub(super) fn detect(bytes: &[u8]) -> bool {
    bytes.starts_with(b"PK")
}

/// Reads a dataset. `path` is for messages only.
///
/// # Errors
/// As [`npz::from_bytes`].
pub(super) fn read(path: &Path, bytes: &[u8], options: &LogOptions) -> Result<ImportedLog> {
    let mut columns = npz::from_bytes(path, bytes)?.into_columns();
    if let Some(maximum_m) = options.max_range_m {
        ranges::limit_channels_in_metres(&mut columns, maximum_m);
    }
    let mut account = ImportReport::default();
    (0..columns.pose.len()).for_each(|_| account.used("snapshot"));
    let recording = crate::recording::Recording::new(columns);
    Ok(ImportedLog {
        recording: recording.map_err(|e: Error| e.in_file(path))?,
        account,
        odometry: OdometrySource::Stated,
    })
}
