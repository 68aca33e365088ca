//! The filter with a recording before it.

use super::Bayes;
use crate::{
    belief::{Belief, Places},
    detector::Detector,
    error::Result,
    geometry::Pose,
    localiser::{
        BayesLocaliser, Estimate, Player, Probable, SensorModel, Step, features::FeatureModel,
    },
    recording::Recording,
    seed::{Seed, Stream},
};
use rand::RngExt;

/// A place that holds less than this share of the likeliest one's probability is left out of the posterior.
const NEGLIGIBLE: f64 = 1e-6;

/// A recording's answers, and the map at the cells.
pub(super) struct Filter<'a> {
    bayes: &'a Bayes,
    recording: &'a Recording,
    senses: Senses,
}

impl<'a> Filter<'a> {
    pub(super) fn new(bayes: &'a Bayes, recording: &'a Recording) -> Result<Self> {
        let answers = bayes.known.filters.probabilities(recording)?;
        // Values past all bounds make networks answer NaN.
        let is_answer = |g: &f32| (0.0..=1.0).contains(g);
        let rows = answers.rows().into_iter();
        let silent = rows.map(|row| !row.iter().all(is_answer)).collect();
        let cells = bayes.map.at(bayes.grid.places())?;
        let zero_rad = bayes.compass_zero_rad;
        let heading = |k| Some(recording.observation(k).compass_rad? + zero_rad?);
        Ok(Self {
            bayes,
            recording,
            senses: Senses {
                features: FeatureModel::new(&answers, cells, bayes.evidence),
                silent,
                north: North {
                    headings: headings(bayes),
                    concentration: bayes.compass_sd_rad.powi(-2),
                    told: (0..recording.len()).map(heading).collect(),
                },
            },
        })
    }

    /// The belief of a place in the plane: its cells of all headings together.
    fn posterior(&self, belief: &Belief) -> Vec<Probable> {
        let sites = &self.bayes.sites;
        let mut mass = vec![0.0; sites.len()];
        for cells in belief.mass().chunks(sites.len()) {
            mass.iter_mut().zip(cells).for_each(|(m, cell)| *m += cell);
        }
        let least = NEGLIGIBLE * mass.iter().copied().fold(0.0, f64::max);
        let kept = || mass.iter().zip(sites).filter(|(m, _)| **m > least);
        let total: f64 = kept().map(|(m, _)| m).sum();
        kept().map(|(m, place)| (*place, m / total)).collect()
    }
}

/// The headings that the grid tells apart; none along a route.
fn headings(bayes: &Bayes) -> Vec<f64> {
    match &**bayes.grid.places() {
        Places::Route(_) => Vec::new(),
        Places::Plane(cells) => {
            let first_sites = cells.iter().step_by(bayes.sites.len());
            first_sites.map(|cell| cell.heading_rad).collect()
        }
    }
}

impl Player for Filter<'_> {
    fn play(&self, trial: &[usize], _: Option<Pose>, stream: &mut Stream) -> Result<Vec<Step>> {
        let features = Seed(stream.random()).stream("sampled features");
        let Bayes {
            grid,
            motion,
            sites,
            ..
        } = self.bayes;
        let lost = Belief::uniform(grid.places())?;
        let mut robot = BayesLocaliser::new(grid, motion, lost, Some(&self.senses), features)?;
        let step = |&k: &usize| {
            let belief = robot.observe(k, &self.recording.observation(k))?;
            Ok(Step {
                estimate: Some(Estimate::Place(sites[belief.mode() % sites.len()])),
                posterior: self.posterior(belief),
            })
        };
        trial.iter().map(step).collect()
    }
}

/// What a snapshot says: its features and its compass.
struct Senses {
    features: FeatureModel,
    /// Snapshots that the filters can't answer.
    silent: Vec<bool>,
    north: North,
}

impl SensorModel for Senses {
    fn log_likelihood(
        &self,
        snapshot: usize,
        belief: &Belief,
        stream: &mut Stream,
    ) -> Result<Vec<f64>> {
        let mut log_likelihood = if self.silent[snapshot] {
            vec![0.0; belief.mass().len()]
        } else {
            self.features.log_likelihood(snapshot, belief, stream)?
        };
        self.north.add(snapshot, &mut log_likelihood);
        Ok(log_likelihood)
    }
}

/// The compass: the heading that it tells is drawn from a von Mises distribution around the true one, whose concentration
/// is 1/sd² (as good as exact for the sd of a compass).
struct North {
    /// Of the grid, `[heading]`.
    headings: Vec<f64>,
    concentration: f64,
    /// The compass's heading in the map, `[snapshot]`.
    told: Vec<Option<f64>>,
}

impl North {
    /// Adds the logarithm of the likelihood of a snapshot's compass heading, up to a constant, to each cell's.
    fn add(&self, snapshot: usize, log_likelihood: &mut [f64]) {
        let Some(told_rad) = self.told[snapshot].filter(|_| !self.headings.is_empty()) else {
            return;
        };
        let sites = log_likelihood.len() / self.headings.len();
        for (cells, heading_rad) in log_likelihood.chunks_mut(sites).zip(&self.headings) {
            let north = self.concentration * ((told_rad - heading_rad).cos() - 1.0);
            cells.iter_mut().for_each(|cell| *cell += north);
        }
    }
}
