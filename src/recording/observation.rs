//! What a robot senses at one time.

use super::Channel;
use crate::{
    error::{Error, Result},
    geometry::Pose,
};
use ndarray::ArrayView1;

/// What a localiser may see of a snapshot: everything but the truth.
#[derive(Debug, Clone, Copy)]
pub struct Observation<'a> {
    /// The sensors whose values these are, in their order.
    pub channels: &'a [Channel],
    /// Time in seconds, on the recording's own clock.
    pub stamp_s: f64,
    /// All channels side by side, in the order of `channels`, `[value]`; NaN = no return.
    pub values: ArrayView1<'a, f32>,
    /// Dead-reckoned pose since some start: only differences between two of one run mean anything.
    pub odometry: Pose,
    /// Compass heading in radians, where the robot has one.
    pub compass_rad: Option<f64>,
}

impl<'a> Observation<'a> {
    /// What a robot senses now: the raw values of all its `channels` side by side (NaN = no return), the time in seconds, and
    /// the pose that odometry has reckoned so far. Without a compass; set `compass_rad` where there is one.
    ///
    /// ```
    /// use ballmark::{geometry::Pose, recording::{Channel, Observation}};
    /// let sonar = Channel { name: "sonar".into(), width: 2, unit: "m".into(), bearing_rad: None, maximum: Some(5.0), offset_m: None };
    /// let channels = [sonar];
    /// let observation = Observation::new(&channels, &[1.5, f32::NAN], 12.0, Pose::new(3.0, 0.0, 0.1))?;
    /// assert_eq!(observation.values[0], 1.5);
    /// let error = Observation::new(&channels, &[1.5], 12.0, Pose::default()).unwrap_err();
    /// assert_eq!(error.to_string(), "observation: 1 value; expected 2, those of `sonar` (2)");
    /// # Ok::<(), ballmark::Error>(())
    /// ```
    ///
    /// # Errors
    /// Where the channels have another number of values, or stamp or odometry is not finite.
    pub fn new(
        channels: &'a [Channel],
        values: &'a [f32],
        stamp_s: f64,
        odometry: Pose,
    ) -> Result<Self> {
        let observation = Self {
            channels,
            stamp_s,
            values: ArrayView1::from(values),
            odometry,
            compass_rad: None,
        };
        observation.check()?;
        Ok(observation)
    }

    /// # Errors
    /// As [`Observation::new`].
    pub(crate) fn check(&self) -> Result<()> {
        check_width(self.channels, self.values.len()).map_err(|e| e.context("observation"))?;
        let (stamp_s, odometry) = (self.stamp_s, self.odometry);
        if !(stamp_s.is_finite() && odometry.is_finite()) {
            return Err(Error::work(format!(
                "observation: stamp {stamp_s} s, odometry {odometry:?}; expected finite numbers"
            )));
        }
        Ok(())
    }

    /// The way from here to `next`, of the same run, as odometry has it but with north from the compass: metres along x and y
    /// of the frame that the compass counts its headings in. `None` without a compass.
    ///
    /// Odometry is asked only for the movement in the robot's own frame, the compass for the heading that it began with, so
    /// that errors in heading don't add up: the compass-based odometry of Duckett & Nehmzow (1998), 5.2, who anchor their
    /// robot's turret to north and reckon by its angle against the base. Where the turret is what poses and odometry tell
    /// of, this is the same.
    ///
    /// ```
    /// use ballmark::{geometry::Pose, recording::Observation};
    /// let nothing = ndarray::Array1::zeros(0);
    /// let at = |odometry, compass_rad| Observation { channels: &[], stamp_s: 0.0, values: nothing.view(), odometry, compass_rad };
    /// // Odometry has long lost its heading and believes to have gone east; the compass says that the robot faced north.
    /// let (from, to) = (Pose::new(4.0, 1.0, 0.0), Pose::new(6.0, 1.0, 0.3));
    /// let north = Some(std::f64::consts::FRAC_PI_2);
    /// let [x_m, y_m] = at(from, north).north_displacement(&at(to, None)).unwrap();
    /// assert!(x_m.abs() < 1e-12 && (y_m - 2.0).abs() < 1e-12);
    /// assert_eq!(at(from, None).north_displacement(&at(to, north)), None);
    /// ```
    pub fn north_displacement(&self, next: &Observation) -> Option<[f64; 2]> {
        let moved = self.odometry.displacement_to(&next.odometry);
        let facing = Pose::new(0.0, 0.0, self.compass_rad?);
        let reached = facing.after(moved);
        Some([reached.x_m, reached.y_m])
    }
}

/// Are there as many values in a snapshot as its channels say?
///
/// # Errors
/// Where there are more or fewer; the message says how many each channel has.
pub(crate) fn check_width(channels: &[Channel], values: usize) -> Result<()> {
    let expected: usize = channels.iter().map(|channel| channel.width).sum();
    if values == expected {
        return Ok(());
    }
    let plural = if values == 1 { "" } else { "s" };
    let widths: Vec<String> = channels
        .iter()
        .map(|channel| format!("`{}` ({})", channel.name, channel.width))
        .collect();
    Err(Error::work(format!(
        "{values} value{plural}; expected {expected}, those of {}",
        widths.join(", ")
    )))
}
