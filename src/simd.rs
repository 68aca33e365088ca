//! Code that is compiled once for each instruction set, and run with the widest vector registers of this machine.
//!
//! Work is a structure with a `run` method, compiled for AVX-512, AVX2, SSE 4.2, NEON and for none of them; which copy
//! runs is found out at run time, by the crate `macerator`, without unsafe code here. There are two kinds of work:
//! [`Kernel`], plain loops that the compiler turns into vectors, and [`RegisterKernel`], written with registers.
//!
//! Everything that `run` calls in its inner loops must be `#[inline(always)]`, and no closure: what is compiled as a
//! function of its own knows nothing of wide registers, and is up to ten times as slow.

use macerator::{AutoArch, Simd, WithSimd};

/// Work in plain loops. It asks for no fused multiply-add, so every copy gives the same bits.
pub(crate) trait Kernel {
    /// What it returns.
    type Output;

    /// Does the work.
    fn run(self) -> Self::Output;
}

/// Work written in registers of an instruction set `S`, each of `L` numbers of 32 bits.
pub(crate) trait RegisterKernel {
    /// What it returns.
    type Output;

    /// Does the work.
    fn run<S: Simd, const L: usize>(self) -> Self::Output;
}

/// Which copy of a kernel runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum InstructionSet {
    /// The one for the best instructions found on this machine.
    Best,
    /// The one that runs everywhere.
    #[cfg_attr(
        not(test),
        expect(dead_code, reason = "what the best is tested against")
    )]
    Portable,
}

impl InstructionSet {
    /// Runs a kernel.
    pub(crate) fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self {
            InstructionSet::Best => run(kernel),
            InstructionSet::Portable => kernel.run(),
        }
    }
}

/// Runs a kernel with the best instructions of this machine.
pub(crate) fn run<K: Kernel>(kernel: K) -> K::Output {
    struct Loops<K>(K);
    impl<K: Kernel> WithSimd for Loops<K> {
        type Output = K::Output;

        #[inline(always)]
        fn with_simd<S: Simd>(self) -> K::Output {
            self.0.run()
        }
    }
    AutoArch::new().dispatch(Loops(kernel))
}

/// Runs a kernel with the widest registers of this machine.
pub(crate) fn run_in_registers<K: RegisterKernel>(kernel: K) -> K::Output {
    struct Registers<K>(K);
    impl<K: RegisterKernel> WithSimd for Registers<K> {
        type Output = K::Output;

        #[inline(always)]
        fn with_simd<S: Simd>(self) -> K::Output {
            match S::lanes32() {
                16 => self.0.run::<S, 16>(),
                8 => self.0.run::<S, 8>(),
                _ => self.0.run::<S, 4>(),
            }
        }
    }
    AutoArch::new().dispatch(Registers(kernel))
}

/// Numbers of 32 bits that a register of this machine holds.
pub(crate) fn lanes() -> usize {
    struct Lanes;
    impl RegisterKernel for Lanes {
        type Output = usize;

        #[inline(always)]
        fn run<S: Simd, const L: usize>(self) -> usize {
            L
        }
    }
    run_in_registers(Lanes)
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Product<'a>(&'a [f32], &'a mut [f32]);

    impl Kernel for Product<'_> {
        type Output = usize;

        #[inline(always)]
        fn run(self) -> usize {
            for (out, x) in self.1.iter_mut().zip(self.0) {
                *out = *out * x + 0.1;
            }
            self.1.len()
        }
    }

    #[test]
    fn the_best_instructions_and_none_give_the_same_bits() {
        let x: Vec<f32> = (0..1000).map(|i| 1.0 / (i as f32 + 3.0)).collect();
        let start: Vec<f32> = (0..1000).map(|i| (i as f32).sqrt()).collect();
        let (mut best, mut portable) = (start.clone(), start.clone());
        let counts = [
            InstructionSet::Best.run(Product(&x, &mut best)),
            InstructionSet::Portable.run(Product(&x, &mut portable)),
        ];
        assert_eq!(counts, [1000, 1000]);
        assert_eq!(best, portable);
        assert_ne!(best, start);
    }

    /// The register's size in bytes, and `L`.
    struct Sizes;

    impl RegisterKernel for Sizes {
        type Output = (usize, usize);

        #[inline(always)]
        fn run<S: Simd, const L: usize>(self) -> (usize, usize) {
            (size_of::<macerator::Vector<S, f32>>(), L)
        }
    }

    #[test]
    fn a_register_holds_as_many_numbers_as_its_size_says() {
        let (bytes, numbers) = run_in_registers(Sizes);
        assert_eq!(bytes, numbers * size_of::<f32>());
        assert_eq!(lanes(), numbers);
    }
}
