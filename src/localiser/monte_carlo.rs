//! Monte Carlo localisation with an occupancy map: what most users of a laser scanner have (AMCL of the Robot Operating System
//! is of its kind).
//!
//! The belief is a set of weighted poses (Thrun, Burgard & Fox, *Probabilistic Robotics*, 2005, below PR, 8.3): each moves as
//! odometry says, with noise drawn from the motion model, and is weighed by the map's likelihood field. Where few
//! particles hold most of the weight they are drawn anew: as many as the belief's spread asks for (KLD sampling, PR
//! table 8.4), some of them anywhere while scans fit worse than they used to (augmented MCL, PR table 8.3).
//!
//! Motion, likelihood and the places that the robot can be at are those of the grid's filter, so the two differ in how they
//! hold a belief alone.

mod config;
mod kld;
mod particles;
mod recovery;

pub use config::MonteCarloConfig;

use super::{Estimate, Localiser, Step, TrialRunner, prepared::Prepared};
use crate::{
    belief::{Grid, OdometryMotion, Places},
    error::{Error, Result},
    geometry::{Pose, wrapped},
    mapping::{Beam, LikelihoodField},
    recording::{Channel, Recording},
    seed::Stream,
};
use config::USUAL_SCALE;
use kld::Bins;
use particles::Particles;
use rand::RngExt;
use rand_distr::StandardNormal;
use rayon::prelude::*;
use recovery::Recovery;
use std::{f64::consts::TAU, sync::Arc};

/// Particles are drawn anew where their effective number is below this share of them.
const LEAST_EFFECTIVE: f64 = 0.5;
/// Particles that one thread weighs at least.
const PARTICLES_A_TASK: usize = 512;
/// Draws about a known start, until one is on the grid.
const DRAWS_ABOUT_START: usize = 20;

/// A map's likelihood field, and how particles are moved and drawn.
///
/// ```
/// use ballmark::{belief::{Grid, GridConfig, OdometryMotion, Places}, localiser::{Localiser, monte_carlo::*}, seed::Seed};
/// use ballmark::mapping::{LikelihoodField, LikelihoodFieldConfig, OccupancyMap, OccupancyMapConfig};
/// use ballmark::world::{Building, simulate};
/// use std::sync::Arc;
/// let run = simulate(&Building::read("configs/worlds/ruizmayor2006-r1.toml".as_ref())?, Seed(1), &Default::default())?;
/// let all: Vec<usize> = (0..run.len()).collect();
///
/// let map = OccupancyMap::from_scans(&run, &all, &OccupancyMapConfig::default())?;
/// let field = Arc::new(LikelihoodField::new(&map, &LikelihoodFieldConfig::default())?);
/// let places = Places::Plane(run.poses().to_vec());
/// let grid = Arc::new(Grid::over(&places, &GridConfig::default())?);
/// let config = MonteCarloConfig { particles: 2000, ..MonteCarloConfig::default() };
/// let monte_carlo = MonteCarlo::new(field, OdometryMotion::default(), grid, config)?;
///
/// let player = monte_carlo.prepare(&run, &all)?;
/// let [start, truth] = [0, 14].map(|k| run.poses()[k]);
/// let steps = player.play(&all[..15], Some(start), &mut Seed(1).stream("a trial"))?;
/// let off_m = |place: &[f64; 2]| (place[0] - truth.x_m).hypot(place[1] - truth.y_m);
/// let expected_error_m: f64 = steps[14].posterior.iter().map(|(place, p)| p * off_m(place)).sum();
/// assert!(expected_error_m < 0.3, "{expected_error_m}");
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct MonteCarlo {
    field: Arc<LikelihoodField>,
    motion: OdometryMotion,
    grid: Arc<Grid>,
    config: MonteCarloConfig,
    /// Power of a scan's evidence.
    scale: f64,
    /// The range sensors that the map was made with, where it takes no others.
    sensors: Option<Vec<Channel>>,
}

impl MonteCarlo {
    /// Particles start, and are drawn at random, over the cells of `grid`, which they do not leave. Any range sensor whose
    /// beams have bearings will do; see [`MonteCarlo::with_sensors_of`].
    ///
    /// # Errors
    /// Where the grid lies along a route, or a constant or noise makes no sense (a usage error that names it).
    pub fn new(
        field: Arc<LikelihoodField>,
        motion: OdometryMotion,
        grid: Arc<Grid>,
        config: MonteCarloConfig,
    ) -> Result<Self> {
        config.check()?;
        if matches!(**grid.places(), Places::Route(_)) {
            return Err(Error::work(
                "monte_carlo: the grid lies along a route; expected one in the plane, as a map asks for poses",
            ));
        }
        Ok(Self {
            field,
            motion: motion.checked()?,
            grid,
            scale: config.evidence_scale.unwrap_or(USUAL_SCALE),
            config,
            sensors: None,
        })
    }

    /// The same, for recordings with the range sensors among these channels alone: those that the map was made with, say.
    ///
    /// # Errors
    /// Where none of them is a range sensor whose beams have bearings.
    pub fn with_sensors_of(mut self, channels: &[Channel]) -> Result<Self> {
        self.check_channels(channels)?;
        let sensors = channels.iter().filter(|channel| has_beams(channel));
        self.sensors = Some(sensors.cloned().collect());
        Ok(self)
    }

    /// The pose of a robot that may be anywhere: even over the cells, and within them.
    fn anywhere(&self, stream: &mut Stream) -> Pose {
        let centre = self
            .grid
            .places()
            .pose(stream.random_range(0..self.grid.len()));
        let [east, north, turn] = [(); 3].map(|()| stream.random_range(-0.5..0.5));
        let (cell_m, cell_rad) = (self.grid.cell_m(), TAU / self.grid.headings() as f64);
        Pose::new(
            centre.x_m + east * cell_m,
            centre.y_m + north * cell_m,
            wrapped(centre.heading_rad + turn * cell_rad),
        )
    }

    /// The pose of a robot that is put down here, or at the nearest cell where that is off the grid.
    fn about(&self, start: &Pose, stream: &mut Stream) -> Pose {
        let MonteCarloConfig {
            start_spread_m,
            start_spread_rad,
            ..
        } = self.config;
        for _ in 0..DRAWS_ABOUT_START {
            let [east, north, turn]: [f64; 3] = [(); 3].map(|()| stream.sample(StandardNormal));
            let pose = Pose::new(
                start.x_m + start_spread_m * east,
                start.y_m + start_spread_m * north,
                wrapped(start.heading_rad + start_spread_rad * turn),
            );
            if self.grid.cell_of(&pose).is_some() {
                return pose;
            }
        }
        let cells = self.grid.places();
        let away_m = |&cell: &usize| cells.pose(cell).distance_m(start);
        let nearest = (0..self.grid.len() / self.grid.headings())
            .min_by(|a, b| away_m(a).total_cmp(&away_m(b)));
        Pose {
            heading_rad: start.heading_rad,
            ..cells.pose(nearest.unwrap_or(0))
        }
    }

    /// A particle that is drawn again, a little beside where it was, unless that is off the grid.
    fn roughened(&self, pose: Pose, stream: &mut Stream) -> Pose {
        let MonteCarloConfig {
            roughening_m,
            roughening_rad,
            ..
        } = self.config;
        if roughening_m == 0.0 && roughening_rad == 0.0 {
            return pose;
        }
        let [east, north, turn]: [f64; 3] = [(); 3].map(|()| stream.sample(StandardNormal));
        let rough = Pose::new(
            pose.x_m + roughening_m * east,
            pose.y_m + roughening_m * north,
            wrapped(pose.heading_rad + roughening_rad * turn),
        );
        match self.grid.cell_of(&rough) {
            Some(_) => rough,
            None => pose,
        }
    }

    /// As many draws as KLD sampling asks for (PR table 8.4).
    fn enough(&self, mut draw: impl FnMut() -> Pose) -> Particles {
        let mut bins = Bins::new(&self.config);
        let mut poses = Vec::new();
        while poses.len() < bins.enough() {
            let pose = draw();
            bins.add(&pose);
            poses.push(pose);
        }
        Particles::new(poses)
    }
}

/// Does it hold ranges whose directions are known?
fn has_beams(channel: &Channel) -> bool {
    channel.unit == "m" && channel.bearing_rad.is_some()
}

impl Localiser for MonteCarlo {
    fn name(&self) -> &'static str {
        "monte_carlo"
    }

    fn places(&self) -> usize {
        0
    }

    fn bytes_per_place(&self) -> usize {
        0
    }

    fn asks_for_the_start(&self) -> bool {
        true
    }

    fn can_start_anywhere(&self) -> bool {
        true
    }

    fn evidence_scale(&self) -> Option<f64> {
        Some(self.scale)
    }

    fn with_evidence_scale(&self, scale: f64) -> Option<Box<dyn Localiser + '_>> {
        let is_stated = self.config.evidence_scale.is_some();
        let scaled = || Self {
            scale,
            ..self.clone()
        };
        (!is_stated).then(|| Box::new(scaled()) as Box<dyn Localiser>)
    }

    fn check_channels(&self, channels: &[Channel]) -> Result<()> {
        for wanted in self.sensors.iter().flatten() {
            let known = |channel: &&Channel| channel.name == wanted.name;
            let fault = match channels.iter().find(known) {
                None => format!("no channel `{}`", wanted.name.escape_debug()),
                Some(channel)
                    if (channel.width, &channel.unit, &channel.bearing_rad)
                        != (wanted.width, &wanted.unit, &wanted.bearing_rad) =>
                {
                    format!("channel `{}` has other beams", channel.name.escape_debug())
                }
                Some(_) => continue,
            };
            return Err(Error::work(format!(
                "monte_carlo: {fault}; expected {} ranges in the directions of the map's sensor",
                wanted.width
            )));
        }
        if !channels.iter().any(has_beams) {
            let names: Vec<&str> = channels.iter().map(|c| c.name.as_str()).collect();
            return Err(Error::work(format!(
                "monte_carlo: no channel among {} is in metres and has bearings; expected a range sensor",
                names.join(", ").escape_debug()
            )));
        }
        Ok(())
    }

    fn prepare<'a>(
        &'a self,
        recording: &'a Recording,
        snapshots: &[usize],
    ) -> Result<Box<dyn TrialRunner + 'a>> {
        self.check_channels(recording.channels())?;
        let channels = recording.channels();
        let beams = |&k: &usize| self.field.beams(channels, &recording.observation(k));
        let beams: Result<Vec<Vec<Beam>>> = snapshots.iter().map(beams).collect();
        Ok(Box::new(Runner {
            monte_carlo: self,
            recording,
            beams: Prepared::new(snapshots, beams?),
        }))
    }
}

/// Monte Carlo localisation with a recording before it.
struct Runner<'a> {
    monte_carlo: &'a MonteCarlo,
    recording: &'a Recording,
    beams: Prepared<Vec<Beam>>,
}

impl TrialRunner for Runner<'_> {
    fn play(&self, trial: &[usize], start: Option<Pose>, stream: &mut Stream) -> Result<Vec<Step>> {
        let mut robot = Robot::new(self.monte_carlo, start, stream);
        let step = |&k: &usize| {
            let odometry = self.recording.observation(k).odometry;
            robot.observe(odometry, self.beams.get(k)?, stream)
        };
        trial.iter().map(step).collect()
    }
}

/// A robot in the middle of a trial.
struct Robot<'a> {
    monte_carlo: &'a MonteCarlo,
    particles: Particles,
    recovery: Recovery,
    last: Option<Pose>,
}

impl<'a> Robot<'a> {
    fn new(monte_carlo: &'a MonteCarlo, start: Option<Pose>, stream: &mut Stream) -> Self {
        let config = &monte_carlo.config;
        Self {
            monte_carlo,
            particles: monte_carlo.enough(|| match &start {
                Some(start) => monte_carlo.about(start, stream),
                None => monte_carlo.anywhere(stream),
            }),
            recovery: Recovery::new(config.slow_decay, config.fast_decay),
            last: None,
        }
    }

    /// PR table 8.3 for one scan. The answer is of the weighted particles, before they are drawn anew: that would only add
    /// noise, and places drawn at random are no opinion before a scan has weighed them.
    fn observe(&mut self, odometry: Pose, beams: &[Beam], stream: &mut Stream) -> Result<Step> {
        let MonteCarlo { grid, motion, .. } = self.monte_carlo;
        if let Some(last) = self.last.replace(odometry) {
            let step = last.displacement_to(&odometry);
            if !(step.forward_m + step.left_m + step.turn_rad).is_finite() {
                return Err(Error::work(format!("odometry: {step:?} is not a movement")));
            }
            self.particles.advance(grid, motion, &step, stream);
        }
        if !beams.is_empty() {
            self.weigh(beams);
        }
        let posterior = self.particles.posterior();
        let MonteCarloConfig {
            kld_bin_m,
            kld_bin_rad,
            ..
        } = self.monte_carlo.config;
        let place = particles::heaviest_place(&posterior, kld_bin_m);
        // Of the particles whose mean the place is, or nearly: those in its bin and the neighbours.
        let about = |place| {
            let radius_m = 1.5 * kld_bin_m;
            self.particles.heading_about(place, radius_m, kld_bin_rad)
        };
        let heading_rad = place.and_then(about);
        if !beams.is_empty() {
            self.draw_anew(stream);
        }
        Ok(Step {
            estimate: place.map(Estimate::Place),
            heading_rad,
            posterior,
        })
    }

    fn weigh(&mut self, beams: &[Beam]) {
        let MonteCarlo { field, scale, .. } = self.monte_carlo;
        let poses = self.particles.poses().par_iter();
        let log_likelihood: Vec<f64> = poses
            .with_min_len(PARTICLES_A_TASK)
            .map(|pose| scale * field.log_likelihood(pose, beams))
            .collect();
        let log_predictive = self.particles.correct(&log_likelihood);
        // w_avg of table 8.3, but of one beam, as the geometric mean over all: whole scans differ by tens of powers of ten,
        // and by how many beams came back.
        let counted = scale * beams.len() as f64;
        self.recovery.add((log_predictive / counted).exp());
    }

    fn draw_anew(&mut self, stream: &mut Stream) {
        let count = self.particles.poses().len() as f64;
        let random_share = self.recovery.random_share();
        let is_degenerate = self.particles.effective_number() < LEAST_EFFECTIVE * count;
        if !is_degenerate && random_share * count < 1.0 {
            return;
        }
        let mut kept = self.particles.draws(stream.random());
        let drawn = self.monte_carlo.enough(|| {
            let is_random = stream.random::<f64>() < random_share;
            let kept = match is_random {
                true => None,
                false => kept
                    .next()
                    .map(|pose| self.monte_carlo.roughened(pose, stream)),
            };
            kept.unwrap_or_else(|| self.monte_carlo.anywhere(stream))
        });
        drop(kept);
        self.particles = drawn;
    }
}

#[cfg(test)]
mod tests;
