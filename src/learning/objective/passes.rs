//! The three passes over the places, on all threads, chunk by chunk.
//!
//! A pass cuts the places into chunks of fixed size, so that no bit depends on the number of threads. Only M, U and U∘ē
//! stay in memory from one pass to the next.

use super::{
    Evaluation,
    activations::Activations,
    kernels::{ChunkWorkspace, ExpectedError, MapGradient, MapOutcomes},
    outcomes::tiles,
};
use crate::{
    learning::{
        lanes::{Lanes, Real},
        prior_operator::{Accumulator, CHUNK, PriorOperator, Rows, Scratch},
    },
    simd::InstructionSet,
};
use ndarray::{Array2, ArrayView1, ArrayView2};
use rayon::prelude::*;

/// Parts that every thread takes of a pass: a few, since neither handing out work nor making a workspace is free.
const PARTS_A_THREAD: usize = 2;

/// The objective with its buffers, for one evaluation after the other: new buffers cost more than the sums. Where priors of
/// different sizes are evaluated in turn, keep one for each.
///
/// ```
/// use ballmark::{belief::Places, learning::{objective::{Objective, equal_weights}, prior_operator::PriorOperator}};
/// use ndarray::array;
/// let places = Places::Route(vec![0.0, 99.0]);
/// let prior = PriorOperator::new("global".parse()?, &places, &places);
/// let mut objective = Objective::<f32>::new();
/// for step in 0..3 {
///     let g = array![[0.9f32 + 0.01 * step as f32], [0.2]];
///     let e = objective.evaluate(&prior, g.view(), g.view(), equal_weights(2).view())?;
///     assert!(e.posterior_error_m < 25.001);
/// }
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug)]
pub struct Objective<T> {
    instructions: InstructionSet,
    buffers: Buffers<T>,
    pub(super) evaluation: Evaluation<T>,
}

/// What is kept of a pass for the next, and of an evaluation for the next.
#[derive(Debug)]
struct Buffers<T> {
    /// M `[candidate, tile]`, in the operator's order, as are U and U∘ē `[truth, tile]`.
    m: Vec<Lanes<T>>,
    u: Vec<Lanes<T>>,
    u_errors: Vec<Lanes<f64>>,
    map_scratch: Scratch<T>,
    truth_scratch: Scratch<T>,
    workspaces: Vec<ChunkWorkspace<T>>,
    /// E of every chunk of truths.
    errors_m: Vec<f64>,
    /// Gradients that are not yet in the callers' order.
    in_order: Vec<T>,
}

impl<T: Real> Default for Objective<T> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Real> Objective<T> {
    /// With buffers still empty: they take their size from the first evaluation.
    pub fn new() -> Self {
        Self::with_instructions(InstructionSet::Best)
    }

    pub(super) fn with_instructions(instructions: InstructionSet) -> Self {
        Self {
            instructions,
            buffers: Buffers {
                m: Vec::new(),
                u: Vec::new(),
                u_errors: Vec::new(),
                map_scratch: Scratch::default(),
                truth_scratch: Scratch::default(),
                workspaces: Vec::new(),
                errors_m: Vec::new(),
                in_order: Vec::new(),
            },
            evaluation: Evaluation::default(),
        }
    }

    /// M, and what [`PriorOperator::apply`] needs of it.
    pub(super) fn map_outcomes(&mut self, prior: &PriorOperator, map: ArrayView2<T>) {
        let map = map.as_standard_layout();
        let activations = Activations::new(&map, prior.candidate_order());
        let (tiles, instructions) = (tiles(activations.features), self.instructions);
        let Buffers {
            m,
            map_scratch,
            workspaces,
            ..
        } = &mut self.buffers;
        m.resize(prior.candidates() * tiles, Lanes::default());
        let accumulators = prior.map_accumulators(tiles, map_scratch);
        let mut chunks: Vec<_> = m.chunks_mut(CHUNK * tiles).zip(accumulators).collect();
        in_chunks(
            &mut chunks,
            workspaces,
            tiles,
            |first, (m, accumulator), workspace| {
                instructions.run(MapOutcomes {
                    activations,
                    first,
                    highs: workspace.highs_of_one(),
                    out: m,
                });
                accumulator.add(&rows(tiles, m, None), instructions);
            },
        );
        drop(chunks);
        prior.prepare(&rows(tiles, m, None), map_scratch, instructions);
    }

    /// N, D and ē of every truth; from them E, ∂E/∂g of the truths, U and U∘ē.
    pub(super) fn expected_error(
        &mut self,
        prior: &PriorOperator,
        truth: ArrayView2<T>,
        weight: ArrayView1<f64>,
    ) {
        let (truth, weight) = (truth.as_standard_layout(), weight.as_standard_layout());
        let weight = weight.as_slice().unwrap_or_default(); // a standard layout is a slice
        let activations = Activations::new(&truth, prior.truth_order());
        let (n, instructions) = (activations.features, self.instructions);
        let (tiles, truths) = (tiles(n), prior.truths());
        let Buffers {
            m,
            u,
            u_errors,
            map_scratch,
            truth_scratch,
            workspaces,
            errors_m,
            in_order,
        } = &mut self.buffers;
        u.resize(truths * tiles, Lanes::default());
        u_errors.resize(truths * tiles, Lanes::default());
        errors_m.resize(truths.div_ceil(CHUNK), 0.0);
        let (m, map_scratch) = (rows(tiles, m, None), &*map_scratch);
        let gradient = &mut self.evaluation.truth_gradient;
        fill(
            gradient,
            in_order,
            (truths, n),
            activations.order,
            |gradient| {
                let mut chunks: Vec<_> = u
                    .chunks_mut(CHUNK * tiles)
                    .zip(u_errors.chunks_mut(CHUNK * tiles))
                    .zip(gradient.chunks_mut(CHUNK * n))
                    .zip(errors_m.iter_mut())
                    .zip(prior.truth_accumulators(tiles, truth_scratch))
                    .map(
                        |((((u, u_errors), gradient), error_m), accumulator)| TruthChunk {
                            u,
                            u_errors,
                            gradient,
                            error_m,
                            accumulator,
                        },
                    )
                    .collect();
                in_chunks(&mut chunks, workspaces, tiles, |first, chunk, workspace| {
                    *chunk.error_m = instructions.run(ExpectedError {
                        prior,
                        activations,
                        weight,
                        first,
                        m: &m,
                        scratch: map_scratch,
                        workspace,
                        u: &mut *chunk.u,
                        u_errors: &mut *chunk.u_errors,
                        gradient: &mut *chunk.gradient,
                    });
                    let rows = rows(tiles, chunk.u, Some(chunk.u_errors));
                    chunk.accumulator.add(&rows, instructions);
                });
            },
        );
        self.evaluation.posterior_error_m = errors_m.iter().sum();
        prior.prepare_transpose(&rows(tiles, u, Some(u_errors)), truth_scratch, instructions);
    }

    /// ∂E/∂M and with it ∂E/∂g of the map's places.
    pub(super) fn map_gradient(&mut self, prior: &PriorOperator, map: ArrayView2<T>) {
        let map = map.as_standard_layout();
        let activations = Activations::new(&map, prior.candidate_order());
        let (n, instructions) = (activations.features, self.instructions);
        let tiles = tiles(n);
        let Buffers {
            u,
            u_errors,
            truth_scratch: scratch,
            workspaces,
            in_order,
            ..
        } = &mut self.buffers;
        let (u, scratch) = (rows(tiles, u, Some(u_errors)), &*scratch);
        let gradient = &mut self.evaluation.map_gradient;
        let shape = (prior.candidates(), n);
        fill(gradient, in_order, shape, activations.order, |gradient| {
            let mut chunks: Vec<_> = gradient.chunks_mut(CHUNK * n).collect();
            in_chunks(
                &mut chunks,
                workspaces,
                tiles,
                |first, gradient, workspace| {
                    instructions.run(MapGradient {
                        prior,
                        activations,
                        first,
                        u: &u,
                        scratch,
                        workspace,
                        gradient,
                    });
                },
            );
        });
    }
}

/// What is made of a chunk of truths.
struct TruthChunk<'a, T> {
    u: &'a mut [Lanes<T>],
    u_errors: &'a mut [Lanes<f64>],
    gradient: &'a mut [T],
    error_m: &'a mut f64,
    accumulator: Accumulator<'a, 3>,
}

/// Does `work` for every chunk on all threads, given the number of the chunk's first place and a workspace.
fn in_chunks<T: Real, C: Send>(
    chunks: &mut [C],
    workspaces: &mut Vec<ChunkWorkspace<T>>,
    tiles: usize,
    work: impl Fn(usize, &mut C, &mut ChunkWorkspace<T>) + Sync,
) {
    let parts = PARTS_A_THREAD * rayon::current_num_threads();
    let length = chunks.len().div_ceil(parts).max(1);
    let parts = chunks.len().div_ceil(length);
    workspaces.retain(|workspace| workspace.tiles() == tiles);
    if workspaces.len() < parts {
        workspaces.resize_with(parts, || ChunkWorkspace::new(tiles));
    }
    let parts = workspaces
        .par_iter_mut()
        .zip(chunks.par_chunks_mut(length))
        .enumerate();
    parts.for_each(|(part, (workspace, chunks))| {
        for (number, chunk) in (part * length..).zip(chunks) {
            work(number * CHUNK, chunk, workspace);
        }
    });
}

fn rows<'a, T>(
    tiles: usize,
    weighted: &'a [Lanes<T>],
    unweighted: Option<&'a [Lanes<f64>]>,
) -> Rows<'a, T> {
    Rows {
        tiles,
        weighted,
        unweighted,
    }
}

/// Lets a gradient be filled in the operator's order, and puts it into the caller's.
fn fill<T: Real>(
    gradient: &mut Array2<T>,
    workspace: &mut Vec<T>,
    shape: (usize, usize),
    order: Option<&[usize]>,
    in_order: impl FnOnce(&mut [T]),
) {
    if gradient.dim() != shape {
        *gradient = Array2::from_elem(shape, T::default());
    }
    let out = gradient.as_slice_mut().unwrap_or_default(); // a standard layout is a slice
    match order {
        None => in_order(out),
        Some(order) => {
            workspace.resize(out.len(), T::default());
            in_order(workspace);
            let n = shape.1.max(1);
            for (&k, row) in order.iter().zip(workspace.chunks_exact(n)) {
                out[k * n..(k + 1) * n].copy_from_slice(row);
            }
        }
    }
}
