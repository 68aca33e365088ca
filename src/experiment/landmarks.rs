//! Landmarks chosen by people, held against the plan: how often a door or a ceiling light is found where there is one.
//!
//! T98 compares BaLL with doors (Koenig & Simmons 1996) and ceiling lights (King & Weiman 1990) and doesn't tell how well
//! these were found (5.1.2). In a simulated building it can be measured: the detectors work from sensor values, the truth comes
//! from the plan.

use crate::{
    detector::{
        Detector,
        ceiling_light::CeilingLight,
        door::{Door, DoorConfig, Side},
    },
    error::{Error, Result},
    geometry::Pose,
    recording::Recording,
    world::{Building, camera::Direction},
};
use nalgebra::Point2;
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_2;

/// The detectors' constants, and when a lamp is in view.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LandmarksConfig {
    /// Of the door detector; its `side` is that of the camera where there is one.
    pub door: DoorConfig,
    /// Of the ceiling lights'.
    pub ceiling_light: CeilingLight,
    /// A lamp is in view of a camera that looks up where its middle is within so many metres of the robot. The default is
    /// what Thrun's camera sees as it is simulated (1.4 m below the ceiling, ±0.6 m of it ahead and behind; lamps 0.3 m
    /// long that way).
    pub lamp_within_m: f64,
}

impl Default for LandmarksConfig {
    fn default() -> Self {
        Self {
            door: DoorConfig::default(),
            ceiling_light: CeilingLight::default(),
            lamp_within_m: 0.8,
        }
    }
}

impl LandmarksConfig {
    /// # Errors
    /// A usage error that names the first constant out of bounds.
    pub fn check(&self) -> Result<()> {
        let within_m = self.lamp_within_m;
        if !(within_m > 0.0 && within_m.is_finite()) {
            return Err(Error::usage(format!(
                "landmarks: `lamp_within_m` is {within_m}; expected more than 0"
            )));
        }
        self.door.check()?;
        self.ceiling_light.check()
    }
}

/// How well one detector finds what it is named after. It says yes where P(f = 1 | s) is above one half.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct LandmarkRecord {
    /// `door` or `ceiling_light`.
    pub detector: String,
    /// How many snapshots it was asked about.
    pub snapshots: usize,
    /// Snapshots with a landmark, and so it said.
    pub true_positives: usize,
    /// Snapshots without, but it said there was one.
    pub false_positives: usize,
    /// Snapshots with a landmark that it did not find.
    pub missed: usize,
    /// Share of those it called landmarks that are; `None` where it called none.
    pub precision: Option<f64>,
    /// Share of the landmarks that it found; `None` where there are none.
    pub recall: Option<f64>,
}

impl LandmarkRecord {
    /// From pairs of what the plan has and what the detector said.
    fn of(detector: &str, answers: impl Iterator<Item = (bool, bool)>) -> Self {
        let (mut snapshots, mut found, mut mistaken, mut missed) = (0, 0, 0, 0);
        for (is_there, is_said) in answers {
            snapshots += 1;
            match (is_there, is_said) {
                (true, true) => found += 1,
                (false, true) => mistaken += 1,
                (true, false) => missed += 1,
                (false, false) => {}
            }
        }
        let share = |all: usize| (all > 0).then(|| found as f64 / all as f64);
        Self {
            detector: detector.into(),
            snapshots,
            true_positives: found,
            false_positives: mistaken,
            missed,
            precision: share(found + mistaken),
            recall: share(found + missed),
        }
    }
}

/// Holds the detectors against the plan of the building that a recording was simulated in, on its snapshots `testing`;
/// what the door detector learns (how far apart walls usually are) it learns from `mapping`.
///
/// A camera to one side is asked for doors on that side, one that looks up for ceiling lights; without a camera, doors are
/// looked for by ranges on the side that the configuration names. There is a door where the wall abeam of the robot is a
/// door's (see [`Building::is_door_towards`]). `set` is the set of runs that was recorded, where the building has several
/// whose cameras look elsewhere.
///
/// On all runs of Thrun's corridor with seed 1: doors on D-1 with a precision of .77 and a recall of .83, on D-2 .40 and
/// .84, ceiling lights on D-3 .99 and .95; in the corridor of twice the length .58 and .86, .59 and .87, 1.00 and .95.
///
/// ```
/// use ballmark::experiment::landmarks::{LandmarksConfig, judge};
/// use ballmark::{seed::Seed, world::corridor};
/// let config = corridor::CorridorConfig { runs: 2, spacing_m: 0.5 }; // sonars alone
/// let recording = corridor::thrun1998(Seed(1), &config)?;
/// let building = corridor::building(&config)?;
/// let [first, second] = [0, 1].map(|run| recording.runs()[run].clone().collect::<Vec<_>>());
/// let doors = judge(&building, None, &recording, &first, &second, &LandmarksConfig::default())?;
/// assert_eq!((doors.len(), doors[0].detector.as_str()), (1, "door"));
/// assert!(doors[0].recall.unwrap() > 0.5); // but doors on the other side are found as well
/// # Ok::<(), ballmark::Error>(())
/// ```
///
/// # Errors
/// Where the recording comes from another building, there is no such set or more than one direction of view, the camera
/// looks ahead, an index is none of the recording's, or its sensors are not what the detectors need; a usage error where
/// `config` makes no sense.
pub fn judge(
    building: &Building,
    set: Option<&str>,
    recording: &Recording,
    mapping: &[usize],
    testing: &[usize],
    config: &LandmarksConfig,
) -> Result<Vec<LandmarkRecord>> {
    config.check()?;
    let wrong = |fault: String| Err(Error::work(format!("landmarks: {fault}")));
    let simulated = format!("simulated world {}", building.name());
    let source = recording.columns().source.as_deref().unwrap_or(&simulated);
    let rest = source.strip_prefix(&simulated);
    if !rest.is_some_and(|rest| rest.is_empty() || rest.starts_with([' ', ','])) {
        return wrong(format!(
            "the recording is of `{source}`; expected `{simulated}`"
        ));
    }
    let mut all = mapping.iter().chain(testing);
    if let Some(index) = all.find(|index| **index >= recording.len()) {
        let snapshots = recording.len();
        return wrong(format!("snapshot {index}; expected one of {snapshots}"));
    }
    let place = |pose: &Pose| Point2::new(pose.x_m, pose.y_m);
    let judged = |name: &str, detector: &dyn Detector, is_there: &dyn Fn(&Pose) -> bool| {
        let probability = detector.probabilities(recording)?;
        let answers = testing.iter().map(|&k| {
            let is_said = probability[[k, 0]] > 0.5;
            (is_there(&recording.poses()[k]), is_said)
        });
        Ok(vec![LandmarkRecord::of(name, answers)])
    };
    let side = match direction_of_view(building, set)? {
        Some(Direction::Up) => {
            let is_lit = |pose: &Pose| building.has_lamp_within(&place(pose), config.lamp_within_m);
            return judged("ceiling_light", &config.ceiling_light, &is_lit);
        }
        Some(Direction::Ahead) => {
            return wrong("the camera looks ahead; expected left, right or up".into());
        }
        Some(Direction::Left) => Side::Left,
        Some(Direction::Right) => Side::Right,
        None => config.door.side,
    };
    let door = DoorConfig {
        side,
        ..config.door.clone()
    };
    let abeam_rad = match side {
        Side::Left => FRAC_PI_2,
        Side::Right => -FRAC_PI_2,
    };
    let is_door =
        |pose: &Pose| building.is_door_towards(&place(pose), pose.heading_rad + abeam_rad);
    judged("door", &Door::fit(&door, recording, mapping)?, &is_door)
}

/// Where the camera of a set looks, or that of all sets; `None`: there is no camera.
fn direction_of_view(building: &Building, set: Option<&str>) -> Result<Option<Direction>> {
    let names = || building.set_names().join(", ");
    let sets = building.sets().iter();
    let asked = sets.filter(|known| set.is_none_or(|name| name == known.name));
    let mut looks = asked.map(|known| known.sensors.camera.as_ref().map(|c| c.config().look));
    let Some(look) = looks.next() else {
        return Err(Error::usage(format!(
            "landmarks: no set `{}`; expected one of {}",
            set.unwrap_or_default(),
            names()
        )));
    };
    if looks.any(|other| other != look) {
        return Err(Error::usage(format!(
            "landmarks: the cameras of the building's sets look elsewhere; expected one of {}",
            names()
        )));
    }
    Ok(look)
}

#[cfg(test)]
mod tests;
