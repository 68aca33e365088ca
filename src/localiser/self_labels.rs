//! A robot that knows its place labels what it senses by itself.
//!
//! Thrun (1998, section 7): "As the robot knows roughly where it is, BaLL can use its position estimates to label sensor data
//! automatically, and use this self-labeled data for further training." A run is played from its odometry and observations alone;
//! of its poses nothing is read. Anchors, snapshots `spacing_m` apart by odometry, are corrected by what they sense, as evidence
//! was tuned at that spacing; their places are those of the belief that the whole run gives ([`smooth`]), so that a robot that had no
//! idea at first labels its first metres as well. Snapshots between two anchors lie where odometry has them, the difference that is left shared
//! out along the way.
//!
//! A wrong label teaches a wrong map, which gives more wrong labels. So the labels of a run pass the gate only where its belief is sure (its mass
//! within 1 m of the likeliest place, on average) and predicts what is sensed without having seen it ([`LostConfig::score`](super::LostConfig::score)), and each
//! of them only where its belief has that one place ([`modes`](Belief::modes)) and has it on the map and not beyond ([`SelfLabelConfig::beyond_m`]). The run is asked as a whole, since what has changed contradicts the map where it
//! is sensed, and is what there is to learn ([`GateOver`]).

use super::{
    PreparedSensorModel,
    sensor_model::{Scaled, scale_of, sensor_of},
};
use crate::{
    belief::{
        Belief, Evidence, Grid, OdometryMotion, Places,
        smoothing::{Knowing, smooth},
    },
    error::{Error, Result},
    geometry::{Displacement, Pose},
    model::Model,
    recording::Recording,
    seed::Seed,
};
use std::{ops::Range, sync::Arc};

mod along_route;
mod anchor;
mod between;
mod beyond;
mod config;
mod prediction;

pub use config::{GateOver, LabelsFrom, SelfLabelConfig};

use along_route::RouteInPlane;
use anchor::{Anchor, score_of_run, scores};
use between::between;
use beyond::{Beyond, BeyondTheMap};

/// Where a robot believes that it took a snapshot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SelfLabel {
    /// The place, in the frame of the map.
    pub pose: Pose,
    /// And along its route in metres, where it has one.
    pub route_m: Option<f64>,
    /// How much speaks against it, 0 to 1: [`LostConfig::score`](super::LostConfig::score).
    pub score: f64,
    /// Did it pass the gate?
    pub kept: bool,
    /// Is the place, or one next to it on the way, believed to be beyond the map?
    pub beyond: bool,
}

/// A known start: a Gaussian about a pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KnownStart {
    /// The pose; along a route `x_m` is the coordinate.
    pub pose: Pose,
    /// Standard deviation along the ground, metres.
    pub spread_m: f64,
    /// And of the heading, radians.
    pub spread_rad: f64,
}

/// What a run is played with: a sensor model at the cells of a grid, and the places of its map in the plane.
pub struct Labeller<'a> {
    /// Cells of the belief.
    pub grid: &'a Arc<Grid>,
    /// How far odometry can be trusted.
    pub motion: &'a OdometryMotion,
    /// What the snapshots of the recording say, evidence scaled.
    pub sensor: &'a dyn PreparedSensorModel,
    /// Poses of the map.
    pub pose: &'a [Pose],
    /// Their coordinates along the route, where there is one.
    pub route_m: Option<&'a [f64]>,
    /// Whether a cell is one of the map, `[cell]`, where the grid reaches beyond it: what is believed to be beyond is not kept.
    pub is_mapped: Option<&'a [bool]>,
}

/// A label for every snapshot of a recording, as a trained model gives them; each run from no idea where, or the first from a known
/// start. Of the recording its observations and runs are read, never its poses or its route.
///
/// # Errors
/// Where a constant makes no sense, the recording lacks the model's sensors, or the start is off the map.
pub fn of_model(
    model: &Model,
    recording: &Recording,
    config: &SelfLabelConfig,
    start: Option<KnownStart>,
) -> Result<Vec<SelfLabel>> {
    config.check()?;
    let recording = &*model.seen_in(recording)?;
    let cells = Beyond::new(&model.places(), &config.grid, config.beyond_m)?;
    let sensor = sensor_of(model, &cells.mapped, Evidence::MeanField, 0, Seed(0))?;
    let every: Vec<usize> = (0..recording.len()).collect();
    let prepared = sensor.prepare(recording, &every)?;
    let scale = scale_of(model, None)?;
    let scaled = scale.map(|scale| Scaled::new(&*prepared, scale));
    let on_map = scaled.as_ref().map_or(&*prepared, |scaled| scaled);
    let sensor = BeyondTheMap {
        within: on_map,
        anywhere: Belief::uniform(cells.mapped.places())?,
        cells: &cells,
    };
    let labeller = Labeller {
        grid: &cells.grid,
        motion: &model.header.motion,
        sensor: &sensor,
        pose: &model.pose,
        route_m: model.route_m.as_deref(),
        is_mapped: Some(&cells.is_mapped()),
    };
    self_labels(&labeller, recording, config, start)
}

/// The same with any sensor model. Evidence that draws random features draws them anew in each pass; mean-field evidence and raw
/// snapshots draw none.
///
/// # Errors
/// As [`of_model`].
pub fn self_labels(
    labeller: &Labeller,
    recording: &Recording,
    config: &SelfLabelConfig,
    start: Option<KnownStart>,
) -> Result<Vec<SelfLabel>> {
    config.check()?;
    let runs = recording.runs().into_iter().enumerate();
    let of_run = |(number, run): (usize, Range<usize>)| {
        let start = match start.filter(|_| number == 0) {
            Some(start) => known_start(labeller.grid, &start)?,
            None => Belief::uniform(labeller.grid.places())?,
        };
        labels_of_run(labeller, recording, run, config, start)
    };
    let labels = runs.map(of_run).collect::<Result<Vec<_>>>()?;
    Ok(labels.concat())
}

fn known_start(grid: &Grid, start: &KnownStart) -> Result<Belief> {
    let at = match **grid.places() {
        Places::Route(_) => Places::Route(vec![start.pose.x_m]),
        Places::Plane(_) => Places::Plane(vec![start.pose]),
    };
    if !start.pose.is_finite() || grid.cell_at(&at, 0).is_none() {
        return Err(Error::work(format!(
            "start: {:?} is off the grid; expected a place of the map",
            start.pose
        )));
    }
    Belief::around(grid.places(), &at, 0, start.spread_m, start.spread_rad)
}

fn labels_of_run(
    labeller: &Labeller,
    recording: &Recording,
    run: Range<usize>,
    config: &SelfLabelConfig,
    start: Belief,
) -> Result<Vec<SelfLabel>> {
    let odometry = |k: usize| recording.observation(k).odometry;
    let anchors = spaced(run.clone(), config.spacing_m, odometry);
    let steps: Vec<Displacement> = anchors
        .windows(2)
        .map(|pair| odometry(pair[0]).displacement_to(&odometry(pair[1])))
        .collect();
    let knowing = match config.from {
        LabelsFrom::Smoothed => Knowing::TheRun,
        LabelsFrom::Filtered => Knowing::ThePast,
    };
    let mut stream = Seed(0).stream("self-labels");
    let mut found: Vec<Option<Anchor>> = anchors.iter().map(|_| None).collect();
    smooth(
        labeller.grid,
        labeller.motion,
        start,
        &steps,
        knowing,
        &mut |t, belief| {
            let sensor = labeller.sensor;
            sensor.log_likelihood(anchors[t], belief, &mut stream)
        },
        &mut |t, moment| {
            found[t] = Some(Anchor::new(anchors[t], &moment, labeller.is_mapped));
            Ok(())
        },
    )?;
    let found: Vec<Anchor> = found.into_iter().flatten().collect();
    let scores = scores(&found, &config.lost);
    let of_run = score_of_run(&found, &config.lost);
    let passes = |i: usize| {
        let score = match config.gate_over {
            GateOver::Moment => scores[i],
            GateOver::Run => of_run,
        };
        config.is_open() || (score <= config.gate && found[i].modes == 1 && found[i].is_mapped)
    };
    let in_plane = labeller
        .route_m
        .map(|route_m| RouteInPlane::new(labeller.pose, route_m));
    let label = |place: Pose, score: f64, ends: &[usize]| SelfLabel {
        pose: in_plane.as_ref().map_or(place, |route| route.at(place.x_m)),
        route_m: in_plane.as_ref().map(|_| place.x_m),
        score,
        kept: ends.iter().all(|&end| passes(end)),
        beyond: ends.iter().any(|&end| !found[end].is_mapped),
    };
    let mut labels = Vec::with_capacity(run.len());
    for (i, anchor) in found.iter().enumerate() {
        labels.push(label(anchor.place, scores[i], &[i]));
        let end = found.get(i + 1).map_or(run.end, |next| next.snapshot);
        let on_the_way: Vec<Pose> = (anchor.snapshot..end).map(odometry).collect();
        let next = found
            .get(i + 1)
            .map(|next| (next.place, odometry(next.snapshot)));
        let places = between(anchor.place, &on_the_way, next, in_plane.is_some());
        let ends = [i, (i + 1).min(found.len() - 1)];
        let score = ends.map(|end| scores[end]).into_iter().fold(0.0, f64::max);
        labels.extend(places.into_iter().map(|place| label(place, score, &ends)));
    }
    Ok(labels)
}

/// The first snapshot of a run, and from there every one that odometry has this far from the last.
fn spaced(run: Range<usize>, spacing_m: f64, odometry: impl Fn(usize) -> Pose) -> Vec<usize> {
    let (mut anchors, mut since_m) = (vec![run.start], 0.0);
    for k in run.start + 1..run.end {
        since_m += odometry(k - 1).distance_m(&odometry(k));
        if since_m >= spacing_m - 1e-9 {
            anchors.push(k);
            since_m = 0.0;
        }
    }
    anchors
}

#[cfg(test)]
mod tests;
