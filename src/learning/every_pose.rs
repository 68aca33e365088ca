//! Candidates that nobody visited: scans rendered at every pose of the training scans' map.
//!
//! A map that is filled from visits knows places and headings where the robot was. One that is filled from rendered scans
//! answers everywhere, if the networks answer a rendered scan as they answer a real one: that has to be learned. So the
//! candidates of a step are rendered scans, some beside its truths and some anywhere, and the truths are real snapshots.

use super::recipe::Recipe;
use crate::{
    belief::{FilledFrom, Grid, GridConfig, MapConfig, Places},
    detector::{
        input::Input,
        rendered::{RenderedInputs, SensedMap},
    },
    error::{Error, Result},
    geometry::{Pose, wrapped},
    mapping::{Occupancy, OccupancyMap, RangeSensors, drawn_maps, rendered_as},
    recording::{Recording, split::Split},
    seed::Stream,
};
use ndarray::{Array2, Axis};
use rand::seq::index;
use rand_distr::{Distribution, StandardNormal};
use std::collections::BTreeSet;

/// Most poses that are rendered for training: 64 MB of 160 inputs each.
const MOST_POSES: usize = 100_000;

/// How far from a truth two of its candidates are drawn (standard deviations, in metres): one that is nearly right, and one
/// that is not.
const BESIDE_M: [f64; 2] = [0.15, 0.6];
/// And how far turned, a metre.
const TURNED_RAD_PER_M: f64 = 1.0 / 3.0;

/// Snapshots that a map is held against.
const COMPARED: usize = 300;

/// What is rendered for a training.
pub struct EveryPose {
    /// Where it is rendered.
    pub sensed: SensedMap,
    /// Inputs at the training places, `[training snapshot, input]`.
    pub at_training: Array2<f32>,
    grid: Grid,
    /// Cells of the grid that may be candidates, ascending, …
    cells: Vec<usize>,
    /// … and their inputs, `[candidate, input]`.
    inputs: Array2<f32>,
}

impl EveryPose {
    /// For a recipe's map, as its [`MapConfig::filled_from`] says, from the training part of a split recording; `None` where the map is
    /// filled from visits. `given` is a map that was made elsewhere.
    ///
    /// # Errors
    /// Where rendered scans are asked for and the sensors don't allow them, or the scans draw no map.
    pub fn prepare(
        recipe: &Recipe,
        recording: &Recording,
        split: &Split,
        input: &Input,
        given: Option<&OccupancyMap>,
    ) -> Result<Option<Self>> {
        let asked = recipe.map.filled_from == FilledFrom::Rendered || given.is_some();
        let can_draw = recipe.descent.truths_per_step > 0;
        if recipe.map.filled_from == FilledFrom::Visits || !(asked || can_draw) {
            return Ok(None);
        }
        match Self::rendered(recording, split, input, given) {
            Ok(rendered) => Ok(Some(rendered)),
            Err(fault) if asked => Err(fault.context("map.filled_from")),
            Err(_) => Ok(None),
        }
    }

    fn rendered(
        recording: &Recording,
        split: &Split,
        input: &Input,
        given: Option<&OccupancyMap>,
    ) -> Result<Self> {
        let Places::Plane(poses) = Places::of(recording).select(&split.train) else {
            return Err(Error::work(
                "the training places lie along a route; expected poses in the plane for rendered scans",
            ));
        };
        let sensed = sensed_map(recording, split, input, given)?;
        let rendered = RenderedInputs::new(&sensed, recording.channels(), input)?;
        let at_training = rendered.at(&poses)?.values;
        let grid = grid_over(poses)?;
        let Places::Plane(all) = &**grid.places() else {
            return Err(Error::work("rendered scans: a grid along a route"));
        };
        let is_free = |cell: &usize| {
            let pose = &all[*cell];
            sensed.map.at(pose.x_m, pose.y_m) == Occupancy::Free
        };
        let free: Vec<usize> = (0..all.len()).filter(is_free).collect();
        let at: Vec<Pose> = free.iter().map(|&cell| all[cell]).collect();
        let at = rendered.at(&at)?;
        let seen: Vec<usize> = (0..free.len()).filter(|&k| at.seen[k]).collect();
        if seen.is_empty() {
            return Err(Error::work(
                "rendered scans: from no free cell is anything seen; expected a map of the places where the robot was",
            ));
        }
        Ok(Self {
            at_training,
            cells: seen.iter().map(|&k| free[k]).collect(),
            inputs: at.values.select(Axis(0), &seen),
            grid,
            sensed,
        })
    }

    /// Candidates for some truths: two beside each, the rest anywhere; about `count` of them, each once.
    pub fn draw(
        &self,
        truths: &Places,
        count: usize,
        random: &mut Stream,
    ) -> (Places, Array2<f32>) {
        let mut drawn = BTreeSet::new();
        for k in 0..truths.len() {
            let truth = truths.pose(k);
            for deviation_m in BESIDE_M {
                let mut off = |deviation: f64| -> f64 {
                    let standard: f64 = StandardNormal.sample(random);
                    deviation * standard
                };
                let turn_rad = off(deviation_m * TURNED_RAD_PER_M);
                let beside = Pose::new(
                    truth.x_m + off(deviation_m),
                    truth.y_m + off(deviation_m),
                    wrapped(truth.heading_rad + turn_rad),
                );
                let cell = self.grid.cell_of(&beside);
                drawn.extend(cell.and_then(|cell| self.cells.binary_search(&cell).ok()));
            }
        }
        let all = self.cells.len();
        for anywhere in index::sample(random, all, count.min(all)) {
            if drawn.len() >= count {
                break;
            }
            drawn.insert(anywhere);
        }
        let rows: Vec<usize> = drawn.into_iter().collect();
        let cells: Vec<usize> = rows.iter().map(|&row| self.cells[row]).collect();
        (
            self.grid.places().select(&cells),
            self.inputs.select(Axis(0), &rows),
        )
    }
}

/// How a map is read at a rendered pose: its own scan speaks for it, nobody else's.
pub fn alone(map: &MapConfig) -> MapConfig {
    let mut map = map.clone();
    map.nearness.k = 1;
    map
}

/// A grid over some poses, as fine as localisation's where that is not too much to render.
fn grid_over(poses: Vec<Pose>) -> Result<Grid> {
    let places = Places::Plane(poses);
    let mut config = GridConfig::default();
    loop {
        let grid = Grid::over(&places, &config)?;
        if grid.len() <= MOST_POSES {
            return Ok(grid);
        }
        config.cell_m *= (grid.len() as f64 / MOST_POSES as f64).sqrt().max(1.1);
    }
}

/// The map that training scans draw and the way to look at it: those in which rendered scans are most like the real ones of the
/// validation part, or where there is none of the training part. Sonar and infrared cones may be taken as such or as rays, in
/// drawing and in looking.
fn sensed_map(
    recording: &Recording,
    split: &Split,
    input: &Input,
    given: Option<&OccupancyMap>,
) -> Result<SensedMap> {
    let sensors = RangeSensors {
        channels: input.channel_names().map(String::from).collect(),
        ..RangeSensors::default()
    };
    let maps = match given {
        Some(map) => vec![map.clone()],
        None => drawn_maps(recording, &split.train, &sensors)?,
    };
    let looks = rendered_as(recording, &sensors)?;
    let asked = match split.validation.is_empty() {
        true => &split.train,
        false => &split.validation,
    };
    let compared: Vec<usize> = asked
        .iter()
        .step_by(asked.len().div_ceil(COMPARED).max(1))
        .copied()
        .collect();
    let real = input.transform(&recording.select(&compared)?)?;
    let poses: Vec<Pose> = compared.iter().map(|&k| recording.poses()[k]).collect();
    let mut best: Option<(f32, SensedMap)> = None;
    for map in maps {
        for sensors in &looks {
            let sensed = SensedMap {
                map: map.cropped(),
                sensors: sensors.clone(),
            };
            let rendered = RenderedInputs::new(&sensed, recording.channels(), input)?;
            let off = (rendered.at(&poses)?.values - &real).mapv(f32::abs);
            let off = off.mean().unwrap_or(f32::INFINITY);
            if best.as_ref().is_none_or(|(least, _)| off < *least) {
                best = Some((off, sensed));
            }
        }
    }
    let best = best.map(|(_, sensed)| sensed);
    best.ok_or_else(|| Error::work("rendered scans: no map to choose from"))
}

#[cfg(test)]
mod tests;
