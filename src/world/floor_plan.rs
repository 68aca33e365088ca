//! A floor plan: walls as segments in the plane, each of a material that says how sound comes back from it.

use super::Look;
use crate::error::{Error, Result};
use nalgebra::{Point2, Vector2};
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, TAU};

/// How a surface answers to ultrasound and to light.
///
/// A surface that is smooth against the wavelength (7 mm at 50 kHz) is a mirror: it throws sound back to the sender
/// only where it is met nearly head-on (Kuc & Siegel, *Physically based simulation model for acoustic sensor robot
/// navigation*, 1987). Roughness widens the angle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Material {
    /// Share of the sensor's maximum range up to which an echo off this surface is still heard, in (0, 1]. Several
    /// surfaces on one way multiply.
    pub reflectivity: f64,
    /// Largest angle between a ray and the surface's normal at which sound comes back, in (0, π/2] radians. Beyond it
    /// the surface is a mirror.
    pub critical_angle_rad: f64,
    /// Share of infrared light that it throws back, in [0, 1].
    pub infrared: f64,
    /// What a camera sees of it.
    pub look: Look,
}

impl Material {
    /// Light plaster: smooth to sound, pale and bare to a camera. Other materials say how they differ from it.
    pub const PLAIN: Self = Self {
        reflectivity: 0.9,
        critical_angle_rad: 0.2,
        infrared: 0.7,
        look: Look::PLAIN,
    };

    /// What is out of bounds, if anything.
    pub(super) fn check(&self) -> std::result::Result<(), String> {
        let Self {
            reflectivity,
            critical_angle_rad,
            infrared,
            look,
        } = *self;
        if !(0.0..=1.0).contains(&infrared) {
            return Err(format!("infrared {infrared}; expected 0 to 1"));
        }
        look.check()?;
        if !(reflectivity > 0.0 && reflectivity <= 1.0) {
            return Err(format!(
                "reflectivity {reflectivity}; expected above 0, up to 1"
            ));
        }
        if !(critical_angle_rad > 0.0 && critical_angle_rad <= FRAC_PI_2) {
            return Err(format!(
                "critical angle {critical_angle_rad} rad; expected above 0, up to π/2"
            ));
        }
        Ok(())
    }
}

impl Default for Material {
    fn default() -> Self {
        Self::PLAIN
    }
}

/// A straight wall, seen from both sides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wall {
    /// One end, metres.
    pub from: Point2<f64>,
    /// The other end, metres.
    pub to: Point2<f64>,
    /// What it is made of.
    pub material: Material,
    /// Where it begins above the floor, metres.
    pub low_m: f64,
    /// Where it ends, metres; ∞: at the ceiling.
    pub high_m: f64,
}

impl Wall {
    /// A wall from one point to another, from the floor to the ceiling.
    pub fn new(from: Point2<f64>, to: Point2<f64>, material: Material) -> Self {
        Self {
            from,
            to,
            material,
            low_m: 0.0,
            high_m: f64::INFINITY,
        }
    }

    /// The same wall between two heights above the floor: a bin, a bench, the pane of a window.
    pub fn between(self, low_m: f64, high_m: f64) -> Self {
        Self {
            low_m,
            high_m,
            ..self
        }
    }

    /// Does it stand in the way at this height above the floor?
    pub fn stands_at(&self, height_m: f64) -> bool {
        (self.low_m..self.high_m).contains(&height_m)
    }

    /// Distance of a point to the nearest point of the wall, in metres.
    pub fn distance_m(&self, point: &Point2<f64>) -> f64 {
        let along = self.to - self.from;
        let share = (point - self.from).dot(&along) / along.norm_squared();
        (point - (self.from + along * share.clamp(0.0, 1.0))).norm()
    }
}

/// Walls that have been checked: at least one, all finite, none without length, materials within their bounds.
///
/// ```
/// use ballmark::world::{FloorPlan, Material, Wall};
/// use nalgebra::Point2;
/// let plaster = Material { reflectivity: 0.9, critical_angle_rad: 0.2, ..Material::PLAIN };
/// let plan = FloorPlan::new(vec![Wall::new(Point2::new(0.0, 0.0), Point2::new(4.0, 0.0), plaster)])?;
/// assert_eq!(plan.clearance_m(&Point2::new(1.0, 3.0)), 3.0);
/// assert_eq!(plan.clearance_m(&Point2::new(7.0, 4.0)), 5.0);
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct FloorPlan {
    walls: Vec<Wall>,
}

impl FloorPlan {
    /// A plan of these walls.
    ///
    /// # Errors
    /// Where there is no wall, an end is not finite, a wall has no length, or a material is out of bounds. The message
    /// names the first wall at fault, counted from 0.
    pub fn new(walls: Vec<Wall>) -> Result<Self> {
        if walls.is_empty() {
            return Err(Error::work("floor plan: no wall; expected at least one"));
        }
        for (index, wall) in walls.iter().enumerate() {
            let wrong =
                |fault: String| Err(Error::work(format!("floor plan: wall {index}: {fault}")));
            let ends = [wall.from.x, wall.from.y, wall.to.x, wall.to.y];
            if ends.iter().any(|number| !number.is_finite()) {
                return wrong(format!("ends at {ends:?}; expected finite metres"));
            }
            // A length whose square vanishes or overflows can't be divided by.
            let length_m = (wall.to - wall.from).norm();
            if !(1e-6..=1e6).contains(&length_m) {
                return wrong(format!("{length_m} m long; expected 1e-6 to 1e6 m"));
            }
            if !(wall.low_m >= 0.0 && wall.low_m < wall.high_m) {
                return wrong(format!(
                    "stands from {} to {} m above the floor; expected a stretch upwards",
                    wall.low_m, wall.high_m
                ));
            }
            if let Err(fault) = wall.material.check() {
                return wrong(fault);
            }
        }
        Ok(Self { walls })
    }

    /// The walls, in the order given.
    pub fn walls(&self) -> &[Wall] {
        &self.walls
    }

    /// Lower left and upper right corner of the smallest upright box around all walls, metres.
    pub fn bounds(&self) -> (Point2<f64>, Point2<f64>) {
        let first = self.walls[0].from; // never empty: checked by `new`
        self.walls
            .iter()
            .flat_map(|wall| [wall.from, wall.to])
            .fold((first, first), |(low, high), end| {
                (low.inf(&end), high.sup(&end))
            })
    }

    /// Distance of a point to the nearest wall, in metres.
    pub fn clearance_m(&self, point: &Point2<f64>) -> f64 {
        self.walls
            .iter()
            .map(|wall| wall.distance_m(point))
            .fold(f64::INFINITY, f64::min)
    }
}

/// A round thing, such as a bin or a pillar, as the polygon of `faces` walls around it.
///
/// ```
/// # use ballmark::world::{floor_plan::round, Material};
/// # use nalgebra::Point2;
/// let plastic = Material { reflectivity: 0.8, critical_angle_rad: 0.5, ..Material::PLAIN };
/// assert_eq!(round(Point2::new(1.0, 2.0), 0.2, 8, plastic).len(), 8);
/// ```
pub fn round(centre: Point2<f64>, radius_m: f64, faces: usize, material: Material) -> Vec<Wall> {
    let corner = |face: usize| {
        let angle_rad = TAU * (face % faces) as f64 / faces as f64;
        centre + Vector2::new(angle_rad.cos(), angle_rad.sin()) * radius_m
    };
    (0..faces)
        .map(|face| Wall::new(corner(face), corner(face + 1), material))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLASTER: Material = Material {
        reflectivity: 0.9,
        critical_angle_rad: 0.2,
        ..Material::PLAIN
    };

    fn plan_error(from: [f64; 2], to: [f64; 2], material: Material) -> String {
        FloorPlan::new(vec![Wall::new(from.into(), to.into(), material)])
            .unwrap_err()
            .to_string()
    }

    #[test]
    fn each_bad_wall_is_told_in_one_line() {
        let no_echo = Material {
            reflectivity: 0.0,
            ..PLASTER
        };
        let too_wide = Material {
            critical_angle_rad: 2.0,
            ..PLASTER
        };
        for (message, expected) in [
            (FloorPlan::new(vec![]).unwrap_err().to_string(), "no wall"),
            (
                plan_error([0.0, f64::NAN], [1.0, 0.0], PLASTER),
                "finite metres",
            ),
            (
                plan_error([0.0, 0.0], [f64::INFINITY, 0.0], PLASTER),
                "finite metres",
            ),
            (
                plan_error([1.0, 2.0], [1.0, 2.0], PLASTER),
                "wall 0: 0 m long",
            ),
            (
                plan_error([0.0, 0.0], [1.0, 0.0], no_echo),
                "reflectivity 0",
            ),
            (
                plan_error([0.0, 0.0], [1.0, 0.0], too_wide),
                "critical angle 2 rad",
            ),
        ] {
            assert!(
                message.contains(expected) && !message.contains('\n'),
                "{message}"
            );
        }
    }

    #[test]
    fn bounds_hold_every_end() {
        let walls = round(Point2::new(3.0, -1.0), 2.0, 4, PLASTER);
        let (low, high) = FloorPlan::new(walls).unwrap().bounds();
        assert!((low - Point2::new(1.0, -3.0)).norm() < 1e-12);
        assert!((high - Point2::new(5.0, 1.0)).norm() < 1e-12);
    }
}
