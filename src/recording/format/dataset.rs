//! A dataset as a log: its maximum may be set anew, and several can be joined.

use crate::{
    error::Result,
    recording::{
        import_report::ImportReport,
        imported_log::{ImportedLog, OdometrySource},
        log_options::LogOptions,
        npz,
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
pub(super) fn read(path: &Path, bytes: &[u8], _: &LogOptions) -> Result<ImportedLog> {
    let recording = npz::from_bytes(path, bytes)?;
    let columns = recording.columns();
    let odometry = match columns.odometry == columns.pose {
        true => OdometrySource::Poses,
        false => OdometrySource::Stated,
    };
    let mut account = ImportReport::default();
    (0..recording.len()).for_each(|_| account.used("snapshot"));
    Ok(ImportedLog {
        recording,
        account,
        odometry,
    })
}
