//! Correction by the nearest of the perceptions expected around the predicted pose (Ruiz-Mayor et al., *A performance metric
//! for mobile robot localization*, 2006, below R06, 4.1).
//!
//! It is given the pose at which a trial starts and reckons by odometry. After every half metre it lays a grid of poses around the
//! reckoned one, works out from the plan of the building what its sensors would read at each (H), and goes on from the
//! pose whose expected perception is nearest to what was sensed, x̂ = H⁻¹(f_nn(z, H(G_LP))) (eq. 4-1).
//!
//! R06 calls 40 cm the grid's radius "from its centre", and the most that a correction can make up for; so positions are
//! those lattice points that lie in the disc: 49 at the printed constants, where a square would have 81, with corners
//! 57 cm away. Its axes are those of the plan. Of several poses as near, that nearest to the reckoned one counts.

use super::{Estimate, Learn, Localiser, Step, TrialRunner};
use crate::{
    error::{Error, Result},
    geometry::{Pose, wrapped},
    recording::{Channel, Recording},
    seed::{Seed, Stream},
    world::ExpectedRanges,
};
use serde::{Deserialize, Serialize};
use std::{f64::consts::PI, path::PathBuf};

/// Which plan, and which poses are compared.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LocalGridConfig {
    /// File of the world (TOML) whose walls the robot is given as its plan, and what its sonars or laser are like. Not said: in a
    /// comparison the world that the dataset is simulated in.
    pub world: PathBuf,
    /// s_XY: from one position of the grid to the next, metres.
    pub position_step_m: f64,
    /// s_T: from one heading of the grid to the next, radians.
    pub heading_step_rad: f64,
    /// How far positions of the grid lie from its centre at most, metres.
    pub position_radius_m: f64,
    /// How far headings of the grid are turned from its centre's at most, radians.
    pub heading_radius_rad: f64,
    /// Metres travelled from one correction to the next.
    pub estimation_every_m: f64,
}

impl Default for LocalGridConfig {
    /// As R06 prints them in 4.1.
    fn default() -> Self {
        Self {
            world: PathBuf::new(),
            position_step_m: 0.1,
            heading_step_rad: 10_f64.to_radians(),
            position_radius_m: 0.4,
            heading_radius_rad: 40_f64.to_radians(),
            estimation_every_m: 0.5,
        }
    }
}

/// Most poses of a grid: each is a whole scan to work out.
const MAX_POSES: f64 = 100_000.0;
/// Lattice points this much past the radius still count, as a share of a step: 0.4 is not four times 0.1 to the bit.
const SLACK: f64 = 1e-6;

impl LocalGridConfig {
    /// # Errors
    /// Where no world is named, or a constant makes no sense.
    pub fn check(&self) -> Result<()> {
        if self.world.as_os_str().is_empty() {
            return Err(Error::usage(
                "local_grid.world: none; expected the file of a world, whose walls are the plan",
            ));
        }
        self.check_constants()
    }

    fn check_constants(&self) -> Result<()> {
        let wrong = |key: &str, value: f64, expected: &str| {
            Err(Error::usage(format!(
                "local_grid.{key} = {value}: expected {expected}"
            )))
        };
        for (key, value) in [
            ("position_step_m", self.position_step_m),
            ("heading_step_rad", self.heading_step_rad),
            ("estimation_every_m", self.estimation_every_m),
        ] {
            if !(value.is_finite() && value > 0.0) {
                return wrong(key, value, "more than 0");
            }
        }
        if !(0.0..=1e6).contains(&self.position_radius_m) {
            return wrong("position_radius_m", self.position_radius_m, "0 to 1e6 m");
        }
        if !(0.0..=PI).contains(&self.heading_radius_rad) {
            return wrong("heading_radius_rad", self.heading_radius_rad, "0 to π");
        }
        let across = |radius: f64, step: f64| 2.0 * (radius / step).floor() + 1.0;
        let positions = across(self.position_radius_m, self.position_step_m).powi(2);
        let poses = positions * across(self.heading_radius_rad, self.heading_step_rad);
        if poses > MAX_POSES {
            return Err(Error::usage(format!(
                "local_grid: radii and steps ask for {poses} poses; expected up to {MAX_POSES}"
            )));
        }
        Ok(())
    }

    /// Poses that are compared in a correction.
    pub fn poses(&self) -> usize {
        self.offsets().len()
    }

    /// G_LP less its centre, x, y and turn: from the centre outwards, of positions as far away in rows, of headings the
    /// least turned first.
    fn offsets(&self) -> Vec<Pose> {
        let steps = |radius: f64, step: f64| (radius / step + SLACK).floor() as i64;
        let across = steps(self.position_radius_m, self.position_step_m);
        let turns = steps(self.heading_radius_rad, self.heading_step_rad);
        let farthest = (self.position_radius_m / self.position_step_m + SLACK).powi(2);
        let mut offsets: Vec<(i64, i64, Pose)> = Vec::new();
        for (row, column) in
            (-across..=across).flat_map(|r| (-across..=across).map(move |c| (r, c)))
        {
            let square = row * row + column * column;
            if square as f64 <= farthest {
                let [x_m, y_m] = [column, row].map(|n| n as f64 * self.position_step_m);
                offsets.extend((-turns..=turns).map(|turn| {
                    let turn_rad = turn as f64 * self.heading_step_rad;
                    (square, turn.abs(), Pose::new(x_m, y_m, turn_rad))
                }));
            }
        }
        offsets.sort_by_key(|&(square, turn, _)| (square, turn));
        offsets.into_iter().map(|(.., offset)| offset).collect()
    }
}

/// A plan, and the grid that is laid around a reckoned pose.
///
/// ```
/// use ballmark::{geometry::Pose, localiser::{Learn, local_grid::{LocalGrid, LocalGridConfig}}, seed::Seed};
/// use ballmark::world::{Building, simulate};
/// let file = "configs/worlds/ruizmayor2006-r1.toml";
/// let run = simulate(&Building::read(file.as_ref())?, Seed(1), &Default::default())?;
/// let config = LocalGridConfig { world: file.into(), ..LocalGridConfig::default() };
/// let grid = LocalGrid::learn(&config, &run, &[0], Seed(1))?;
///
/// let truth = run.poses()[5];
/// let reckoned = Pose::new(truth.x_m + 0.2, truth.y_m - 0.1, truth.heading_rad);
/// let corrected = grid.corrected(run.channels(), run.observation(5).values, &reckoned);
/// assert!(truth.distance_m(&corrected) < 0.01);
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LocalGrid {
    config: LocalGridConfig,
    expected: ExpectedRanges,
}

impl LocalGrid {
    /// The correction of one pose by what was sensed there (all values of a snapshot, in the channels' order): the pose of
    /// the grid around `reckoned` whose expected perception is the nearest. Where nothing came back it stays as reckoned.
    pub fn corrected(
        &self,
        channels: &[Channel],
        values: ndarray::ArrayView1<f32>,
        reckoned: &Pose,
    ) -> Pose {
        let Some(sensed) = self.expected.sensed(channels, values) else {
            return *reckoned;
        };
        let expected = self.expected.near(reckoned, self.config.position_radius_m);
        let mut nearest = (f64::INFINITY, *reckoned);
        for offset in self.config.offsets() {
            let pose = Pose::new(
                reckoned.x_m + offset.x_m,
                reckoned.y_m + offset.y_m,
                wrapped(reckoned.heading_rad + offset.heading_rad),
            );
            if let Some(square) = expected.square_distance(&pose, &sensed, nearest.0) {
                nearest = (square, pose);
            }
        }
        nearest.1
    }
}

struct Corrector<'a> {
    grid: &'a LocalGrid,
    recording: &'a Recording,
}

impl TrialRunner for Corrector<'_> {
    /// Without a start it has nothing to correct, and no answer.
    fn play(&self, trial: &[usize], start: Option<Pose>, _: &mut Stream) -> Result<Vec<Step>> {
        let Some(mut pose) = start else {
            return Ok(vec![Step::default(); trial.len()]);
        };
        let mut travelled_m = 0.0;
        let mut last: Option<Pose> = None;
        let step = |&k: &usize| {
            let observation = self.recording.observation(k);
            if let Some(last) = last.replace(observation.odometry) {
                let moved = last.displacement_to(&observation.odometry);
                pose = pose.after(moved);
                travelled_m += moved.distance_m();
                // Here, if the next snapshot is likely to come farther past the distance than this one falls short of it.
                if travelled_m + moved.distance_m() / 2.0 >= self.grid.config.estimation_every_m {
                    travelled_m = 0.0;
                    let channels = self.recording.channels();
                    pose = self.grid.corrected(channels, observation.values, &pose);
                }
            }
            Step {
                estimate: Some(Estimate::Place([pose.x_m, pose.y_m])),
                heading_rad: Some(pose.heading_rad),
                ..Step::default()
            }
        };
        Ok(trial.iter().map(step).collect())
    }
}

impl Localiser for LocalGrid {
    fn name(&self) -> &'static str {
        "local_grid"
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

    fn check_channels(&self, channels: &[Channel]) -> Result<()> {
        self.expected.check_channels(channels)
    }

    fn prepare<'a>(
        &'a self,
        recording: &'a Recording,
        _: &[usize],
    ) -> Result<Box<dyn TrialRunner + 'a>> {
        self.check_channels(recording.channels())?;
        Ok(Box::new(Corrector {
            grid: self,
            recording,
        }))
    }
}

impl Learn for LocalGrid {
    type Config = LocalGridConfig;

    /// Reads the plan; of the mapping part it needs the channels alone.
    fn learn(
        config: &LocalGridConfig,
        recording: &Recording,
        _: &[usize],
        seed: Seed,
    ) -> Result<Self> {
        config.check()?;
        Ok(Self {
            expected: ExpectedRanges::of_world(&config.world, recording.channels(), seed)?,
            config: config.clone(),
        })
    }

    fn check(&self) -> Result<()> {
        self.config.check_constants()
    }
}

#[cfg(test)]
mod tests;
