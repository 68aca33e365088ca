//! Buildings drawn at random, each with a run through it and later visits of the same places: what landmarks are
//! pre-trained on, before they see a building of their own.
//!
//! A [`PlanKind`] draws the plan: an office, rooms cut from one another, a long corridor, a hall. Furniture fills it, panes
//! of glass replace stretches of wall, and some plans are bent. At a moment, doors stand open or shut and loose things lie about; the robot goes from goal to goal
//! through what is then free. It comes again at later moments, a little beside its places. All of it follows from the
//! seed and the building's number.

mod bend;
mod chance;
mod config;
mod corridor;
mod free_space;
mod frontage;
mod furnishing;
mod glazing;
mod hall;
mod kind;
mod moment;
mod office;
mod path;
mod plan;
mod rooms;
mod sensor;
#[cfg(test)]
mod tests;
mod visits;

pub use config::{GeneratedConfig, GeneratedSensor};
pub use kind::{KindShares, PlanKind};

use super::{FloorPlan, OdometryConfig, Raycaster, RobotConfig, odometry::DeadReckoning};
use crate::{
    error::{Error, Result},
    geometry::Pose,
    recording::{Columns, Recording},
    seed::Seed,
};
use chance::Chance;
use free_space::FreeSpace;
use moment::Moment;
use nalgebra::Point2;
use ndarray::Array2;
#[cfg(test)]
use plan::Plan;
use sensor::Sensor;

/// Pause before each later visit, on the recording's clock, seconds.
const PAUSE_S: f64 = 600.0;
/// Fewest places of a building that is kept.
const LEAST_PLACES: usize = 50;

/// A building drawn at random, and what a robot saw in it.
///
/// ```
/// use ballmark::{seed::Seed, world::generated::{GeneratedBuilding, GeneratedConfig}};
/// let config = GeneratedConfig { path_m: [30.0, 40.0], visits: 2, ..Default::default() };
/// let built = (0..9).find_map(|number| GeneratedBuilding::draw(&config, number, Seed(1)).transpose());
/// let building = built.unwrap()?;
/// let places = building.first.len();
/// assert_eq!(building.second.len(), 2 * places);
/// let (place, later) = (building.first.poses()[7], building.second.poses()[places + 7]);
/// assert!(place.distance_m(&later) < 3.0); // the second of the later visits of place 7
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct GeneratedBuilding {
    /// What kind of building it is.
    pub kind: PlanKind,
    /// The run that maps it: run 0, one channel, poses labelled as mapping yields them, with a slow drift.
    pub first: Recording,
    /// Later visits: run v holds visit v = 1, 2, … of all places, so row `(v − 1) · first.len() + i` is one of place `i`. Doors,
    /// loose things, people, glass and noise are drawn anew. The channel is that of `first`.
    pub second: Recording,
}

impl GeneratedBuilding {
    /// Draws building number `number`; `None` where the drawn plan has too little free floor to go about in.
    ///
    /// # Errors
    /// A usage error where a constant is out of bounds.
    pub fn draw(config: &GeneratedConfig, number: u64, seed: Seed) -> Result<Option<Self>> {
        let Some(site) = Site::draw(config, number, seed)? else {
            return Ok(None);
        };
        let mut recorder = Recorder {
            sensor: Sensor::draw(config, number, seed)?,
            odometry: Chance(seed.numbered_stream("world/generated/odometry", number)),
            stamp_s: stamps_s(&site.visits[0].truth),
            source: format!("generated building {number}, seed {}", seed.0),
        };
        let mut labels = Chance(seed.numbered_stream("world/generated/labels", number));
        let (first, later) = site.visits.split_at(1);
        let mapped = visits::mapped(&first[0].truth, config, &mut labels);
        let first = recorder.record(first, 0, mapped)?;
        let localised = later
            .iter()
            .flat_map(|visit| visits::localised(&visit.truth, config, &mut labels))
            .collect();
        Ok(Some(Self {
            kind: site.kind,
            first,
            second: recorder.record(later, 1, localised)?,
        }))
    }
}

/// The building at one visit, and where the robot stands.
struct Visit {
    caster: Raycaster,
    truth: Vec<Pose>,
    moment: Moment,
}

/// A building before any sensor has been there.
struct Site {
    kind: PlanKind,
    /// The first visit, then the later ones.
    visits: Vec<Visit>,
    #[cfg(test)]
    plan: Plan,
}

impl Site {
    fn draw(config: &GeneratedConfig, number: u64, seed: Seed) -> Result<Option<Self>> {
        config.check()?;
        let chance = |name| Chance(seed.numbered_stream(name, number));
        let mut drawn = chance("world/generated/plan");
        let kind = config.shares.draw(&mut drawn);
        let glass = drawn.one_of(&config.glass);
        let bent = drawn.yes(config.bent);
        let plan = kind.plan(glass, bent, &mut drawn);
        let mut moments = chance("world/generated/moments");
        let openness = moments.one_of(&config.openness);
        let changed = moments.one_of(&config.changed);
        let moment = Moment::first(&plan, openness, &mut moments);
        let floor = FloorPlan::new(moment.walls(&plan))?;
        let space = FreeSpace::new(&floor, &plan, config.clearance_m);
        if space.area_m2() < config.least_free_m2 {
            return Ok(None);
        }
        let mut way = chance("world/generated/way");
        let places = path::places(&space, &floor, config, &mut way);
        if places.len() < LEAST_PLACES {
            return Ok(None);
        }
        let points: Vec<Point2<f64>> = places
            .iter()
            .map(|pose| Point2::new(pose.x_m, pose.y_m))
            .collect();
        let mut beside = chance("world/generated/visits");
        let mut visits = vec![Visit {
            caster: Raycaster::new(floor),
            truth: places,
            moment,
        }];
        for _ in 0..config.visits {
            let first = &visits[0];
            let moment = first
                .moment
                .later(&plan, (openness, changed), &points, &mut moments);
            let caster = Raycaster::new(FloorPlan::new(moment.walls(&plan))?);
            let truth = visits::beside(&first.truth, &plan, &caster, config, &mut beside);
            visits.push(Visit {
                caster,
                truth,
                moment,
            });
        }
        Ok(Some(Self {
            kind,
            visits,
            #[cfg(test)]
            plan,
        }))
    }
}

/// When the robot is at each place, seconds after it started.
fn stamps_s(places: &[Pose]) -> Vec<f64> {
    let speed = RobotConfig::default().speed_m_per_s;
    let mut stamp_s = 0.0;
    let steps = places.windows(2).map(|pair| {
        stamp_s += pair[0].distance_m(&pair[1]) / speed;
        stamp_s
    });
    std::iter::once(0.0).chain(steps).collect()
}

/// Turns visits into recordings, one after another.
struct Recorder {
    sensor: Sensor,
    odometry: Chance,
    /// When the robot is at each place, seconds after a visit began.
    stamp_s: Vec<f64>,
    source: String,
}

impl Recorder {
    /// A recording of these visits, whose runs count up from `first_run`, with a label for each snapshot.
    fn record(&mut self, visits: &[Visit], first_run: usize, pose: Vec<Pose>) -> Result<Recording> {
        let channel = self.sensor.channel()?;
        let shape = (pose.len(), channel.width);
        let mut columns = Columns {
            channels: vec![channel],
            pose,
            source: Some(self.source.clone()),
            ..Columns::default()
        };
        let lasts_s = self.stamp_s.last().map_or(0.0, |end_s| end_s + PAUSE_S);
        let mut values = Vec::with_capacity(shape.0 * shape.1);
        for (index, visit) in visits.iter().enumerate() {
            let run = first_run + index;
            let slip = &mut self.odometry.0;
            let mut reckoning = DeadReckoning::draw(&OdometryConfig::default(), slip);
            for (pose, stamp_s) in visit.truth.iter().zip(&self.stamp_s) {
                columns.stamp_s.push(run as f64 * lasts_s + stamp_s);
                columns.odometry.push(reckoning.reach(pose, slip));
                columns.run.push(run as i64);
                values.extend(self.sensor.scan(&visit.caster, pose)?);
            }
        }
        columns.values = Array2::from_shape_vec(shape, values)
            .map_err(|fault| Error::work(format!("{}: {fault}", self.source)))?;
        Recording::new(columns)
    }
}
