//! `--rerun FILE.rrd`: kept trials as a recording for the viewer Rerun, in builds with that feature.

use crate::{
    error::{Error, Result},
    experiment::localisation::Record,
    model::Model,
    recording::Recording,
    storage,
};
use std::path::Path;

/// Can the recording be written, as far as can be known before the trials?
///
/// # Errors
/// Where this build can't make one, the viewer wouldn't know it by its name, or no file of that name can be made.
pub(super) fn check(file: &Path) -> Result<()> {
    if !cfg!(feature = "rerun") {
        return Err(Error::usage(
            "--rerun: this build writes no recordings for Rerun; expected one that does: cargo install --path . --features rerun",
        ));
    }
    if file.extension().is_none_or(|extension| extension != "rrd") {
        return Err(Error::usage(format!(
            "--rerun {}: expected a name that ends with .rrd, by which the viewer knows its files",
            file.display()
        )));
    }
    storage::check_target(file).map(drop)
}

/// Writes what was kept of a record's trials, with what the robot sensed in `run` and this model made of it.
///
/// # Errors
/// Where the model does not know the sensors, or the file can't be written.
#[cfg(feature = "rerun")]
pub(super) fn write(
    file: &Path,
    title: &str,
    record: &Record,
    run: &Recording,
    model: &Model,
) -> Result<()> {
    let beliefs = record.beliefs.as_ref();
    let sensed = beliefs.map(|beliefs| beliefs.sensed(run, Some(&model.detector())));
    let sensed = sensed.transpose()?.unwrap_or_default();
    let bytes = crate::report::rerun::recording(title, record, &sensed)?;
    storage::write_file(file, |out| out.write_all(&bytes))
}

/// Never asked: [`check`] has refused.
#[cfg(not(feature = "rerun"))]
pub(super) fn write(file: &Path, _: &str, _: &Record, _: &Recording, _: &Model) -> Result<()> {
    check(file)
}
