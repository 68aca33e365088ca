//! How much of the expected localisation error sensing removes (Thrun 1998, eq. 46).

use serde::{Deserialize, Serialize};

/// Expected errors before and after sensing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    /// E_prior, before sensing, in metres.
    pub prior_error_m: f64,
    /// E_posterior, after sensing, in metres.
    pub posterior_error_m: f64,
}

/// Expected errors of a part of a recording before and after sensing, and what they were averaged over.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ErrorReduction {
    /// E_prior, before sensing, in metres.
    pub prior_error_m: f64,
    /// E_posterior, after sensing, in metres.
    pub posterior_error_m: f64,
    /// 1 − posterior/prior (Thrun 1998, eq. 46).
    pub error_reduction: f64,
    /// Snapshots that the errors are the mean of.
    pub snapshots: usize,
}
