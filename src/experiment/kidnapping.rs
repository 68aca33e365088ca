//! Kidnapped robots: carried to another place without a word, after they have found out where they are (Engelson & McDermott, *Error
//! correction in mobile robot map learning*, 1992; Thrun, Burgard & Fox, *Probabilistic Robotics*, 2005, 7.1).

use super::{
    carried::{CARRIED_M, Ground, Jump, jumps, on_unseen},
    confidence::{areas, scored},
    convergence::{Answers, SURE_WITHIN_M, converged_at_m, median_distance_m},
    method::Method,
    methods::MethodContext,
    paired_trials::{PairedTest, TrialFigures, paired_tests},
    sequences::motion,
    trial_play::stream,
    trials::Trial,
};
use crate::{
    belief::Belief,
    error::{Error, Result},
    localiser::{
        BayesLocaliser, LostConfig, PreparedSensorModel,
        sensor_model::{EvidenceScale, Memory, Remembered, Scaled},
    },
    score::{Auroc, ClusteredMean},
};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// What brings a kidnapped robot back.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Way {
    /// Nothing: evidence counts as it is, however small a likelihood is.
    Nothing,
    /// A floor: no snapshot can rule a place out further than to
    /// [`UNMODELLED`](crate::localiser::sensor_model::evidence_scale::UNMODELLED), as in all other trials.
    Floor,
    /// The floor, and a restart where sensors are explained worse than they used to be
    /// ([`RestartConfig`](crate::localiser::RestartConfig)).
    Restart,
}

/// How the filter did with one way.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Recovery {
    /// Which.
    pub way: Way,
    /// Trials in which the robot was right within 1 m when it was carried away: those that count here.
    pub localised: usize,
    /// Share of them in which it is found again after the jump, in the same sense as in all trials.
    pub recovered: Option<f64>,
    /// Its 95 % interval, by bootstrap over runs or stretches.
    pub recovered_ci95: Option<[f64; 2]>,
    /// Median metres from the jump until then; null where fewer than half are.
    pub recovered_after_m: Option<f64>,
}

/// How a method did where it was kidnapped.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Kidnapped {
    /// Metres from a start anywhere to the jump.
    pub after_m: f64,
    /// Trials with a jump.
    pub trials: usize,
    /// Without anything, with the floor, and with the restart besides.
    pub ways: Vec<Recovery>,
    /// Restart against floor, after the jump, over the trials in which both were right before; null where there is none.
    pub gain: Option<PairedTest>,
    /// Restart against floor in the trials without a jump.
    pub harm: Option<PairedTest>,
    /// Share of the trials with the floor in which the robot says that it is lost before it is found again.
    pub noticed: Option<f64>,
    /// Median metres from the jump until then; null where fewer than half say so.
    pub noticed_after_m: Option<f64>,
    /// Area under the receiver operating characteristic of the lost score over the steps after the jump, with the floor.
    pub lost_auroc: Option<Auroc>,
    /// The same of the belief's mass alone.
    pub mass_auroc: Option<Auroc>,
}

/// Plays the trials with jumps; none of a method that is no filter with a sensor model, or where the configuration wants none.
///
/// # Errors
/// Where no trial goes as far as the jump, or there is nowhere to carry the robot; or the sensor model fails.
pub(super) fn kidnapped(
    method: &Method,
    trials: &[Trial],
    context: &MethodContext,
    scale: Option<EvidenceScale>,
    lost: Option<&LostConfig>,
) -> Result<Option<Kidnapped>> {
    let Some(after_m) = context.config.kidnap_m else {
        return Ok(None);
    };
    let jumps = drawn(trials, context, after_m)?;
    on_unseen(method, context, |sensor| {
        let memory = Memory::default(); // every jump is played three times
        let sensor = Remembered::new(sensor, &memory);
        let play = Play {
            method,
            context,
            sensor: &sensor,
            scale: scale.unwrap_or(EvidenceScale::of(1.0)),
            lost,
        };
        play.all(trials, &jumps, after_m)
    })
}

/// The jumps that everybody suffers.
pub(super) fn drawn(trials: &[Trial], context: &MethodContext, after_m: f64) -> Result<Vec<Jump>> {
    let jumps = jumps(trials, &context.parts.places, |_| after_m, context.seed());
    if !jumps.is_empty() {
        return Ok(jumps);
    }
    let ends = trials.iter().filter_map(|trial| trial.travelled_m.last());
    let longest_m = ends.copied().fold(0.0, f64::max);
    Err(Error::work(match longest_m < after_m {
        true => format!(
            "localise.kidnap_m = {after_m}: the longest trial ends after {longest_m:.1} m; expected a jump before that"
        ),
        false => format!(
            "localise.kidnap_m = {after_m}: no trial starts {CARRIED_M} m or more from where another is by then; expected \
             somewhere to carry the robot to"
        ),
    }))
}

struct Play<'a> {
    method: &'a Method<'a>,
    context: &'a MethodContext<'a>,
    sensor: &'a dyn PreparedSensorModel,
    scale: EvidenceScale,
    lost: Option<&'a LostConfig>,
}

impl Play<'_> {
    fn all(&self, trials: &[Trial], jumps: &[Jump], after_m: f64) -> Result<Kidnapped> {
        let (resamples, seed) = (self.context.config.resamples, self.context.seed());
        let ways = [Way::Nothing, Way::Floor, Way::Restart];
        let legs: Vec<Vec<&Trial>> = jumps.iter().map(|j| vec![&j.before, &j.after]).collect();
        let played = ways.map(|way| self.drives(way, &legs));
        let [nothing, floor, restart] = played;
        let played = [nothing?, floor?, restart?];
        let recoveries = ways.into_iter().zip(&played);
        let recoveries = recoveries.map(|(way, drives)| self.recovery(way, jumps, drives));
        let [_, floor, restart] = &played;
        let both = (0..jumps.len()).filter(|&k| is_right(&floor[k]) && is_right(&restart[k]));
        let both: Vec<usize> = both.collect();
        let after: Vec<Trial> = both.iter().map(|&k| jumps[k].after.clone()).collect();
        let last = |drives: &[Vec<Answers>]| -> Vec<Answers> {
            both.iter().map(|&k| drives[k][1].clone()).collect()
        };
        let gain = self.against(&after, &last(floor), &last(restart));
        let without: Vec<Vec<&Trial>> = trials.iter().map(|trial| vec![trial]).collect();
        let [usual, careful] = [Way::Floor, Way::Restart].map(|way| self.drives(way, &without));
        let harm = self.against(trials, &usual?.concat(), &careful?.concat());

        // Every jump, whether or not the robot was right before.
        let after: Vec<Trial> = jumps.iter().map(|jump| jump.after.clone()).collect();
        let answers: Vec<Answers> = floor.iter().map(|drive| drive[1].clone()).collect();
        let steps = scored(&after, &answers, self.lost).unwrap_or_default();
        let (lost_auroc, mass_auroc) = areas(&steps, resamples, seed);
        let right = (0..jumps.len()).filter(|&k| is_right(&floor[k]));
        let noticed: Vec<Option<f64>> = right
            .map(|k| self.noticed_at_m(&after[k], &answers[k]))
            .collect();
        let share = noticed.iter().flatten().count() as f64 / noticed.len() as f64;
        Ok(Kidnapped {
            after_m,
            trials: jumps.len(),
            ways: recoveries.collect(),
            gain,
            harm,
            noticed: share.is_finite().then_some(share),
            noticed_after_m: median_distance_m(&noticed),
            lost_auroc,
            mass_auroc,
        })
    }

    /// All drives in one way, from a start anywhere, leg by leg.
    fn drives(&self, way: Way, drives: &[Vec<&Trial>]) -> Result<Vec<Vec<Answers>>> {
        let (context, config) = (self.context, self.context.config);
        let scale = match way {
            Way::Nothing => EvidenceScale {
                unmodelled: 0.0,
                ..self.scale
            },
            Way::Floor | Way::Restart => self.scale,
        };
        let sensor = Scaled::new(self.sensor, scale);
        let restart = config.restart.clone().unwrap_or_default();
        let ground = Ground {
            recording: context.parts.run,
            places: &context.parts.places,
            grid: &context.grid,
        };
        let anywhere = Belief::uniform(context.grid.places())?;
        let motion = motion(self.method, context);
        let drive = |(number, legs): (usize, &Vec<&Trial>)| {
            let (start, stream) = (anywhere.clone(), stream(context, number));
            let robot = BayesLocaliser::new(&context.grid, motion, start, Some(&sensor), stream)?;
            let robot = match way {
                Way::Restart => robot.restarting(&restart)?,
                Way::Nothing | Way::Floor => robot,
            };
            ground.drive(robot, legs)
        };
        drives.par_iter().enumerate().map(drive).collect()
    }

    fn recovery(&self, way: Way, jumps: &[Jump], drives: &[Vec<Answers>]) -> Recovery {
        let both = jumps
            .iter()
            .zip(drives)
            .filter(|(_, drive)| is_right(drive));
        let at_m: Vec<(usize, Option<f64>)> = both
            .map(|(jump, drive)| (jump.after.unit, converged_at_m(&jump.after, &drive[1])))
            .collect();
        let found: Vec<(usize, bool)> = at_m.iter().map(|(u, at)| (*u, at.is_some())).collect();
        let (resamples, seed) = (self.context.config.resamples, self.context.seed());
        let found = ClusteredMean::share(&found, resamples, seed);
        let at_m: Vec<Option<f64>> = at_m.into_iter().map(|(_, at_m)| at_m).collect();
        Recovery {
            way,
            localised: at_m.len(),
            recovered: found.map(|found| found.mean),
            recovered_ci95: found.and_then(|found| found.ci95),
            recovered_after_m: median_distance_m(&at_m),
        }
    }

    /// Restart against floor over the same trials; none where there is no trial.
    fn against(
        &self,
        trials: &[Trial],
        floor: &[Answers],
        restart: &[Answers],
    ) -> Option<PairedTest> {
        let config = self.context.config;
        let figures =
            [floor, restart].map(|answers| TrialFigures::new(trials, answers, config.spacing_m));
        let named = [("floor", &figures[0]), ("restart", &figures[1])];
        let unit_of: Vec<usize> = trials.iter().map(|trial| trial.unit).collect();
        let tests = paired_tests(&named, &unit_of, config.resamples, self.context.seed());
        tests.into_iter().next().filter(|_| !trials.is_empty())
    }

    /// Metres from the jump until the robot says that it is lost; none where it is found before, or never says so.
    fn noticed_at_m(&self, after: &Trial, answers: &Answers) -> Option<f64> {
        let lost = self.lost?;
        let until_m = converged_at_m(after, answers).unwrap_or(f64::INFINITY);
        let mut steps = after.travelled_m.iter().enumerate();
        let says_so = |(step, m): &(usize, &f64)| {
            let score = answers.sureness.score(*step, Some(lost));
            **m < until_m && score.is_some_and(|score| score >= lost.threshold)
        };
        steps.find(says_so).map(|(_, metres)| *metres)
    }
}

/// Was the robot right when it was carried away?
fn is_right(drive: &[Answers]) -> bool {
    let before = drive.first().and_then(|leg| leg.point_error_m.last());
    before.is_some_and(|error_m| *error_m <= SURE_WITHIN_M)
}
