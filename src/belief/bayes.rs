//! The Bayes filter: Table 1 of Thrun, *Bayesian Landmark Learning for Mobile Robot Localization*, Machine Learning 33,
//! 1998.

use super::{
    belief::Belief,
    correction,
    grid::Grid,
    motion::OdometryMotion,
    support::{BLOCK, Support},
    transport::{self, Workspace},
};
use crate::{
    error::{Error, Result},
    geometry::Displacement,
};
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
///
/// It keeps track of where the belief has mass, in blocks of 64 cells, and passes by all others: a settled belief costs what
/// the cells around it cost, however large the grid. A mass below 10⁻¹⁰⁰ counts as none, so that a step over n cells drops
/// less than n · 10⁻¹⁰⁰. From the first movement on it holds a second array of masses to work in.
#[derive(Debug, Clone)]
pub struct BayesFilter {
    grid: Arc<Grid>,
    motion: OdometryMotion,
    belief: Belief,
    support: Support,
    workspace: Workspace,
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
            support: Support::everywhere(grid.len(), grid.lattice().len()),
            workspace: Workspace::default(),
        })
    }

    /// 2. For each observed feature vector: [`correct`], with its result and errors.
    pub fn correct(&mut self, log_likelihood: &[f64]) -> Result<f64> {
        correct_within(&mut self.belief, &mut self.support, log_likelihood)
    }

    /// 3. For each action: [`predict`], with its errors.
    pub fn predict(&mut self, step: &Displacement) -> Result<()> {
        predict_within(
            &mut self.belief,
            &self.grid,
            &self.motion,
            step,
            &mut self.support,
            &mut self.workspace,
        )
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
        self.support.held_mut().fill(true);
        Ok(())
    }

    /// Bel(ξ) ← (1 − share) Bel(ξ) + share · other(ξ): the robot may have been carried away, to where `other` says. With the
    /// uniform belief this is what random particles are to a particle filter (Thrun, Burgard & Fox, *Probabilistic Robotics*,
    /// 2005, 8.3.5).
    ///
    /// # Errors
    /// Where `other` is not about the cells of the grid (work), or `share` isn't in 0 to 1 (usage): the belief stays.
    pub fn mix(&mut self, other: &Belief, share: f64) -> Result<()> {
        if other.places() != self.grid.places() {
            return Err(not_its_cells());
        }
        if !(0.0..=1.0).contains(&share) {
            return Err(Error::usage(format!(
                "belief: a share of {share} to mix in; expected 0 to 1"
            )));
        }
        if share > 0.0 {
            self.belief.mix(other.mass(), share);
            self.support.held_mut().fill(true);
        }
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
    const TOGETHER: usize = 64 * BLOCK;
    let cells = belief.mass().len();
    let mut support = Support::everywhere(cells, TOGETHER.min(cells));
    correct_within(belief, &mut support, log_likelihood)
}

/// [`correct`] where the belief has mass, according to `support`, which is what it is after as well.
fn correct_within(
    belief: &mut Belief,
    support: &mut Support,
    log_likelihood: &[f64],
) -> Result<f64> {
    if log_likelihood.len() != belief.mass().len() {
        let (values, places) = (log_likelihood.len(), belief.mass().len());
        return Err(Error::work(format!(
            "likelihood: {values} values for {places} places"
        )));
    }
    correction::weigh(belief.mass_mut(), support, log_likelihood)
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
    let mut support = Support::everywhere(grid.len(), grid.lattice().len());
    let mut workspace = Workspace::default();
    predict_within(belief, grid, motion, step, &mut support, &mut workspace)
}

fn predict_within(
    belief: &mut Belief,
    grid: &Grid,
    motion: &OdometryMotion,
    step: &Displacement,
    support: &mut Support,
    workspace: &mut Workspace,
) -> Result<()> {
    if !(step.forward_m + step.left_m + step.turn_rad).is_finite() {
        return Err(Error::work(format!("odometry: {step:?} is not a movement")));
    }
    if belief.mass().len() != grid.len() {
        return Err(not_its_cells());
    }
    let mass = belief.mass_mut();
    transport::step(grid, motion, step, mass, support, workspace);
    Ok(())
}

fn not_its_cells() -> Error {
    Error::work("belief: its places are not the cells of the grid")
}

#[cfg(test)]
mod tests {
    use super::{super::belief::NEGLIGIBLE, *};
    use crate::{
        belief::{
            Places,
            laws::{bend, corridor, grid, step},
        },
        geometry::Pose,
    };

    /// Where there is 10⁻⁹⁹ of the mass, 10⁻¹⁰¹ and the rest; nothing moves.
    #[test]
    fn only_what_is_below_the_threshold_is_dropped() {
        let grid = grid(&corridor());
        let mut mass = vec![0.0; grid.len()];
        (mass[2], mass[30], mass[50]) = (1e-99, 1.0, 1e-101);
        let belief = Belief::from_mass(grid.places(), mass.clone()).unwrap();
        let mut robot = BayesFilter::new(&grid, OdometryMotion::exact(), belief).unwrap();
        for _ in 0..2 {
            robot.predict(&step(0.0, 0.0, 0.0)).unwrap();
            robot.correct(&vec![-1.0; grid.len()]).unwrap();
            for (cell, (now, start)) in robot.belief().mass().iter().zip(&mass).enumerate() {
                assert!((now - start).abs() < NEGLIGIBLE + 1e-12 * start, "{cell}");
            }
            assert_eq!(robot.belief().mass()[50], 0.0);
        }
    }

    #[test]
    fn passing_by_cells_without_mass_changes_no_bit() {
        let here = Places::Plane(vec![Pose::new(2.0, 0.1, 0.4)]);
        for (mapped, start) in [(bend(), here), (corridor(), Places::Route(vec![3.0]))] {
            let grid = grid(&mapped);
            let prior = Belief::around(grid.places(), &start, 0, 0.1, 0.1).unwrap();
            let motion = OdometryMotion {
                rotation_floor_rad: 0.3,
                translation_floor_m: 0.2,
                ..OdometryMotion::default()
            };
            let mut selective = BayesFilter::new(&grid, motion, prior).unwrap();
            let mut full = selective.clone();
            let mut passed_by = 0;
            for t in 0..30 {
                full.support.held_mut().fill(true);
                let forward_m = if t % 8 < 4 { 0.4 } else { -0.35 };
                for robot in [&mut selective, &mut full] {
                    robot.predict(&step(forward_m, 0.05, 0.2)).unwrap();
                }
                assert_eq!(selective.belief(), full.belief(), "step {t}");
                let log: Vec<f64> = (0..grid.len())
                    .map(|cell| -40.0 * grid.places().distance_m(cell, &start, 0).min(3.0))
                    .collect();
                full.support.held_mut().fill(true);
                let evidence =
                    [&mut selective, &mut full].map(|robot| robot.correct(&log).unwrap());
                assert_eq!(evidence[0], evidence[1]);
                assert_eq!(selective.belief(), full.belief(), "correction {t}");
                let held = selective.support.held();
                passed_by += held.iter().filter(|held| !**held).count();
                for (blocks, masses) in held
                    .chunks(selective.support.blocks())
                    .zip(selective.belief().mass().chunks(selective.support.sites()))
                {
                    for (held, masses) in blocks.iter().zip(masses.chunks(BLOCK)) {
                        assert_eq!(*held, masses.iter().any(|m| *m > 0.0));
                    }
                }
            }
            assert!(
                matches!(mapped, Places::Route(_)) || passed_by > 30,
                "{passed_by}"
            );
        }
    }

    #[test]
    fn what_is_mixed_in_is_looked_at_everywhere() {
        let grid = grid(&corridor());
        let mut sharp = vec![0.0; grid.len()];
        sharp[3] = 1.0;
        let start = Belief::from_mass(grid.places(), sharp).unwrap();
        let anywhere = Belief::uniform(grid.places()).unwrap();
        let mut robot = BayesFilter::new(&grid, OdometryMotion::exact(), start).unwrap();
        robot.correct(&vec![0.0; grid.len()]).unwrap(); // from here on only where there is mass
        robot.mix(&anywhere, 0.25).unwrap();
        let n = grid.len() as f64;
        let mass = robot.belief().mass();
        assert!((mass[3] - (0.75 + 0.25 / n)).abs() < 1e-12);
        assert!((mass[30] - 0.25 / n).abs() < 1e-12);
        let mut door = vec![-20.0; grid.len()];
        door[30] = 0.0;
        robot.correct(&door).unwrap();
        assert_eq!(robot.belief().mode(), 30);
        let before = robot.belief().clone();
        for share in [-0.1, 1.1, f64::NAN] {
            assert!(robot.mix(&anywhere, share).unwrap_err().is_usage());
        }
        assert_eq!(robot.belief(), &before);
    }

    #[test]
    fn a_new_belief_is_looked_at_everywhere() {
        let grid = grid(&bend());
        let at = |x_m: f64| {
            let place = Places::Plane(vec![Pose::new(x_m, 0.0, 0.0)]);
            Belief::around(grid.places(), &place, 0, 0.05, 0.1).unwrap()
        };
        let movement = step(0.3, 0.0, 0.1);
        let mut robot = BayesFilter::new(&grid, OdometryMotion::default(), at(0.5)).unwrap();
        robot.predict(&movement).unwrap();
        robot.restart(at(5.0)).unwrap();
        robot.predict(&movement).unwrap();
        let mut fresh = at(5.0);
        predict(&mut fresh, &grid, &OdometryMotion::default(), &movement).unwrap();
        assert_eq!(robot.belief(), &fresh);
    }
}
