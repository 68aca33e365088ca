//! What each pixel sees: rays through the plan, floor and ceiling, and the light that comes back along them.

use super::{
    config::{CameraConfig, Direction},
    lighting::{Lighting, Lit},
    texture::{sheet, spots},
};
use crate::{
    geometry::Pose,
    world::{Hit, Look, RunScene, Surroundings, Wall},
};
use nalgebra::{Point2, Point3, Vector2, Vector3};
use std::ops::ControlFlow;

/// Red, green and blue light.
pub(super) type Light = [f64; 3];

/// A camera in its place: where it is and how its picture lies in the world.
struct View {
    eye: Point3<f64>,
    forward: Vector3<f64>,
    right: Vector3<f64>,
    up: Vector3<f64>,
    rows: usize,
    columns: usize,
    /// Side of a ray's square in the picture a metre ahead, metres.
    pitch: f64,
}

impl View {
    fn of(config: &CameraConfig, pose: &Pose) -> Self {
        let (sin, cos) = pose.heading_rad.sin_cos();
        let (ahead, right) = (Vector3::new(cos, sin, 0.0), Vector3::new(sin, -cos, 0.0));
        let (forward, right, up) = match config.look {
            Direction::Ahead => (ahead, right, Vector3::z()),
            Direction::Left => (-right, ahead, Vector3::z()),
            Direction::Right => (right, -ahead, Vector3::z()),
            Direction::Up => (Vector3::z(), right, -ahead),
        };
        let columns = config.columns * config.samples;
        Self {
            eye: Point3::new(pose.x_m, pose.y_m, config.height_m),
            forward,
            right,
            up,
            rows: config.rows * config.samples,
            columns,
            pitch: 2.0 * (config.opening_rad / 2.0).tan() / columns as f64,
        }
    }

    /// How far right of the middle a column's rays lie, a metre ahead.
    fn aside(&self, column: usize) -> f64 {
        (column as f64 + 0.5 - self.columns as f64 / 2.0) * self.pitch
    }

    /// How far above the middle a row's rays lie, a metre ahead.
    fn above(&self, row: usize) -> f64 {
        (self.rows as f64 / 2.0 - row as f64 - 0.5) * self.pitch
    }
}

/// Everything that a ray may meet, in the light of the moment.
struct Stage<'a> {
    scene: &'a RunScene,
    around: &'a Surroundings<'a>,
    lighting: &'a Lighting,
    on_floor: Lit<'a>,
    on_ceiling: Lit<'a>,
    view: &'a View,
    reach_m: f64,
}

/// The light that arrives along each ray, `[row, column]`, row 0 at the top; `samples` rays a pixel's side.
pub(super) fn rays(
    config: &CameraConfig,
    scene: &RunScene,
    around: &Surroundings,
    pose: &Pose,
) -> Vec<Light> {
    let view = View::of(config, pose);
    let upwards = config.look == Direction::Up;
    // Looking up, nothing is seen beyond where the corner rays meet the ceiling.
    let reach_m = if upwards {
        let corner = view.aside(0).hypot(view.above(0));
        (corner * (scene.ceiling_m - config.height_m).max(0.0)).min(config.reach_m)
    } else {
        config.reach_m
    };
    let lighting = Lighting::around(scene, around, &view.eye.xy(), reach_m);
    let stage = Stage {
        scene,
        around,
        lighting: &lighting,
        on_floor: lighting.on_floor(),
        on_ceiling: lighting.on_ceiling(),
        view: &view,
        reach_m,
    };
    let mut light = vec![[0.0; 3]; view.rows * view.columns];
    if upwards {
        stage.look_up(&mut light);
    } else {
        (0..view.columns).for_each(|column| stage.look_along(column, &mut light));
    }
    light
}

impl Stage<'_> {
    /// A column of a level picture: its rays lie above each other, so that one way through the plan does for all.
    fn look_along(&self, column: usize, light: &mut [Light]) {
        let view = self.view;
        let flat = (view.forward + view.right * view.aside(column)).xy();
        let stretch = flat.norm();
        let direction = flat / stretch;
        // Rise of each row's ray, a metre of way over the floor.
        let rise = |row: usize| view.above(row) / stretch;
        let mut open: Vec<usize> = (0..view.rows).collect();
        let eye = view.eye.xy();
        let mut see = |hit: Hit| {
            let wall = self.around.wall(&hit);
            let mut face = None;
            open.retain(|&row| {
                let height_m = view.eye.z + rise(row) * hit.distance_m;
                let met =
                    (0.0..self.scene.ceiling_m).contains(&height_m) && wall.stands_at(height_m);
                if met {
                    let face = face.get_or_insert_with(|| self.face(wall, &hit, &direction));
                    light[row * view.columns + column] = face.light(height_m);
                }
                !met
            });
            let shut = wall.low_m <= 0.0 && wall.high_m >= self.scene.ceiling_m;
            if shut || open.is_empty() {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        };
        self.around
            .cast_through(&eye, &direction, self.reach_m, &mut see);
        for row in open {
            let rise = rise(row);
            let room_m = if rise > 0.0 {
                self.scene.ceiling_m
            } else {
                0.0
            } - view.eye.z;
            let way_m = room_m / rise;
            if way_m <= self.reach_m {
                let point = eye + direction * way_m;
                light[row * view.columns + column] = self.level(rise > 0.0, &point, way_m);
            }
        }
    }

    /// A picture of the ceiling, and of walls near by.
    fn look_up(&self, light: &mut [Light]) {
        let view = self.view;
        let eye = view.eye.xy();
        let room_m = self.scene.ceiling_m - view.eye.z;
        let walls = self.around.caster().plan().walls().iter();
        let near = walls
            .chain(self.around.passing())
            .any(|wall| wall.high_m > view.eye.z && wall.distance_m(&eye) <= self.reach_m);
        for row in 0..view.rows {
            for column in 0..view.columns {
                let flat = (view.right * view.aside(column) + view.up * view.above(row)).xy();
                // Way over the floor for a metre up.
                let slant = flat.norm();
                let mut seen = None;
                if near && slant > 0.0 {
                    let direction = flat / slant;
                    self.around
                        .cast_through(&eye, &direction, slant * room_m, |hit| {
                            let height_m = view.eye.z + hit.distance_m / slant;
                            let wall = self.around.wall(&hit);
                            if !wall.stands_at(height_m) {
                                return ControlFlow::Continue(());
                            }
                            seen = Some(self.face(wall, &hit, &direction).light(height_m));
                            ControlFlow::Break(())
                        });
                }
                light[row * view.columns + column] = seen.unwrap_or_else(|| {
                    let point = eye + flat * room_m;
                    self.level(true, &point, room_m * (1.0 + slant * slant).sqrt())
                });
            }
        }
    }

    /// The light from the ceiling or the floor at a point `way_m` metres away.
    fn level(&self, ceiling: bool, point: &Point2<f64>, way_m: f64) -> Light {
        let (height_m, normal, lit, material) = if ceiling {
            let height_m = self.scene.ceiling_m;
            (
                height_m,
                -Vector3::z(),
                &self.on_ceiling,
                &self.scene.ceiling,
            )
        } else {
            (0.0, Vector3::z(), &self.on_floor, &self.scene.floor)
        };
        let falling = lit.falling(&Point3::new(point.x, point.y, height_m), &normal);
        let lamp = ceiling.then(|| self.lighting.lamp_at(point, &falling));
        lamp.flatten().unwrap_or_else(|| {
            let sheet = u64::from(ceiling);
            let texture = self.texture(&material.look, sheet, [point.x, point.y], way_m);
            self.thrown_back(&material.look, texture, &falling)
        })
    }

    /// The face of a wall where a ray meets it.
    fn face<'a>(&'a self, wall: &'a Wall, hit: &Hit, direction: &Vector2<f64>) -> Face<'a> {
        let point = self.view.eye.xy() + direction * hit.distance_m;
        let along = (wall.to - wall.from).normalize();
        // Where on its line a wall begins, and which way it was drawn, must not tell in its texture.
        let backwards = along.x < -1e-9 || (along.x < 1e-9 && along.y < 0.0);
        let along = if backwards { -along } else { along };
        let aside_m = along.perp(&point.coords);
        let middle_m = (wall.low_m + wall.high_m.min(self.scene.ceiling_m)) / 2.0;
        let at = Point3::new(point.x, point.y, middle_m);
        Face {
            stage: self,
            wall,
            point,
            along_m: along.dot(&point.coords),
            sheet: sheet([along.x, along.y, aside_m]),
            way_m: hit.distance_m,
            normal: Vector3::new(hit.normal.x, hit.normal.y, 0.0),
            lit: self.lighting.on_wall(self.around, &at, &hit.normal),
        }
    }

    /// How much a spot on a surface differs from its mean; what is finer than a ray is wide blurs.
    fn texture(&self, look: &Look, sheet: u64, at_m: [f64; 2], way_m: f64) -> f64 {
        if look.contrast == 0.0 {
            return 1.0;
        }
        let blurred = (look.grain_m / (way_m * self.view.pitch)).min(1.0);
        let spot = spots(sheet, at_m.map(|m| m / look.grain_m));
        (1.0 + look.contrast * blurred * spot).max(0.0)
    }

    fn thrown_back(&self, look: &Look, texture: f64, falling: &Light) -> Light {
        std::array::from_fn(|c| {
            look.colour[c] * texture * falling[c] + look.daylight[c] * self.scene.daylight
        })
    }
}

/// A wall where a column of rays meets it.
struct Face<'a> {
    stage: &'a Stage<'a>,
    wall: &'a Wall,
    point: Point2<f64>,
    along_m: f64,
    sheet: u64,
    way_m: f64,
    normal: Vector3<f64>,
    lit: Lit<'a>,
}

impl Face<'_> {
    /// The light that comes from it at a height above the floor.
    fn light(&self, height_m: f64) -> Light {
        let look = &self.wall.material.look;
        let point = Point3::new(self.point.x, self.point.y, height_m);
        let falling = self.lit.falling(&point, &self.normal);
        let at_m = [self.along_m, height_m];
        let texture = self.stage.texture(look, self.sheet, at_m, self.way_m);
        self.stage.thrown_back(look, texture, &falling)
    }
}
