//! A building as one run finds it: walls and doors as they stand, and how it is lit.

use super::{FloorPlan, Material, Wall};
use nalgebra::{Point2, Rotation2};

/// A rectangular lamp in the ceiling.
///
/// ```
/// use ballmark::world::Light;
/// use nalgebra::Point2;
/// let along_y = Light { at: Point2::new(1.0, 2.0), size_m: [1.2, 0.3], heading_rad: 1.570796, ..Light::default() };
/// assert!(along_y.covers(&Point2::new(1.1, 2.5)) && !along_y.covers(&Point2::new(1.5, 2.1)));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Light {
    /// Its centre, metres.
    pub at: Point2<f64>,
    /// Length along its heading and width across it, metres.
    pub size_m: [f64; 2],
    /// Direction of its length, radians.
    pub heading_rad: f64,
    /// How bright it looks where it is lit, red, green and blue alike; a white surface in full light is 1.
    pub brightness: f64,
    /// Does it burn? A lamp that doesn't is a dull white panel.
    pub lit: bool,
}

impl Light {
    /// Does it cover a point of the ceiling?
    pub fn covers(&self, point: &Point2<f64>) -> bool {
        let aside = Rotation2::new(-self.heading_rad) * (point - self.at);
        aside.x.abs() <= self.size_m[0] / 2.0 && aside.y.abs() <= self.size_m[1] / 2.0
    }
}

impl Default for Light {
    /// A lit fluorescent panel of 1.2 × 0.3 m at the origin.
    fn default() -> Self {
        Self {
            at: Point2::origin(),
            size_m: [1.2, 0.3],
            heading_rad: 0.0,
            brightness: 3.0,
            lit: true,
        }
    }
}

/// What a building is like during one run; everything in it is drawn once a run, nothing moves.
///
/// ```
/// use ballmark::world::{FloorPlan, Material, RunScene, floor_plan::round};
/// use nalgebra::Point2;
/// let tower = FloorPlan::new(round(Point2::origin(), 3.0, 24, Material::PLAIN))?;
/// let scene = RunScene { daylight: 0.3, ..RunScene::of(tower) };
/// assert_eq!((scene.illumination, scene.ceiling_m), (1.0, 2.6));
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct RunScene {
    /// Walls, doors and things as they stand in this run.
    pub plan: FloorPlan,
    /// Lamps in the ceiling.
    pub lights: Vec<Light>,
    /// Brightness of all lamps in this run against their usual one.
    pub illumination: f64,
    /// Daylight that comes through the windows, from 0 (night) to 1 (full sun).
    pub daylight: f64,
    /// Height of the ceiling above the floor, metres.
    pub ceiling_m: f64,
    /// What the floor is made of.
    pub floor: Material,
    /// What the ceiling is made of.
    pub ceiling: Material,
    /// Fire doors across the way, shut except while a person goes through; not part of the plan.
    pub fire_doors: Vec<Wall>,
}

impl RunScene {
    /// A plan without lamps in full daylight, under a plain ceiling 2.6 m high.
    pub fn of(plan: FloorPlan) -> Self {
        Self {
            plan,
            lights: Vec::new(),
            illumination: 1.0,
            daylight: 1.0,
            ceiling_m: 2.6,
            floor: Material::PLAIN,
            ceiling: Material::PLAIN,
            fire_doors: Vec::new(),
        }
    }
}
