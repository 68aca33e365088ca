//! Named arrays of two number types: what both containers carry.

use crate::error::{Error, Result};
use ndarray::{Array1, Array2, ArrayD, Ix1, Ix2};
use std::path::Path;

/// Arrays in the order they are written.
#[derive(Debug, Default)]
pub(super) struct Arrays {
    pub(super) list: Vec<(String, Values)>,
}

#[derive(Debug)]
pub(super) enum Values {
    F32(ArrayD<f32>),
    F64(ArrayD<f64>),
}

impl Arrays {
    pub(super) fn put_f32(&mut self, name: String, values: ArrayD<f32>) {
        self.list.push((name, Values::F32(values)));
    }

    pub(super) fn put_f64(&mut self, name: String, values: ArrayD<f64>) {
        self.list.push((name, Values::F64(values)));
    }

    pub(super) fn names(&self) -> impl Iterator<Item = &String> {
        self.list.iter().map(|(name, _)| name)
    }

    fn get(&self, path: &Path, name: &str) -> Result<&Values> {
        let found = self.list.iter().find(|(known, _)| known == name);
        found.map(|(_, values)| values).ok_or_else(|| {
            Error::input(
                path,
                format!("`{name}`"),
                "missing; expected this array in a model",
            )
        })
    }

    fn f32(&self, path: &Path, name: &str) -> Result<&ArrayD<f32>> {
        match self.get(path, name)? {
            Values::F32(values) if values.iter().all(|v| v.is_finite()) => Ok(values),
            Values::F32(_) => Err(Error::input(
                path,
                format!("`{name}`"),
                "holds a number that is not finite",
            )),
            Values::F64(_) => Err(Error::input(path, format!("`{name}`"), "f64; expected f32")),
        }
    }

    fn f64(&self, path: &Path, name: &str) -> Result<&ArrayD<f64>> {
        match self.get(path, name)? {
            Values::F64(values) if values.iter().all(|v| v.is_finite()) => Ok(values),
            Values::F64(_) => Err(Error::input(
                path,
                format!("`{name}`"),
                "holds a number that is not finite",
            )),
            Values::F32(_) => Err(Error::input(path, format!("`{name}`"), "f32; expected f64")),
        }
    }

    pub(super) fn f32_1(&self, path: &Path, name: &str) -> Result<Array1<f32>> {
        self.f32(path, name)?
            .clone()
            .into_dimensionality::<Ix1>()
            .map_err(|_| shape(path, name, 1))
    }

    pub(super) fn f32_2(&self, path: &Path, name: &str) -> Result<Array2<f32>> {
        self.f32(path, name)?
            .clone()
            .into_dimensionality::<Ix2>()
            .map_err(|_| shape(path, name, 2))
    }

    pub(super) fn f64_1(&self, path: &Path, name: &str) -> Result<Array1<f64>> {
        self.f64(path, name)?
            .clone()
            .into_dimensionality::<Ix1>()
            .map_err(|_| shape(path, name, 1))
    }

    pub(super) fn f64_2(&self, path: &Path, name: &str) -> Result<Array2<f64>> {
        self.f64(path, name)?
            .clone()
            .into_dimensionality::<Ix2>()
            .map_err(|_| shape(path, name, 2))
    }
}

fn shape(path: &Path, name: &str, axes: usize) -> Error {
    Error::input(
        path,
        format!("`{name}`"),
        format!("expected an array of {axes} axes"),
    )
}
