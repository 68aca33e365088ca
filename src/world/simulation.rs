//! From a building to a Recording: drive run after run, and record what the sensors say.

mod clearance;
mod drive;
mod spacing;

use super::{
    Building, Camera, Compass, Infrared, Laser, Sonar, Stop, Surroundings,
    building::{RunSet, Sensors},
};
use crate::{
    error::{Error, Result},
    geometry::{Pose, wrapped},
    recording::{Channel, Columns, Recording},
    seed::Seed,
};
use drive::{Drive, drive_set};
use ndarray::Array2;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Pause between two runs, on the recording's clock, seconds.
const PAUSE_S: f64 = 600.0;

/// Most values of one recording: 2 GB.
const MAX_VALUES: usize = 500_000_000;

/// Which runs of a building are simulated.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Choice {
    /// Those of this set only; of all sets, one after another, where there is none.
    pub set: Option<String>,
    /// This number of runs of each set, instead of the file's.
    pub runs: Option<usize>,
}

/// Simulates a building's robot and records all its sensors.
///
/// Run r depends on the seed, the building and r only, not on how many threads work.
///
/// ```
/// use ballmark::{seed::Seed, world::{Building, simulation::{Choice, simulate}}};
/// let hall = Building::from_text(r#"
///     name = "hall"
///     wall = [{ points = [[0, 0], [9, 0], [9, 4], [0, 4]], closed = true }]
///     sonar = { beams = 8 }
///     path = { corners = [[1, 2], [8, 2]] }
///     record = { snapshots = 15, runs = 2 }
/// "#)?;
/// let recording = simulate(&hall, Seed(1), &Choice::default())?;
/// assert_eq!((recording.len(), recording.runs().len()), (15, 2));
/// # Ok::<(), ballmark::Error>(())
/// ```
///
/// # Errors
/// A usage error where the choice names no set, or the sets' sensors differ in their channels; a work error where the
/// robot could get out, starts in a wall or comes nearer to one than its radius: the message names the run.
pub fn simulate(building: &Building, seed: Seed, choice: &Choice) -> Result<Recording> {
    simulate_watched(building, seed, choice, &|_, _| ())
}

/// As [`simulate`]; `progress` is told, from any thread, how many snapshots of how many were seen.
///
/// # Errors
/// As [`simulate`].
pub fn simulate_watched(
    building: &Building,
    seed: Seed,
    choice: &Choice,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<Recording> {
    let sets = chosen(building, choice)?;
    let channels = sets[0].1.sensors.channels();
    if channels.is_empty() {
        return Err(Error::usage(
            "no sensor; expected a table of at least one, such as [sonar]",
        ));
    }
    if let Some((_, set, _)) = sets
        .iter()
        .find(|(_, set, _)| set.sensors.channels() != channels)
    {
        return Err(Error::usage(format!(
            "the sensors of sets `{}` and `{}` differ; expected --set with one of {}",
            sets[0].1.name,
            set.name,
            building.set_names().join(", ")
        )));
    }
    let mut drives: Vec<(Drive, &Sensors)> = Vec::new();
    for (first, set, runs) in sets {
        let start_s = drives
            .last()
            .map_or(0.0, |(drive, _)| drive.end_s() + PAUSE_S);
        let driven = drive_set(building, seed, first, set, runs, start_s)?;
        drives.extend(driven.into_iter().map(|drive| (drive, &set.sensors)));
    }
    let source = match building.source() {
        "" => format!("simulated world {}, seed {}", building.name(), seed.0),
        after => format!(
            "simulated world {} after {after}, seed {}",
            building.name(),
            seed.0
        ),
    };
    record(
        (seed, seed.within(building.name())),
        &drives,
        Some(source),
        progress,
    )
}

/// Number of the first run that a choice picks, for [`Building::plan_of_run`].
///
/// # Errors
/// As [`simulate`] where the choice is wrong.
pub fn first_run(building: &Building, choice: &Choice) -> Result<u64> {
    Ok(chosen(building, choice)?
        .first()
        .map_or(0, |(first, ..)| *first))
}

/// The sets that are asked for, each with the number of its first run and how many there are.
fn chosen<'a>(building: &'a Building, choice: &Choice) -> Result<Vec<(u64, &'a RunSet, usize)>> {
    if let Some(runs) = choice.runs.filter(|runs| !(1..=10_000).contains(runs)) {
        return Err(Error::usage(format!("--runs {runs}: expected 1 to 10000")));
    }
    let mut first = 0;
    let mut sets = Vec::new();
    for set in building.sets() {
        if choice.set.as_ref().is_none_or(|name| *name == set.name) {
            sets.push((first, set, choice.runs.unwrap_or(set.runs)));
        }
        // Where one set is asked for, its runs keep their numbers, however many there are to be.
        let runs = match choice.set {
            Some(_) => set.runs,
            None => set.runs.max(choice.runs.unwrap_or(0)),
        };
        first += runs as u64;
    }
    match &choice.set {
        Some(name) if sets.is_empty() => Err(Error::usage(format!(
            "--set {name}: no such set in the world `{}`; expected {}",
            building.name(),
            match &building.set_names()[..] {
                [] => "none, since it has no [[set]]".to_string(),
                names => format!("one of {}", names.join(", ")),
            }
        ))),
        _ => Ok(sets),
    }
}

impl Sensors {
    /// Channels in their fixed order.
    fn channels(&self) -> Vec<Channel> {
        let sonar = self.sonar.iter().map(Sonar::channel);
        let infrared = self.infrared.iter().map(Infrared::channel);
        let laser = self.laser.iter().map(Laser::channel);
        let camera = self.camera.iter().map(Camera::channel);
        sonar.chain(infrared).chain(laser).chain(camera).collect()
    }

    /// Values in a snapshot.
    fn width(&self) -> usize {
        self.channels().iter().map(|channel| channel.width).sum()
    }

    /// One reading of every sensor at a stop, channels side by side.
    fn read(&self, seed: Seed, number: u64, drive: &Drive, index: usize) -> Vec<f32> {
        let stop = &drive.stops[index];
        let (scene, caster) = drive.building_at(index);
        let mut passing = Vec::new();
        drive.passing_at(stop.stamp_s, &mut passing);
        let around = Surroundings::new(caster, &passing);
        let mut values = Vec::new();
        // Each sensor has noise of its own, so that one sensor more changes nothing in the others.
        let noise = |name| seed.numbered_stream(name, number);
        if let Some(sonar) = &self.sonar {
            values.extend(sonar.read(&around, &stop.pose, &mut noise("world/sonar")));
        }
        if let Some(infrared) = &self.infrared {
            values.extend(infrared.read(&around, &stop.pose, &mut noise("world/infrared")));
        }
        if let Some(laser) = &self.laser {
            values.extend(laser.read(&around, &stop.pose, &mut noise("world/laser")));
        }
        if let Some(camera) = &self.camera {
            values.extend(camera.read(scene, &around, &stop.pose, &mut noise("world/camera")));
        }
        values
    }
}

/// Reads the sensors at every stop. The second of the seeds is the environment's own, which its compass is drawn from.
fn record(
    (seed, own): (Seed, Seed),
    drives: &[(Drive, &Sensors)],
    source: Option<String>,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<Recording> {
    let places: Vec<(usize, usize)> = drives
        .iter()
        .enumerate()
        .flat_map(|(run, (drive, _))| (0..drive.stops.len()).map(move |stop| (run, stop)))
        .collect();
    let widest = drives.iter().map(|(_, sensors)| sensors.width()).max();
    let numbers = places.len().saturating_mul(widest.unwrap_or(0));
    if numbers > MAX_VALUES {
        return Err(Error::usage(format!(
            "simulation: {} snapshots make {numbers} values; expected up to {MAX_VALUES}",
            places.len()
        )));
    }
    let seen = AtomicUsize::new(0);
    let values: Vec<f32> = places
        .par_iter()
        .flat_map_iter(|&(run, stop)| {
            let (drive, sensors) = &drives[run];
            // Both are below 2^32: see MAX_SNAPSHOTS.
            let number = drive.run << 32 | stop as u64;
            let values = sensors.read(seed, number, drive, stop);
            progress(1 + seen.fetch_add(1, Ordering::Relaxed), places.len());
            values
        })
        .collect();
    // Runs of one recording have a compass all, or none; its distortion is the building's.
    let compasses = drives.iter().map(|(_, sensors)| sensors.compass.clone());
    let compasses: Option<Vec<Compass>> = compasses
        .map(|config| config.map(|config| Compass::new(config, own)).transpose())
        .collect::<Result<_>>()?;
    let compass_rad = compasses.map(|compasses| {
        let each = places.iter().map(|&(run, stop)| {
            let drive = &drives[run].0;
            let number = drive.run << 32 | stop as u64;
            let mut noise = own.numbered_stream("world/compass/noise", number);
            let read_rad = compasses[run].read(&drive.stops[stop].pose, &mut noise);
            wrapped(read_rad + drive.unsteady_rad[stop])
        });
        each.collect()
    });
    let of_each = |value: &dyn Fn(&Drive, &Stop) -> f64| -> Vec<f64> {
        let each = places.iter().map(|&(run, stop)| (&drives[run].0, stop));
        each.map(|(drive, stop)| value(drive, &drive.stops[stop]))
            .collect()
    };
    let pose_of_each = |pose: fn(&Stop) -> Pose| -> Vec<Pose> {
        let each = places.iter().map(|&(run, stop)| &drives[run].0.stops[stop]);
        each.map(pose).collect()
    };
    let channels = drives
        .first()
        .map_or_else(Vec::new, |(_, sensors)| sensors.channels());
    let width = channels.iter().map(|channel| channel.width).sum();
    let values = Array2::from_shape_vec((places.len(), width), values)
        .map_err(|fault| Error::work(format!("simulation: {fault}")))?;
    Recording::new(Columns {
        channels,
        values,
        stamp_s: of_each(&|drive, stop| drive.start_s + stop.stamp_s),
        pose: pose_of_each(|stop| stop.pose),
        odometry: pose_of_each(|stop| stop.odometry),
        run: places.iter().map(|&(run, _)| run as i64).collect(),
        compass_rad,
        route_m: Some(of_each(&|_, stop| stop.route_m)),
        source,
        ..Columns::default()
    })
}

#[cfg(test)]
mod tests;
