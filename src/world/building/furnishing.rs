//! `[[thing]]`, `[[light]]` and `[[fire_door]]`: what stands, hangs and swings in a building.

use super::{material::Materials, within};
use crate::{
    error::{Error, Result},
    seed::Stream,
    world::{Light, Material, Wall, floor_plan::round},
};
use nalgebra::{Point2, Vector2};
use rand::RngExt;
use rand_distr::StandardNormal;
use serde::Deserialize;

/// Something round that stands on the floor: a bin, a pillar.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ThingConfig {
    /// Its middle, metres.
    pub at: [f64; 2],
    /// Radius, metres.
    pub radius_m: f64,
    /// Height, metres; without it up to the ceiling.
    pub height_m: Option<f64>,
    /// What it is made of; without it plastic.
    pub material: Option<String>,
    /// Standard deviation of where it stands, over runs, in x and in y, metres.
    #[serde(default)]
    pub moved_sd_m: f64,
    /// With it, things move along this direction alone (as a bin does along its wall), degrees.
    pub moved_deg: Option<f64>,
    /// Probability that it is there in a run.
    #[serde(default = "always")]
    pub present: f64,
}

/// A lamp in the ceiling.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LightConfig {
    /// Its middle, metres.
    pub at: [f64; 2],
    /// Length along its heading and width across, metres.
    #[serde(default = "panel")]
    pub size_m: [f64; 2],
    /// Direction of its length, degrees.
    #[serde(default)]
    pub heading_deg: f64,
    /// How bright it looks; a white surface in full light is 1.
    #[serde(default = "brightness")]
    pub brightness: f64,
    /// Does it burn?
    #[serde(default = "yes")]
    pub lit: bool,
}

/// A door that is shut except for the seconds while a person goes through.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FireDoorConfig {
    /// One end of its leaf, metres.
    pub from: [f64; 2],
    /// The other end, metres.
    pub to: [f64; 2],
    /// What it is made of; without it steel.
    pub material: Option<String>,
}

fn always() -> f64 {
    1.0
}
fn yes() -> bool {
    true
}
fn panel() -> [f64; 2] {
    Light::default().size_m
}
fn brightness() -> f64 {
    Light::default().brightness
}

/// Faces of a round thing.
const FACES: usize = 12;
/// A thing moves no further than this many standard deviations, so that it never crosses the building.
const MAX_SDS: f64 = 2.0;

/// A checked [`ThingConfig`].
#[derive(Debug, Clone)]
pub(super) struct Thing {
    at: Point2<f64>,
    radius_m: f64,
    height_m: f64,
    material: Material,
    moved_sd_m: f64,
    moved_rad: Option<f64>,
    present: f64,
}

impl Thing {
    pub(super) fn new(config: &ThingConfig, number: usize, materials: &Materials) -> Result<Self> {
        let place = format!("[[thing]] {number}");
        place_within(config.at, "at", &place)?;
        within(config.radius_m, "radius_m", 0.001..=1000.0, &place)?;
        let height_m = config.height_m.unwrap_or(f64::INFINITY);
        if height_m.is_nan() || height_m <= 0.0 {
            return Err(Error::usage(format!(
                "{place}: `height_m` is {height_m}; expected more than 0"
            )));
        }
        within(config.moved_sd_m, "moved_sd_m", 0.0..=1000.0, &place)?;
        let turned_deg = config.moved_deg.unwrap_or(0.0);
        within(turned_deg, "moved_deg", -3600.0..=3600.0, &place)?;
        within(config.present, "present", 0.0..=1.0, &place)?;
        let plastic = materials.named("plastic", &place)?;
        Ok(Self {
            at: config.at.into(),
            radius_m: config.radius_m,
            height_m,
            material: materials.named_or(config.material.as_ref(), plastic, &place)?,
            moved_sd_m: config.moved_sd_m,
            moved_rad: config.moved_deg.map(f64::to_radians),
            present: config.present,
        })
    }

    /// Its walls in one run; the same number of draws whatever comes out.
    pub(super) fn walls(&self, random: &mut Stream) -> Vec<Wall> {
        let mut moved = || {
            random
                .sample::<f64, _>(StandardNormal)
                .clamp(-MAX_SDS, MAX_SDS)
        };
        let mut moved = Vector2::new(moved(), moved()) * self.moved_sd_m;
        if let Some(angle_rad) = self.moved_rad {
            moved = Vector2::new(angle_rad.cos(), angle_rad.sin()) * moved.x;
        }
        if random.random::<f64>() >= self.present {
            return Vec::new();
        }
        let sides = round(self.at + moved, self.radius_m, FACES, self.material).into_iter();
        sides.map(|side| side.between(0.0, self.height_m)).collect()
    }
}

impl LightConfig {
    pub(super) fn light(&self, number: usize) -> Result<Light> {
        let place = format!("[[light]] {number}");
        place_within(self.at, "at", &place)?;
        for size_m in self.size_m {
            within(size_m, "size_m", 0.001..=1000.0, &place)?;
        }
        within(self.heading_deg, "heading_deg", -3600.0..=3600.0, &place)?;
        within(self.brightness, "brightness", 0.0..=1000.0, &place)?;
        Ok(Light {
            at: self.at.into(),
            size_m: self.size_m,
            heading_rad: self.heading_deg.to_radians(),
            brightness: self.brightness,
            lit: self.lit,
        })
    }
}

impl FireDoorConfig {
    pub(super) fn wall(&self, number: usize, materials: &Materials) -> Result<Wall> {
        let place = format!("[[fire_door]] {number}");
        place_within(self.from, "from", &place)?;
        place_within(self.to, "to", &place)?;
        let (from, to): (Point2<f64>, Point2<f64>) = (self.from.into(), self.to.into());
        if (to - from).norm() < 1e-3 {
            return Err(Error::usage(format!(
                "{place}: `from` and `to` are the same place; expected the two ends of its leaf"
            )));
        }
        let steel = materials.named("steel", &place)?;
        let material = materials.named_or(self.material.as_ref(), steel, &place)?;
        Ok(Wall::new(from, to, material))
    }
}

fn place_within(place_m: [f64; 2], key: &str, place: &str) -> Result<()> {
    place_m
        .into_iter()
        .try_for_each(|metres| within(metres, key, -1e6..=1e6, place))
}
