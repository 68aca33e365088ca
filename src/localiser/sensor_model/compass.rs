//! The likelihood of a compass heading.

use super::{SensorModel, flat};
use crate::{
    belief::{Belief, Places},
    error::{Error, Result},
    geometry::wrapped,
    recording::{Observation, Recording},
    seed::Stream,
};

/// A compass: the heading that it shows is drawn from a von Mises distribution around the true one, whose concentration is
/// 1/sd² (as good as exact for the sd of a compass). Without a compass heading, and along a route, where heading plays no
/// part, it says nothing.
///
/// ```
/// use ballmark::{belief::{Belief, Places}, geometry::Pose, localiser::sensor_model::{Compass, SensorModel}, recording::Observation, seed::Seed};
/// let cells = std::sync::Arc::new(Places::Plane(vec![Pose::new(0.0, 0.0, 0.0), Pose::new(0.0, 0.0, 3.0)]));
/// let observation = Observation { compass_rad: Some(0.1), ..Observation::new(&[], &[], 0.0, Pose::default())? };
/// let belief = Belief::uniform(&cells)?;
/// let log_likelihood = Compass::new(0.0, 0.2)?.log_likelihood(&observation, &belief, &mut Seed(1).stream("unused"))?;
/// assert!(log_likelihood[0] > log_likelihood[1] + 20.0);
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Compass {
    zero_rad: f64,
    concentration: f64,
}

impl Compass {
    /// `zero_rad` is what is added to a compass heading to make it one of the map, `sd_rad` the standard deviation of a
    /// heading, both in radians.
    ///
    /// # Errors
    /// Where the standard deviation isn't above 10⁻⁶ (the call is wrong), or the zero is not finite.
    pub fn new(zero_rad: f64, sd_rad: f64) -> Result<Self> {
        if !(sd_rad.is_finite() && sd_rad > 1e-6) {
            return Err(Error::usage(format!(
                "compass_sd_rad = {sd_rad}: expected radians, above 1e-6"
            )));
        }
        if !zero_rad.is_finite() {
            return Err(Error::work(format!(
                "the compass's zero is at {zero_rad}; expected radians"
            )));
        }
        Ok(Self {
            zero_rad,
            concentration: sd_rad.powi(-2),
        })
    }

    /// By how much the headings of the map are turned from those of the compass, in radians: the direction of the mean, over
    /// the mapping part. None without a compass.
    pub fn zero_rad(recording: &Recording, mapping: &[usize]) -> Option<f64> {
        let compass = recording.columns().compass_rad.as_ref()?;
        let turned = |&k: &usize| recording.poses()[k].heading_rad - compass[k];
        let (sin, cos) = mapping.iter().map(turned).fold((0.0, 0.0), |sum, turned| {
            (sum.0 + turned.sin(), sum.1 + turned.cos())
        });
        Some(wrapped(sin.atan2(cos)))
    }
}

impl SensorModel for Compass {
    fn name(&self) -> &str {
        "compass"
    }

    fn log_likelihood(
        &self,
        observation: &Observation,
        belief: &Belief,
        _: &mut Stream,
    ) -> Result<Vec<f64>> {
        let (Some(compass_rad), Places::Plane(cells)) =
            (observation.compass_rad, &**belief.places())
        else {
            return Ok(flat(belief));
        };
        let shown_rad = compass_rad + self.zero_rad;
        if !shown_rad.is_finite() {
            return Ok(flat(belief));
        }
        // Cells of one heading lie side by side: one cosine is enough for them.
        let (mut heading_rad, mut log_likelihood) = (f64::NAN, 0.0);
        let each = cells.iter().map(|cell| {
            if cell.heading_rad != heading_rad {
                heading_rad = cell.heading_rad;
                log_likelihood = self.concentration * ((shown_rad - heading_rad).cos() - 1.0);
            }
            log_likelihood
        });
        Ok(each.collect())
    }

    fn depends_on_belief(&self) -> bool {
        false
    }
}
