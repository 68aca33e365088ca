//! Sixteen numbers side by side.
//!
//! The objective does the same to every outcome f, so outcomes lie side by side in rows of [`LANES`] numbers: one
//! register of sixteen `f32` with AVX-512, two with AVX2, four elsewhere. [Kernels](crate::simd::Kernel) are plain loops
//! over such rows.

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
    fn from_f64(value: f64) -> Self;
    /// As `f64`, exactly.
    fn to_f64(self) -> f64;
    /// A row rounded to this precision.
    #[inline(always)]
    #[expect(
        private_interfaces,
        reason = "nobody outside calls it: the trait is sealed"
    )]
    fn rounded(row: &Lanes<f64>) -> Lanes<Self> {
        let mut out = Lanes::all(Self::default());
        for l in 0..LANES {
            out[l] = Self::from_f64(row[l]);
        }
        out
    }
}

impl Real for f32 {
    const ONE: Self = 1.0;
    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        value as f32
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
}

impl Real for f64 {
    const ONE: Self = 1.0;
    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_total_is_the_sum_of_all_sixteen() {
        let row = Lanes(std::array::from_fn(|l| f64::from(1u32 << l)));
        assert_eq!(total(&row), 65535.0);
    }
}
