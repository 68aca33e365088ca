//! A belief in few numbers: mean, covariance, entropy.

use super::{belief::Belief, places::Places};
use crate::geometry::{Pose, wrapped};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::FRAC_PI_2;

/// How far from the mode mass counts for the mode's heading.
const NEAR_MODE_M: f64 = 1.0;

impl Belief {
    /// Σ_ξ ξ Bel(ξ): the mean of x and y, and the circular mean of the heading (the direction of the mean of all headings as
    /// unit vectors; 0 where they cancel). Along a route `x_m` is the mean coordinate in metres and the rest is 0.
    ///
    /// A belief with two peaks has its mean between them, where the robot is not: [`Belief::mode`] then says more.
    pub fn mean(&self) -> Pose {
        let mean = |value: &(dyn Fn(&Pose) -> f64 + Sync)| {
            self.sum(|cell, mass| mass * value(&self.places().pose(cell)))
        };
        let x_m = mean(&|pose| pose.x_m);
        if let Places::Route(_) = **self.places() {
            return Pose::new(x_m, 0.0, 0.0);
        }
        let (sin, cos) = (
            mean(&|pose| pose.heading_rad.sin()),
            mean(&|pose| pose.heading_rad.cos()),
        );
        // Rounding leaves headings that cancel a direction that means nothing.
        let heading_rad = if sin.hypot(cos) < 1e-12 {
            0.0
        } else {
            sin.atan2(cos)
        };
        Pose::new(x_m, mean(&|pose| pose.y_m), heading_rad)
    }

    /// The heading that goes with the [mode](Belief::mode), in radians, finer than the cells tell headings apart: the direction of
    /// the mean of the headings, as unit vectors, of all mass within 1 m of the mode and a quarter turn of its heading. `None`
    /// along a route, where a belief knows no heading.
    pub fn mode_heading_rad(&self) -> Option<f64> {
        let Places::Plane(cells) = &**self.places() else {
            return None;
        };
        let mode = cells[self.mode()];
        let (mut sin, mut cos) = (0.0, 0.0);
        for (cell, mass) in cells.iter().zip(self.mass()) {
            let is_near = *mass > 0.0
                && cell.distance_m(&mode) <= NEAR_MODE_M
                && cell.turn_rad(&mode) <= FRAC_PI_2;
            if is_near {
                sin += mass * cell.heading_rad.sin();
                cos += mass * cell.heading_rad.cos();
            }
        }
        Some(sin.atan2(cos))
    }

    /// Σ_ξ (ξ − mean)(ξ − mean)ᵀ Bel(ξ) in the order x, y, heading: m², m·rad, rad². Headings count by the shorter way round
    /// from the circular mean. Along a route only the first entry is not 0.
    ///
    /// ```
    /// use ballmark::belief::{Belief, Places};
    /// let corridor = std::sync::Arc::new(Places::Route(vec![0.0, 2.0]));
    /// let belief = Belief::uniform(&corridor)?;
    /// assert_eq!(belief.mean().x_m, 1.0);
    /// assert_eq!(belief.covariance()[(0, 0)], 1.0);
    /// assert_eq!(belief.entropy(), 2f64.ln());
    /// # Ok::<(), ballmark::Error>(())
    /// ```
    pub fn covariance(&self) -> Matrix3<f64> {
        let mean = self.mean();
        let deviation = |cell: usize| {
            let pose = self.places().pose(cell);
            Vector3::new(
                pose.x_m - mean.x_m,
                pose.y_m - mean.y_m,
                wrapped(pose.heading_rad - mean.heading_rad),
            )
        };
        let mut covariance = Matrix3::zeros();
        for row in 0..3 {
            for column in row..3 {
                let entry = self.sum(|cell, mass| {
                    if mass > 0.0 {
                        let deviation = deviation(cell);
                        mass * deviation[row] * deviation[column]
                    } else {
                        0.0
                    }
                });
                covariance[(row, column)] = entry;
                covariance[(column, row)] = entry;
            }
        }
        covariance
    }

    /// −Σ Bel ln Bel, in nats: ln of the number of places for a uniform belief, 0 for a certain one.
    pub fn entropy(&self) -> f64 {
        self.sum(|_, mass| if mass > 0.0 { -mass * mass.ln() } else { 0.0 })
    }

    /// ln Σ_ξ Bel(ξ) P(z|ξ): how likely the belief holds an observation with these ln P(z|ξ), one a place, to be. −∞ where the
    /// belief holds it to be impossible.
    pub fn log_predictive(&self, log_likelihood: &[f64]) -> f64 {
        let pairs = self.mass().iter().zip(log_likelihood);
        let believed = pairs.filter(|(mass, _)| **mass > 0.0).map(|(_, l)| *l);
        let best = believed.fold(f64::NEG_INFINITY, f64::max);
        if best == f64::NEG_INFINITY {
            return best;
        }
        let sum = self.sum(|cell, mass| {
            if mass > 0.0 {
                mass * (log_likelihood[cell] - best).exp()
            } else {
                0.0
            }
        });
        best + sum.ln()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::{f64::consts::PI, sync::Arc};

    fn plane(poses: &[[f64; 3]], mass: &[f64]) -> Belief {
        let poses = poses
            .iter()
            .map(|&[x, y, heading]| Pose::new(x, y, heading));
        let places = Arc::new(Places::Plane(poses.collect()));
        Belief::from_mass(&places, mass.to_vec()).unwrap()
    }

    #[test]
    fn three_weighted_poses_by_hand() {
        let belief = plane(
            &[[0.0, 0.0, 0.1], [4.0, 0.0, 0.1], [4.0, 8.0, 0.1]],
            &[1.0, 1.0, 2.0],
        );
        let mean = belief.mean();
        assert!((mean.x_m - 3.0).abs() < 1e-15 && (mean.y_m - 4.0).abs() < 1e-15);
        assert!((mean.heading_rad - 0.1).abs() < 1e-15);
        // x: (9 + 1 + 2·1)/4; y: (16 + 16 + 2·16)/4; xy: (−3·−4 + 1·−4 + 2·1·4)/4
        let expected = Matrix3::new(3.0, 4.0, 0.0, 4.0, 16.0, 0.0, 0.0, 0.0, 0.0);
        let off = (belief.covariance() - expected).abs().max();
        assert!(off < 1e-14, "{}", belief.covariance());
        assert!((belief.entropy() - 1.5 * 2f64.ln()).abs() < 1e-15);
        assert!((belief.entropy() / 2f64.ln() - belief.entropy_bits()).abs() < 1e-14);
    }

    #[test]
    fn headings_are_averaged_across_the_cut() {
        let (left, right) = (PI - 0.1, -PI + 0.3);
        let belief = plane(&[[0.0, 0.0, left], [0.0, 0.0, right]], &[1.0, 1.0]);
        let mean = belief.mean().heading_rad;
        assert!((wrapped(mean - (PI + 0.1))).abs() < 1e-12, "{mean}");
        assert!((belief.covariance()[(2, 2)] - 0.04).abs() < 1e-12);
        let cancel = plane(&[[0.0, 0.0, 0.0], [0.0, 0.0, PI]], &[1.0, 1.0]);
        assert_eq!(cancel.mean().heading_rad, 0.0);
        // A turn that goes with x shows beside the diagonal.
        let turning = plane(&[[-1.0, 0.0, -0.2], [1.0, 0.0, 0.2]], &[1.0, 1.0]);
        assert!((turning.covariance()[(0, 2)] - 0.2).abs() < 1e-12);
    }

    #[test]
    fn the_heading_of_the_mode_is_finer_than_cells_and_deaf_to_other_peaks() {
        // Headings 0 and 0.2 beside the mode; its reverse, and a peak far away, count for nothing.
        let belief = plane(
            &[[0.0; 3], [0.0, 0.0, 0.2], [0.5, 0.0, PI], [9.0, 0.0, 1.0]],
            &[3.0, 3.0, 2.9, 2.9],
        );
        let heading = belief.mode_heading_rad().unwrap();
        assert!((heading - 0.1).abs() < 1e-15, "{heading}");
        let route = Arc::new(Places::Route(vec![0.0, 1.0]));
        let along = Belief::uniform(&route).unwrap();
        assert_eq!(along.mode_heading_rad(), None);
    }

    #[test]
    fn the_predictive_likelihood_is_a_weighted_sum() {
        let belief = plane(&[[0.0; 3], [1.0, 0.0, 0.0]], &[3.0, 1.0]);
        let log_likelihood = [0.2f64.ln(), 0.6f64.ln()];
        let expected = (0.75f64 * 0.2 + 0.25 * 0.6).ln();
        assert!((belief.log_predictive(&log_likelihood) - expected).abs() < 1e-15);
        let tiny = [-5000.0, -5001.0];
        let expected = -5000.0 + (0.75 + 0.25 * (-1f64).exp()).ln();
        assert!((belief.log_predictive(&tiny) - expected).abs() < 1e-9);
        let certain = plane(&[[0.0; 3], [1.0, 0.0, 0.0]], &[0.0, 1.0]);
        let impossible = [0.0, f64::NEG_INFINITY];
        assert_eq!(certain.log_predictive(&impossible), f64::NEG_INFINITY);
        // A correction says the same.
        let mut corrected = belief.clone();
        let said = super::super::bayes::correct(&mut corrected, &log_likelihood).unwrap();
        assert!((said - belief.log_predictive(&log_likelihood)).abs() < 1e-15);
    }
}
