//! Anchors: snapshots that correct the belief, and how much speaks against where it has them.

use super::prediction::{Explained, Prediction};
use crate::{
    belief::{Belief, smoothing::Moment},
    geometry::{Pose, wrapped},
    localiser::{
        live::LEAST_MODE,
        lost::{LostConfig, NEAR_M},
    },
};
use std::f64::consts::FRAC_PI_2;

/// A snapshot that corrects the belief, and what comes of it.
pub(super) struct Anchor {
    pub(super) snapshot: usize,
    /// Place in the grid's own coordinates: along a route `x_m` alone.
    pub(super) place: Pose,
    pub(super) near_mass: f64,
    pub(super) modes: usize,
    /// Is it more likely on the map than beyond?
    pub(super) is_mapped: bool,
    pub(super) explained: Explained,
}

impl Anchor {
    /// From what a run says of the moment of this snapshot; `is_mapped` says of each cell whether the map has it.
    pub(super) fn new(snapshot: usize, moment: &Moment, is_mapped: Option<&[bool]>) -> Self {
        let (belief, mode) = (&moment.belief, moment.belief.mode());
        let on_map = is_mapped.map_or(1.0, |is_mapped| {
            let cells = belief.mass().iter().zip(is_mapped);
            cells
                .map(|(mass, is_mapped)| if *is_mapped { *mass } else { 0.0 })
                .sum()
        });
        Self {
            snapshot,
            place: mean_about_mode(belief, mode),
            near_mass: belief.mass_within_m(belief.places(), mode, NEAR_M),
            modes: belief.modes(NEAR_M, LEAST_MODE).len(),
            is_mapped: on_map > 0.5,
            explained: Explained {
                by_belief: moment.by_others,
                anywhere: moment.anywhere,
            },
        }
    }
}

/// The mean of the cells within a metre and a quarter turn of the likeliest one: finer than a cell.
fn mean_about_mode(belief: &Belief, mode: usize) -> Pose {
    let (places, middle) = (belief.places(), belief.places().pose(mode));
    let (mut total, mut off) = (0.0, [0.0; 3]);
    for (cell, &mass) in belief.mass().iter().enumerate() {
        if mass == 0.0 {
            continue;
        }
        let pose = places.pose(cell);
        let turned_rad = wrapped(pose.heading_rad - middle.heading_rad);
        if middle.distance_m(&pose) <= NEAR_M && turned_rad.abs() <= FRAC_PI_2 {
            total += mass;
            off[0] += mass * (pose.x_m - middle.x_m);
            off[1] += mass * (pose.y_m - middle.y_m);
            off[2] += mass * turned_rad;
        }
    }
    let [x_m, y_m, heading_rad] = off.map(|sum| sum / total); // the mode has mass
    Pose::new(
        middle.x_m + x_m,
        middle.y_m + y_m,
        wrapped(middle.heading_rad + heading_rad),
    )
}

/// The lost score of a whole run: of the mean mass, and of how well the belief predicts on average what is sensed where it has not
/// seen it; of the anchors on the map, as nothing is predicted beyond.
pub(super) fn score_of_run(anchors: &[Anchor], lost: &LostConfig) -> f64 {
    let on_map: Vec<&Anchor> = anchors.iter().filter(|anchor| anchor.is_mapped).collect();
    let n = on_map.len().max(1) as f64;
    let mass = on_map.iter().map(|anchor| anchor.near_mass).sum::<f64>() / n;
    let each = on_map.iter().map(|anchor| {
        let mut one = Prediction::default(); // which bounds what a single snapshot says
        one.observe(anchor.explained, 1.0);
        one.mean()
    });
    lost.of_mean(mass, each.sum::<f64>() / n)
}

/// The lost score of every anchor. What its neighbours say on either side counts as much as what a live robot's last observations say.
pub(super) fn scores(anchors: &[Anchor], lost: &LostConfig) -> Vec<f64> {
    let means = |order: &mut dyn Iterator<Item = &Anchor>| {
        let mut prediction = Prediction::default();
        let each = order.map(|anchor| {
            prediction.observe(anchor.explained, lost.short);
            prediction.mean()
        });
        each.collect::<Vec<f64>>()
    };
    let onwards = means(&mut anchors.iter());
    let mut backwards = means(&mut anchors.iter().rev());
    backwards.reverse();
    let both = onwards.iter().zip(&backwards).map(|(a, b)| 0.5 * (a + b));
    let each = anchors.iter().zip(both);
    each.map(|(anchor, mean)| lost.of_mean(anchor.near_mass, mean))
        .collect()
}
