//! How sure a live robot is of its place.

use super::{super::lost::NEAR_M, LiveLocaliser};
use crate::{belief::Mode, geometry::Pose};
use nalgebra::Matrix3;

/// A peak of less than this share of the belief is no mode.
pub const LEAST_MODE: f64 = 0.05;

impl LiveLocaliser {
    /// [`Belief::mean`](crate::belief::Belief::mean): mean of x and y, circular mean of the heading.
    pub fn mean(&self) -> Pose {
        self.belief().mean()
    }

    /// [`Belief::covariance`](crate::belief::Belief::covariance) of x, y (m²) and heading (rad²) about that mean.
    pub fn covariance(&self) -> Matrix3<f64> {
        self.belief().covariance()
    }

    /// The centre of the cell of the largest mass.
    pub fn mode(&self) -> Pose {
        self.belief().places().pose(self.belief().mode())
    }

    /// [`Belief::modes`](crate::belief::Belief::modes): every separate place, 1 m wide, that holds a twentieth of the mass or more,
    /// with its share, the heaviest first. Two of them: the robot is at one of two places that it can't tell apart; none: it may
    /// be in many.
    pub fn modes(&self) -> Vec<Mode> {
        self.belief().modes(NEAR_M, LEAST_MODE)
    }

    /// [`Belief::entropy`](crate::belief::Belief::entropy), in nats.
    pub fn entropy(&self) -> f64 {
        self.belief().entropy()
    }

    /// Mass of all places no farther than `radius_m` from the mode, any heading: how sure the robot is of it.
    pub fn mass_within(&self, radius_m: f64) -> f64 {
        let (belief, mode) = (self.belief(), self.belief().mode());
        belief.mass_within_m(belief.places(), mode, radius_m)
    }

    /// Expected distance from the mode to the truth, as the belief has it, in metres.
    pub fn spread_m(&self) -> f64 {
        let (belief, mode) = (self.belief(), self.belief().mode());
        belief.expected_error_m(belief.places(), mode)
    }

    /// How well the mode explains what was sensed, in nats: the mean of ln [P(z | where the robot was then, if it is at the mode now) / P(z | anywhere
    /// on the grid)] over the last observations z, later ones counting more ([`LostConfig::short`](crate::localiser::LostConfig)); 0 before the first
    /// one.
    ///
    /// As long as the robot is where it believes, that explains better than any place would, and the mean is above 0. A
    /// robot that was carried away, or has left the map, is sure of places where it is not; there its sensors contradict it
    /// again and again, and the mean falls below 0.
    pub fn explains(&self) -> f64 {
        self.lost.mean(&self.ratios())
    }

    fn ratios(&self) -> Vec<f64> {
        self.hindsight.ratios(self.grid(), self.belief().mode())
    }

    /// Between 0 and 1, how much speaks for the mode being more than 1 m from the truth
    /// ([`LostConfig::score`](crate::localiser::LostConfig::score)): near 1 while the belief has little of its mass within 1 m of
    /// the mode, and where the sensors contradict a belief that is sure. `ballmark localise` judges such scores on runs never seen
    /// and prints the constants that a recording's validation part asks for (`confidence.score` in its JSON);
    /// [`LiveConfig::lost`](super::LiveConfig::lost) takes them.
    pub fn lost_score(&self) -> f64 {
        self.lost.score(self.mass_within(NEAR_M), &self.ratios())
    }

    /// Is the robot lost, by [`LiveLocaliser::lost_score`] and the threshold of [`LostConfig`](crate::localiser::LostConfig)?
    ///
    /// Where nothing can be told apart, sensors don't contradict anything: a robot that was carried from one such place to another
    /// is not noticed before it comes to others.
    pub fn lost(&self) -> bool {
        self.lost_score() >= self.lost.threshold
    }
}
