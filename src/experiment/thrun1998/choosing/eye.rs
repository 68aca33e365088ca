//! Cameras that look to the right, to the left and up from the same places.

use super::super::{MOST_FEATURES, Thrun1998Config, local, simulated};
use crate::{
    belief::{Evidence, Grid, GridConfig, GridMap, OdometryMotion, Places, held_apart::HeldApart},
    error::{Error, Result},
    localiser::sensor_model::{DetectorAnswers, PreparedFeatures},
    model::{Training, held_apart},
    recording::Recording,
    seed::Seed,
};
use std::sync::Arc;

/// Runs that features are learned from.
const LEARNED: usize = 2;

/// Runs of the first camera that nobody learned from: one for each of its copies, which see the same places at other times.
const UNSEEN: usize = 1 + COPIES.len();

/// A camera with the features learned for it, and a run that it never saw.
pub(super) struct Eye {
    /// Where it looks, or which copy it is.
    pub name: &'static str,
    /// What its features say about the place.
    pub sensor: PreparedFeatures,
    /// What they promise.
    pub held_apart: Arc<HeldApart>,
    /// Its snapshots along the way: metres along the route and number in its recording, ascending.
    along: Vec<(f64, usize)>,
}

impl Eye {
    /// Its snapshot nearest to a place of the route.
    pub fn nearest(&self, route_m: f64) -> Option<usize> {
        let next = self.along.partition_point(|(at_m, _)| *at_m < route_m);
        let around = self.along[next.saturating_sub(1)..(next + 1).min(self.along.len())].iter();
        let nearest = around.min_by(|a, b| (a.0 - route_m).abs().total_cmp(&(b.0 - route_m).abs()));
        nearest.map(|(_, k)| *k)
    }
}

/// All cameras, and the run that the robot drives.
pub(super) struct Eyes {
    /// The recording of the camera that looks to the right: its odometry is the robot's.
    pub recording: Recording,
    /// Its places.
    pub places: Places,
    /// The unseen snapshots of the run that is driven, in order.
    pub driven: Vec<usize>,
    /// What the filter believes of odometry.
    pub motion: OdometryMotion,
    /// Cells of the belief.
    pub grid: Arc<Grid>,
    /// To the right, to the left, up; then the first camera in the other unseen runs.
    eyes: Vec<Eye>,
}

const HEADINGS: [(&str, &str); 3] = [("d1", "right"), ("d2", "left"), ("d3", "up")];
const COPIES: [&str; 2] = ["right, in another run", "right, in a third run"];

impl Eyes {
    /// Simulates and learns: four features for ±2 m for each camera.
    pub fn open(config: &Thrun1998Config, seed: Seed) -> Result<Self> {
        let mut first: Option<(Recording, Grid, OdometryMotion)> = None;
        let mut eyes = Vec::new();
        for (set, name) in HEADINGS {
            let is_first = set == HEADINGS[0].0;
            let config = &Thrun1998Config {
                seed: seed.0,
                runs: LEARNED + if is_first { UNSEEN } else { 1 },
                ..config.clone()
            };
            let recording = simulated(config, "worlds/thrun1998.toml", set)?;
            let runs = recording.runs();
            let learned: Vec<usize> = runs.iter().take(LEARNED).cloned().flatten().collect();
            let own = recording.select(&learned)?;
            let mut recipe = config.recipe(MOST_FEATURES, local(), 0);
            recipe.split.test_fold = None; // all of these runs
            let model = &Training::new(&recipe, &own).run()?.model;
            if first.is_none() {
                let grid = Grid::over(&model.places(), &GridConfig::default())?;
                first = Some((recording.clone(), grid, model.header.motion.clone()));
            }
            let (_, grid, _) = first.as_ref().ok_or_else(|| Error::work("no camera"))?;
            let cells = grid.places();
            let map: Arc<GridMap> = Arc::new(model.map()?.at(cells)?);
            let run = recording.run_numbers(&learned);
            let promise = Arc::new(held_apart(model, &run, cells)?);
            let all: Vec<usize> = (0..recording.len()).collect();
            let answered = DetectorAnswers::of(&model.detector(), &recording, &all)?;
            let of_run = |name: &'static str, number: usize| {
                let route_m = recording.route_m().unwrap_or_default();
                let unseen = runs.get(LEARNED + number).cloned();
                let mut along: Vec<(f64, usize)> = unseen
                    .into_iter()
                    .flatten()
                    .map(|k| (route_m[k], k))
                    .collect();
                along.sort_by(|a, b| a.0.total_cmp(&b.0));
                Eye {
                    name,
                    sensor: PreparedFeatures::new(
                        answered.clone(),
                        Arc::clone(&map),
                        Evidence::Sampled,
                    ),
                    held_apart: Arc::clone(&promise),
                    along,
                }
            };
            eyes.push(of_run(name, 0));
            if is_first {
                let copies = COPIES.iter().enumerate();
                eyes.extend(copies.map(|(number, name)| of_run(name, number + 1)));
            }
        }
        let (recording, grid, motion) = first.ok_or_else(|| Error::work("no camera"))?;
        let driven = recording.runs().get(LEARNED).cloned();
        Ok(Self {
            places: Places::of(&recording),
            driven: driven.into_iter().flatten().collect(),
            recording,
            motion,
            grid: Arc::new(grid),
            eyes,
        })
    }

    /// Three ways to look.
    pub fn headings(&self) -> Vec<&Eye> {
        let is_copy = |eye: &&Eye| COPIES.contains(&eye.name);
        self.eyes.iter().filter(|eye| !is_copy(eye)).collect()
    }

    /// One way to look, three times.
    pub fn copies(&self) -> Vec<&Eye> {
        let is_one = |eye: &&Eye| eye.name == HEADINGS[0].1 || COPIES.contains(&eye.name);
        self.eyes.iter().filter(is_one).collect()
    }
}
