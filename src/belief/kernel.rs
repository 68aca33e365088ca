//! A blur with a stated variance.

/// Weights of the centre, of each neighbour at distance 1, at distance 2, …
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Kernel {
    weights: Vec<f64>,
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
            return Self { weights: vec![1.0] };
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
        Self { weights }
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

    /// Blurs a stretch between two walls. What would pass a wall stays where it was: so mass is kept, and a flat belief
    /// stays flat.
    pub(super) fn blur(&self, source: &[f64], target: &mut [f64]) {
        let n = source.len();
        // From `n` cells on, both sides are behind the walls.
        let own = self.weights[0] + 2.0 * self.weights.iter().skip(n.max(1)).sum::<f64>();
        target
            .iter_mut()
            .zip(source)
            .for_each(|(t, s)| *t = own * s);
        for (d, &weight) in self.weights.iter().enumerate().take(n).skip(1) {
            let add = |target: &mut [f64], source: &[f64]| {
                target
                    .iter_mut()
                    .zip(source)
                    .for_each(|(t, s)| *t += weight * s);
            };
            add(&mut target[d..], source); // from the left …
            add(&mut target[..d], &source[..d]); // … where there is a left
            add(target, &source[d..]);
            add(&mut target[n - d..], &source[n - d..]);
        }
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
            let mut blurred = vec![0.0; n];
            kernel.blur(&flat, &mut blurred);
            assert!(blurred.iter().all(|v| (v - 0.5).abs() < 1e-14), "{n}");
            let mut peak = vec![0.0; n];
            peak[n / 3] = 1.0;
            kernel.blur(&peak, &mut blurred);
            assert!((blurred.iter().sum::<f64>() - 1.0).abs() < 1e-14, "{n}");
        }
    }
}
