//! A blur with a stated variance.

/// Weights of the centre, of each neighbour at distance 1, at distance 2, …
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Kernel {
    weights: Vec<f64>,
    /// Sum of the weights at distances above 0, above 1, …, above the radius.
    beyond: Vec<f64>,
}

/// Weight that may be missing where the two tails are cut.
const CUT: f64 = 1e-9;

/// Below this variance, in cells², nothing is blurred.
const LEAST_VARIANCE: f64 = 1e-9;

impl Kernel {
    /// The discrete analogue of the Gaussian, T(d; t) = e^−t I_d(t) with I_d the modified Bessel function (Lindeberg,
    /// *Scale-space for discrete signals*, 1990). A Gaussian sampled at the cells has too little variance where it is
    /// narrower than a cell; this one has variance t for every t.
    ///
    /// `variance` in cells²; at most `most` cells wide on either side.
    pub(super) fn gaussian(variance: f64, most: usize) -> Self {
        if variance.is_nan() || variance <= LEAST_VARIANCE {
            return Self::of_weights(vec![1.0]);
        }
        // Wider than the grid is flat: no use in going on.
        let variance = variance.min((most * most) as f64);
        // Miller's backward recurrence I_{d−1} = I_{d+1} + (2d/t) I_d, from far outside; I_0 + 2 Σ I_d = e^t fixes the scale.
        let outside = 12 + (8.0 * variance.sqrt()).ceil() as usize;
        let mut weights = vec![0.0; outside + 2];
        weights[outside] = 1e-200;
        for d in (1..=outside).rev() {
            weights[d - 1] = weights[d + 1] + 2.0 * d as f64 / variance * weights[d];
        }
        let scale = weights[0] + 2.0 * weights[1..].iter().sum::<f64>();
        let mut tail = 0.0;
        let radius = (1..weights.len())
            .rev()
            .find(|&d| {
                tail += 2.0 * weights[d] / scale;
                tail > CUT
            })
            .unwrap_or(0);
        weights.truncate(radius.min(most) + 1);
        let sum = weights[0] + 2.0 * weights[1..].iter().sum::<f64>();
        weights.iter_mut().for_each(|w| *w /= sum);
        Self::of_weights(weights)
    }

    fn of_weights(weights: Vec<f64>) -> Self {
        let mut beyond = vec![0.0; weights.len()];
        for d in (1..weights.len()).rev() {
            beyond[d - 1] = beyond[d] + weights[d];
        }
        Self { weights, beyond }
    }

    /// Does it leave everything as it is?
    pub(super) fn is_identity(&self) -> bool {
        self.weights.len() == 1
    }

    /// Weight at a distance of `cells` to either side.
    pub(super) fn weight(&self, cells: usize) -> f64 {
        self.weights.get(cells).copied().unwrap_or(0.0)
    }

    /// Cells on either side that get any weight.
    pub(super) fn radius(&self) -> usize {
        self.weights.len() - 1
    }

    /// Share of a mass that would pass a wall on one side, with `cells` cells between the two.
    pub(super) fn beyond(&self, cells: usize) -> f64 {
        self.beyond.get(cells).copied().unwrap_or(0.0)
    }

    /// Cells to the left and right of `stretch` that its mass reaches, in a row with `before` and `after` free cells on
    /// either side of the stretch.
    pub(super) fn reach(&self, before: usize, stretch: usize, after: usize) -> (usize, usize) {
        let farthest = self.radius().min((before + stretch + after).max(1) - 1);
        (before.min(farthest), after.min(farthest))
    }

    /// Blurs the masses of a stretch of a row between two walls, with `before` and `after` cells between the stretch and the
    /// walls. `target` is the stretch and the cells on either side of it that [`Kernel::reach`] says; `padded` is room to
    /// work in. What would pass a wall stays where it was: so mass is kept, and a flat belief stays flat.
    #[inline(always)]
    pub(super) fn blur(
        &self,
        before: usize,
        source: &[f64],
        after: usize,
        padded: &mut Vec<f64>,
        target: &mut [f64],
    ) {
        let radius = self.radius().min(before + source.len() + after - 1);
        let (left, right) = self.reach(before, source.len(), after);
        padded.clear();
        padded.resize(radius + left, 0.0);
        padded.extend_from_slice(source);
        padded.resize(padded.len() + radius + right, 0.0);
        let weights = &self.weights[..=radius];
        let (parts, rest) = target.as_chunks_mut::<16>();
        let mut at = radius;
        for part in parts {
            let mut sums = [0.0; 16];
            for (d, weight) in weights.iter().enumerate().skip(1) {
                let sides = padded[at - d..][..16].iter().zip(&padded[at + d..][..16]);
                for (sum, (l, r)) in sums.iter_mut().zip(sides) {
                    *sum += weight * (l + r);
                }
            }
            let centre = sums.iter().zip(&padded[at..][..16]);
            for (t, (sum, s)) in part.iter_mut().zip(centre) {
                *t = sum + weights[0] * s;
            }
            at += 16;
        }
        for t in rest {
            *t = weights[0] * padded[at];
            for (d, weight) in weights.iter().enumerate().skip(1) {
                *t += weight * (padded[at - d] + padded[at + d]);
            }
            at += 1;
        }
        let own = &mut target[left..left + source.len()];
        let pairs = own.iter_mut().zip(source).zip(before..self.radius());
        pairs.for_each(|((t, s), cells)| *t += self.beyond(cells) * s);
        let pairs = own.iter_mut().zip(source).rev().zip(after..self.radius());
        pairs.for_each(|((t, s), cells)| *t += self.beyond(cells) * s);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn has_mass_one_and_the_stated_variance() {
        for variance in [1e-8, 1e-3, 0.1, 0.5, 1.0, 7.3, 400.0] {
            let kernel = Kernel::gaussian(variance, 1000);
            let (mut mass, mut spread) = (kernel.weight(0), 0.0);
            for d in 1..=kernel.radius() {
                mass += 2.0 * kernel.weight(d);
                spread += 2.0 * (d * d) as f64 * kernel.weight(d);
            }
            assert!((mass - 1.0).abs() < 1e-14, "{variance}: {mass}");
            assert!(
                (spread / variance - 1.0).abs() < 1e-5,
                "{variance}: {spread}"
            );
        }
    }

    #[test]
    fn agrees_with_the_bessel_function() {
        // Abramowitz & Stegun, table 9.8: e^−1 I_0(1) = .4657596, e^−1 I_1(1) = .2079104.
        let kernel = Kernel::gaussian(1.0, 100);
        assert!((kernel.weight(0) - 0.465_759_6).abs() < 1e-7);
        assert!((kernel.weight(1) - 0.207_910_4).abs() < 1e-7);
    }

    #[test]
    fn walls_keep_mass_and_flatness() {
        for n in [1, 2, 5, 40] {
            let kernel = Kernel::gaussian(9.0, 1000);
            let flat = vec![0.5; n];
            let (mut blurred, mut padded) = (vec![0.0; n], Vec::new());
            kernel.blur(0, &flat, 0, &mut padded, &mut blurred);
            assert!(blurred.iter().all(|v| (v - 0.5).abs() < 1e-14), "{n}");
            let mut peak = vec![0.0; n];
            peak[n / 3] = 1.0;
            kernel.blur(0, &peak, 0, &mut padded, &mut blurred);
            assert!((blurred.iter().sum::<f64>() - 1.0).abs() < 1e-14, "{n}");
        }
    }

    #[test]
    fn a_part_is_blurred_like_the_whole_row_with_nothing_around_it() {
        let mut padded = Vec::new();
        for variance in [0.1, 1.0, 50.0] {
            let kernel = Kernel::gaussian(variance, 1000);
            for (before, after) in [(0, 0), (1, 3), (30, 0), (2, 90), (60, 60)] {
                let part: Vec<f64> = (0..13).map(|i| f64::from(i * i % 7 + 1)).collect();
                let row = [vec![0.0; before], part.clone(), vec![0.0; after]].concat();
                let mut expected = vec![0.0; row.len()];
                for (i, mass) in row.iter().enumerate() {
                    expected[i] += kernel.weight(0) * mass;
                    for d in 1..=kernel.radius() {
                        let left = if d <= i { i - d } else { i };
                        let right = if i + d < row.len() { i + d } else { i };
                        expected[left] += kernel.weight(d) * mass;
                        expected[right] += kernel.weight(d) * mass;
                    }
                }
                let (left, right) = kernel.reach(before, part.len(), after);
                let mut blurred = vec![0.0; left + part.len() + right];
                kernel.blur(before, &part, after, &mut padded, &mut blurred);
                for (i, e) in expected.iter().enumerate() {
                    let got = (i + left).checked_sub(before);
                    let got = got.and_then(|at| blurred.get(at)).unwrap_or(&0.0);
                    assert!((got - e).abs() < 1e-13, "{variance}, {before}, cell {i}");
                }
            }
        }
    }
}
