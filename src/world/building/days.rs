//! `[days]`: runs of one day find the building alike, and from day to day some of it changes for good.
//!
//! Where every run draws its doors anew, nothing lasts, and what was seen yesterday tells no more of today than what was seen a year
//! ago. Here each door, thing and lamp stays as it is with some probability a night, and is drawn anew otherwise, each by itself;
//! shares of open doors are what they were. How bright lamps and daylight are is drawn for each day.

use super::within;
use crate::{
    error::{Error, Result},
    seed::{Seed, Stream},
};
use rand::RngExt;
use serde::Deserialize;

/// How a building changes from day to day.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DaysConfig {
    /// Runs of one day.
    pub runs: usize,
    /// Probability that a door, a thing or a lamp is as it was the day before.
    pub kept: f64,
    /// Probability that a lamp burns which does so in the file.
    #[serde(default = "always")]
    pub lit: f64,
}

fn always() -> f64 {
    1.0
}

/// Most days that anything is followed through: a building of many runs should not take a minute a door.
const MOST_DAYS: u64 = 100_000;

impl DaysConfig {
    pub(super) fn check(&self) -> Result<()> {
        if self.runs == 0 {
            return Err(Error::usage(
                "[days]: `runs` is 0; expected at least one run a day",
            ));
        }
        within(self.kept, "kept", 0.0..=1.0, "[days]")?;
        within(self.lit, "lit", 0.0..=1.0, "[days]")
    }

    /// The day of a run.
    pub(super) fn day(&self, run: u64) -> u64 {
        (run / self.runs as u64).min(MOST_DAYS)
    }

    /// What number `number` of a kind draws its state of a day from: the same stream until it changes.
    pub(super) fn state(&self, seed: Seed, kind: &str, number: usize, day: u64) -> Stream {
        let name = format!("world/days/{kind}/{number}");
        let changes = format!("{name}/changes");
        let changes = |day: &u64| {
            let draw: f64 = seed.numbered_stream(&changes, *day).random();
            draw >= self.kept
        };
        let since = (1..=day).rev().find(changes).unwrap_or(0);
        seed.numbered_stream(&name, since)
    }
}

#[cfg(test)]
mod tests {
    use crate::{
        seed::Seed,
        world::{Building, RunScene},
    };

    /// A hall with forty doors, a bin and a lamp.
    fn hall(days: &str) -> crate::error::Result<Building> {
        let doors = (0..40).map(|n| {
            let at_m = 0.5 + 2.0 * f64::from(n);
            format!("{{ at_m = {at_m}, width_m = 1, open = 0.5, opened_deg = [90, 90] }}")
        });
        let doors = doors.collect::<Vec<_>>().join(", ");
        Building::from_text(&format!(
            "name = \"hall\"\nlight = [{{ at = [1, 1] }}]\nthing = [{{ at = [5, 3], radius_m = 0.2, moved_sd_m = 0.3 }}]\n\
             [building]\ndaylight = [0.0, 1.0]\n[[wall]]\npoints = [[0, 0], [90, 0], [90, 6], [0, 6]]\nclosed = true\n\
             door = [{doors}]\n[sonar]\n[path]\ncorners = [[1, 3], [9, 3]]\n[record]\nevery_m = 1\n{days}"
        ))
    }

    /// Which of the doors stand open.
    fn open(scene: &RunScene) -> Vec<bool> {
        let walls = scene.plan.walls();
        let leaf = |n: i32| {
            let from_m = 0.5 + 2.0 * f64::from(n);
            // Something stands right behind a shut door; an open one's room is deep.
            walls.iter().all(|wall| {
                let [x_m, y_m] = [
                    0.5 * (wall.from.x + wall.to.x),
                    0.5 * (wall.from.y + wall.to.y),
                ];
                !((from_m + 0.3..from_m + 0.7).contains(&x_m) && (-0.3..0.0).contains(&y_m))
            })
        };
        (0..40).map(leaf).collect()
    }

    fn changed(a: &RunScene, b: &RunScene) -> usize {
        let (a, b) = (open(a), open(b));
        a.iter().zip(&b).filter(|(a, b)| a != b).count()
    }

    #[test]
    fn a_day_lasts_and_a_night_changes_some() {
        let hall = hall("[days]\nruns = 2\nkept = 0.8\nlit = 0.5").unwrap();
        let run = |run: u64| hall.plan_of_run(Seed(2), run).unwrap();
        let first = run(0);
        assert!((8..=32).contains(&open(&first).iter().filter(|open| **open).count()));
        assert_eq!(first, run(1));
        // Of forty doors eight are drawn anew, and four of them differ; after twenty nights half of all do.
        let nights = (0..20).map(|day| changed(&run(2 * day), &run(2 * day + 2)));
        let nights: usize = nights.sum();
        assert!((40..=120).contains(&nights), "{nights}");
        assert!((10..=30).contains(&changed(&first, &run(40))));
        assert_ne!(first.daylight, run(2).daylight);
        let lamps = (0..20).map(|day| run(2 * day).lights[0].lit);
        let lamps: Vec<bool> = lamps.collect();
        assert!(lamps.contains(&true) && lamps.contains(&false), "{lamps:?}");
    }

    #[test]
    fn nothing_changes_where_all_is_kept() {
        let hall = hall("[days]\nruns = 1\nkept = 1").unwrap();
        let plan = |run: u64| hall.plan_of_run(Seed(2), run).unwrap().plan;
        assert_eq!(plan(0), plan(9));
    }

    #[test]
    fn days_that_make_no_sense_are_refused() {
        for (days, words) in [
            ("runs = 0\nkept = 1", "`runs` is 0"),
            ("runs = 1\nkept = 1.5", "`kept` is 1.5"),
            ("runs = 1\nkept = 1\nlit = -1", "`lit` is -1"),
        ] {
            let fault = hall(&format!("[days]\n{days}")).unwrap_err();
            assert!(
                fault.is_usage() && fault.to_string().contains(words),
                "{fault}"
            );
        }
    }
}
