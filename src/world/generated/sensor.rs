//! The sensor that goes through a generated building: its noise, and the people, the glass and the lost beams of each scan.

use super::{GeneratedConfig, GeneratedSensor, chance::Chance, glazing::CLEAREST};
use crate::{
    error::Result,
    geometry::{Pose, wrapped},
    recording::Channel,
    seed::{Seed, Stream},
    world::{
        Laser, LaserConfig, Material, Raycaster, Sonar, SonarConfig, Surroundings, Wall, floor_plan,
    },
};
use nalgebra::{Point2, Vector2};
use std::f64::consts::PI;

/// How many people may stand near the robot at once.
const PEOPLE: usize = 3;
/// Faces that a person is made of.
const FACES: usize = 10;
/// How far people stand from the sensor, metres.
const AWAY_M: [f64; 2] = [0.5, 5.0];
/// Radius of a person: from a leg to a body with arms, metres.
const RADIUS_M: [f64; 2] = [0.08, 0.3];
/// What clothes do to sound.
const CLOTHES: Material = Material {
    reflectivity: 0.7,
    critical_angle_rad: 1.2,
    ..Material::PLAIN
};
/// Most blank stretches of a scan that has any.
const STRETCHES: usize = 3;
/// Width of a blank stretch, as a share of the fan.
const STRETCH: [f64; 2] = [0.01, 0.11];
/// Share of the beams in it that are lost.
const STRETCH_LOST: f64 = 0.8;
/// Shortest range that a laser and a sonar tell, metres.
const LEAST_M: [f64; 2] = [0.05, 0.15];
/// Rays that sample a sonar's cone, and mirrors that they are followed through: fewer than the simulated robots' own.
const CONE_RAYS: usize = 9;
const REFLECTIONS: usize = 1;

/// The sensor of one building, with the streams that its scans draw from.
pub(super) struct Sensor {
    model: Model,
    /// Probability of each of [`PEOPLE`] to be there.
    people: f64,
    /// Share of the scans with blank stretches.
    blank: f64,
    persons: Chance,
    noise: Chance,
}

enum Model {
    /// The fan, and by how much it is turned against a [`Laser`] of the same constants, whose beams point half a beam
    /// farther to the left.
    Laser(LaserConfig, f64),
    Sonar(Sonar),
}

impl Sensor {
    /// Draws the sensor of building number `number`.
    pub fn draw(config: &GeneratedConfig, number: u64, seed: Seed) -> Result<Self> {
        let stream = |name| -> Stream { seed.numbered_stream(name, number) };
        let mut chance = Chance(stream("world/generated/sensor"));
        let noise_m = chance.between(config.noise_m[0], config.noise_m[1]);
        let dropped = chance.one_of(&config.dropped);
        let model = match config.sensor {
            GeneratedSensor::Laser => Model::Laser(
                LaserConfig {
                    beams: config.beams,
                    field_of_view_rad: config.field_of_view_rad,
                    ahead_m: 0.0,
                    minimum_m: LEAST_M[0],
                    maximum_m: config.maximum_m,
                    noise_m,
                    noise_per_m: 0.0,
                    resolution_m: 0.0,
                    short_probability: 0.0,
                    lost_probability: dropped,
                    ..LaserConfig::default()
                },
                -config.field_of_view_rad / (2.0 * config.beams as f64),
            ),
            GeneratedSensor::Sonar => {
                let [narrow, wide] = config.sonar_opening_rad;
                Model::Sonar(Sonar::new(SonarConfig {
                    beams: config.sonars,
                    ring_radius_m: 0.0,
                    opening_rad: chance.between(narrow, wide),
                    rays: CONE_RAYS,
                    minimum_m: LEAST_M[1],
                    maximum_m: config.sonar_maximum_m,
                    reflections: REFLECTIONS,
                    noise_m,
                    noise_per_m: 0.005,
                    short_probability: chance.between(0.0, 0.02),
                    lost_probability: dropped + chance.between(0.0, 0.05),
                    ..SonarConfig::default()
                })?)
            }
        };
        Ok(Self {
            model,
            people: chance.one_of(&config.people),
            blank: chance.one_of(&config.blank),
            persons: Chance(stream("world/generated/people")),
            noise: Chance(stream("world/generated/noise")),
        })
    }

    /// The channel that its scans make.
    pub fn channel(&self) -> Result<Channel> {
        Ok(match &self.model {
            Model::Sonar(sonar) => sonar.channel(),
            Model::Laser(config, turned_rad) => {
                let laser = Laser::new(config.clone())?;
                let bearings = 0..config.beams;
                Channel {
                    bearing_rad: Some(
                        bearings
                            .map(|beam| wrapped(laser.bearing_rad(beam) + turned_rad))
                            .collect(),
                    ),
                    ..laser.channel()
                }
            }
        })
    }

    /// One scan: metres, NaN = no return.
    pub fn scan(&mut self, caster: &Raycaster, pose: &Pose) -> Result<Vec<f32>> {
        let people = self.people_near(pose);
        let around = Surroundings::new(caster, &people);
        let noise = &mut self.noise;
        match &self.model {
            Model::Sonar(sonar) => Ok(sonar.read(&around, pose, &mut noise.0)),
            Model::Laser(config, turned_rad) => {
                // Whether a pane is seen depends on light, angle and dust: some are in one scan and not in the next.
                let laser = Laser::new(LaserConfig {
                    clear_below: noise.between(0.0, CLEAREST),
                    ..config.clone()
                })?;
                let turned = Pose {
                    heading_rad: pose.heading_rad + turned_rad,
                    ..*pose
                };
                let mut ranges = laser.read(&around, &turned, &mut noise.0);
                if noise.yes(self.blank) {
                    blank_stretches(&mut ranges, noise);
                }
                Ok(ranges)
            }
        }
    }

    /// Everybody who stands near the robot at the moment.
    fn people_near(&mut self, pose: &Pose) -> Vec<Wall> {
        let half_rad = match &self.model {
            Model::Laser(config, _) => config.field_of_view_rad / 2.0,
            Model::Sonar(_) => PI,
        };
        let chance = &mut self.persons;
        let mut walls = Vec::new();
        for _ in 0..PEOPLE {
            // The same draws whether somebody comes or not, so that a crowd is one person more than a pair.
            let comes = chance.yes(self.people);
            let away_m = chance.between(AWAY_M[0], AWAY_M[1]);
            let towards_rad = pose.heading_rad + chance.between(-half_rad, half_rad);
            let radius_m = chance.between(RADIUS_M[0], RADIUS_M[1]);
            if comes {
                let aside = Vector2::new(towards_rad.cos(), towards_rad.sin()) * away_m;
                let centre = Point2::new(pose.x_m, pose.y_m) + aside;
                walls.extend(floor_plan::round(centre, radius_m, FACES, CLOTHES));
            }
        }
        walls
    }
}

/// Loses most beams of one to three stretches: sun, black furniture, glass that nobody has drawn.
fn blank_stretches(ranges: &mut [f32], chance: &mut Chance) {
    let beams = ranges.len();
    for _ in 0..1 + chance.below(STRETCHES) {
        let width = (chance.between(STRETCH[0], STRETCH[1]) * beams as f64).ceil() as usize;
        let first = chance.below(beams + 1 - width.min(beams));
        for range in ranges.iter_mut().skip(first).take(width) {
            if chance.yes(STRETCH_LOST) {
                *range = f32::NAN;
            }
        }
    }
}
