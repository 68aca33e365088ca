//! Between arrays and tensors, and what is done to gradients as tensors.

use crate::{
    detector::{device::cpu, net::values},
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
    if slopes.iter().any(|slope| slope.device() != cpu()) {
        return Ok(limited_on_device(slopes, limit));
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

/// The same without waiting for what a GPU has found.
fn limited_on_device(slopes: Vec<Tensor<3>>, limit: f64) -> Vec<Tensor<3>> {
    let squares = slopes.iter().map(|slope| slope.clone().square().sum());
    let Some(length) = squares.reduce(|a, b| a + b).map(Tensor::sqrt) else {
        return slopes;
    };
    let share = (length.recip() * limit as f32)
        .clamp_max(1.0)
        .reshape([1, 1, 1]);
    let shorten = |slope: Tensor<3>| slope * share.clone();
    slopes.into_iter().map(shorten).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gradients_are_shortened_alike_wherever_they_are() {
        let slopes = || {
            let tensor = |numbers: [f32; 4]| Tensor::<1>::from_floats(numbers, &cpu());
            vec![
                tensor([3.0, 0.0, -1.0, 2.0]).reshape([1, 2, 2]),
                tensor([1.0, 4.0, 0.5, -2.0]).reshape([2, 1, 2]),
            ]
        };
        for (limit, shortened) in [(1.0, true), (100.0, false)] {
            let on_device = limited_on_device(slopes(), limit);
            let on_cpu = limited(slopes(), limit).unwrap();
            let mut square = 0.0;
            for (a, b) in on_cpu.into_iter().zip(on_device) {
                let (a, b) = (values(a).unwrap(), values(b).unwrap());
                assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-6));
                square += b.iter().map(|b| b * b).sum::<f32>();
            }
            assert_eq!((square - 1.0).abs() < 1e-5, shortened);
        }
    }
}
