//! Where the robot was at every moment of a run, once the whole run is known: two-filter smoothing on a grid.
//!
//! A Bayes filter knows at a moment what was sensed until then. What is sensed afterwards says as much of that moment: of a robot
//! that started anywhere, it is all that tells where it started. The forward filter (Thrun 1998, Table 1) and one that goes
//! through the run backwards are multiplied (Fraser & Potter, *The optimum linear smoother as a combination of two optimum linear
//! filters*, IEEE Transactions on Automatic Control 14(4), 1969),
//!
//! Bel(ξ_t | z_1…z_T) ∝ Bel(ξ_t | z_1…z_t−1) · P(z_t | ξ_t) · Bel(ξ_t | z_t+1…z_T),
//!
//! of which the first and the last factor together are what all *other* observations say, and so a judge of z_t that has not
//! seen it. The backward filter moves by the reversed displacement with the same noise. That is the transposed motion model up to the
//! spread of headings within a step, and cells at the border.

use super::{
    bayes::{BayesFilter, correct},
    belief::Belief,
    grid::Grid,
    motion::OdometryMotion,
    places::Places,
};
use crate::{
    error::{Error, Result},
    geometry::{Displacement, Pose},
};
use std::sync::Arc;

/// Masses below this are not kept of the forward filter.
const LEAST_KEPT: f64 = 1e-12;

/// What a run says of one of its moments.
#[derive(Debug, Clone, PartialEq)]
pub struct Moment {
    /// Where the robot was then, by all observations.
    pub belief: Belief,
    /// ln Σ_ξ Bel(ξ) P(z|ξ) of the observation z of that moment, with the belief that the others give, in nats; −∞ where what came
    /// before and what came after exclude each other.
    pub by_others: f64,
    /// The same of a robot that may be anywhere, up to the same constant.
    pub anywhere: f64,
}

/// Which observations a moment's belief rests on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Knowing {
    /// Those before it and its own: the filter.
    ThePast,
    /// All of the run: forward filter times backward filter.
    TheRun,
}

/// Goes through a run of T moments from a belief at its start; `steps[t]` leads from moment t to the next one, and
/// `log_likelihood` is ln P(z_t | ξ) at every cell, `[cell]`, of the observation at moment t (asked for twice). The moments come to `visit`
/// with their numbers, each once, of [`Knowing::TheRun`] the last one first.
///
/// Where what came before a moment and what came after exclude each other (the robot was carried, or one of both is wrong), its
/// belief is that of the forward filter.
///
/// ```
/// use ballmark::{belief::{Belief, Grid, GridConfig, OdometryMotion, Places, smoothing::{Knowing, smooth}}, geometry::Displacement};
/// // A corridor whose only door is at 7 m: a robot that comes to it after 4 m of bare wall began at 3 m.
/// let grid = std::sync::Arc::new(Grid::along_route(0.0, 10.0, &GridConfig::default())?);
/// let Places::Route(cells) = &**grid.places() else { unreachable!() };
/// let door = |sees: bool| move |x: &f64| if ((x - 7.0).abs() < 0.5) == sees { 0.0 } else { 0.02_f64.ln() };
/// let mut sensed = |t: usize, _: &Belief| Ok(cells.iter().map(door(t == 4)).collect());
/// let ahead = [Displacement { forward_m: 1.0, left_m: 0.0, turn_rad: 0.0 }; 4];
/// let start = Belief::uniform(grid.places())?;
/// let mut began_m = 0.0;
/// smooth(&grid, &OdometryMotion::default(), start, &ahead, Knowing::TheRun, &mut sensed, &mut |t, moment| {
///     if t == 0 { began_m = moment.belief.mean().x_m }
///     Ok(())
/// })?;
/// assert!((began_m - 3.0).abs() < 0.2, "{began_m}");
/// # Ok::<(), ballmark::Error>(())
/// ```
///
/// # Errors
/// Where the start is about other cells, a step is not finite, or the likelihood is 0 wherever a belief has mass.
pub fn smooth(
    grid: &Arc<Grid>,
    motion: &OdometryMotion,
    start: Belief,
    steps: &[Displacement],
    knowing: Knowing,
    log_likelihood: &mut dyn FnMut(usize, &Belief) -> Result<Vec<f64>>,
    visit: &mut dyn FnMut(usize, Moment) -> Result<()>,
) -> Result<()> {
    let no_idea = Belief::uniform(grid.places())?;
    let mut forward = BayesFilter::new(grid, motion.clone(), start)?;
    let mut predicted = Vec::new();
    for t in 0..=steps.len() {
        if t > 0 {
            forward.predict(&steps[t - 1])?;
        }
        let likelihood = log_likelihood(t, forward.belief())?;
        if knowing == Knowing::TheRun {
            predicted.push(Sparse::of(forward.belief())?);
        }
        let by_others = forward.correct(&likelihood)?;
        if knowing == Knowing::ThePast {
            let moment = Moment {
                belief: forward.belief().clone(),
                by_others,
                anywhere: no_idea.log_predictive(&likelihood),
            };
            visit(t, moment)?;
        }
    }
    if knowing == Knowing::ThePast {
        return Ok(());
    }
    let mut backward = BayesFilter::new(grid, motion.clone(), no_idea.clone())?;
    while let Some(before) = predicted.pop() {
        let t = predicted.len();
        if let Some(step) = steps.get(t) {
            backward.predict(&reversed(step, grid.places()))?;
        }
        let after = backward.belief();
        let together = before.times(after.mass());
        let excluded = together.iter().all(|mass| *mass == 0.0);
        let mass = if excluded { before.dense() } else { together };
        let mut belief = Belief::from_mass(grid.places(), mass)?;
        let likelihood = log_likelihood(t, &belief)?;
        let by_others = correct(&mut belief, &likelihood)?;
        let moment = Moment {
            belief,
            by_others: if excluded {
                f64::NEG_INFINITY
            } else {
                by_others
            },
            anywhere: no_idea.log_predictive(&likelihood),
        };
        visit(t, moment)?;
        backward.correct(&likelihood)?;
    }
    Ok(())
}

/// The movement back.
fn reversed(step: &Displacement, places: &Places) -> Displacement {
    match places {
        // As long as the way, whatever the robot's headings are.
        Places::Route(_) => Displacement {
            forward_m: -step.along_route_m(),
            left_m: 0.0,
            turn_rad: -step.turn_rad,
        },
        Places::Plane(_) => {
            let here = Pose::default();
            here.after(*step).displacement_to(&here)
        }
    }
}

/// The masses of a belief that are not next to nothing.
struct Sparse {
    cells: usize,
    cell: Vec<u32>,
    mass: Vec<f32>,
}

impl Sparse {
    fn of(belief: &Belief) -> Result<Self> {
        let all = belief.mass();
        let kept = all.iter().enumerate().filter(|(_, m)| **m >= LEAST_KEPT);
        let number = |(cell, mass): (usize, &f64)| {
            let cell = u32::try_from(cell);
            cell.map(|cell| (cell, *mass as f32))
                .map_err(|_| Error::work("smoothing: more than 2^32 cells"))
        };
        let kept = kept.map(number).collect::<Result<Vec<_>>>()?;
        let (cell, mass) = kept.into_iter().unzip();
        Ok(Self {
            cells: all.len(),
            cell,
            mass,
        })
    }

    fn each(&self) -> impl Iterator<Item = (usize, f64)> {
        let cells = self.cell.iter().map(|&cell| cell as usize);
        cells.zip(self.mass.iter().map(|&mass| f64::from(mass)))
    }

    fn dense(&self) -> Vec<f64> {
        self.times(&vec![1.0; self.cells])
    }

    /// Cell by cell with other masses.
    fn times(&self, other: &[f64]) -> Vec<f64> {
        let mut product = vec![0.0; self.cells];
        for (cell, mass) in self.each() {
            product[cell] = mass * other[cell];
        }
        product
    }
}

#[cfg(test)]
mod tests;
