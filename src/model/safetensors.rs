//! Models as `.safetensors`: the layout that PyTorch, numpy and every other framework load.

use super::arrays::{Arrays, Values};
use crate::{
    error::{Error, Result},
    storage,
};
use ::safetensors::{Dtype, SafeTensorError, SafeTensors, tensor::TensorView};
use ndarray::ArrayD;
use std::{collections::HashMap, path::Path};

/// Key of the metadata under which the model's JSON stands.
pub const METADATA_KEY: &str = "ballmark";

pub(super) fn write(path: &Path, meta: &str, arrays: &Arrays) -> Result<()> {
    let failed = |e: SafeTensorError| Error::work(format!("{}: {e}", path.display()));
    let data: Vec<(Dtype, Vec<usize>, Vec<u8>)> = arrays
        .list
        .iter()
        .map(|(_, values)| match values {
            Values::F32(a) => (
                Dtype::F32,
                a.shape().to_vec(),
                a.iter().flat_map(|v| v.to_le_bytes()).collect(),
            ),
            Values::F64(a) => (
                Dtype::F64,
                a.shape().to_vec(),
                a.iter().flat_map(|v| v.to_le_bytes()).collect(),
            ),
        })
        .collect();
    let views = arrays
        .names()
        .zip(&data)
        .map(|(name, (dtype, shape, bytes))| {
            Ok((
                name.as_str(),
                TensorView::new(*dtype, shape.clone(), bytes)?,
            ))
        })
        .collect::<std::result::Result<Vec<_>, SafeTensorError>>()
        .map_err(failed)?;
    let metadata = HashMap::from([(METADATA_KEY.to_string(), meta.to_string())]);
    let bytes = ::safetensors::serialize(views, Some(metadata)).map_err(failed)?;
    storage::write_file(path, |out| out.write_all(&bytes))
}

pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<(String, Arrays)> {
    let not_ours = |e: SafeTensorError| {
        Error::file(
            path,
            format!(
                "not a whole .safetensors file ({e:?}); expected a model that `ballmark train` wrote"
            ),
        )
    };
    let file = SafeTensors::deserialize(bytes).map_err(not_ours)?;
    let (_, header) = SafeTensors::read_metadata(bytes).map_err(not_ours)?;
    let meta = header
        .metadata()
        .as_ref()
        .and_then(|m| m.get(METADATA_KEY))
        .ok_or_else(|| {
            Error::file(
                path,
                format!(
                    "no metadata key `{METADATA_KEY}`; expected a model that `ballmark train` wrote"
                ),
            )
        })?;
    let mut arrays = Arrays::default();
    for (name, view) in file.tensors() {
        let shape = view.shape().to_vec();
        let wrong = |_| Error::input(path, format!("`{name}`"), "its size does not fit its shape");
        match view.dtype() {
            Dtype::F32 => {
                let numbers = view
                    .data()
                    .as_chunks::<4>()
                    .0
                    .iter()
                    .map(|b| f32::from_le_bytes(*b))
                    .collect();
                arrays.put_f32(
                    name.clone(),
                    ArrayD::from_shape_vec(shape, numbers).map_err(wrong)?,
                );
            }
            Dtype::F64 => {
                let numbers = view
                    .data()
                    .as_chunks::<8>()
                    .0
                    .iter()
                    .map(|b| f64::from_le_bytes(*b))
                    .collect();
                arrays.put_f64(
                    name.clone(),
                    ArrayD::from_shape_vec(shape, numbers).map_err(wrong)?,
                );
            }
            other => {
                return Err(Error::input(
                    path,
                    format!("`{name}`"),
                    format!("{other:?}; expected F32 or F64"),
                ));
            }
        }
    }
    Ok((meta.clone(), arrays))
}
