//! Bounds of a table's constants, and one wording for all that lie outside of them.

use crate::error::{Error, Result};
use std::fmt::Display;

/// Checks the constants of the table that it is named after.
pub(super) struct Bounds(pub(super) &'static str);

impl Bounds {
    /// The error about one constant.
    pub(super) fn wrong(&self, key: &str, value: impl Display, expected: &str) -> Result<()> {
        let table = self.0;
        Err(Error::usage(format!(
            "{table}: `{key}` is {value}; expected {expected}"
        )))
    }

    /// Every constant is finite and more than 0.
    pub(super) fn positive(&self, constants: &[(&str, f64)]) -> Result<()> {
        let fits = |value: f64| value > 0.0 && value.is_finite();
        self.all(constants, fits, "more than 0")
    }

    /// Every constant is finite and 0 or more.
    pub(super) fn not_negative(&self, constants: &[(&str, f64)]) -> Result<()> {
        let fits = |value: f64| value >= 0.0 && value.is_finite();
        self.all(constants, fits, "0 or more")
    }

    /// Every constant is a share or a probability.
    pub(super) fn shares(&self, constants: &[(&str, f64)]) -> Result<()> {
        let fits = |value: f64| (0.0..=1.0).contains(&value);
        self.all(constants, fits, "0 to 1")
    }

    fn all(
        &self,
        constants: &[(&str, f64)],
        fits: impl Fn(f64) -> bool,
        expected: &str,
    ) -> Result<()> {
        match constants.iter().find(|(_, value)| !fits(*value)) {
            Some((key, value)) => self.wrong(key, value, expected),
            None => Ok(()),
        }
    }
}
