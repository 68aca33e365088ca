//! What is noted of a belief after each step, to judge later how sure it was: the truth's part of it included.

use crate::{
    belief::{Belief, Grid, Places},
    localiser::{
        Probable,
        live::LEAST_MODE,
        lost::{LostConfig, NEAR_M},
    },
};

/// How sure a belief was along one trial, one entry a snapshot; empty where an answer comes without a belief.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Sureness {
    /// Mass within 1 m of the point estimate.
    pub near_mass: Vec<f64>,
    /// How well the point estimate, with the way that led there, explains the last snapshots
    /// ([`Hindsight::ratios`](crate::belief::Hindsight::ratios)); empty where nobody knows.
    pub ratios: Vec<Vec<f64>>,
    /// What the belief gave to the place of the truth, one cell wide, any heading; none where that is off the grid.
    pub true_place_mass: Vec<Option<f64>>,
    /// Entropy after the last snapshot, in nats.
    pub end_entropy_nats: Option<f64>,
    /// Modes of the last belief that hold a twentieth or more.
    pub end_modes: Option<usize>,
}

impl Sureness {
    /// Notes a belief over the cells of a grid, of a robot at place `k` of `truths`.
    pub(super) fn note(&mut self, grid: &Grid, belief: &Belief, truths: &Places, k: usize) {
        let (cells, mode) = (grid.places(), belief.mode());
        self.near_mass
            .push(belief.mass_within_m(cells, mode, NEAR_M));
        let sites = grid.len() / grid.headings();
        let of_site = |cell: usize| {
            let cells = (cell % sites..grid.len()).step_by(sites);
            cells.map(|cell| belief.mass()[cell]).sum()
        };
        let truth = grid.cell_at(truths, k);
        self.true_place_mass.push(truth.map(of_site));
    }

    /// The lost score after a step, by these constants where the last snapshots are known, else 1 less the mass; none where an answer comes without
    /// a belief.
    pub(super) fn score(&self, step: usize, lost: Option<&LostConfig>) -> Option<f64> {
        let near_mass = *self.near_mass.get(step)?;
        Some(match (lost, self.ratios.get(step)) {
            (Some(lost), Some(ratios)) => lost.score(near_mass, ratios),
            _ => 1.0 - near_mass,
        })
    }

    /// Notes the last belief of a trial.
    pub(super) fn end(&mut self, belief: &Belief) {
        self.end_entropy_nats = Some(belief.entropy());
        self.end_modes = Some(belief.modes(NEAR_M, LEAST_MODE).len());
    }

    /// Notes a posterior over places in the plane, such as particles; places within one square, its edges `square_m` long, are one
    /// place. `near` is what it gives to places within 1 m of its estimate.
    pub(super) fn note_places(
        &mut self,
        posterior: &[Probable],
        near: f64,
        truth: [f64; 2],
        square_m: f64,
    ) {
        let square = |place: [f64; 2]| place.map(|v| (v / square_m).floor() as i64);
        let here = posterior.iter().filter(|p| square(p.0) == square(truth));
        self.near_mass.push(near);
        self.true_place_mass
            .push(Some(here.map(|(_, mass)| mass).sum()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{belief::GridConfig, geometry::Pose};

    #[test]
    fn the_true_place_counts_with_all_its_headings() {
        let config = GridConfig {
            headings: 4,
            margin_m: 0.5,
            ..GridConfig::default()
        };
        let here = Places::Plane(vec![Pose::new(0.1, 0.1, 0.0), Pose::new(50.0, 0.0, 0.0)]);
        let grid = Grid::over(&here.select(&[0]), &config).unwrap();
        let belief = Belief::uniform(grid.places()).unwrap();
        let mut sureness = Sureness::default();
        sureness.note(&grid, &belief, &here, 0);
        sureness.note(&grid, &belief, &here, 1);
        let sites = grid.len() as f64 / 4.0;
        let of_truth = sureness.true_place_mass[0].unwrap();
        assert!((of_truth - 1.0 / sites).abs() < 1e-12);
        assert_eq!(sureness.true_place_mass[1], None);
        assert!((sureness.near_mass[0] - 1.0).abs() < 1e-9);
    }

    #[test]
    fn particles_count_by_squares() {
        let posterior = [([0.1, 0.1], 0.5), ([0.2, 0.2], 0.25), ([3.0, 0.0], 0.25)];
        let mut sureness = Sureness::default();
        sureness.note_places(&posterior, 0.75, [0.05, 0.05], 0.25);
        assert_eq!(sureness.true_place_mass, [Some(0.75)]);
        assert_eq!(sureness.near_mass, [0.75]);
    }
}
