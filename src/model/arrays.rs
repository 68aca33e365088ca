//! Named arrays of a few number types: what both containers carry.

use crate::error::{Error, Result};
use ndarray::{Array, ArrayD, Dimension};
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

/// What messages say was expected where a file is no model.
pub(super) const EXPECTED: &str = "a model such as `ballmark train` writes";

/// Arrays in the order of their names, whatever the container's own; errors name the file they are of.
#[derive(Debug, Default)]
pub(super) struct Arrays {
    path: PathBuf,
    by_name: BTreeMap<String, Values>,
}

#[derive(Debug, Clone)]
pub(super) enum Values {
    U8(ArrayD<u8>),
    F32(ArrayD<f32>),
    F64(ArrayD<f64>),
}

impl Values {
    fn number_type(&self) -> &'static str {
        match self {
            Values::U8(_) => "u8",
            Values::F32(_) => "f32",
            Values::F64(_) => "f64",
        }
    }
}

impl Arrays {
    /// None yet, of the file `path`.
    pub(super) fn new(path: &Path) -> Self {
        Self {
            path: path.to_path_buf(),
            by_name: BTreeMap::new(),
        }
    }

    pub(super) fn put_u8(&mut self, name: &str, values: ArrayD<u8>) {
        self.by_name.insert(name.to_string(), Values::U8(values));
    }

    pub(super) fn put_f32(&mut self, name: &str, values: ArrayD<f32>) {
        self.by_name.insert(name.to_string(), Values::F32(values));
    }

    pub(super) fn put_f64(&mut self, name: &str, values: ArrayD<f64>) {
        self.by_name.insert(name.to_string(), Values::F64(values));
    }

    pub(super) fn put(&mut self, name: &str, values: Values) {
        self.by_name.insert(name.to_string(), values);
    }

    pub(super) fn into_all(self) -> impl Iterator<Item = (String, Values)> {
        self.by_name.into_iter()
    }

    pub(super) fn all(&self) -> impl Iterator<Item = (&String, &Values)> {
        self.by_name.iter()
    }

    pub(super) fn has(&self, name: &str) -> bool {
        self.by_name.contains_key(name)
    }

    /// An error that names the file and the array.
    pub(super) fn wrong(&self, name: &str, fault: impl std::fmt::Display) -> Error {
        Error::input(
            &self.path,
            format!("array `{}`", name.escape_debug()),
            fault,
        )
    }

    /// The array of that name: u8, of so many axes as `D` has.
    pub(super) fn u8<D: Dimension>(&self, name: &str) -> Result<Array<u8, D>> {
        match self.get(name)? {
            Values::U8(values) => self.checked(name, values, |_| true),
            other => Err(self.wrong(name, format!("{}; expected u8", other.number_type()))),
        }
    }

    /// The array of that name: f32, of so many axes as `D` has, all its numbers finite.
    pub(super) fn f32<D: Dimension>(&self, name: &str) -> Result<Array<f32, D>> {
        match self.get(name)? {
            Values::F32(values) => self.checked(name, values, |v| v.is_finite()),
            other => Err(self.wrong(name, format!("{}; expected f32", other.number_type()))),
        }
    }

    /// The same in f64.
    pub(super) fn f64<D: Dimension>(&self, name: &str) -> Result<Array<f64, D>> {
        match self.get(name)? {
            Values::F64(values) => self.checked(name, values, |v| v.is_finite()),
            other => Err(self.wrong(name, format!("{}; expected f64", other.number_type()))),
        }
    }

    fn get(&self, name: &str) -> Result<&Values> {
        self.by_name
            .get(name)
            .ok_or_else(|| self.wrong(name, "missing; expected it in every model of this header"))
    }

    fn checked<T: Copy, D: Dimension>(
        &self,
        name: &str,
        values: &ArrayD<T>,
        is_finite: fn(T) -> bool,
    ) -> Result<Array<T, D>> {
        if let Some(at) = values.iter().position(|v| !is_finite(*v)) {
            let fault = format!("entry {at} (in row order) is not finite; expected a number");
            return Err(self.wrong(name, fault));
        }
        values.clone().into_dimensionality().map_err(|_| {
            let axes = D::NDIM.map_or(String::new(), |n| n.to_string());
            self.wrong(
                name,
                format!("shape {:?}; expected {axes} axes", values.shape()),
            )
        })
    }
}
