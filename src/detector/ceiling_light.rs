//! A landmark chosen by people: is a ceiling light in view of a camera that looks up?
//!
//! King & Weiman, *HelpMate autonomous mobile robot navigation system* (1990), as the baseline that Thrun (1998), 5.1.2 and
//! 5.3, gives his third data set: lamps are bright, stand still and are rarely hidden. How they found theirs is not described. Ours
//! is a bright bar in an image of which otherwise all is ceiling: the brightest of ten rows against their median. The image's
//! values are in its own standard deviations, so the lamp's strength and the time of day drop out.

use super::{
    Detector,
    camera::{BRIGHTNESS, Camera, STRIPS, probability},
    check_width,
};
use crate::{
    error::{Error, Result},
    recording::Channel,
};
use ndarray::{Array2, ArrayView2};
use serde::{Deserialize, Serialize};

/// The one feature: a light is in view.
///
/// On the third data set of the simulated corridor, where a lamp within 0.8 m of the robot is in view, its precision is .99
/// and its recall .95. Constants were chosen there, between ceilings without a lamp (.4 at most in 95 of 100 images) and
/// lamps overhead (1.9 at least).
///
/// ```
/// use ballmark::{detector::{Detector, ceiling_light::CeilingLight}, geometry::Pose, recording::{Channel, Columns, Recording}};
/// let camera = Channel { name: "camera".into(), width: 140, unit: "1".into(), bearing_rad: None, maximum: None, offset_m: None };
/// let mut values = ndarray::Array2::from_elem((2, 140), -0.2f32);
/// values[[1, 4 * 7]] = 2.1; // brightness of the fifth row
/// let recording = Recording::new(Columns {
///     channels: vec![camera],
///     values,
///     stamp_s: vec![0.0, 1.0],
///     pose: vec![Pose::default(); 2],
///     odometry: vec![Pose::default(); 2],
///     run: vec![0; 2],
///     ..Columns::default()
/// })?;
/// let seen = CeilingLight::default().probabilities(&recording)?;
/// assert!(seen[[0, 0]] < 0.01 && seen[[1, 0]] > 0.99);
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CeilingLight {
    /// By how many standard deviations the brightest row exceeds the median where a light is as likely as not.
    pub contrast: f64,
    /// How many more of them multiply the odds by e.
    pub softness: f64,
}

impl Default for CeilingLight {
    fn default() -> Self {
        Self {
            contrast: 1.0,
            softness: 0.15,
        }
    }
}

impl CeilingLight {
    /// # Errors
    /// A usage error where a constant is no positive number; the message names it.
    pub fn check(&self) -> Result<()> {
        for (key, value) in [("contrast", self.contrast), ("softness", self.softness)] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(Error::usage(format!(
                    "ceiling_light.{key} = {value}: expected more than 0"
                )));
            }
        }
        Ok(())
    }
}

impl Detector for CeilingLight {
    fn features(&self) -> usize {
        1
    }

    fn detect_batch(&self, channels: &[Channel], values: ArrayView2<f32>) -> Result<Array2<f32>> {
        check_width(channels, values)?;
        let Some(camera) = Camera::find(channels) else {
            return Err(Error::work(
                "ceiling lights: expected a channel `camera` of 140 values, of a camera that looks up",
            ));
        };
        let seen = values.rows().into_iter().map(|values| {
            let mut rows: [f64; STRIPS] =
                std::array::from_fn(|row| camera.row(values, row, BRIGHTNESS));
            rows.sort_by(f64::total_cmp);
            let median = (rows[STRIPS / 2 - 1] + rows[STRIPS / 2]) / 2.0;
            probability((rows[STRIPS - 1] - median - self.contrast) / self.softness)
        });
        Ok(seen
            .collect::<ndarray::Array1<f32>>()
            .insert_axis(ndarray::Axis(1)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        geometry::Pose,
        recording::{Columns, Recording},
    };

    fn images(brightness: &[[f32; STRIPS]], width: usize) -> Recording {
        let camera = Channel {
            name: "camera".into(),
            width,
            unit: "1".into(),
            bearing_rad: None,
            maximum: None,
            offset_m: None,
        };
        let sonar = Channel {
            name: "sonar".into(),
            width: 1,
            unit: "m".into(),
            ..camera.clone()
        };
        let k = brightness.len();
        let value = |(k, i): (usize, usize)| match i {
            0 => 3.0,
            i if (i - 1) % 7 == 0 && i < 71 => brightness[k][(i - 1) / 7],
            _ => 0.5,
        };
        Recording::new(Columns {
            channels: vec![sonar, camera],
            values: Array2::from_shape_fn((k, width + 1), value),
            stamp_s: vec![0.0; k],
            pose: vec![Pose::default(); k],
            odometry: vec![Pose::default(); k],
            run: vec![0; k],
            ..Columns::default()
        })
        .unwrap()
    }

    #[test]
    fn a_bright_row_anywhere_is_a_light_and_a_gradient_is_none() {
        let mut rows = vec![[0.0; STRIPS]; STRIPS];
        (0..STRIPS).for_each(|i| rows[i][i] = 2.0);
        rows.push(std::array::from_fn(|i| i as f32 * 0.1));
        rows.push([f32::NAN; STRIPS]);
        rows.push([1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]); // as much as the contrast asked for
        let seen = CeilingLight::default()
            .probabilities(&images(&rows, 140))
            .unwrap();
        assert_eq!(seen.dim(), (STRIPS + 3, 1));
        assert!((0..STRIPS).all(|i| seen[[i, 0]] > 0.99), "{seen}");
        assert!(seen[[STRIPS, 0]] < 0.1 && seen[[STRIPS + 1, 0]] < 0.01);
        assert_eq!(seen[[STRIPS + 2, 0]], 0.5);
        assert!(seen.iter().all(|&p| p > 0.0 && p < 1.0));
    }

    #[test]
    fn another_camera_and_odd_constants_are_reported() {
        let other = images(&[[0.0; STRIPS]], 100);
        let error = CeilingLight::default().probabilities(&other).unwrap_err();
        assert!(error.to_string().contains("`camera` of 140"), "{error}");
        let odd = CeilingLight {
            softness: 0.0,
            ..CeilingLight::default()
        };
        assert!(odd.check().unwrap_err().to_string().contains("softness"));
        assert!(CeilingLight::default().check().is_ok());
    }
}
