//! How much light falls on a surface: from all around, from lamps, and through windows.
//!
//! Surfaces and sources are matt: a source of area A and brightness L that a surface sees at distance r under the cosines
//! c and c' lights it as a white surface in full light is lit, times L A c c' / (π r² + A), which is exact for a disc
//! face to face. What comes by way of other surfaces is the same everywhere.

use crate::world::{RunScene, Surroundings};
use nalgebra::{Point2, Point3, Rotation2, Vector2, Vector3};
use std::{f64::consts::PI, ops::ControlFlow};

/// Light from all around, where full light is 1: what lamps of usual strength give by way of walls and floor.
const AMBIENT: f64 = 0.6;
/// How much more light a lamp gives than its brightness tells. Assumed: with panels of 1.2 × 0.3 m and brightness 3 at a
/// usual height, a wall 1.2 m abreast of one is in full light, and one between two that are 5 m apart a third darker.
const LAMP_GAIN: f64 = 8.0;
/// Sources farther away than this give nothing, metres; up to there they fade.
const REACH_M: f64 = 12.0;
/// A dark lamp's panel: a share of the light that falls on the ceiling.
const DARK_PANEL: f64 = 0.7;
/// Shadow rays begin and end this far off, so that a surface doesn't shade itself, metres.
const OFF_M: f64 = 1e-3;

/// Something that lights other things.
struct Source {
    at: Point3<f64>,
    normal: Vector3<f64>,
    /// Does its back shine too?
    both_sides: bool,
    area_m2: f64,
    brightness: [f64; 3],
}

/// A lamp as it is seen in the ceiling.
struct Panel {
    at: Point2<f64>,
    aside: Rotation2<f64>,
    half_m: [f64; 2],
    /// `None`: dark.
    brightness: Option<f64>,
}

/// All light near a camera.
pub(super) struct Lighting {
    ambient: f64,
    lamps: Vec<Source>,
    /// Lamps as the floor throws their light back at the ceiling.
    from_floor: Vec<Source>,
    windows: Vec<Source>,
    panels: Vec<Panel>,
    ceiling_m: f64,
}

impl Lighting {
    /// The light of a scene as far as it matters to what is seen within `reach_m` metres of `eye`.
    pub fn around(
        scene: &RunScene,
        around: &Surroundings,
        eye: &Point2<f64>,
        reach_m: f64,
    ) -> Self {
        let near = |at: &Point2<f64>| (at - eye).norm() < reach_m + REACH_M;
        let lights: Vec<_> = scene
            .lights
            .iter()
            .filter(|light| near(&light.at))
            .collect();
        let floor: f64 = scene.floor.look.colour.iter().sum::<f64>() / 3.0;
        let lamp = |height_m: f64, facing: f64, share: f64| -> Vec<Source> {
            let lit = lights.iter().filter(|light| light.lit);
            lit.map(|light| Source {
                at: Point3::new(light.at.x, light.at.y, height_m),
                normal: Vector3::z() * facing,
                both_sides: false,
                area_m2: light.size_m[0] * light.size_m[1],
                brightness: [light.brightness * LAMP_GAIN * scene.illumination * share; 3],
            })
            .collect()
        };
        let walls = around
            .caster()
            .plan()
            .walls()
            .iter()
            .chain(around.passing());
        let windows = walls
            .filter(|wall| wall.material.look.daylight != [0.0; 3])
            .filter_map(|wall| {
                let middle = nalgebra::center(&wall.from, &wall.to);
                let along = wall.to - wall.from;
                let high_m = wall.high_m.min(scene.ceiling_m);
                let seen = near(&middle) && high_m > wall.low_m;
                seen.then(|| Source {
                    at: Point3::new(middle.x, middle.y, (wall.low_m + high_m) / 2.0),
                    normal: Vector3::new(-along.y, along.x, 0.0).normalize(),
                    both_sides: true,
                    area_m2: along.norm() * (high_m - wall.low_m),
                    brightness: wall.material.look.daylight.map(|l| l * scene.daylight),
                })
            })
            .collect();
        let panels = lights.iter().map(|light| Panel {
            at: light.at,
            aside: Rotation2::new(-light.heading_rad),
            half_m: light.size_m.map(|side| side / 2.0),
            brightness: light.lit.then_some(light.brightness * scene.illumination),
        });
        Self {
            ambient: AMBIENT * scene.illumination,
            lamps: lamp(scene.ceiling_m, -1.0, 1.0),
            // As if the floor were a mirror.
            from_floor: lamp(-scene.ceiling_m, 1.0, floor),
            windows,
            panels: panels.collect(),
            ceiling_m: scene.ceiling_m,
        }
    }

    /// What lights a wall: the sources that see it at this point, `off` being its side that is looked at.
    pub fn on_wall(
        &self,
        around: &Surroundings,
        point: &Point3<f64>,
        off: &Vector2<f64>,
    ) -> Lit<'_> {
        let sources = self.lamps.iter().chain(&self.windows);
        let seen = sources.filter(|source| self.sees(around, source, point, off));
        Lit {
            ambient: self.ambient,
            sources: seen.collect(),
        }
    }

    /// What lights the floor; without shadows.
    pub fn on_floor(&self) -> Lit<'_> {
        Lit {
            ambient: self.ambient,
            sources: self.lamps.iter().chain(&self.windows).collect(),
        }
    }

    /// What lights the ceiling; without shadows.
    pub fn on_ceiling(&self) -> Lit<'_> {
        Lit {
            ambient: self.ambient,
            sources: self.from_floor.iter().chain(&self.windows).collect(),
        }
    }

    /// The light that comes out of the ceiling here if there is a lamp, where `falling` is the light on it.
    pub fn lamp_at(&self, point: &Point2<f64>, falling: &[f64; 3]) -> Option<[f64; 3]> {
        let covers = |panel: &&Panel| {
            let offset = panel.aside * (point - panel.at);
            offset.x.abs() <= panel.half_m[0] && offset.y.abs() <= panel.half_m[1]
        };
        let panel = self.panels.iter().find(covers)?;
        Some(match panel.brightness {
            Some(brightness) => [brightness; 3],
            None => falling.map(|light| light * DARK_PANEL),
        })
    }

    fn sees(
        &self,
        around: &Surroundings,
        source: &Source,
        point: &Point3<f64>,
        off: &Vector2<f64>,
    ) -> bool {
        let from = point.xy() + off * OFF_M;
        let way = source.at.xy() - from;
        let way_m = way.norm();
        if way_m >= REACH_M || off.dot(&way) < 0.0 {
            return false;
        }
        if way_m <= 2.0 * OFF_M {
            return true;
        }
        let rise = (source.at.z - point.z) / way_m;
        let mut free = true;
        around.cast_through(&from, &(way / way_m), way_m - OFF_M, |hit| {
            let height_m = (point.z + rise * hit.distance_m).min(self.ceiling_m - OFF_M);
            if around.wall(&hit).stands_at(height_m) {
                free = false;
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        });
        free
    }
}

/// The sources that light a surface.
pub(super) struct Lit<'a> {
    ambient: f64,
    sources: Vec<&'a Source>,
}

impl Lit<'_> {
    /// Red, green and blue light that falls on the surface here.
    pub fn falling(&self, point: &Point3<f64>, normal: &Vector3<f64>) -> [f64; 3] {
        let mut sum = [self.ambient; 3];
        for source in &self.sources {
            let way = source.at - point;
            let squared = way.norm_squared();
            if squared >= REACH_M * REACH_M {
                continue;
            }
            // Both cosines carry a factor r, divided out at the end.
            let (at_surface, at_source) = (way.dot(normal), -way.dot(&source.normal));
            let at_source = if source.both_sides {
                at_source.abs()
            } else {
                at_source
            };
            if at_surface <= 0.0 || at_source <= 0.0 {
                continue;
            }
            let fade = (1.0 - squared / (REACH_M * REACH_M)).powi(2);
            let share = source.area_m2 * at_surface * at_source
                / (squared * (PI * squared + source.area_m2));
            (0..3).for_each(|c| sum[c] += fade * share * source.brightness[c]);
        }
        sum
    }
}
