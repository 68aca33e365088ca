//! A rival that learns nothing: raw snapshots, held against those that are remembered by their distance.

use super::{LifelongConfig, judge::judged};
use crate::{
    belief::{Grid, GridConfig, Neighbours, Places, Uncertainty},
    detector::input::{Input, InputConfig},
    error::Result,
    experiment::{evidence_tuning::tuned_bandwidth, mapped::Mapped},
    learning::training_set::covered,
    localiser::{
        LiveLocaliser, SelfLabel, SelfLabelConfig, SensorModel,
        self_labels::{Labeller, self_labels},
        sensor_model::{EvidenceScale, PreparedSensorModel, RawKernel, Scaled, least_mean_squares},
    },
    model::{Memory, Model},
    recording::Recording,
    seed::Seed,
};
use ndarray::Axis;
use std::sync::Arc;

/// What makes snapshots comparable, and how alike is alike: as found on the first day, one run against the others.
pub(super) struct Scans {
    input: Input,
    bandwidth: f64,
    scale: EvidenceScale,
}

/// Powers of its evidence that are tried on the last run of the first day, against a map of the others.
const SCALES: [f64; 4] = [1.0, 0.5, 0.25, 0.125];

impl Scans {
    pub(super) fn of(model: &Model, memory: &Memory, lifelong: &LifelongConfig) -> Result<Self> {
        let recording = memory.recording();
        let every: Vec<usize> = (0..recording.len()).collect();
        let config: InputConfig = Mapped::from(model).input;
        let input = Input::fit(&config, recording, &every)?.with_common_scale();
        let (runs, places) = (recording.run_numbers(&every), Places::of(recording));
        let last = runs.iter().copied().max().unwrap_or(0);
        let (asked, mapped): (Vec<usize>, Vec<usize>) =
            every.iter().partition(|&&k| runs[k] == last);
        let (asked, mapped) = match mapped.is_empty() {
            true => every.iter().partition(|&&k| k % 2 == 0),
            false => (asked, mapped),
        };
        let map = places.select(&mapped);
        let last_run = recording.select(&asked)?;
        let asked = covered(&places, &asked, &map);
        let inputs = input.transform(recording)?;
        let views = [inputs.select(Axis(0), &mapped)];
        let square = least_mean_squares(inputs.select(Axis(0), &asked).view(), &views);
        let truths = places.select(&asked);
        let mut scans = Self {
            bandwidth: tuned_bandwidth(Uncertainty::Global, &truths, &map, square.view()),
            input,
            scale: EvidenceScale::of(SCALES[0]),
        };
        let others = recording.select(&mapped)?;
        let mut best: Option<(f64, EvidenceScale)> = None;
        for scale in SCALES {
            scans.scale = EvidenceScale::of(scale);
            let mut robot = scans.robot_of(model, &others)?;
            let seed = Seed(model.header.recipe.seed).within("evidence");
            let judged = judged(&mut robot, &last_run, lifelong, seed)?;
            let error_m: f64 = judged.curve_m.iter().sum();
            if best.is_none_or(|(least_m, _)| error_m < least_m) {
                best = Some((error_m, scans.scale));
            }
        }
        scans.scale = best.map_or(scans.scale, |(_, scale)| scale);
        Ok(scans)
    }

    /// The kernel over what is remembered.
    fn kernel(&self, model: &Model, memory: &Recording, grid: &Grid) -> Result<RawKernel> {
        let map = &model.header.recipe.map;
        let near = Neighbours::find(&Places::of(memory), grid.places(), &map.nearness)?;
        RawKernel::new(
            self.input.clone(),
            vec![self.input.transform(memory)?],
            Arc::new(near),
            self.bandwidth,
            map.unmodelled_probability,
        )
    }

    /// A robot that goes by it.
    pub(super) fn robot(&self, model: &Model, memory: &Memory) -> Result<LiveLocaliser> {
        self.robot_of(model, memory.recording())
    }

    fn robot_of(&self, model: &Model, memory: &Recording) -> Result<LiveLocaliser> {
        let grid = Arc::new(Grid::over(&Places::of(memory), &GridConfig::default())?);
        let kernel = Box::new(self.kernel(model, memory, &grid)?);
        let motion = model.header.motion.clone();
        let stream = Seed(0).stream("unused");
        let robot = LiveLocaliser::from_parts(&grid, motion, kernel, stream)?;
        Ok(robot.scaled(self.scale))
    }

    /// How such a robot labels a day.
    pub(super) fn labels(
        &self,
        model: &Model,
        memory: &Memory,
        day: &Recording,
        config: &SelfLabelConfig,
    ) -> Result<Vec<SelfLabel>> {
        let grid = Arc::new(Grid::over(&model.places(), &config.grid)?);
        let kernel = self.kernel(model, memory.recording(), &grid)?;
        let every: Vec<usize> = (0..day.len()).collect();
        let prepared = kernel.prepare(day, &every)?;
        let scaled: &dyn PreparedSensorModel = &Scaled::new(&*prepared, self.scale);
        let labeller = Labeller {
            grid: &grid,
            motion: &model.header.motion,
            sensor: scaled,
            pose: &model.pose,
            route_m: model.route_m.as_deref(),
            is_mapped: None,
        };
        self_labels(&labeller, day, config, None)
    }
}
