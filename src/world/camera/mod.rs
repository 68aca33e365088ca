//! A colour camera: rays through plan, floor and ceiling, matt surfaces under lamps and daylight, and a noisy chip.

mod config;
mod exposure;
mod lighting;
#[cfg(test)]
mod tests;
mod texture;
mod trace;

pub use config::{CameraConfig, Direction};

use super::{RunScene, Surroundings};
use crate::{
    error::{Error, Result},
    geometry::Pose,
    recording::{
        Channel,
        image::{self, Image},
    },
};
use rand::Rng;

/// A camera whose constants have been checked.
///
/// ```
/// use ballmark::{geometry::Pose, seed::Seed, world::{floor_plan::round, Camera, CameraConfig, FloorPlan, Material, Raycaster, RunScene}};
/// use nalgebra::Point2;
/// let scene = RunScene::of(FloorPlan::new(round(Point2::origin(), 3.0, 48, Material::PLAIN))?);
/// let caster = Raycaster::new(scene.plan.clone());
/// let camera = Camera::new(CameraConfig::default())?;
/// camera.check_in(&scene)?;
/// let mut noise = Seed(1).stream("camera");
/// let image = camera.render(&scene, &(&caster).into(), &Pose::default(), &mut noise);
/// assert_eq!((image.rows(), image.columns()), (60, 64));
/// let features = camera.read(&scene, &(&caster).into(), &Pose::default(), &mut noise);
/// assert_eq!(features.len(), camera.channel().width);
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    config: CameraConfig,
}

impl Camera {
    /// A camera of these constants.
    ///
    /// # Errors
    /// A usage error that names the first constant out of bounds.
    pub fn new(config: CameraConfig) -> Result<Self> {
        config.check()?;
        Ok(Self { config })
    }

    /// Makes sure that it fits under the ceiling.
    ///
    /// # Errors
    /// A usage error that names both heights.
    pub fn check_in(&self, scene: &RunScene) -> Result<()> {
        let (height_m, ceiling_m) = (self.config.height_m, scene.ceiling_m);
        if ceiling_m > height_m {
            return Ok(());
        }
        Err(Error::usage(format!(
            "camera: `height_m` is {height_m}; expected less than the ceiling's {ceiling_m}"
        )))
    }

    /// The constants.
    pub fn config(&self) -> &CameraConfig {
        &self.config
    }

    /// The channel that its readings make: `camera`, 140 values.
    pub fn channel(&self) -> Channel {
        image::channel()
    }

    /// The 140 features of one image taken at a pose (Thrun 1998, 5.1.3; see [`image::features`]).
    pub fn read(
        &self,
        scene: &RunScene,
        around: &Surroundings,
        pose: &Pose,
        random: &mut impl Rng,
    ) -> Vec<f32> {
        image::features(&self.render(scene, around, pose, random))
    }

    /// One image taken at a pose, `[row, column, colour]`. Walls are those of `around`; lamps, daylight, floor and ceiling
    /// those of `scene`.
    pub fn render(
        &self,
        scene: &RunScene,
        around: &Surroundings,
        pose: &Pose,
        random: &mut impl Rng,
    ) -> Image {
        let rays = trace::rays(&self.config, scene, around, pose);
        let values = exposure::exposed(&self.config, &rays, random);
        Image::from_values(self.config.rows, self.config.columns, values)
    }
}
