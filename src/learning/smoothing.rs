//! The map inside the objective: from activations of snapshots to P(f|ξ) of places, and back.

use crate::{
    belief::{MapConfig, Nearness, Neighbours, Places},
    error::Result,
};
use ndarray::{Array2, ArrayView2};
use rayon::prelude::*;

/// Rows that a thread takes at once.
const ROWS: usize = 256;

/// Features that are summed side by side.
const BESIDE: usize = 4;

/// P(f_i|ξ) of every training place as [`crate::belief::FeatureMap`] has it: the mean activation over its nearest
/// training snapshots (Thrun 1998, 5.1.6), kept off 0 and 1.
///
/// ```
/// use ballmark::{belief::{MapConfig, Nearness, Places}, learning::smoothing::Smoothing};
/// use ndarray::{Array2, array};
/// let nearness = Nearness { k: 2, ..Nearness::default() };
/// let config = MapConfig { nearness, unmodelled_probability: 0.0, ..MapConfig::default() };
/// let smoothing = Smoothing::new(&config, &Places::Route(vec![0.0, 1.0, 5.0]))?;
/// let mut map = Array2::default((0, 0)); // [place, feature]
/// smoothing.apply(array![[0.0], [1.0], [0.5]].view(), &mut map);
/// assert_eq!(map, array![[0.5], [0.5], [0.75]]);
/// # Ok::<(), ballmark::Error>(())
/// ```
pub struct Smoothing {
    /// The snapshots that a place's map is made of.
    near: Lists,
    /// The places whose map a snapshot is part of.
    far: Lists,
    /// Weight of a snapshot in the map of a place.
    share: f32,
    /// The map where no snapshot answers.
    floor: f32,
}

impl Smoothing {
    /// The map of some places from the snapshots taken there, all of them where there are fewer than neighbours wanted.
    ///
    /// # Errors
    /// Where there is no place.
    pub fn new(config: &MapConfig, places: &Places) -> Result<Self> {
        let nearness = Nearness {
            k: config.nearness.k.min(places.len()),
            ..config.nearness.clone()
        };
        let neighbours = Neighbours::find(places, places, &nearness)?;
        let near = Lists::new(&neighbours);
        Ok(Self {
            far: near.transposed(),
            near,
            share: ((1.0 - config.unmodelled_probability) / neighbours.k() as f64) as f32,
            floor: (0.5 * config.unmodelled_probability) as f32,
        })
    }

    /// From activations `[snapshot, feature]` to the map `[place, feature]`.
    pub fn apply(&self, activation: ArrayView2<f32>, map: &mut Array2<f32>) {
        self.near.sums(activation, self.share, self.floor, map);
    }

    /// The snapshots that each place's map is made of, as many a place: `[place, neighbour]`, one row after the other.
    pub fn near(&self) -> &[u32] {
        &self.near.index
    }

    /// What each of them counts for, and the map where none of them answers.
    pub fn share_and_floor(&self) -> (f32, f32) {
        (self.share, self.floor)
    }

    /// The transpose: from ∂E/∂map to ∂E/∂activation.
    pub fn apply_transpose(&self, gradient: ArrayView2<f32>, out: &mut Array2<f32>) {
        self.far.sums(gradient, self.share, 0.0, out);
    }
}

/// Rows that belong to each row, in lists one after the other.
struct Lists {
    start: Vec<u32>,
    index: Vec<u32>,
}

impl Lists {
    fn new(neighbours: &Neighbours) -> Self {
        let all = 0..neighbours.len();
        Self {
            start: (0..=neighbours.len())
                .map(|row| (row * neighbours.k()) as u32)
                .collect(),
            index: all
                .flat_map(|row| neighbours.of(row))
                .map(|&k| k as u32)
                .collect(),
        }
    }

    fn rows(&self) -> usize {
        self.start.len() - 1
    }

    fn list(&self, row: usize) -> &[u32] {
        &self.index[self.start[row] as usize..self.start[row + 1] as usize]
    }

    /// The same pairs from the other end, each list ascending.
    fn transposed(&self) -> Self {
        let mut start = vec![0; self.rows() + 1];
        for &other in &self.index {
            start[other as usize + 1] += 1;
        }
        for row in 0..self.rows() {
            start[row + 1] += start[row];
        }
        let (mut next, mut index) = (start.clone(), vec![0; self.index.len()]);
        for row in 0..self.rows() {
            for &other in self.list(row) {
                let slot = &mut next[other as usize];
                index[*slot as usize] = row as u32;
                *slot += 1;
            }
        }
        Self { start, index }
    }

    /// `share` · Σ over each row's list + `floor`, `[row, feature]`.
    fn sums(&self, input: ArrayView2<f32>, share: f32, floor: f32, out: &mut Array2<f32>) {
        let n = input.ncols();
        if out.dim() != (self.rows(), n) {
            *out = Array2::zeros((self.rows(), n));
        }
        let input = input.as_standard_layout();
        // A standard layout is a slice.
        let input = input.as_slice().unwrap_or_default();
        let rows = out.as_slice_mut().unwrap_or_default();
        let chunks = rows.par_chunks_mut((ROWS * n).max(1)).enumerate();
        chunks.for_each(|(chunk, rows)| {
            for (row, out) in rows.chunks_exact_mut(n).enumerate() {
                let list = self.list(chunk * ROWS + row);
                let (beside, rest) = out.as_chunks_mut::<BESIDE>();
                let summed = n - rest.len();
                for (column, out) in beside.iter_mut().enumerate() {
                    *out = sum(list, &input[column * BESIDE..], n).map(|sum| share * sum + floor);
                }
                for (column, out) in rest.iter_mut().enumerate() {
                    let [sum] = sum(list, &input[summed + column..], n);
                    *out = share * sum + floor;
                }
            }
        });
    }
}

/// Σ over a list of rows of `n` numbers, of their first `M`.
#[inline(always)]
fn sum<const M: usize>(list: &[u32], rows: &[f32], n: usize) -> [f32; M] {
    let mut sum = [0.0; M];
    for &k in list {
        let row = &rows[k as usize * n..][..M];
        for (sum, x) in sum.iter_mut().zip(row) {
            *sum += x;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seed::Seed;
    use rand::RngExt;

    #[test]
    fn forward_is_the_mean_of_neighbours_and_back_its_transpose() {
        let mut random = Seed(3).stream("smoothing");
        let places = Places::Route((0..700).map(|_| random.random_range(0.0..90.0)).collect());
        let config = MapConfig::default();
        let (k, chance) = (config.nearness.k as f64, config.unmodelled_probability);
        let smoothing = Smoothing::new(&config, &places).unwrap();
        let neighbours = Neighbours::find(&places, &places, &config.nearness).unwrap();
        for n in [1, 4, 7, 12] {
            let mut draw =
                || Array2::from_shape_simple_fn((700, n), || random.random_range(0.0..1f32));
            let (g, slope) = (draw(), draw());
            let (mut map, mut back) = (Array2::default((0, 0)), Array2::default((0, 0)));
            smoothing.apply(g.view(), &mut map);
            smoothing.apply_transpose(slope.view(), &mut back);
            let mut expected = Array2::<f64>::zeros(g.raw_dim());
            for place in 0..700 {
                for feature in 0..n {
                    let near = neighbours
                        .of(place)
                        .iter()
                        .map(|&k| f64::from(g[[k, feature]]));
                    let mean = (1.0 - chance) * near.sum::<f64>() / k + 0.5 * chance;
                    assert!((mean - f64::from(map[[place, feature]])).abs() < 3e-7);
                    for &k in neighbours.of(place) {
                        expected[[k, feature]] += f64::from(slope[[place, feature]]);
                    }
                }
            }
            for (expected, found) in expected.iter().zip(&back) {
                assert!((expected * (1.0 - chance) / k - f64::from(*found)).abs() < 3e-6);
            }
        }
    }
}
