//! Between arrays and tensors, and what is done to gradients as tensors.

use crate::{
    detector::net::values,
    error::{Error, Result},
};
use burn::tensor::{Device, Tensor, TensorData};
use ndarray::{Array2, ArrayView2};

/// An array on a device.
pub(super) fn tensor(array: ArrayView2<f32>, device: &Device) -> Tensor<2> {
    let shape = [array.nrows(), array.ncols()];
    Tensor::from_data(
        TensorData::new(array.iter().copied().collect::<Vec<f32>>(), shape),
        device,
    )
}

/// And back.
pub(super) fn array(tensor: Tensor<2>) -> Result<Array2<f32>> {
    let [rows, columns] = tensor.dims();
    Array2::from_shape_vec((rows, columns), values(tensor)?).map_err(|e| Error::work(e.to_string()))
}

/// Gradients shortened to a length of `limit` over all of them, where they are longer; 0: as they are.
pub(super) fn limited(slopes: Vec<Tensor<3>>, limit: f64) -> Result<Vec<Tensor<3>>> {
    if limit == 0.0 {
        return Ok(slopes);
    }
    let mut squares = 0.0;
    for slope in &slopes {
        let slope = values(slope.clone())?;
        squares += slope.iter().map(|&x| f64::from(x).powi(2)).sum::<f64>();
    }
    let length = squares.sqrt();
    if length <= limit {
        return Ok(slopes);
    }
    let shorten = |slope: Tensor<3>| slope.mul_scalar(limit / length);
    Ok(slopes.into_iter().map(shorten).collect())
}
