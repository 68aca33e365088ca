//! Where the networks compute: on the CPU, or on a GPU that this build knows how to reach.
//!
//! The CPU is always there; each GPU backend is a Cargo feature of the same name (`cargo install --path . --features
//! wgpu`). Chosen by `--device` or [`DeviceChoice`]; whoever holds networks is given the opened [`Device`].
//!
//! What a GPU gives back is rounded in another order than on the CPU, so a training on one ends near the same weights,
//! not in the same bits. Promises about equal bytes are for the CPU.

use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};
use std::{fmt, str::FromStr};

pub use burn::tensor::Device;

/// The CPU: Burn's `flex` backend, pure Rust.
pub fn cpu() -> Device {
    Device::flex()
}

/// A device by its name.
///
/// ```
/// use ballmark::detector::device::{DeviceChoice, cpu};
///
/// let device = "cpu".parse::<DeviceChoice>()?.open()?;
/// assert_eq!(device, cpu());
///
/// let error = "gpu".parse::<DeviceChoice>().unwrap_err();
/// assert_eq!(error.to_string(), "device `gpu`: expected one of cpu, cuda, wgpu, metal, rocm");
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DeviceChoice {
    /// The processor, in every build.
    #[default]
    Cpu,
    /// The first NVIDIA GPU, through CUDA.
    Cuda,
    /// The fastest GPU that Vulkan, Metal, DirectX or OpenGL offer; where there is none, a software one.
    Wgpu,
    /// An Apple GPU, by shaders in Metal's own language.
    Metal,
    /// The first AMD GPU, through ROCm.
    Rocm,
}

impl DeviceChoice {
    /// Every device there is a name for, built in or not.
    pub const ALL: [Self; 5] = [Self::Cpu, Self::Cuda, Self::Wgpu, Self::Metal, Self::Rocm];

    /// As it is written in calls and configurations, and as its Cargo feature is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cpu => "cpu",
            Self::Cuda => "cuda",
            Self::Wgpu => "wgpu",
            Self::Metal => "metal",
            Self::Rocm => "rocm",
        }
    }

    /// Was this build made with the device's Cargo feature?
    pub fn is_built_in(self) -> bool {
        match self {
            Self::Cpu => true,
            Self::Cuda => cfg!(feature = "cuda"),
            Self::Wgpu => cfg!(feature = "wgpu"),
            Self::Metal => cfg!(feature = "metal"),
            Self::Rocm => cfg!(feature = "rocm"),
        }
    }

    /// Finds the device and makes it ready.
    ///
    /// CUDA and ROCm are asked for how many GPUs they see, and make the first one ready at its first use; Burn has no
    /// word for what goes wrong then (a driver too old, a GPU that another process holds alone), and panics.
    ///
    /// # Errors
    /// A wrong call where this build lacks the device's feature; failed work where the machine has no such GPU.
    pub fn open(self) -> Result<Device> {
        match self {
            Self::Cpu => Ok(cpu()),
            #[cfg(feature = "cuda")]
            Self::Cuda => gpu::first(self, burn::tensor::DeviceType::Cuda),
            #[cfg(feature = "wgpu")]
            Self::Wgpu => gpu::graphics(self, burn::tensor::wgpu::WgpuBackend::Auto),
            #[cfg(feature = "metal")]
            Self::Metal => gpu::graphics(self, burn::tensor::wgpu::WgpuBackend::Metal),
            #[cfg(feature = "rocm")]
            Self::Rocm => gpu::first(self, burn::tensor::DeviceType::Rocm),
            #[allow(unreachable_patterns, reason = "a build may have every feature")]
            absent => Err(absent.not_built_in()),
        }
    }

    fn not_built_in(self) -> Error {
        let built_in = Self::ALL.into_iter().filter(|d| d.is_built_in());
        let built_in = built_in.map(Self::name).collect::<Vec<_>>().join(", ");
        Error::usage(format!(
            "device {self}: this ballmark was built without the feature `{self}`; expected one of {built_in}, or a build \
             by `cargo install --path . --features {self}`"
        ))
    }
}

impl fmt::Display for DeviceChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for DeviceChoice {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let named = Self::ALL.into_iter().find(|d| d.name() == text);
        named.ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            Error::usage(format!("device `{text}`: expected one of {names}"))
        })
    }
}

/// Finding GPUs, so far as Burn answers instead of panicking.
#[cfg(any(feature = "cuda", feature = "rocm", feature = "wgpu"))]
mod gpu {
    use super::{Device, DeviceChoice};
    use crate::error::{Error, Result};

    /// The first of the devices that a vendor's driver counts; no driver counts none.
    #[cfg(any(feature = "cuda", feature = "rocm"))]
    pub fn first(choice: DeviceChoice, kind: burn::tensor::DeviceType) -> Result<Device> {
        let mut found = Device::enumerate(kind).into_iter();
        found
            .next()
            .ok_or_else(|| none(choice, "its driver is missing or counts no GPU"))
    }

    /// The GPU that a graphics API prefers.
    ///
    /// Burn keeps one set-up an API for the whole process and refuses to make it twice, so it is kept here as well.
    #[cfg(feature = "wgpu")]
    pub fn graphics(choice: DeviceChoice, api: burn::tensor::wgpu::WgpuBackend) -> Result<Device> {
        use std::sync::{Mutex, PoisonError};
        static OPENED: Mutex<Vec<(DeviceChoice, Device)>> = Mutex::new(Vec::new());
        let mut opened = OPENED.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, device)) = opened.iter().find(|(opened_as, _)| *opened_as == choice) {
            return Ok(device.clone());
        }
        let device = Device::wgpu_options()
            .graphics_api(api)
            .init()
            .map_err(|e| none(choice, e))?;
        opened.push((choice, device.clone()));
        Ok(device)
    }

    fn none(choice: DeviceChoice, why: impl std::fmt::Display) -> Error {
        let why = why.to_string().replace('\n', " ");
        Error::work(format!(
            "device {choice}: no such GPU can be used here ({why}); expected one, or the device cpu"
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use burn::tensor::{Tensor, TensorData};

    #[test]
    fn names_are_read_as_they_are_written() {
        for device in DeviceChoice::ALL {
            assert_eq!(device.to_string().parse::<DeviceChoice>().unwrap(), device);
            let json = serde_json::to_string(&device).unwrap();
            assert_eq!(json, format!("\"{device}\""));
            assert_eq!(serde_json::from_str::<DeviceChoice>(&json).unwrap(), device);
        }
        assert_eq!(DeviceChoice::default(), DeviceChoice::Cpu);
        assert!("CUDA".parse::<DeviceChoice>().unwrap_err().is_usage());
    }

    /// Of every device, built in or not, there or not: a product as the CPU has it, or one line that says why not.
    #[test]
    fn a_device_computes_or_says_why_not() {
        let numbers = |rows: usize, columns: usize| {
            let values = (0..rows * columns)
                .map(|i| (i as f32 * 0.7).sin())
                .collect();
            TensorData::new::<f32, _>(values, [rows, columns])
        };
        let product = |device: &Device| {
            let left = Tensor::<2>::from_data(numbers(40, 30), device);
            let right = Tensor::<2>::from_data(numbers(30, 20), device);
            let product = left.matmul(right).try_into_data().unwrap();
            product.try_to_vec::<f32>().unwrap()
        };
        let expected = product(&cpu());
        for choice in DeviceChoice::ALL {
            for again in [false, true] {
                let error = match choice.open() {
                    Ok(device) => {
                        assert!(choice.is_built_in());
                        let found = product(&device);
                        let near = |(a, b): (&f32, &f32)| (a - b).abs() < 1e-5;
                        assert!(found.iter().zip(&expected).all(near), "{choice}");
                        continue;
                    }
                    Err(error) => error,
                };
                assert_eq!(error.is_usage(), !choice.is_built_in(), "{again}: {error}");
                let message = error.to_string();
                assert!(
                    message.starts_with(&format!("device {choice}: ")),
                    "{message}"
                );
                assert!(
                    message.contains("cpu") && !message.contains('\n'),
                    "{message}"
                );
            }
        }
    }
}
