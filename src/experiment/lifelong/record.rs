//! What came of it, over seeds.

use super::{LifelongConfig, ROBOTS, RobotKind, judge::Judged};
use crate::{
    experiment::adaptation::{AdaptConfig, LabelRecord},
    learning::Recipe,
    score::MeanInterval,
};
use serde::{Deserialize, Serialize};

/// How a world changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Change {
    /// Doors, things and lamps from night to night, daylight from day to day.
    Changing,
    /// Nothing ever does.
    Still,
}

/// The whole experiment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct LifelongRecord {
    /// Version of this crate that ran it.
    pub version: String,
    /// Days and seeds.
    pub config: LifelongConfig,
    /// What the first day's model is trained by; its seed is the world's.
    pub recipe: Recipe,
    /// How it is adapted.
    pub adapt: AdaptConfig,
    /// The world that changes, and the one that doesn't.
    pub worlds: Vec<WorldRow>,
}

/// A world's robots.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct WorldRow {
    /// Which world.
    pub change: Change,
    /// Each robot, the frozen one first.
    pub robots: Vec<RobotRow>,
}

/// How a robot did, over all days but the first; means and intervals over seeds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct RobotRow {
    /// Which robot.
    pub kind: RobotKind,
    /// Its name.
    pub title: String,
    /// Mean expected error after 10 m from a start anywhere, metres.
    pub error_at_10m_m: MeanInterval,
    /// The same minus that of the first day's model of the same world: below 0 where learning on helps.
    pub error_at_10m_m_change: MeanInterval,
    /// Share of the trials that end up sure and right within 1 m.
    pub found: MeanInterval,
    /// Minus that of the first day's model.
    pub found_change: MeanInterval,
    /// Mean distance until then, metres; never counts as the trial's length.
    pub found_after_m: MeanInterval,
    /// Minus that of the first day's model.
    pub found_after_m_change: MeanInterval,
    /// First distance at which the mean error over all days and seeds is at most 1 m; none within a trial's length.
    pub mean_below_1m_at_m: Option<f64>,
    /// Day by day.
    pub days: Vec<DayRow>,
}

/// A day of a robot, the first one that is judged being number 2.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct DayRow {
    /// Its number, from 2.
    pub day: usize,
    /// Mean expected error after 10 m.
    pub error_at_10m_m: MeanInterval,
    /// Share of the trials that end up sure and right.
    pub found: MeanInterval,
    /// Share of the day's snapshots whose own label was kept, afterwards; none where it labels nothing by itself.
    pub labels_kept: Option<f64>,
    /// Share of these that are wrong by more than a metre, over all seeds.
    pub labels_wrong: Option<f64>,
    /// Mean over seeds of their median error, metres.
    pub labels_median_m: Option<f64>,
    /// And of the error that 95 of 100 are below, metres.
    pub labels_p95_m: Option<f64>,
}

impl WorldRow {
    /// From what was played, `[seed][robot][day]`.
    pub(super) fn new(
        change: Change,
        played: &[Vec<Vec<Judged>>],
        config: &LifelongConfig,
    ) -> Self {
        let robots = ROBOTS.iter().enumerate();
        Self {
            change,
            robots: robots
                .filter_map(|(number, kind)| RobotRow::new(*kind, number, played, config))
                .collect(),
        }
    }
}

impl RobotRow {
    fn new(
        kind: RobotKind,
        number: usize,
        played: &[Vec<Vec<Judged>>],
        config: &LifelongConfig,
    ) -> Option<Self> {
        let rival = match kind {
            RobotKind::RawAdapted => ROBOTS.iter().position(|k| *k == RobotKind::RawFrozen)?,
            _ => 0,
        };
        let over_days = |days: &[Judged], value: fn(&Judged) -> f64| {
            days.iter().map(value).sum::<f64>() / days.len() as f64
        };
        let mean = |value: fn(&Judged) -> f64| {
            let each = played.iter().map(|seed| over_days(&seed[number], value));
            MeanInterval::of(&each.collect::<Vec<_>>())
        };
        let change = |value: fn(&Judged) -> f64| {
            let each = played
                .iter()
                .map(|seed| over_days(&seed[number], value) - over_days(&seed[rival], value));
            MeanInterval::of(&each.collect::<Vec<_>>())
        };
        let all = || played.iter().flat_map(|seed| &seed[number]);
        let steps = all().next()?.curve_m.len();
        let mean_at =
            |step: usize| all().map(|day| day.curve_m[step]).sum::<f64>() / all().count() as f64;
        let below = (0..steps).find(|&step| mean_at(step) <= 1.0);
        let days = 0..played.first()?.get(number)?.len();
        Some(Self {
            kind,
            title: kind.title().into(),
            error_at_10m_m: mean(|day| day.error_at_10m_m)?,
            error_at_10m_m_change: change(|day| day.error_at_10m_m)?,
            found: mean(|day| day.found)?,
            found_change: change(|day| day.found)?,
            found_after_m: mean(|day| day.found_after_m)?,
            found_after_m_change: change(|day| day.found_after_m)?,
            mean_below_1m_at_m: below.map(|step| step as f64 * config.spacing_m),
            days: days
                .filter_map(|day| {
                    let today: Vec<&Judged> =
                        played.iter().map(|seed| &seed[number][day]).collect();
                    DayRow::new(day + 2, &today)
                })
                .collect(),
        })
    }
}

impl DayRow {
    fn new(day: usize, today: &[&Judged]) -> Option<Self> {
        let mean = |value: fn(&Judged) -> f64| {
            let each = today.iter().map(|judged| value(judged));
            MeanInterval::of(&each.collect::<Vec<_>>())
        };
        let labels: Option<Vec<LabelRecord>> = today.iter().map(|judged| judged.labels).collect();
        let labels = labels.unwrap_or_default();
        let sum = |of: &dyn Fn(&LabelRecord) -> f64| labels.iter().map(of).sum::<f64>();
        let (all, kept) = (sum(&|l| l.snapshots as f64), sum(&|l| l.kept as f64));
        let wrong = sum(&|l| {
            l.errors
                .map_or(0.0, |errors| errors.beyond_1m * l.kept as f64)
        });
        let errors: Vec<_> = labels.iter().filter_map(|l| l.errors).collect();
        let mean_of = |values: Vec<f64>| MeanInterval::of(&values).map(|mean| mean.mean);
        Some(Self {
            day,
            error_at_10m_m: mean(|judged| judged.error_at_10m_m)?,
            found: mean(|judged| judged.found)?,
            labels_kept: (all > 0.0).then(|| kept / all),
            labels_wrong: (kept > 0.0).then(|| wrong / kept),
            labels_median_m: mean_of(errors.iter().map(|e| e.median_m).collect()),
            labels_p95_m: mean_of(errors.iter().map(|e| e.p95_m).collect()),
        })
    }
}
