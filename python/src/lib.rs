//! The Python module `ballmark._ballmark`: what `python/ballmark` is made of. One file a concept; docstrings are in Python's own
//! files, where type checkers and `help()` find them beside the signatures.

mod configuration;
mod dataset;
mod faults;
mod judging;
mod model;
mod waiting;

use pyo3::prelude::*;

// As the command has it: training makes and drops arrays of some hundred kilobytes.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Runs the command with these arguments, its name first; returns its exit status.
#[pyfunction]
fn command(py: Python<'_>, arguments: Vec<std::ffi::OsString>) -> u8 {
    py.detach(|| ballmark::cli::run_with(arguments))
}

#[pymodule]
mod _ballmark {
    #[pymodule_export]
    use super::command;
    #[pymodule_export]
    use super::dataset::{Dataset, import_log};
    #[pymodule_export]
    use super::judging::{compare, localise, score, uncertainty_coefficient};
    #[pymodule_export]
    use super::model::{Model, train};
}
