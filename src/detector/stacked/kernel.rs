//! The two products that stacked networks are made of, held in registers of whatever width the machine has.
//!
//! Matrices are slices in row order whose rows are filled up with zeros: rows that are read as registers to whole
//! registers, all to whole blocks. So no kernel has a ragged edge. The loops over `ROWS` and `COLUMNS` vanish in compiling:
//! their sums stay in registers, each number read from `a` is used `COLUMNS` times and each register read `ROWS` times.

use macerator::{Scalar, Simd, Vector};
use std::array::from_fn;

/// Rows of a product, and of an outer product's result, come in whole blocks of this many.
pub const BLOCK: usize = 8;

/// A product's inner dimension comes in whole steps of this many.
pub const STEP: usize = 4;

/// A register of an instruction set.
pub type Register<S> = Vector<S, f32>;

/// Fills a register. (The cast panics where the sizes differ: [`crate::simd`] sees that they do not.)
#[inline(always)]
pub fn load<S: Simd, const L: usize>(numbers: &[f32; L]) -> Register<S> {
    bytemuck::cast(*numbers)
}

/// Writes a register back.
#[inline(always)]
pub fn store<S: Simd, const L: usize>(register: Register<S>, numbers: &mut [f32; L]) {
    *numbers = bytemuck::cast(register);
}

/// Fills some registers from the front.
#[inline(always)]
fn registers<S: Simd, const L: usize, const COLUMNS: usize>(
    numbers: &[[f32; L]],
) -> [Register<S>; COLUMNS] {
    let mut registers = [0f32.splat::<S>(); COLUMNS];
    for (register, numbers) in registers.iter_mut().zip(&numbers[..COLUMNS]) {
        *register = load(numbers);
    }
    registers
}

/// Rows of numbers, `stride` each.
#[derive(Clone, Copy)]
pub struct Matrix<'a> {
    values: &'a [f32],
    stride: usize,
}

impl<'a> Matrix<'a> {
    /// As many whole rows as there are.
    pub fn new(values: &'a [f32], stride: usize) -> Self {
        Self { values, stride }
    }
}

/// Calls a block kernel for all registers of a row, as many at once as there are registers for their sums: of 32, three
/// columns of eight rows; of 16, three columns of four.
macro_rules! in_columns {
    ($vectors:expr, $lanes:expr, $block:ident::<$s:ty, $l:tt>($($argument:expr),*)) => {
        let mut column = 0;
        while column < $vectors {
            let (left, many) = ($vectors - column, $lanes >= 16);
            match left {
                1 => $block::<$s, $l, 8, 1>(0, column, $($argument),*),
                2 if many => $block::<$s, $l, 8, 2>(0, column, $($argument),*),
                _ if many => $block::<$s, $l, 8, 3>(0, column, $($argument),*),
                2 => {
                    $block::<$s, $l, 4, 2>(0, column, $($argument),*);
                    $block::<$s, $l, 4, 2>(4, column, $($argument),*);
                }
                _ => {
                    $block::<$s, $l, 4, 3>(0, column, $($argument),*);
                    $block::<$s, $l, 4, 3>(4, column, $($argument),*);
                }
            }
            column += left.min(3);
        }
    };
}

/// out\[r, c\] = bias\[c\] + Σ_i a\[r, i\] b\[i, c\], over the rows i that b has.
#[inline(always)]
pub fn product<S: Simd, const L: usize>(
    a: Matrix,
    b: Matrix,
    bias: Option<&[f32]>,
    out: &mut [f32],
) {
    let vectors = b.stride / L;
    let b = b.values.as_chunks::<L>().0;
    let bias = bias.map(|bias| bias.as_chunks::<L>().0);
    let blocks = out.as_chunks_mut::<L>().0.chunks_exact_mut(BLOCK * vectors);
    for (values, out) in a.values.chunks_exact(BLOCK * a.stride).zip(blocks) {
        let a = Matrix::new(values, a.stride);
        in_columns!(vectors, L, product_block::<S, L>(a, b, bias, vectors, out));
    }
}

#[inline(always)]
fn product_block<S: Simd, const L: usize, const ROWS: usize, const COLUMNS: usize>(
    first: usize,
    column: usize,
    a: Matrix,
    b: &[[f32; L]],
    bias: Option<&[[f32; L]]>,
    vectors: usize,
    out: &mut [[f32; L]],
) {
    let rows: [&[[f32; STEP]]; ROWS] =
        from_fn(|r| a.values[(first + r) * a.stride..][..a.stride].as_chunks().0);
    let mut start = [0f32.splat::<S>(); COLUMNS];
    if let Some(bias) = bias {
        for (start, bias) in start.iter_mut().zip(&bias[column..]) {
            *start = load(bias);
        }
    }
    let mut sum = [start; ROWS];
    for (step, b) in b.chunks_exact(STEP * vectors).enumerate() {
        let a: [&[f32; STEP]; ROWS] = from_fn(|r| &rows[r][step]);
        for i in 0..STEP {
            let b = registers::<S, L, COLUMNS>(&b[i * vectors + column..]);
            for (sum, a) in sum.iter_mut().zip(a) {
                let a = a[i].splat::<S>();
                for (sum, b) in sum.iter_mut().zip(b) {
                    *sum = a.mul_add(b, *sum);
                }
            }
        }
    }
    for (sum, out) in sum.iter().zip(out.chunks_exact_mut(vectors).skip(first)) {
        for (&sum, out) in sum.iter().zip(&mut out[column..]) {
            store(sum, out);
        }
    }
}

/// out\[i, c\] += Σ_r a\[r, i\] b\[r, c\].
#[inline(always)]
pub fn outer<S: Simd, const L: usize>(a: Matrix, b: Matrix, out: &mut [f32]) {
    let vectors = b.stride / L;
    let b = b.values.as_chunks::<L>().0;
    let blocks = out.as_chunks_mut::<L>().0.chunks_exact_mut(BLOCK * vectors);
    for (block, out) in blocks.enumerate() {
        let block = block * BLOCK;
        in_columns!(vectors, L, outer_block::<S, L>(block, a, b, vectors, out));
    }
}

#[inline(always)]
fn outer_block<S: Simd, const L: usize, const ROWS: usize, const COLUMNS: usize>(
    first: usize,
    column: usize,
    block: usize,
    a: Matrix,
    b: &[[f32; L]],
    vectors: usize,
    out: &mut [[f32; L]],
) {
    let mut sum = [[0f32.splat::<S>(); COLUMNS]; ROWS];
    for (sum, out) in sum.iter_mut().zip(out.chunks_exact(vectors).skip(first)) {
        *sum = registers::<S, L, COLUMNS>(&out[column..]);
    }
    let rows = a.values.chunks_exact(a.stride);
    for (a, b) in rows.zip(b.chunks_exact(vectors)) {
        let a = &a[block + first..][..ROWS];
        let b = registers::<S, L, COLUMNS>(&b[column..]);
        for (sum, a) in sum.iter_mut().zip(a) {
            let a = a.splat::<S>();
            for (sum, b) in sum.iter_mut().zip(b) {
                *sum = a.mul_add(b, *sum);
            }
        }
    }
    for (sum, out) in sum.iter().zip(out.chunks_exact_mut(vectors).skip(first)) {
        for (&sum, out) in sum.iter().zip(&mut out[column..]) {
            store(sum, out);
        }
    }
}
