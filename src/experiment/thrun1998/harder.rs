//! Why the simulated corridor is easier than the paper's: what it assumes, made harder piece by piece.

use super::{Thrun1998Config, reductions::Fold, set_record::JudgedRow};
use crate::{
    error::Result,
    experiment::reproduce::Paper,
    score::MeanInterval,
    seed::Seed,
    world::{
        Building,
        simulation::{Choice, simulate},
    },
};
use serde::{Deserialize, Serialize};

/// A guess: what it is called, and the keys that are put below the heads of tables of the world.
struct Guess {
    name: &'static str,
    keys: &'static [(&'static str, &'static str)],
}

/// Keys of a robot that wanders, and turns to get out of people's way: T98 5.1.2 has "sometimes substantially changed the heading".
const WANDERS: (&str, &str) = ("[robot]", "lateral_sd_m = 0.24\nheading_sd_rad = 0.2");
/// Of a camera of that time, and of its colours.
const NOISY: (&str, &str) = ("[camera]", "read_noise = 12.0");
/// Of a corridor full of people.
const CROWDED: (&str, &str) = ("[people]", "per_minute = 5.0");

const GUESSES: [Guess; 4] = [
    Guess {
        name: "wanders twice as far, turns by 0.2 rad",
        keys: &[WANDERS],
    },
    Guess {
        name: "camera of eight times the noise",
        keys: &[NOISY],
    },
    Guess {
        name: "ten times as many people",
        keys: &[CROWDED],
    },
    Guess {
        name: "all of these",
        keys: &[WANDERS, NOISY, CROWDED],
    },
];

/// Number of guesses.
pub(super) const COUNT: usize = GUESSES.len();

/// An approach at ±2 m in a corridor that is harder in one way.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct HarderRecord {
    /// In words.
    pub name: String,
    /// `door`, `ceiling_light` or `ball`.
    pub approach: String,
    /// n.
    pub features: usize,
    /// Error reduction at ±2 m by the objective, as a share.
    pub objective: MeanInterval,
    /// By the map of the other runs.
    pub held_out: MeanInterval,
}

/// One guess, on one data set: landmarks chosen by people, one and four features.
pub(super) fn harder(
    config: &Thrun1998Config,
    set: &str,
    number: usize,
) -> Result<Vec<HarderRecord>> {
    let choice = Choice {
        set: Some(set.into()),
        runs: Some(config.runs),
    };
    let recording = simulate(
        &Building::from_text(&world(number)?)?,
        Seed(config.seed),
        &choice,
    )?;
    let folds = (0..config.runs).map(|tested| {
        let fold = Fold::one_and_four(config, &recording, set, tested)?;
        fold.local_rows()
    });
    let folds = folds.collect::<Result<Vec<_>>>()?;
    let of_row = |row: usize| {
        let mean = |of: fn(&JudgedRow) -> Option<f64>| {
            let values: Option<Vec<f64>> = folds.iter().map(|rows| of(&rows[row])).collect();
            MeanInterval::of(&values?)
        };
        Some(HarderRecord {
            name: GUESSES[number].name.into(),
            approach: folds.first()?[row].approach.into(),
            features: folds.first()?[row].features,
            objective: mean(|row| row.objective)?,
            held_out: mean(|row| row.held_out)?,
        })
    };
    let rows = folds.first().map_or(0, Vec::len);
    Ok((0..rows).filter_map(of_row).collect())
}

/// The paper's world as a guess has it.
fn world(number: usize) -> Result<String> {
    let mut text = Paper::Thrun1998.file("worlds/thrun1998.toml")?.to_string();
    for (table, keys) in GUESSES[number].keys {
        text = with_keys(&text, table, keys);
    }
    Ok(text)
}

/// A world with some keys of a table other than they were, whether or not they were there.
fn with_keys(text: &str, table: &str, keys: &str) -> String {
    let named = |line: &str| line.split('=').next().map(str::trim).map(String::from);
    let replaced: Vec<Option<String>> = keys.lines().map(named).collect();
    let (mut made, mut is_within) = (String::new(), false);
    for line in text.lines() {
        let is_head = line.starts_with('[');
        if is_head {
            is_within = line.starts_with(table);
        }
        if is_within && !is_head && line.contains('=') && replaced.contains(&named(line)) {
            continue;
        }
        made += line;
        made += "\n";
        if is_head && is_within {
            made += keys;
            made += "\n";
        }
    }
    made
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_take_the_place_of_those_that_were_there() {
        let text = "name = \"a\"\n[robot] # b\nkind = \"b21\"\nspeed = 1\n[people]\nspeed = 2\n";
        let made = with_keys(text, "[robot]", "speed = 3\nwander = 4");
        let expected = "name = \"a\"\n[robot] # b\nspeed = 3\nwander = 4\nkind = \"b21\"\n[people]\nspeed = 2\n";
        assert_eq!(made, expected);
    }

    #[test]
    fn every_guess_makes_another_world() {
        for (number, guess) in GUESSES.iter().enumerate() {
            let made = world(number).unwrap();
            assert!(!guess.keys.is_empty());
            assert!(guess.keys.iter().all(|(_, keys)| made.contains(keys)));
            Building::from_text(&made).unwrap();
        }
    }

    #[test]
    fn doors_and_features_are_judged_in_a_harder_corridor() {
        let config = Thrun1998Config {
            steps: 8,
            ..Thrun1998Config::default().toy()
        };
        let made = harder(&config, "d1", COUNT - 1).unwrap();
        let rows = made.iter().map(|row| (row.approach.as_str(), row.features));
        assert_eq!(
            rows.collect::<Vec<_>>(),
            [("door", 1), ("ball", 1), ("ball", 4)]
        );
        assert_eq!(made[0].name, "all of these");
        let shares = made.iter().map(|row| row.objective.mean);
        assert!(shares.is_sorted(), "{made:?}");
    }
}
