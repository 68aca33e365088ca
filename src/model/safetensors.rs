//! Models as `.safetensors`: the layout that PyTorch, numpy and every other framework load.

use super::arrays::{Arrays, EXPECTED, Values};
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
    let data: Vec<(&String, Dtype, &[usize], Vec<u8>)> = arrays
        .all()
        .map(|(name, values)| match values {
            Values::U8(a) => (name, Dtype::U8, a.shape(), a.iter().copied().collect()),
            Values::F32(a) => {
                let bytes = a.iter().flat_map(|v| v.to_le_bytes()).collect();
                (name, Dtype::F32, a.shape(), bytes)
            }
            Values::F64(a) => {
                let bytes = a.iter().flat_map(|v| v.to_le_bytes()).collect();
                (name, Dtype::F64, a.shape(), bytes)
            }
        })
        .collect();
    let views = data
        .iter()
        .map(|(name, dtype, shape, bytes)| {
            Ok((name, TensorView::new(*dtype, shape.to_vec(), bytes)?))
        })
        .collect::<std::result::Result<Vec<_>, SafeTensorError>>()
        .map_err(failed)?;
    // One key only: the order of several would be another in every run.
    let metadata = HashMap::from([(METADATA_KEY.to_string(), meta.to_string())]);
    let bytes = ::safetensors::serialize(views, Some(metadata)).map_err(failed)?;
    storage::write_file(path, |out| out.write_all(&bytes))
}

pub(super) fn read(path: &Path, file: &[u8]) -> Result<(String, Arrays)> {
    let not_whole = |e: SafeTensorError| {
        Error::file(
            path,
            format!(
                "not a whole .safetensors file ({}); expected {EXPECTED}",
                reason(&e)
            ),
        )
    };
    let tensors = SafeTensors::deserialize(file).map_err(not_whole)?;
    let (_, header) = SafeTensors::read_metadata(file).map_err(not_whole)?;
    let metadata = header.metadata().as_ref();
    let Some(meta) = metadata.and_then(|m| m.get(METADATA_KEY)) else {
        return Err(Error::input(
            path,
            format!("metadata key `{METADATA_KEY}`"),
            format!("missing; expected {EXPECTED}"),
        ));
    };
    let mut arrays = Arrays::new(path);
    let mut views = tensors.tensors();
    views.sort_by(|a, b| a.0.cmp(&b.0)); // so that every run names the same fault first
    for (name, view) in views {
        let shape = view.shape().to_vec();
        let misshapen = |e| {
            arrays.wrong(
                &name,
                format!("{e}; expected a shape that fits its numbers"),
            )
        };
        match view.dtype() {
            Dtype::U8 => {
                let array = ArrayD::from_shape_vec(shape, view.data().to_vec());
                arrays.put_u8(&name, array.map_err(misshapen)?);
            }
            Dtype::F32 => {
                let numbers = view.data().as_chunks::<4>().0.iter();
                let numbers = numbers.map(|b| f32::from_le_bytes(*b)).collect();
                let array = ArrayD::from_shape_vec(shape, numbers).map_err(misshapen)?;
                arrays.put_f32(&name, array);
            }
            Dtype::F64 => {
                let numbers = view.data().as_chunks::<8>().0.iter();
                let numbers = numbers.map(|b| f64::from_le_bytes(*b)).collect();
                let array = ArrayD::from_shape_vec(shape, numbers).map_err(misshapen)?;
                arrays.put_f64(&name, array);
            }
            other => return Err(arrays.wrong(&name, format!("{other:?}; expected U8, F32 or F64"))),
        }
    }
    Ok((meta.clone(), arrays))
}

/// The fault in one line; what the file itself says is quoted, not printed as it stands.
fn reason(e: &SafeTensorError) -> String {
    e.to_string().escape_debug().to_string()
}
