//! Waiting for work that runs without Python's lock: progress goes out, Ctrl-C and exceptions come back.

use pyo3::prelude::*;

/// Calls back into Python now and then.
pub struct Waiting {
    callback: Option<Py<PyAny>>,
    /// What the callback or a signal raised.
    raised: Option<PyErr>,
}

impl Waiting {
    pub fn new(callback: Option<Py<PyAny>>) -> Self {
        Self {
            callback,
            raised: None,
        }
    }

    /// Passes arguments on; false where the work is to end: an exception was raised (Ctrl-C, too), or the callback returned
    /// `False`.
    pub fn goes_on<A>(&mut self, arguments: A) -> bool
    where
        A: for<'py> pyo3::call::PyCallArgs<'py>,
    {
        if self.raised.is_some() {
            return false;
        }
        Python::attach(|py| {
            let answer = py.check_signals().and_then(|()| match &self.callback {
                None => Ok(true),
                Some(callback) => {
                    let answer = callback.bind(py).call1(arguments)?;
                    Ok(answer.is_none() || answer.is_truthy()?)
                }
            });
            answer.unwrap_or_else(|e| {
                self.raised = Some(e);
                false
            })
        })
    }

    /// Was an exception raised?
    pub fn has_raised(&self) -> bool {
        self.raised.is_some()
    }

    /// The exception, if one was raised, in place of what the work says of having been ended.
    pub fn done<T>(self, result: PyResult<T>) -> PyResult<T> {
        match self.raised {
            Some(raised) => Err(raised),
            None => result,
        }
    }
}
