//! The crate's errors as Python's: the same sentences.

use pyo3::{
    PyErr,
    exceptions::{PyKeyboardInterrupt, PyOSError, PyRuntimeError, PyValueError},
};

/// What is wrong with a call or a file is a `ValueError`, what can't be read or written an `OSError`, a cancelled training a
/// `KeyboardInterrupt`, the rest a `RuntimeError`.
pub fn raised(fault: ballmark::Error) -> PyErr {
    let sentence = fault.to_string();
    if fault.is_usage() || fault.is_input() {
        PyValueError::new_err(sentence)
    } else if fault.is_io() {
        PyOSError::new_err(sentence)
    } else if fault.is_cancelled() {
        PyKeyboardInterrupt::new_err(sentence)
    } else {
        PyRuntimeError::new_err(sentence)
    }
}

/// A value as JSON text, for Python's own `json`.
pub fn in_json(value: &impl serde::Serialize) -> pyo3::PyResult<String> {
    serde_json::to_string(value).map_err(|e| PyRuntimeError::new_err(e.to_string()))
}
