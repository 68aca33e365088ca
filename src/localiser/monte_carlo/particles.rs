//! A belief as weighted poses: moved by odometry, weighed by what is sensed, drawn from, and summed up.

use crate::{
    belief::{Grid, OdometryMotion},
    geometry::{Displacement, Pose, wrapped},
    localiser::Probable,
    seed::Stream,
};
use rand::RngExt;
use rand_distr::StandardNormal;
use std::{
    collections::BTreeMap,
    f64::consts::{FRAC_PI_2, TAU},
};

/// Particles that hold less than this share of the heaviest one's weight are left out of the posterior.
const NEGLIGIBLE: f64 = 1e-9;

/// Fractional part of the golden ratio: multiples of it, modulo 1, are spread evenly however many there are.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Poses and how probable each is; the probabilities sum to 1.
pub(super) struct Particles {
    poses: Vec<Pose>,
    weights: Vec<f64>,
}

impl Particles {
    /// All alike.
    pub(super) fn new(poses: Vec<Pose>) -> Self {
        Self {
            weights: vec![1.0 / poses.len() as f64; poses.len()],
            poses,
        }
    }

    pub(super) fn poses(&self) -> &[Pose] {
        &self.poses
    }

    /// Draws each pose after a movement from P(ξ | ξ̃, a), as the grid's filter has it: noise does not push a robot off
    /// the grid; a movement that ends off it did not happen, and was as improbable as that the wheels turned and the robot
    /// stayed.
    pub(super) fn advance(
        &mut self,
        grid: &Grid,
        motion: &OdometryMotion,
        step: &Displacement,
        stream: &mut Stream,
    ) {
        let deviation_m = motion.position_variance_m2(step).sqrt();
        let deviation_rad = motion.heading_variance_rad2(step).sqrt();
        for (pose, weight) in self.poses.iter_mut().zip(&mut self.weights) {
            let stalls = stream.random::<f64>() < motion.stall_probability;
            let [east, north, turn]: [f64; 3] = [(); 3].map(|()| stream.sample(StandardNormal));
            let mut moved = pose.after(*step);
            if stalls || grid.cell_of(&moved).is_none() {
                (moved.x_m, moved.y_m) = (pose.x_m, pose.y_m);
                *weight *= if stalls {
                    1.0
                } else {
                    motion.stall_probability
                };
            }
            let heading_rad = wrapped(moved.heading_rad + deviation_rad * turn);
            let noisy = Pose::new(
                moved.x_m + deviation_m * east,
                moved.y_m + deviation_m * north,
                heading_rad,
            );
            *pose = match grid.cell_of(&noisy) {
                Some(_) => noisy,
                None => Pose {
                    heading_rad,
                    ..moved
                },
            };
        }
        self.normalise();
    }

    /// Weighs every particle by ln P(z|ξ); returns ln Σ P(z|ξ) w, how likely the particles held z to be.
    pub(super) fn correct(&mut self, log_likelihood: &[f64]) -> f64 {
        let weighed = self.weights.iter().zip(log_likelihood);
        let best = weighed
            .filter(|(weight, _)| **weight > 0.0)
            .fold(f64::NEG_INFINITY, |best, (_, l)| best.max(*l));
        for (weight, l) in self.weights.iter_mut().zip(log_likelihood) {
            if *weight > 0.0 {
                *weight *= (l - best).exp();
            }
        }
        best + self.normalise().ln()
    }

    /// Makes the weights sum to 1; returns what they summed to.
    fn normalise(&mut self) -> f64 {
        let total: f64 = self.weights.iter().sum();
        self.weights.iter_mut().for_each(|weight| *weight /= total);
        total
    }

    /// 1 / Σ w²: of so many particles of equal weight a mean would be as certain.
    pub(super) fn effective_number(&self) -> f64 {
        1.0 / self.weights.iter().map(|w| w * w).sum::<f64>()
    }

    /// Poses drawn in proportion to the weights, without end. As in the low-variance sampler (*Probabilistic Robotics*,
    /// table 4.4) one random number decides all draws, and each particle is drawn nearly as often as its weight asks for;
    /// but KLD sampling does not know beforehand how many draws there will be, so the teeth of the comb are laid one by
    /// one, each a golden section further.
    pub(super) fn draws(&self, first: f64) -> impl Iterator<Item = Pose> {
        let mut sum = 0.0;
        let up_to = self.weights.iter().map(|weight| {
            sum += weight;
            sum
        });
        let up_to: Vec<f64> = up_to.collect();
        (0..).map(move |tooth| {
            let at = (first + f64::from(tooth) * GOLDEN).fract() * sum;
            let drawn = up_to.partition_point(|&up_to| up_to <= at);
            self.poses[drawn.min(self.poses.len() - 1)]
        })
    }

    /// Heading of the particles no farther than `radius_m` from a place: the circular mean, by their weights, of those within
    /// a quarter turn of the bin, this wide, that holds the most probability together with its two neighbours. So two headings
    /// as probable are not averaged. None where there is no such particle.
    pub(super) fn heading_about(
        &self,
        place: [f64; 2],
        radius_m: f64,
        bin_rad: f64,
    ) -> Option<f64> {
        let near = || {
            let all = self.poses.iter().zip(&self.weights);
            all.filter(|(p, _)| (p.x_m - place[0]).hypot(p.y_m - place[1]) <= radius_m)
        };
        let count = (TAU / bin_rad).ceil().max(1.0) as usize;
        let width_rad = TAU / count as f64;
        let mut bins = vec![0.0; count];
        for (pose, weight) in near() {
            let bin = (pose.heading_rad.rem_euclid(TAU) / width_rad) as usize;
            bins[bin % count] += weight;
        }
        let around =
            |bin: usize| bins[(bin + count - 1) % count] + bins[bin] + bins[(bin + 1) % count];
        let heaviest = (0..count).max_by(|&a, &b| around(a).total_cmp(&around(b)))?;
        let about_rad = (heaviest as f64 + 0.5) * width_rad;
        let (mut sin, mut cos) = (0.0, 0.0);
        for (pose, weight) in near() {
            if wrapped(pose.heading_rad - about_rad).abs() <= FRAC_PI_2 {
                sin += weight * pose.heading_rad.sin();
                cos += weight * pose.heading_rad.cos();
            }
        }
        (sin.hypot(cos) > 0.0).then(|| sin.atan2(cos))
    }

    /// The places of the particles that hold probability to speak of.
    pub(super) fn posterior(&self) -> Vec<Probable> {
        let least = NEGLIGIBLE * self.weights.iter().copied().fold(0.0, f64::max);
        let kept = || {
            let all = self.poses.iter().zip(&self.weights);
            all.filter(move |(_, weight)| **weight >= least)
        };
        let total: f64 = kept().map(|(_, weight)| weight).sum();
        kept()
            .map(|(pose, weight)| ([pose.x_m, pose.y_m], weight / total))
            .collect()
    }
}

/// Mean of the probable places in the square bin, of this edge, that holds the most probability together with its eight
/// neighbours, and in these. So two places as probable are not averaged.
pub(super) fn heaviest_place(posterior: &[Probable], bin_m: f64) -> Option<[f64; 2]> {
    let mut bins: BTreeMap<[i64; 2], [f64; 3]> = BTreeMap::new();
    for &([x_m, y_m], p) in posterior {
        let bin = bins.entry([x_m, y_m].map(|v| (v / bin_m).floor() as i64));
        let bin = bin.or_default();
        for (sum, value) in bin.iter_mut().zip([p, p * x_m, p * y_m]) {
            *sum += value;
        }
    }
    let around = |[column, row]: [i64; 2]| {
        let mut sums = [0.0; 3];
        let neighbours = (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| [column + dx, row + dy]));
        for bin in neighbours.filter_map(|at| bins.get(&at)) {
            for (sum, value) in sums.iter_mut().zip(bin) {
                *sum += value;
            }
        }
        sums
    };
    let all = bins.keys().map(|&bin| around(bin));
    let [p, x, y] = all.max_by(|a, b| a[0].total_cmp(&b[0]))?;
    Some([x / p, y / p])
}

#[cfg(test)]
mod tests;
