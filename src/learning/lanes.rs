//! Sixteen numbers side by side, and the widest vectors that the machine has for them.
//!
//! The objective does the same to every outcome f, so outcomes lie side by side in rows of [`LANES`] numbers: one
//! register of sixteen `f32` with AVX-512, two with AVX2, four elsewhere. A [`Kernel`] is written once as plain loops
//! over such rows, and [`Vectors::run`] calls the copy compiled for this machine. No kernel asks for fused multiply-add,
//! so every copy gives the same bits.

use macerator::{AutoArch, Simd, WithSimd};
use std::ops::{Add, AddAssign, Div, Index, IndexMut, Mul, Sub};

/// Numbers in a row.
pub(super) const LANES: usize = 16;

/// A row, in one cache line or two: vectors that straddle lines cost twice as much.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(align(64))]
pub(super) struct Lanes<T>(pub(super) [T; LANES]);

impl<T: Copy> Lanes<T> {
    /// The same number everywhere.
    pub(super) const fn all(value: T) -> Self {
        Self([value; LANES])
    }
}

impl<T> Index<usize> for Lanes<T> {
    type Output = T;
    #[inline(always)]
    fn index(&self, l: usize) -> &T {
        &self.0[l]
    }
}

impl<T> IndexMut<usize> for Lanes<T> {
    #[inline(always)]
    fn index_mut(&mut self, l: usize) -> &mut T {
        &mut self.0[l]
    }
}

/// A precision that the objective takes and gives: `f32` to train with, `f64` as the reference. What sums over places
/// is `f64` in both.
pub trait Real:
    Copy
    + Default
    + PartialOrd
    + Send
    + Sync
    + std::fmt::Debug
    + Add<Output = Self>
    + AddAssign
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + sealed::Sealed
    + 'static
{
    /// 1.
    const ONE: Self;
    /// Rounded to this precision.
    fn of(value: f64) -> Self;
    /// As `f64`, exactly.
    fn wide(self) -> f64;
    /// A row rounded to this precision.
    #[inline(always)]
    #[expect(
        private_interfaces,
        reason = "nobody outside calls it: the trait is sealed"
    )]
    fn row_of(row: &Lanes<f64>) -> Lanes<Self> {
        let mut out = Lanes::all(Self::default());
        for l in 0..LANES {
            out[l] = Self::of(row[l]);
        }
        out
    }
}

impl Real for f32 {
    const ONE: Self = 1.0;
    #[inline(always)]
    fn of(value: f64) -> Self {
        value as f32
    }
    #[inline(always)]
    fn wide(self) -> f64 {
        f64::from(self)
    }
}

impl Real for f64 {
    const ONE: Self = 1.0;
    #[inline(always)]
    fn of(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn wide(self) -> f64 {
        self
    }
}

mod sealed {
    /// Kernels are compiled and tested for these two only.
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// The larger; the second where the first is no number.
#[inline(always)]
pub(super) fn at_least<T: Real>(value: T, least: T) -> T {
    if value > least { value } else { least }
}

/// Σ over a row, by halves: fixed order, and vectors all the way.
#[inline(always)]
pub(super) fn total<T: Real>(row: &Lanes<T>) -> T {
    let mut eight: [T; 8] = Default::default();
    for l in 0..8 {
        eight[l] = row[l] + row[l + 8];
    }
    let mut four: [T; 4] = Default::default();
    for l in 0..4 {
        four[l] = eight[l] + eight[l + 4];
    }
    (four[0] + four[2]) + (four[1] + four[3])
}

/// Work that is compiled once for every kind of vectors.
///
/// `run`, and all it calls in its inner loops, must be `#[inline(always)]`: what isn't inlined runs without vectors. A
/// closure can't be, so kernels are structures.
pub(super) trait Kernel {
    type Output;
    fn run(self) -> Self::Output;
}

/// A kernel as `macerator` takes it.
struct Compiled<K>(K);

impl<K: Kernel> WithSimd for Compiled<K> {
    type Output = K::Output;

    #[inline(always)]
    fn with_simd<S: Simd>(self) -> K::Output {
        self.0.run()
    }
}

/// Which copy of a kernel runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Vectors {
    /// The one for the best instructions found on this machine: AVX-512, AVX2, SSE 4.2, NEON or none of them.
    Best,
    /// The one that runs everywhere.
    #[cfg_attr(
        not(test),
        expect(dead_code, reason = "what the best is tested against")
    )]
    Portable,
}

impl Vectors {
    /// Runs a kernel.
    pub(super) fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self {
            Vectors::Best => AutoArch::new().dispatch(Compiled(kernel)),
            Vectors::Portable => kernel.run(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_total_is_the_sum_of_all_sixteen() {
        let row = Lanes(std::array::from_fn(|l| f64::from(1u32 << l)));
        assert_eq!(total(&row), 65535.0);
    }
}
