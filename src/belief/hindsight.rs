//! How well a place explains what a robot has sensed on its way there.
//!
//! A belief that was right and one that is wrong look alike when the robot has just been carried away: both were sure. What differs is the way
//! behind the robot. Whoever is where it believes itself to be was, a moment ago, where odometry says that it came from, and what it sensed
//! then must fit that place, too. So the last observations are kept as what they said of every cell, and any cell can be asked for the way that
//! leads to it.

use super::{Grid, Places, lost::MOST};
use crate::geometry::{Displacement, Pose};
use std::collections::VecDeque;

/// Most observations that are kept.
pub const KEPT: usize = 8;

/// The last observations, and how the robot has moved since each of them.
///
/// ```
/// use ballmark::{belief::{Belief, Grid, GridConfig, Hindsight, Places}, geometry::Displacement};
/// let grid = Grid::along_route(0.0, 10.0, &GridConfig::default())?;
/// let Places::Route(cells) = &**grid.places() else { unreachable!() };
/// // The robot passes a door, and 3 m on a window.
/// let near = |middle: f64| cells.iter().map(|x| if (x - middle).abs() < 0.3 { 0.0 } else { -2.0 }).collect::<Vec<f64>>();
/// let anywhere = Belief::uniform(grid.places())?;
/// let mut hindsight = Hindsight::default();
/// hindsight.sensed(&near(2.0), anywhere.log_predictive(&near(2.0)));
/// hindsight.moved(&Displacement { forward_m: 3.0, left_m: 0.0, turn_rad: 0.0 });
/// hindsight.sensed(&near(5.0), anywhere.log_predictive(&near(5.0)));
/// let at = |x: f64| hindsight.ratios(&grid, grid.cell_at(&Places::Route(vec![x]), 0).unwrap());
/// assert!(at(5.0).iter().all(|ratio| *ratio > 1.0)); // the window here, the door 3 m behind
/// assert!(at(8.0).iter().all(|ratio| *ratio < 0.0));
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct Hindsight {
    /// The newest first.
    kept: VecDeque<Kept>,
}

/// An observation.
#[derive(Debug, Clone)]
struct Kept {
    /// Of each cell ln P(z|ξ) / P(z|anywhere), no further from 0 than [`MOST`].
    ratio: Vec<f32>,
    /// The robot now, as seen from where it was then.
    since: Pose,
    /// How far it has come along its route.
    along_m: f64,
}

impl Hindsight {
    /// The robot moves, in its own frame.
    pub fn moved(&mut self, step: &Displacement) {
        for kept in &mut self.kept {
            kept.since = kept.since.after(*step);
            kept.along_m += step.along_route_m();
        }
    }

    /// An observation, as ln P(z|ξ) of every cell of a grid, and of a robot that may be anywhere on it, up to a constant that both share.
    pub fn sensed(&mut self, log_likelihood: &[f64], anywhere: f64) {
        let mut ratio = match self.kept.len() < KEPT {
            true => Vec::new(),
            false => self.kept.pop_back().map_or(Vec::new(), |kept| kept.ratio),
        };
        let bounded = |l: &f64| (l - anywhere).clamp(-MOST, MOST) as f32;
        ratio.clear();
        ratio.extend(log_likelihood.iter().map(bounded));
        self.kept.push_front(Kept {
            ratio,
            since: Pose::default(),
            along_m: 0.0,
        });
    }

    /// Forgets all.
    pub fn forget(&mut self) {
        self.kept.clear();
    }

    /// How much better than a robot that may be anywhere one explains each of the last observations that is in this cell of the grid now and
    /// came there as odometry says, in nats, the newest first. 0 where its way was off the grid, of which nothing is known.
    pub fn ratios(&self, grid: &Grid, cell: usize) -> Vec<f64> {
        let now = grid.places().pose(cell);
        let of_kept = |kept: &Kept| {
            let then = match **grid.places() {
                Places::Route(_) => Places::Route(vec![now.x_m - kept.along_m]),
                Places::Plane(_) => {
                    let back = kept.since.displacement_to(&Pose::default());
                    Places::Plane(vec![now.after(back)])
                }
            };
            let ratio = grid.cell_at(&then, 0).and_then(|cell| kept.ratio.get(cell));
            ratio.map_or(0.0, |ratio| f64::from(*ratio))
        };
        self.kept.iter().map(of_kept).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::belief::GridConfig;
    use std::f64::consts::FRAC_PI_2;

    fn ahead(forward_m: f64, turn_rad: f64) -> Displacement {
        Displacement {
            forward_m,
            left_m: 0.0,
            turn_rad,
        }
    }

    /// A robot drives east, turns left and drives north; what was seen two moves ago is asked two moves back, with that heading.
    #[test]
    fn the_way_is_followed_back_through_turns() {
        let corners = Places::Plane(vec![Pose::new(0.0, 0.0, 0.0), Pose::new(6.0, 6.0, 0.0)]);
        let config = GridConfig {
            margin_m: 7.0,
            headings: 8,
            ..GridConfig::default()
        };
        let grid = Grid::over(&corners, &config).unwrap();
        let only = |pose: Pose| {
            let there = grid.cell_of(&pose).unwrap();
            let of_cell = |cell: usize| if cell == there { 3.0 } else { -20.0 };
            (0..grid.len()).map(of_cell).collect::<Vec<f64>>()
        };
        let mut hindsight = Hindsight::default();
        hindsight.sensed(&only(Pose::new(0.0, 0.0, 0.0)), 0.0);
        hindsight.moved(&ahead(4.0, FRAC_PI_2));
        hindsight.sensed(&only(Pose::new(4.0, 0.0, FRAC_PI_2)), 0.0);
        hindsight.moved(&ahead(2.0, 0.0));
        let ratios = |x_m: f64, y_m: f64, heading_rad: f64| {
            let cell = grid.cell_of(&Pose::new(x_m, y_m, heading_rad)).unwrap();
            hindsight.ratios(&grid, cell)
        };
        assert_eq!(ratios(4.0, 2.0, FRAC_PI_2), [3.0, 3.0]);
        assert_eq!(ratios(4.0, 2.0, 0.0), [-MOST, -MOST]); // came from the south-west
        assert_eq!(ratios(6.0, 2.0, FRAC_PI_2), [-MOST, -MOST]);
        // The way of a robot in the corner leads through what nobody has mapped.
        assert_eq!(ratios(0.0, -6.9, FRAC_PI_2)[0], 0.0);
        hindsight.forget();
        assert!(hindsight.ratios(&grid, 0).is_empty());
    }

    #[test]
    fn a_route_is_followed_by_its_length_and_the_oldest_is_forgotten() {
        let grid = Grid::along_route(0.0, 20.0, &GridConfig::default()).unwrap();
        let cell = |x: f64| grid.cell_at(&Places::Route(vec![x]), 0).unwrap();
        let mut hindsight = Hindsight::default();
        for k in 0..KEPT + 2 {
            let mut said = vec![-1.0; grid.len()];
            said[cell(k as f64)] = k as f64;
            hindsight.sensed(&said, 0.0);
            hindsight.moved(&ahead(1.0, FRAC_PI_2)); // round the corner
        }
        let expected: Vec<f64> = (2..KEPT + 2).rev().map(|k| (k as f64).min(MOST)).collect();
        assert_eq!(hindsight.ratios(&grid, cell(10.0)), expected);
        hindsight.moved(&ahead(-3.0, 0.0));
        assert_eq!(hindsight.ratios(&grid, cell(7.0)), expected);
        assert_eq!(hindsight.ratios(&grid, cell(8.0)), [-1.0; KEPT]);
    }
}
