//! The experiment of Ruiz-Mayor, Triviño & Bailador, *A performance metric for mobile robot localization*, ICINCO 2006 (R06), 4: what a
//! correction by the nearest expected perception makes of priors that are off by up to half a metre, in three simulated runs.
//!
//! As R06 has it, every snapshot is judged on its own: its prior is drawn around the truth, so that the correction alone is measured.
//! Beside the printed constants, two experiments that R06 proposes: a coarser search in heading (4.3), and readings that are worse (3.4).

mod config;
mod record;
#[cfg(test)]
mod tests;
mod worlds;

pub use config::Ruizmayor2006Config;
pub use record::{ExperimentRecord, Figures, Ruizmayor2006Record, Ruizmayor2006Timing};
pub use worlds::Worlds;

use super::reproduce::Paper;
use crate::{
    error::{Error, Result},
    geometry::{Pose, wrapped},
    localiser::{Learn, local_grid::LocalGrid},
    recording::{Recording, injected_noise::uniform_error},
    score::{
        MeanInterval,
        prediction_correction::{
            Edges, MetricOptions, PositionHeading, PredictionCorrection, RunMetric, Traces,
        },
    },
    seed::{Seed, Stream},
    storage,
    world::{
        Building,
        simulation::{Choice, simulate},
    },
};
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use std::{
    path::{Path, PathBuf},
    time::Instant,
};

/// The runs, and the files of their worlds.
pub const RUNS: [(&str, &str); 3] = [
    ("R1", "worlds/ruizmayor2006-r1.toml"),
    ("R2", "worlds/ruizmayor2006-r2.toml"),
    ("R3", "worlds/ruizmayor2006-r3.toml"),
];

/// A run, and where its snapshots were taken.
struct Run {
    name: &'static str,
    recording: Recording,
    world: PathBuf,
}

/// Runs all of it; `worlds` is a folder that the paper's files were [unpacked](Paper::unpack) to. `progress` is told how many experiments
/// are done, of how many, and what comes next.
///
/// # Errors
/// Where the configuration makes no sense, or a world can't be simulated.
pub fn run(
    config: &Ruizmayor2006Config,
    worlds: &Path,
    progress: &mut dyn FnMut(usize, usize, &str),
) -> Result<Ruizmayor2006Record> {
    config.check()?;
    let runs = simulated(config, worlds, Worlds::AsTheyAre)?;
    let (steps, noises) = (&config.heading_steps_deg, &config.range_noise_m);
    let by_step = steps
        .iter()
        .map(|&step| (step, noises[0], Worlds::AsTheyAre));
    let by_noise = noises[1..]
        .iter()
        .map(|&noise| (steps[0], noise, Worlds::AsTheyAre));
    let longest = config
        .longest_readings_m
        .iter()
        .copied()
        .map(Worlds::LongestReadingM);
    let pilasters = config
        .pilasters_every_m
        .iter()
        .copied()
        .map(Worlds::PilastersEveryM);
    let others = longest
        .chain(pilasters)
        .map(|others| (steps[0], noises[0], others));
    let all: Vec<_> = by_step.chain(by_noise).chain(others).collect();
    let (mut experiments, mut timing) = (Vec::new(), Ruizmayor2006Timing::default());
    for (done, &(step, noise, of_worlds)) in all.iter().enumerate() {
        let of = match of_worlds {
            Worlds::AsTheyAre => String::new(),
            Worlds::LongestReadingM(m) => format!(", sonars to {m} m"),
            Worlds::PilastersEveryM(m) => format!(", pilasters every {m} m"),
        };
        let next = format!("steps of {step}°, noise of {noise} m{of}");
        progress(done, all.len(), &next);
        let experiment = match of_worlds {
            Worlds::AsTheyAre => experiment(config, &runs, step, noise)?,
            _ => experiment(config, &simulated(config, worlds, of_worlds)?, step, noise)?,
        };
        experiments.push(ExperimentRecord {
            worlds: of_worlds,
            ..experiment
        });
    }
    for &step in steps {
        timing
            .correction_s
            .push(correction_s(config, &runs[1], step)?);
    }
    Ok(Ruizmayor2006Record {
        version: env!("CARGO_PKG_VERSION").to_string(),
        config: config.clone(),
        experiments,
        timing,
    })
}

/// The three runs; worlds that are not as they are in the files are written below `folder`.
fn simulated(config: &Ruizmayor2006Config, folder: &Path, worlds: Worlds) -> Result<Vec<Run>> {
    let of = |(name, file): (&'static str, &str)| {
        let text = Paper::Ruizmayor2006.file(file)?;
        let text = text.to_string() + &worlds.added(name);
        let world = match worlds {
            Worlds::AsTheyAre => folder.join(file),
            _ => folder.join(format!("{name}.toml")),
        };
        if worlds != Worlds::AsTheyAre {
            storage::write_file(&world, |out| out.write_all(text.as_bytes()))?;
        }
        let building = Building::from_text(&text)?;
        Ok(Run {
            name,
            recording: simulate(&building, Seed(config.seed), &Choice::default())?,
            world,
        })
    };
    RUNS.into_iter().map(of).collect()
}

/// Prior and posterior poses of one run in one repetition.
struct Estimates {
    prior: Vec<Pose>,
    posterior: Vec<Pose>,
}

fn experiment(
    config: &Ruizmayor2006Config,
    runs: &[Run],
    heading_step_deg: f64,
    range_noise_m: f64,
) -> Result<ExperimentRecord> {
    let mut poses = 0;
    // `[run][repetition]`
    let mut estimates: Vec<Vec<Estimates>> = Vec::new();
    for (number, run) in runs.iter().enumerate() {
        let search = config.search(&run.world, heading_step_deg);
        poses = search.poses();
        let grid = LocalGrid::learn(&search, &run.recording, &[0], Seed(config.seed))?;
        let repeated = (0..config.repetitions).into_par_iter().map(|repetition| {
            let stream = (repetition * RUNS.len() + number) as u64;
            let mut random = Seed(config.seed).numbered_stream("priors of a run", stream);
            let mut noise = Seed(config.seed).numbered_stream("noise of ranges", stream);
            let prior: Vec<Pose> = (run.recording.poses().iter())
                .map(|truth| config.prior(truth, &mut random))
                .collect();
            let posterior = prior.iter().enumerate().map(|(k, prior)| {
                let mut values = run.recording.observation(k).values.to_owned();
                for value in &mut values {
                    let off: f64 = StandardNormal.sample(&mut noise);
                    // What did not come back stays missing.
                    *value = (*value + (range_noise_m * off) as f32).clamp(0.0, f32::MAX);
                }
                grid.corrected(run.recording.channels(), values.view(), prior)
            });
            Estimates {
                posterior: posterior.collect(),
                prior,
            }
        });
        estimates.push(repeated.collect());
    }
    let options = MetricOptions {
        search_step: Some(PositionHeading {
            position_m: Some(config.position_step_m),
            heading_deg: Some(heading_step_deg),
        }),
        truth_precision: Some(PositionHeading {
            position_m: Some(0.0),
            heading_deg: Some(0.0),
        }),
        edges: Edges {
            position_m: vec![0.1, 0.2, 0.3, 0.4],
            heading_deg: vec![10.0, 20.0, 30.0, 40.0],
        },
        ..MetricOptions::default()
    };
    let of_repetition = |repetition: usize| {
        let traces: Vec<Traces> = (runs.iter().zip(&estimates))
            .map(|(run, of)| Traces {
                name: run.name,
                real: run.recording.poses(),
                prior: &of[repetition].prior,
                posterior: &of[repetition].posterior,
            })
            .collect();
        PredictionCorrection::of(&traces, &options)
    };
    let repetitions = (0..config.repetitions)
        .map(of_repetition)
        .collect::<Result<Vec<_>>>()?;
    // All repetitions of a run one after the other.
    let many = |poses: &[Pose]| poses.repeat(config.repetitions);
    let joined: Vec<[Vec<Pose>; 3]> = (runs.iter().zip(&estimates))
        .map(|(run, of)| {
            let all =
                |which: fn(&Estimates) -> &Vec<Pose>| of.iter().flat_map(which).copied().collect();
            [
                many(run.recording.poses()),
                all(|e| &e.prior),
                all(|e| &e.posterior),
            ]
        })
        .collect();
    let traces: Vec<Traces> = (runs.iter().zip(&joined))
        .map(|(run, [real, prior, posterior])| Traces {
            name: run.name,
            real,
            prior,
            posterior,
        })
        .collect();
    let overall: Vec<&RunMetric> = repetitions.iter().map(|metric| &metric.overall).collect();
    let mut figures = vec![figures(&overall)?];
    for number in 0..runs.len() {
        let of_run: Vec<&RunMetric> = repetitions.iter().map(|m| &m.runs[number]).collect();
        figures.push(self::figures(&of_run)?);
    }
    Ok(ExperimentRecord {
        heading_step_deg,
        range_noise_m,
        worlds: Worlds::AsTheyAre,
        poses,
        together: PredictionCorrection::of(&traces, &options)?,
        figures,
    })
}

impl Ruizmayor2006Config {
    /// The truth, off by the prediction's error and by the noise put on it: each uniform over a disc and over an interval.
    fn prior(&self, truth: &Pose, random: &mut Stream) -> Pose {
        let mut pose = *truth;
        for (radius_m, radius_deg) in [
            (self.prediction_m, self.prediction_deg),
            (self.noise_m, self.noise_deg),
        ] {
            let off = uniform_error(radius_m, radius_deg, random);
            pose = Pose::new(
                pose.x_m + off.forward_m,
                pose.y_m + off.left_m,
                wrapped(pose.heading_rad + off.turn_rad),
            );
        }
        pose
    }
}

fn figures(repetitions: &[&RunMetric]) -> Result<Figures> {
    let mean = |of: &dyn Fn(&RunMetric) -> f64| {
        let values: Vec<f64> = repetitions.iter().map(|metric| of(metric)).collect();
        let mean = MeanInterval::of(&values);
        mean.ok_or_else(|| Error::work("ruizmayor2006: a figure that is no finite number"))
    };
    let first = repetitions.first();
    let first = first.ok_or_else(|| Error::work("ruizmayor2006: no repetition"))?;
    let factors = |of: fn(&crate::score::prediction_correction::CorrectionFactor) -> f64| -> Result<[MeanInterval; 3]> {
        Ok([
            mean(&|metric| of(&metric.correction.position))?,
            mean(&|metric| of(&metric.correction.heading))?,
            mean(&|metric| of(&metric.correction.both))?,
        ])
    };
    Ok(Figures {
        name: first.name.clone(),
        n: first.n,
        largest_m: mean(&|metric| metric.posterior.position_m.percentiles.p100)?,
        largest_deg: mean(&|metric| metric.posterior.heading_deg.percentiles.p100)?,
        p95_m: mean(&|metric| metric.posterior.position_m.percentiles.p95)?,
        p95_deg: mean(&|metric| metric.posterior.heading_deg.percentiles.p95)?,
        optimal: mean(&|metric| metric.optimal.map_or(f64::NAN, |optimal| optimal.fraction))?,
        merit_m: mean(&|metric| metric.posterior.position_m.merit)?,
        merit_deg: mean(&|metric| metric.posterior.heading_deg.merit)?,
        not_worse: factors(|factor| factor.not_worse)?,
        better: factors(|factor| factor.better)?,
    })
}

/// Corrections that are timed, after as many that are not.
const TIMED: usize = 60;

/// Median seconds of a correction of a run's snapshots, one after the other.
fn correction_s(config: &Ruizmayor2006Config, run: &Run, heading_step_deg: f64) -> Result<f64> {
    let search = config.search(&run.world, heading_step_deg);
    let grid = LocalGrid::learn(&search, &run.recording, &[0], Seed(config.seed))?;
    let correct = |number: usize| {
        let k = number % run.recording.len();
        let observation = run.recording.observation(k);
        let pose = run.recording.poses()[k];
        let began = Instant::now();
        std::hint::black_box(grid.corrected(run.recording.channels(), observation.values, &pose));
        began.elapsed().as_secs_f64()
    };
    let mut seconds: Vec<f64> = (0..2 * TIMED).map(correct).skip(TIMED).collect();
    seconds.sort_by(f64::total_cmp);
    Ok(seconds[TIMED / 2])
}
