//! The Bayes filter: Table 1 of Thrun, *Bayesian Landmark Learning for Mobile Robot Localization*, Machine Learning 33,
//! 1998.

use super::{belief::Belief, grid::Grid, motion::OdometryMotion, transport};
use crate::{
    error::{Error, Result},
    geometry::Displacement,
};
use rayon::prelude::*;
use std::sync::Arc;

/// A robot that keeps track of where it may be.
///
/// Fig. 1 of the paper: a corridor with three doors. The robot does not know where it is (a); it sees a door (b), moves a
/// metre (c), sees a door again (d), and only one door has another a metre before it.
///
/// ```
/// use ballmark::{belief::{BayesFilter, Belief, Grid, GridConfig, OdometryMotion, Places}, geometry::Displacement};
/// let grid = std::sync::Arc::new(Grid::along_route(0.0, 10.0, &GridConfig::default())?);
/// let Places::Route(cells) = &**grid.places() else { unreachable!() };
/// let near_a_door = |x: f64| [2.0, 3.0, 7.0].iter().any(|door| (x - door).abs() < 0.25);
/// let door: Vec<f64> = cells.iter().map(|&x| if near_a_door(x) { 0.8_f64 } else { 0.1 }.ln()).collect();
/// let [truth, wrong, ahead] = [3.0, 7.0, 8.0].map(|x| Places::Route(vec![x]));
///
/// let mut robot = BayesFilter::new(&grid, OdometryMotion::default(), Belief::uniform(grid.places())?)?;  // (a)
/// robot.correct(&door)?;                                                                           // (b)
/// let three_peaks = robot.belief().clone();
/// assert!((three_peaks.mass_within_m(&truth, 0, 0.25) - three_peaks.mass_within_m(&wrong, 0, 0.25)).abs() < 1e-12);
/// robot.predict(&Displacement { forward_m: 1.0, left_m: 0.0, turn_rad: 0.0 })?;                    // (c)
/// let (peak, moved) = (three_peaks.mass_within_m(&wrong, 0, 0.25), robot.belief().mass_within_m(&ahead, 0, 0.25));
/// assert!(moved > 0.8 * peak && moved < peak); // shifted, and slightly flattened
/// robot.correct(&door)?;                                                                           // (d)
/// assert!(robot.belief().mass_within_m(&truth, 0, 0.5) > 4.0 * robot.belief().mass_within_m(&wrong, 0, 0.5));
/// assert!(robot.belief().point_error_m(&truth, 0) < 0.25);
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct BayesFilter {
    grid: Arc<Grid>,
    motion: OdometryMotion,
    belief: Belief,
}

impl BayesFilter {
    /// 1. Initialisation: Bel(ξ) ← Bel_prior(ξ⁽⁰⁾).
    ///
    /// # Errors
    /// Where the prior is not about the cells of `grid`, or `motion` makes no sense.
    pub fn new(grid: &Arc<Grid>, motion: OdometryMotion, prior: Belief) -> Result<Self> {
        if prior.places() != grid.places() {
            return Err(not_its_cells());
        }
        Ok(Self {
            grid: Arc::clone(grid),
            motion: motion.checked()?,
            belief: prior,
        })
    }

    /// 2. For each observed feature vector: [`correct`], with its result and errors.
    pub fn correct(&mut self, log_likelihood: &[f64]) -> Result<f64> {
        correct(&mut self.belief, log_likelihood)
    }

    /// 3. For each action: [`predict`], with its errors.
    pub fn predict(&mut self, step: &Displacement) -> Result<()> {
        predict(&mut self.belief, &self.grid, &self.motion, step)
    }

    /// Begins anew with another belief.
    ///
    /// # Errors
    /// Where it is not about the cells of the grid.
    pub fn restart(&mut self, belief: Belief) -> Result<()> {
        if belief.places() != self.grid.places() {
            return Err(not_its_cells());
        }
        self.belief = belief;
        Ok(())
    }

    /// Bel(ξ), over the cells of the grid.
    pub fn belief(&self) -> &Belief {
        &self.belief
    }

    /// The cells.
    pub fn grid(&self) -> &Arc<Grid> {
        &self.grid
    }
}

/// Bel(ξ) ← P(f|ξ) Bel(ξ), normalised (eq. 17, 18). `log_likelihood` is ln P(f|ξ) at each place of the belief, up to a
/// constant; any sensor model will do.
///
/// Returns ln P(f) = ln Σ_ξ P(f|ξ) Bel(ξ), how likely the belief held the observation to be, up to the same constant.
///
/// # Errors
/// Where the lengths differ, a value is NaN or +∞, or the likelihood is 0 wherever the belief has mass: the belief stays as
/// it was.
pub fn correct(belief: &mut Belief, log_likelihood: &[f64]) -> Result<f64> {
    if log_likelihood.len() != belief.mass().len() {
        let (values, places) = (log_likelihood.len(), belief.mass().len());
        return Err(Error::work(format!(
            "likelihood: {values} values for {places} places"
        )));
    }
    // Only places that are believed in may set the scale: if the best of all places were far off, all the others could
    // underflow together.
    let pairs = belief.mass().par_iter().zip(log_likelihood);
    let (best, valid) = pairs
        .map(|(&mass, &l)| {
            let counts = if mass > 0.0 { l } else { f64::NEG_INFINITY };
            (counts, l < f64::INFINITY) // false for NaN too
        })
        .reduce(
            || (f64::NEG_INFINITY, true),
            |a, b| (a.0.max(b.0), a.1 && b.1),
        );
    if !valid {
        return Err(Error::work("likelihood: a value is NaN or infinite"));
    }
    if best == f64::NEG_INFINITY {
        return Err(Error::work(
            "likelihood: 0 at every place that the belief holds possible; expected a floor for the unmodelled",
        ));
    }
    let masses = belief.mass_mut().par_iter_mut();
    masses.zip(log_likelihood).for_each(|(mass, l)| {
        if *mass > 0.0 {
            *mass *= (l - best).exp();
        }
    });
    Ok(best + belief.normalise().ln())
}

/// Bel(ξ) ← ∫ P(ξ|ξ̃, a) Bel(ξ̃) dξ̃ (eq. 19), with the movement that odometry reports, in the robot's frame, as a.
///
/// Along a route the step counts with its length, forwards or backwards. Mass that would end off the grid is dropped
/// and normalising makes up for it, since the robot is on the grid; a belief that would leave as a whole stays where it was
/// (see [`OdometryMotion::stall_probability`]).
///
/// # Errors
/// Where the movement is not finite, or the belief is not about the cells of `grid`: the belief stays as it was.
pub fn predict(
    belief: &mut Belief,
    grid: &Grid,
    motion: &OdometryMotion,
    step: &Displacement,
) -> Result<()> {
    if !(step.forward_m + step.left_m + step.turn_rad).is_finite() {
        return Err(Error::work(format!("odometry: {step:?} is not a movement")));
    }
    if belief.mass().len() != grid.len() {
        return Err(not_its_cells());
    }
    let moved = transport::moved(grid, motion, step, belief.mass());
    *belief.mass_mut() = moved;
    belief.normalise();
    Ok(())
}

fn not_its_cells() -> Error {
    Error::work("belief: its places are not the cells of the grid")
}
