//! Models as `.npz`: the arrays by the same names, the header as the array `meta`.

use super::arrays::{Arrays, EXPECTED, Values};
use crate::{
    archive::{
        self, Archive,
        npy::{self, Array, Element},
    },
    error::{Error, Result},
};
use ndarray::{ArrayD, ArrayView1};
use std::path::Path;

/// Array under which the model's JSON stands.
pub const META: &str = "meta";

pub(super) fn write(path: &Path, meta: &str, arrays: &Arrays) -> Result<()> {
    archive::write(path, |archive| {
        archive.add(META, ArrayView1::from(meta.as_bytes()))?;
        for (name, values) in arrays.all() {
            match values {
                Values::U8(array) => archive.add(name, array.view())?,
                Values::F32(array) => archive.add(name, array.view())?,
                Values::F64(array) => archive.add(name, array.view())?,
            }
        }
        Ok(())
    })
}

pub(super) fn read(path: &Path, file: &[u8]) -> Result<(String, Arrays)> {
    let mut archive = Archive::open(path, file, EXPECTED)?;
    let meta = archive.read::<u8>(META)?.data;
    let meta = String::from_utf8(meta)
        .map_err(|_| archive.wrong(META, "not UTF-8 text; expected the model's header as JSON"))?;
    let mut arrays = Arrays::new(path);
    for name in archive.names() {
        if name == META {
            continue;
        }
        let bytes = archive.unpack(&name)?;
        let wrong = |fault| archive.wrong(&name, fault);
        match npy::number_type(&bytes).map_err(wrong)?.as_str() {
            u8::DESCR => arrays.put_u8(
                &name,
                shaped(path, &name, npy::read(&bytes).map_err(wrong)?)?,
            ),
            f32::DESCR => arrays.put_f32(
                &name,
                shaped(path, &name, npy::read(&bytes).map_err(wrong)?)?,
            ),
            f64::DESCR => arrays.put_f64(
                &name,
                shaped(path, &name, npy::read(&bytes).map_err(wrong)?)?,
            ),
            other => {
                let fault = format!(
                    "holds numbers of type `{}`; expected `|u1`, `<f4` or `<f8`",
                    other.escape_debug()
                );
                return Err(wrong(fault));
            }
        }
    }
    Ok((meta, arrays))
}

fn shaped<T>(path: &Path, name: &str, array: Array<T>) -> Result<ArrayD<T>> {
    ArrayD::from_shape_vec(array.shape, array.data).map_err(|e| {
        Error::input(
            path,
            format!("array `{name}`"),
            format!("{e}; expected a shape that fits its numbers"),
        )
    })
}
