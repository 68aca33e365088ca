//! Loops compiled once for every kind of vectors, and run with the widest that the machine has.

use macerator::{AutoArch, Simd, WithSimd};

/// Work in whole numbers, the same result whatever runs it.
///
/// `run`, and all it calls in its inner loops, must be `#[inline(always)]`: what is not inlined runs without vectors.
/// A closure can't be, so kernels are structures.
pub(super) trait Kernel {
    type Output;
    fn run(self) -> Self::Output;
}

struct Compiled<K>(K);

impl<K: Kernel> WithSimd for Compiled<K> {
    type Output = K::Output;

    #[inline(always)]
    fn with_simd<S: Simd>(self) -> K::Output {
        self.0.run()
    }
}

/// Runs a kernel with AVX-512, AVX2, NEON or what else there is, which is found out at run time.
pub(super) fn widest<K: Kernel>(kernel: K) -> K::Output {
    AutoArch::new().dispatch(Compiled(kernel))
}
