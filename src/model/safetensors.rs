//! Models as `.safetensors`: the layout that PyTorch, numpy and every other framework load.

use super::arrays::{Arrays, EXPECTED, Values};
use crate::{
    error::{Error, Result},
    storage,
};
use ::safetensors::{Dtype, SafeTensorError, SafeTensors, tensor::TensorView};
use ndarray::ArrayD;
use sha2::{Digest, Sha256};
use std::{collections::HashMap, path::Path};

/// Key of the metadata under which the model's JSON stands.
pub const METADATA_KEY: &str = "ballmark";

/// Key, first of the JSON, of the SHA-256 of the rest of it and of all arrays. Files of earlier versions, and those that other programs write,
/// have none.
const DIGEST_KEY: &str = "sha256";

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
    let of_arrays = data
        .iter()
        .map(|(name, _, shape, bytes)| (name.as_str(), *shape, &bytes[..]));
    let digest = digest(meta, of_arrays);
    let meta = match meta.strip_prefix('{') {
        Some(rest) => format!("{{\"{DIGEST_KEY}\":\"{digest}\",{rest}"),
        None => meta.to_string(), // no JSON object: nothing to put it in
    };
    // One key only: the order of several would be another in every run.
    let metadata = HashMap::from([(METADATA_KEY.to_string(), meta)]);
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
    let (stated, meta) = without_digest(meta);
    if let Some(stated) = stated {
        let mut views = tensors.tensors();
        views.sort_by(|a, b| a.0.cmp(&b.0)); // as they were written
        let of_arrays = views
            .iter()
            .map(|(name, view)| (name.as_str(), view.shape(), view.data()));
        if digest(&meta, of_arrays) != stated {
            return Err(Error::file(
                path,
                format!(
                    "damaged: its header or its numbers are not those that were written (`{DIGEST_KEY}` in the metadata differs; who \
                     changed them on purpose takes that key out)"
                ),
            ));
        }
    }
    Ok((meta, arrays))
}

/// The digest that stands first in a header, and the header as it was before.
fn without_digest(meta: &str) -> (Option<&str>, String) {
    let start = format!("{{\"{DIGEST_KEY}\":\"");
    let found = meta
        .strip_prefix(&start)
        .and_then(|rest| rest.split_once("\","));
    match found {
        Some((digest, rest)) => (Some(digest), format!("{{{rest}")),
        None => (None, meta.to_string()),
    }
}

fn digest<'a>(
    meta: &str,
    arrays: impl Iterator<Item = (&'a str, &'a [usize], &'a [u8])>,
) -> String {
    let mut all = Sha256::new();
    all.update(meta);
    for (name, shape, bytes) in arrays {
        all.update([0]); // ends what stands before; JSON and names hold none
        all.update(name);
        all.update([0]);
        shape
            .iter()
            .for_each(|&n| all.update((n as u64).to_le_bytes()));
        all.update(bytes);
    }
    storage::hexadecimal(all)
}

/// The fault in one line; what the file itself says is quoted, not printed as it stands.
fn reason(e: &SafeTensorError) -> String {
    e.to_string().escape_debug().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No bit of what was written may change unseen; without the key, as other programs write it, anything that can be read is taken.
    #[test]
    fn every_flipped_bit_is_seen() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.safetensors");
        let mut arrays = Arrays::new(&path);
        let numbers = ArrayD::from_shape_vec(vec![2, 2], vec![0.5, -1.0, 3.0, 2.0]).unwrap();
        arrays.put_f32("filter.0.weight", numbers);
        let meta = r#"{"crate_version":"0.1.0","seed":7}"#;
        write(&path, meta, &arrays).unwrap();
        let whole = std::fs::read(&path).unwrap();
        assert_eq!(read(&path, &whole).unwrap().0, meta);
        let mut windows = whole.windows(DIGEST_KEY.len());
        let key = windows
            .position(|bytes| bytes == DIGEST_KEY.as_bytes())
            .unwrap();
        let in_key = |at: usize| (key..key + DIGEST_KEY.len()).contains(&at);
        for at in (8..whole.len()).filter(|at| !in_key(*at)) {
            for bit in 0..8 {
                let mut damaged = whole.clone();
                damaged[at] ^= 1 << bit;
                // Signs about the key may hide it; then the header is no JSON any more.
                let is_taken = read(&path, &damaged).is_ok_and(|(meta, _)| {
                    serde_json::from_str::<serde_json::Value>(&meta).is_ok()
                });
                assert!(!is_taken, "byte {at}, bit {bit}");
            }
        }
        let mut without = whole.clone();
        without[key] = b'x';
        assert!(read(&path, &without).is_ok());
    }
}
