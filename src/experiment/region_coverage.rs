//! Is a belief as sure as it may be? How often the truth lies in the smallest regions that hold 50, 90, 95 and 99 % of it.

use super::{convergence::Answers, trials::Trial};
use crate::{
    belief::{Belief, Grid, Places},
    localiser::Probable,
    score::ClusteredMean,
    seed::Seed,
};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Masses of the regions that are reported.
pub const LEVELS: [f64; 4] = [0.5, 0.9, 0.95, 0.99];

/// How often the truth lies in a region of the belief.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Coverage {
    /// Mass of the region.
    pub level: f64,
    /// Share of the steps of all trials after which the cell of the truth is inside. Of a belief that is right about how sure
    /// it is, `level` or more (the last cell of a region is inside as a whole); less, where it is too sure.
    pub share: f64,
    /// Its 95 % interval, by bootstrap over runs or stretches with all their steps; null where there is only one.
    pub share_ci95: Option<[f64; 2]>,
}

/// Mass of all cells that are strictly likelier than the one nearest the truth: place `k` of `truths`. That cell belongs to
/// the highest-density region of some level (Hyndman, *Computing and graphing highest density regions*, The American
/// Statistician 50, 1996), the smallest set of cells with that mass, if this is below the level.
pub fn likelier_mass(grid: &Grid, belief: &Belief, truths: &Places, k: usize) -> f64 {
    let cells = grid.places();
    let nearer = |a: &usize, b: &usize| {
        let distance = |cell: usize| truths.distance_m(k, cells, cell);
        let turn = |cell: usize| truths.turn_rad(k, cells, cell);
        let by_distance = distance(*a).total_cmp(&distance(*b));
        by_distance.then_with(|| turn(*a).total_cmp(&turn(*b)))
    };
    let cell = grid.cell_at(truths, k);
    let Some(cell) = cell.or_else(|| (0..grid.len()).min_by(nearer)) else {
        return 1.0; // never: a grid has cells
    };
    let mass = belief.mass();
    mass.iter().filter(|m| **m > mass[cell]).sum()
}

/// The same of a posterior over places in the plane, such as particles: those within one square, its edges `square_m` long, make
/// a cell.
pub fn likelier_mass_of_places(posterior: &[Probable], truth: [f64; 2], square_m: f64) -> f64 {
    let square = |place: [f64; 2]| place.map(|v| (v / square_m).floor() as i64);
    let mut masses: BTreeMap<[i64; 2], f64> = BTreeMap::new();
    for &(place, p) in posterior {
        *masses.entry(square(place)).or_default() += p;
    }
    let of_truth = masses.get(&square(truth)).copied().unwrap_or(0.0);
    masses.values().filter(|mass| **mass > of_truth).sum()
}

/// Coverage over all steps of all trials; empty where the answers come without a belief.
pub fn coverage(
    trials: &[Trial],
    answers: &[Answers],
    resamples: usize,
    seed: Seed,
) -> Vec<Coverage> {
    let at_level = |level: f64| {
        let inside: Vec<(usize, bool)> = trials
            .iter()
            .zip(answers)
            .flat_map(|(trial, answers)| {
                let steps = answers.likelier_mass.iter();
                steps.map(move |likelier| (trial.unit, *likelier < level))
            })
            .collect();
        let inside = ClusteredMean::share(&inside, resamples, seed)?;
        Some(Coverage {
            level,
            share: inside.mean,
            share_ci95: inside.ci95,
        })
    };
    LEVELS.into_iter().filter_map(at_level).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::belief::GridConfig;

    /// Four cells of 1 m along a route with masses .5 .3 .1 .1.
    #[test]
    fn mass_of_likelier_cells_by_hand() {
        let config = GridConfig {
            cell_m: 1.0,
            ..GridConfig::default()
        };
        let grid = Grid::along_route(0.0, 3.5, &config).unwrap();
        assert_eq!(grid.len(), 4);
        let belief = Belief::from_mass(grid.places(), vec![0.1, 0.5, 0.3, 0.1]).unwrap();
        let Places::Route(centres) = &**grid.places() else {
            panic!("no route");
        };
        let mut truths = centres.clone();
        truths.push(99.0); // off the grid: the last cell is the nearest
        let truths = Places::Route(truths);
        let of = |k: usize| likelier_mass(&grid, &belief, &truths, k);
        for (k, expected) in [(0, 0.8), (1, 0.0), (2, 0.5), (3, 0.8), (4, 0.8)] {
            assert!((of(k) - expected).abs() < 1e-12, "{k}: {}", of(k));
        }
    }

    #[test]
    fn places_count_by_squares() {
        let posterior = [
            ([0.1, 0.1], 0.3),
            ([0.2, 0.2], 0.3),
            ([0.3, 0.1], 0.25),
            ([-0.1, 0.1], 0.15),
        ];
        let of = |x: f64| likelier_mass_of_places(&posterior, [x, 0.05], 0.25);
        for (x, expected) in [(0.05, 0.0), (0.4, 0.6), (-0.2, 0.85), (7.0, 1.0)] {
            assert!((of(x) - expected).abs() < 1e-12, "{x}: {}", of(x));
        }
    }

    #[test]
    fn every_step_counts_and_units_are_resampled() {
        let trial = |unit| Trial {
            stretch: unit,
            unit,
            snapshots: vec![0, 1],
            travelled_m: vec![0.0, 0.5],
        };
        let answers = |likelier: [f64; 2]| Answers {
            likelier_mass: likelier.to_vec(),
            ..Answers::default()
        };
        let trials = [trial(0), trial(1)];
        let rows = coverage(
            &trials,
            &[answers([0.0, 0.4]), answers([0.5, 0.95])],
            500,
            Seed(1),
        );
        let shares: Vec<(f64, f64)> = rows.iter().map(|row| (row.level, row.share)).collect();
        assert_eq!(shares, [(0.5, 0.5), (0.9, 0.75), (0.95, 0.75), (0.99, 1.0)]);
        assert_eq!(rows[0].share_ci95, Some([0.0, 1.0]));
        assert_eq!(rows[1].share_ci95, Some([0.5, 1.0]));
        let without = [Answers::default(), Answers::default()];
        assert_eq!(coverage(&trials, &without, 500, Seed(1)), []);
    }
}
