//! What a generated building is drawn with.

use super::kind::KindShares;
use crate::{
    error::{Error, Result},
    world::bounds::Bounds,
};
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// The sensor that goes through the building.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum GeneratedSensor {
    /// A fan of thin beams: channel `laser`.
    Laser,
    /// A ring of cones: channel `sonar`.
    Sonar,
}

/// Every constant that generated buildings are drawn with. Where a value is a list, each building draws one entry, all as
/// likely; where it is a pair of numbers, each building draws evenly between them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GeneratedConfig {
    /// How often each kind of building is drawn.
    pub shares: KindShares,
    /// Share of the buildings that are bent.
    pub bent: f64,
    /// The sensor.
    pub sensor: GeneratedSensor,
    /// Beams of the laser; beam i points to (i / beams − ½) `field_of_view_rad`, so that a beam a degree over 180° runs
    /// from −90° to 89°.
    pub beams: usize,
    /// Full width of the laser's fan, radians.
    pub field_of_view_rad: f64,
    /// Reach of the laser, metres; from there on there is no return.
    pub maximum_m: f64,
    /// Sonars of the ring, evenly spaced counter-clockwise, the first straight ahead.
    pub sonars: usize,
    /// Reach of the sonars, metres.
    pub sonar_maximum_m: f64,
    /// Full opening of the sonars' cones, radians.
    pub sonar_opening_rad: [f64; 2],
    /// Later visits of each place.
    pub visits: usize,
    /// Length of the first run, metres.
    pub path_m: [f64; 2],
    /// Way between two places of it, metres.
    pub spacing_m: [f64; 2],
    /// Most places; where the run is too long for them they lie farther apart.
    pub places: usize,
    /// Least free floor, square metres: buildings with less are refused.
    pub least_free_m2: f64,
    /// Distance that the way keeps from walls, metres.
    pub clearance_m: f64,
    /// Share of the doors that are open.
    pub openness: Vec<f64>,
    /// Share of doors and loose things that have been touched before each later visit.
    pub changed: Vec<f64>,
    /// How far beside its place a later visit is, a visit: standard deviation on both axes, metres.
    pub beside_m: Vec<f64>,
    /// How far a later visit is turned against its place: standard deviation, radians.
    pub beside_rad: [f64; 2],
    /// Standard deviation of the range noise, metres.
    pub noise_m: [f64; 2],
    /// Probability that a beam is dropped.
    pub dropped: Vec<f64>,
    /// Share of the walls with a pane of glass.
    pub glass: Vec<f64>,
    /// Share of the laser's scans with stretches that return nothing.
    pub blank: Vec<f64>,
    /// Probability of each of up to three people to stand near the robot, a scan.
    pub people: Vec<f64>,
    /// Most that the labels of the first run drift: standard deviation, metres. A building draws how much of it.
    pub drift_m: f64,
    /// The same of their headings, radians.
    pub drift_rad: f64,
    /// White noise of the labels of later visits: standard deviation, metres.
    pub label_noise_m: f64,
    /// The same of their headings, radians.
    pub label_noise_rad: f64,
}

impl Default for GeneratedConfig {
    fn default() -> Self {
        Self {
            shares: KindShares::default(),
            bent: 0.2,
            sensor: GeneratedSensor::Laser,
            beams: 180,
            field_of_view_rad: PI,
            maximum_m: 80.0,
            sonars: 24,
            sonar_maximum_m: 7.0,
            sonar_opening_rad: [15_f64.to_radians(), 30_f64.to_radians()],
            visits: 3,
            path_m: [80.0, 220.0],
            spacing_m: [0.1, 0.6],
            places: 550,
            least_free_m2: 20.0,
            clearance_m: 0.34,
            openness: vec![0.2, 0.5, 0.8, 1.0],
            changed: vec![0.02, 0.1, 0.25],
            beside_m: vec![0.1, 0.2, 0.4],
            beside_rad: [0.17, 0.2],
            noise_m: [0.005, 0.05],
            dropped: vec![0.0, 0.0, 0.003, 0.02],
            glass: vec![0.0, 0.0, 0.05, 0.15],
            blank: vec![0.0, 0.0, 0.1, 0.3],
            people: vec![0.0, 0.02, 0.08, 0.2],
            drift_m: 0.04,
            drift_rad: 0.008,
            label_noise_m: 0.05,
            label_noise_rad: 0.012,
        }
    }
}

/// Most beams, places or visits: far beyond any use, small enough to allocate.
const MOST: usize = 10_000;

impl GeneratedConfig {
    /// Checks every constant.
    ///
    /// # Errors
    /// A usage error that names the first one out of bounds.
    pub fn check(&self) -> Result<()> {
        let bounds = Bounds("[pretrain.buildings]");
        self.shares.check()?;
        for (key, count) in [
            ("beams", self.beams),
            ("sonars", self.sonars),
            ("places", self.places),
        ] {
            if !(1..=MOST).contains(&count) {
                return bounds.wrong(key, count, &format!("1 to {MOST}"));
            }
        }
        if !(1..=100).contains(&self.visits) {
            return bounds.wrong("visits", self.visits, "1 to 100");
        }
        if !(self.field_of_view_rad > 0.0 && self.field_of_view_rad <= TAU) {
            return bounds.wrong(
                "field_of_view_rad",
                self.field_of_view_rad,
                "above 0, up to 2π",
            );
        }
        bounds.shares(&[("bent", self.bent)])?;
        for (key, shares) in [
            ("openness", &self.openness),
            ("changed", &self.changed),
            ("dropped", &self.dropped),
            ("glass", &self.glass),
            ("blank", &self.blank),
            ("people", &self.people),
        ] {
            bounds.shares(&of_list(key, shares)?)?;
        }
        bounds.not_negative(&of_list("beside_m", &self.beside_m)?)?;
        for (key, [low, high]) in [
            ("sonar_opening_rad", self.sonar_opening_rad),
            ("path_m", self.path_m),
            ("spacing_m", self.spacing_m),
            ("beside_rad", self.beside_rad),
            ("noise_m", self.noise_m),
        ] {
            if !(0.0 <= low && low <= high && high.is_finite()) {
                let value = format!("[{low}, {high}]");
                return bounds.wrong(key, value, "two numbers from 0 on in rising order");
            }
        }
        if self.sonar_opening_rad[1] > PI {
            return bounds.wrong("sonar_opening_rad", self.sonar_opening_rad[1], "up to π");
        }
        bounds.positive(&[
            ("path_m", self.path_m[0]),
            ("spacing_m", self.spacing_m[0]),
            ("least_free_m2", self.least_free_m2),
        ])?;
        if !(self.clearance_m >= LEAST_CLEARANCE_M && self.clearance_m <= 1.0) {
            let expected = format!("{LEAST_CLEARANCE_M} to 1");
            return bounds.wrong("clearance_m", self.clearance_m, &expected);
        }
        for (key, metres) in [
            ("maximum_m", self.maximum_m),
            ("sonar_maximum_m", self.sonar_maximum_m),
        ] {
            if !(metres > 0.5 && metres.is_finite()) {
                return bounds.wrong(key, metres, "more than 0.5");
            }
        }
        bounds.not_negative(&[
            ("drift_m", self.drift_m),
            ("drift_rad", self.drift_rad),
            ("label_noise_m", self.label_noise_m),
            ("label_noise_rad", self.label_noise_rad),
        ])
    }
}

/// Least distance that a way may keep from walls: smoothed, it comes somewhat nearer, metres.
const LEAST_CLEARANCE_M: f64 = 0.3;

/// The entries of a list, each under the list's key.
fn of_list<'a>(key: &'a str, list: &[f64]) -> Result<Vec<(&'a str, f64)>> {
    if list.is_empty() {
        return Err(Error::usage(format!(
            "[pretrain.buildings]: `{key}` is empty; expected at least one number"
        )));
    }
    Ok(list.iter().map(|value| (key, *value)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{seed::Seed, world::generated::GeneratedBuilding};

    #[test]
    fn constants_out_of_bounds_are_told_by_name() {
        let wrong = |change: fn(&mut GeneratedConfig)| {
            let mut config = GeneratedConfig::default();
            change(&mut config);
            GeneratedBuilding::draw(&config, 0, Seed(1))
                .unwrap_err()
                .to_string()
        };
        type Case = (fn(&mut GeneratedConfig), &'static str);
        let cases: [Case; 8] = [
            (|c| c.beams = 0, "`beams` is 0; expected 1 to 10000"),
            (|c| c.visits = 0, "`visits` is 0; expected 1 to 100"),
            (|c| c.people = vec![1.5], "`people` is 1.5; expected 0 to 1"),
            (
                |c| c.glass = vec![],
                "`glass` is empty; expected at least one number",
            ),
            (
                |c| c.path_m = [9.0, 3.0],
                "`path_m` is [9, 3]; expected two numbers",
            ),
            (
                |c| c.clearance_m = 0.1,
                "`clearance_m` is 0.1; expected 0.3 to 1",
            ),
            (
                |c| c.shares.hall = -1.0,
                "`shares.hall` is -1; expected 0 or more",
            ),
            (
                |c| c.maximum_m = f64::NAN,
                "`maximum_m` is NaN; expected more than 0.5",
            ),
        ];
        for (change, expected) in cases {
            let message = wrong(change);
            assert!(
                message.contains(expected) && !message.contains('\n'),
                "{message}"
            );
        }
        let zero = "office = 0\nrooms = 0\ncorridor = 0\nhall = 0";
        let shares: KindShares = toml::from_str(zero).unwrap();
        assert!(shares.check().is_err());
        assert!(toml::from_str::<GeneratedConfig>("beems = 3").is_err());
    }
}
