//! Learning that goes on, day after day, in a corridor that changes: does a robot that labels what it senses by itself keep up?
//!
//! Thrun (1998, section 7) proposes it: "The effectiveness of such an extension in practice remains to be seen." The world is his
//! corridor with days: doors, bins and lamps stay as they are with some probability a night, daylight is another every day. Of the
//! runs of the first day a model is trained; on each later day every robot is judged on that day's runs, from starts anywhere, with
//! what it knew the evening before, and then learns from these runs in its own way. In a second world nothing ever changes.

mod judge;
mod record;
mod rivals;
mod robots;
mod world;

pub use record::{Change, DayRow, LifelongRecord, RobotRow, WorldRow};
pub use robots::{ROBOTS, RobotKind};

use super::adaptation::AdaptConfig;
use crate::{
    error::{Error, Result},
    experiment::robot_constants,
    learning::Recipe,
    model::{Memory, Model, Training},
    recording::Recording,
    seed::Seed,
    toml_file::out_of_range,
};
use judge::Judged;
use rayon::prelude::*;
use robots::Robot;
use serde::{Deserialize, Serialize};
use std::sync::{Mutex, PoisonError};

/// How many days of which world, and with how many seeds: a configuration's section `[lifelong]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LifelongConfig {
    /// The first seed; each makes a world, a model and trials of its own.
    pub seed: u64,
    /// Number of seeds.
    pub seeds: usize,
    /// Set of runs of Thrun's corridor: `d1` and `d2` look at its sides, `d3` at the ceiling.
    pub set: String,
    /// Days, the first of which is learned from and not judged.
    pub days: usize,
    /// Runs of a day.
    pub runs: usize,
    /// Metres between two snapshots.
    pub spacing_m: f64,
    /// Probability that a door, a bin or a lamp is as it was the day before.
    pub kept: f64,
    /// Probability that a lamp burns.
    pub lit: f64,
    /// Trials a day.
    pub trials: usize,
    /// A trial ends after this many metres.
    pub longest_m: f64,
}

impl Default for LifelongConfig {
    fn default() -> Self {
        Self {
            seed: 1,
            seeds: 10,
            set: "d1".into(),
            days: 10,
            runs: 3,
            spacing_m: 0.5,
            kept: 0.8,
            lit: 0.8,
            trials: 20,
            longest_m: 20.0,
        }
    }
}

impl LifelongConfig {
    /// The same at toy size: does it work here?
    pub fn toy(self) -> Self {
        Self {
            seeds: 2,
            days: 3,
            runs: 2,
            spacing_m: 1.0,
            trials: 4,
            ..self
        }
    }

    /// # Errors
    /// A usage error where a value makes no sense; the message names its key.
    pub fn check(&self) -> Result<()> {
        let wrong = |key: &str, expected: &str| Err(out_of_range("lifelong", self, key, expected));
        if !(1..=1000).contains(&self.seeds) || self.seed.checked_add(self.seeds as u64).is_none() {
            return wrong("seeds", "1 to 1000 of them, none above 2^64 - 1");
        }
        if !["d1", "d2", "d3"].contains(&self.set.as_str()) {
            return wrong("set", "d1, d2 or d3");
        }
        if !(2..=1000).contains(&self.days) {
            return wrong(
                "days",
                "2 to 1000: one to learn from, the others to be judged on",
            );
        }
        if !(1..=100).contains(&self.runs) {
            return wrong("runs", "1 to 100 a day");
        }
        if !(0.01..=5.0).contains(&self.spacing_m) {
            return wrong("spacing_m", "0.01 to 5 metres");
        }
        for (key, share) in [("kept", self.kept), ("lit", self.lit)] {
            if !(0.0..=1.0).contains(&share) {
                return wrong(key, "a probability, 0 to 1");
            }
        }
        if !(1..=10_000).contains(&self.trials) {
            return wrong("trials", "1 to 10,000 a day");
        }
        if !(10.0..=80.0).contains(&self.longest_m) {
            return wrong(
                "longest_m",
                "10 to 80 metres, as errors are judged after ten",
            );
        }
        Ok(())
    }
}

/// Where a long experiment stands.
#[derive(Debug, Clone, Copy)]
pub struct Progress {
    /// Robots' days that are done, …
    pub done: usize,
    /// … of so many.
    pub all: usize,
}

/// Plays all days of both worlds with every seed. Seeds run side by side, and each gives what it gives alone. `recipe` and `adapt` are
/// what models are trained and adapted with, their seeds that of the world.
///
/// # Errors
/// Where a value makes no sense, or a model can't be trained.
pub fn lifelong(
    config: &LifelongConfig,
    recipe: &Recipe,
    adapt: &AdaptConfig,
    progress: &mut (dyn FnMut(Progress) + Send),
) -> Result<LifelongRecord> {
    config.check()?;
    recipe.check()?;
    adapt.check()?;
    let all = 2 * config.seeds * (config.days - 1) * ROBOTS.len();
    let done = Mutex::new((0, progress));
    let tick = || {
        let mut done = done.lock().unwrap_or_else(PoisonError::into_inner);
        let (count, progress) = &mut *done;
        *count += 1;
        progress(Progress { done: *count, all });
    };
    let cells: Vec<(Change, u64)> = [Change::Changing, Change::Still]
        .into_iter()
        .flat_map(|change| (0..config.seeds).map(move |n| (change, config.seed + n as u64)))
        .collect();
    let played: Vec<Result<Vec<Vec<Judged>>>> = cells
        .par_iter()
        .map(|&(change, seed)| {
            let played = played(config, recipe, adapt, (change, seed), &tick);
            played.map_err(|e| e.context(format!("seed {seed}")))
        })
        .collect();
    let played = played.into_iter().collect::<Result<Vec<_>>>()?;
    let (changing, still) = played.split_at(config.seeds);
    Ok(LifelongRecord {
        version: env!("CARGO_PKG_VERSION").into(),
        config: config.clone(),
        recipe: recipe.clone(),
        adapt: adapt.clone(),
        worlds: [(Change::Changing, changing), (Change::Still, still)]
            .map(|(change, played)| WorldRow::new(change, played, config))
            .into(),
    })
}

/// What every robot did on every day of a world, `[robot][day]`, the first day left out.
fn played(
    config: &LifelongConfig,
    recipe: &Recipe,
    adapt: &AdaptConfig,
    (change, seed): (Change, u64),
    tick: &(dyn Fn() + Sync),
) -> Result<Vec<Vec<Judged>>> {
    let days = world::days(config, change, seed)?;
    let Some((first, later)) = days.split_first() else {
        return Err(Error::work("a world without days"));
    };
    let recipe = Recipe {
        seed,
        ..recipe.clone()
    };
    let mut adapt = adapt.clone();
    adapt.update.seed = seed;
    let (model, memory) = trained(&recipe, first)?;
    let one = |kind: &RobotKind| {
        let mut robot = Robot::new(*kind, &model, &memory, config)?;
        let mut judged = Vec::new();
        for (number, day) in later.iter().enumerate() {
            let seed = Seed(seed).within(&format!("day {number}"));
            let mut today = robot.judged(day, config, seed)?;
            today.labels = robot.learn(day, &adapt)?;
            judged.push(today);
            tick();
        }
        Ok(judged)
    };
    ROBOTS.par_iter().map(one).collect()
}

/// The model of the first day, and what it remembers.
fn trained(recipe: &Recipe, first: &Recording) -> Result<(Model, Memory)> {
    let mut model = Training::new(recipe, first).run()?.model;
    let tuned = robot_constants::tuned(&model, first)?;
    model.header.evidence_scale = tuned.map(|tuned| tuned.evidence_scale);
    let memory = Memory::of(&model, first)?;
    Ok((model, memory))
}

#[cfg(test)]
mod tests;
