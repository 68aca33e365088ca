//! Thrun's corridor with days.

use super::{Change, LifelongConfig};
use crate::{
    error::Result,
    recording::Recording,
    seed::Seed,
    world::{
        Building,
        building::{DaysConfig, RecordConfig, WorldConfig},
        corridor::WORLD,
        simulation::{Choice, simulate},
    },
};

/// The runs of each day.
pub(super) fn days(config: &LifelongConfig, change: Change, seed: u64) -> Result<Vec<Recording>> {
    let mut world = WorldConfig::parse(WORLD)?;
    for set in &mut world.set {
        set.snapshots = None;
        set.every_m = Some(config.spacing_m);
        set.runs = Some(config.days * config.runs);
    }
    world.record = RecordConfig {
        every_m: Some(config.spacing_m),
        ..RecordConfig::default()
    };
    world.set.retain(|set| set.name == config.set);
    let kept = match change {
        Change::Changing => config.kept,
        Change::Still => 1.0,
    };
    world.days = Some(DaysConfig {
        runs: config.runs,
        kept,
        lit: config.lit,
    });
    if change == Change::Still {
        let [dim, bright] = world.building.daylight;
        world.building.daylight = [0.5 * (dim + bright); 2];
        world.building.illumination_sd = 0.0;
    }
    let recording = simulate(
        &Building::new(&world, None)?,
        Seed(seed),
        &Choice::default(),
    )?;
    let runs = recording.runs();
    let of_day = |runs: &[std::ops::Range<usize>]| {
        let snapshots: Vec<usize> = runs.iter().cloned().flatten().collect();
        recording.select(&snapshots)
    };
    runs.chunks(config.runs).map(of_day).collect()
}
