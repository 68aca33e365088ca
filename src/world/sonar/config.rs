//! The constants of a sonar ring, their bounds, and the rings of the papers' robots.

use crate::{
    error::{Error, Result},
    world::bounds::Bounds,
};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Every constant of the ring and its noise. Defaults: 24 Polaroid transducers round a B21 (Thrun 1998, 5.1.3 gives
/// their number; all else is assumed from that sensor's usual data), each fired alone in quiet air.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SonarConfig {
    /// Number of sonars, evenly spaced counter-clockwise, the first straight ahead.
    pub beams: usize,
    /// Sets of readings in a scan: between two sets the ring turns on by its spacing over their number, so nine sets of
    /// 16 sonars make 144 readings 2.5° apart (Duckett & Nehmzow 2000, Experiments).
    pub detailed: usize,
    /// Distance of the transducers from the robot's centre, metres; ranges count from the transducer.
    pub ring_radius_m: f64,
    /// Height of the ring above the floor, metres.
    pub height_m: f64,
    /// Full opening of the cone, radians.
    pub opening_rad: f64,
    /// Does the ring report the nearest surface in its cone, whatever that is made of and however it is turned
    /// (Ruiz-Mayor et al. 2006, 4.1: "nearest line segment inside a sensor cone", no rebounds)? Exact, without rays.
    pub plain: bool,
    /// Rays that sample the cone, evenly from edge to edge.
    pub rays: usize,
    /// Standard deviation by which a reading's cone points aside of its sonar's axis, radians: in restless air, and
    /// between pulses, the lobe is never quite the same.
    pub axis_sd_rad: f64,
    /// Shortest reading: the transducer still rings from its own pulse until then, metres.
    pub minimum_m: f64,
    /// Longest reading; from there on there is no return, metres.
    pub maximum_m: f64,
    /// What sound loses at the edge of the cone against the middle, out and back together, dB; in between it grows with the square of
    /// the angle, since the lobe is about normal in shape (Kuc & Siegel 1987). 0: the cone is equally loud throughout.
    pub edge_loss_db: f64,
    /// What an echo loses that is thrown back at a surface's critical angle against one met head-on, dB; in between it grows with
    /// the square of the angle.
    pub incidence_loss_db: f64,
    /// What a metre of air takes away, one way, dB a metre. An echo's loudness also falls with its range, as 20 log₁₀; it is just heard
    /// where its surface's reflectivity has it end.
    pub absorption_db_per_m: f64,
    /// Standard deviation of an echo's loudness from reading to reading, dB: near the threshold echoes come and go. 0: an echo that is
    /// heard once is always heard.
    pub fading_db: f64,
    /// How much too far an echo reads that is just loud enough, metres: its envelope rises over the length of the pulse, and a weaker
    /// one crosses the threshold later. Twice as loud, half as far.
    pub late_m: f64,
    /// How many mirror reflections a ray is followed through.
    pub reflections: usize,
    /// How near to the transducer a ray thrown back by mirrors (a corner) must pass to be heard, metres.
    pub capture_radius_m: f64,
    /// Groups of sonars, each fired at once, one group after another; every sonar in exactly one. A sonar can't tell
    /// another's pulse from its own: cross-talk. Empty: each sonar alone in quiet air, so none.
    pub firing: Vec<Vec<usize>>,
    /// Time from one group's pulse to the next one's, seconds.
    pub firing_interval_s: f64,
    /// Temperature of the air, °C, which sets the speed of sound.
    pub air_celsius: f64,
    /// Temperature for which the sensor turns time into metres, °C.
    pub calibrated_celsius: f64,
    /// Standard deviation of the range noise at range 0, metres.
    pub noise_m: f64,
    /// What a metre of range adds to that standard deviation, metres a metre.
    pub noise_per_m: f64,
    /// Step of the readings, metres; 0: continuous.
    pub resolution_m: f64,
    /// Probability that a reading is false and short (electrical noise, pulses of which nothing is modelled): uniform
    /// between the minimum and the range that it replaces.
    pub short_probability: f64,
    /// Probability that an echo is not heard.
    pub lost_probability: f64,
}

impl Default for SonarConfig {
    fn default() -> Self {
        Self {
            beams: 24,
            detailed: 1,
            ring_radius_m: 0.26,
            height_m: 0.6,
            opening_rad: 25_f64.to_radians(),
            plain: false,
            rays: 17,
            axis_sd_rad: 0.04,
            minimum_m: 0.15,
            maximum_m: 10.0,
            edge_loss_db: 0.0,
            incidence_loss_db: 0.0,
            absorption_db_per_m: 0.0,
            fading_db: 0.0,
            late_m: 0.0,
            reflections: 3,
            capture_radius_m: 0.15,
            firing: Vec::new(),
            firing_interval_s: 0.06,
            air_celsius: 20.0,
            calibrated_celsius: 20.0,
            noise_m: 0.01,
            noise_per_m: 0.01,
            resolution_m: 0.01,
            short_probability: 0.02,
            lost_probability: 0.03,
        }
    }
}

/// Most values that a ring, or rays that a cone, may have: far beyond any real one, small enough to allocate.
const MOST: usize = 10_000;

impl SonarConfig {
    /// The ring of a Nomad 200: 16 sonars (Duckett & Nehmzow 1998, 5), which report whole inches from 6 to 255. Two opposite sonars
    /// fire at once and the next pair before the air is quiet, so that there is cross-talk, as Duckett & Nehmzow 2000 met it.
    ///
    /// Echoes fade as those of a Polaroid transducer, 38.4 mm wide, at 49.4 kHz. Its lobe ends at asin(0.61 λ / a) = 12.75° and is
    /// about normal out to there, two ways exp(−4 θ² / θ₀²): 33 dB at the cone's edge (Kuc & Siegel 1987). Air at 20 °C and 50 % takes
    /// 1.64 dB a metre (ISO 9613-1). A pulse of 16 periods is 5.6 cm of range long. Where many parts of a rough surface answer,
    /// the sum of their echoes varies by 5.6 dB (Rayleigh), where one does, not at all: 3 dB is assumed. So are the loss by incidence, and the
    /// shares that are lost or false and short whatever their echo.
    pub fn nomad200() -> Self {
        Self {
            beams: 16,
            ring_radius_m: 0.22,
            height_m: 0.75,
            minimum_m: 0.1524,
            maximum_m: 6.477,
            edge_loss_db: 33.0,
            incidence_loss_db: 12.0,
            absorption_db_per_m: 1.64,
            fading_db: 3.0,
            late_m: 0.056,
            firing: (0..8).map(|first| vec![first, first + 8]).collect(),
            firing_interval_s: 0.025,
            resolution_m: 0.0254,
            short_probability: 0.005,
            ..Self::default()
        }
    }

    /// The ring of Sancho-2: twelve sonars with cones of 30° and a resolution of 4 cm, at 25 °C, without rebounds,
    /// noise or outliers (Ruiz-Mayor et al. 2006, 4.1 and 4.2). Assumed: its size and its range.
    pub fn sancho2() -> Self {
        Self {
            beams: 12,
            ring_radius_m: 0.25,
            height_m: 0.3,
            opening_rad: 30_f64.to_radians(),
            plain: true,
            axis_sd_rad: 0.0,
            minimum_m: 0.04,
            maximum_m: 6.0,
            air_celsius: 25.0,
            calibrated_celsius: 25.0,
            noise_m: 0.0,
            noise_per_m: 0.0,
            resolution_m: 0.04,
            short_probability: 0.0,
            lost_probability: 0.0,
            ..Self::default()
        }
    }

    /// Checks every constant.
    ///
    /// # Errors
    /// A usage error that names the first one out of bounds.
    pub fn check(&self) -> Result<()> {
        let bounds = Bounds("sonar");
        for (key, count) in [
            ("beams", self.beams),
            ("detailed", self.detailed),
            ("rays", self.rays),
        ] {
            if !(1..=MOST).contains(&count) {
                return bounds.wrong(key, count as f64, &format!("1 to {MOST}"));
            }
        }
        if self.beams * self.detailed > MOST {
            let readings = (self.beams * self.detailed) as f64;
            return bounds.wrong(
                "beams` times `detailed",
                readings,
                &format!("up to {MOST} readings"),
            );
        }
        if self.reflections > MOST {
            return bounds.wrong(
                "reflections",
                self.reflections as f64,
                &format!("0 to {MOST}"),
            );
        }
        if !(self.opening_rad >= 0.0 && self.opening_rad <= PI) {
            return bounds.wrong("opening_rad", self.opening_rad, "0 to π");
        }
        if self.plain && self.opening_rad == 0.0 {
            return bounds.wrong("opening_rad", 0.0, "more than 0 with `plain`");
        }
        bounds.not_negative(&[
            ("ring_radius_m", self.ring_radius_m),
            ("height_m", self.height_m),
            ("axis_sd_rad", self.axis_sd_rad),
            ("minimum_m", self.minimum_m),
            ("edge_loss_db", self.edge_loss_db),
            ("incidence_loss_db", self.incidence_loss_db),
            ("absorption_db_per_m", self.absorption_db_per_m),
            ("fading_db", self.fading_db),
            ("late_m", self.late_m),
            ("capture_radius_m", self.capture_radius_m),
            ("firing_interval_s", self.firing_interval_s),
            ("noise_m", self.noise_m),
            ("noise_per_m", self.noise_per_m),
            ("resolution_m", self.resolution_m),
        ])?;
        if !(self.maximum_m > self.minimum_m && self.maximum_m.is_finite()) {
            return bounds.wrong("maximum_m", self.maximum_m, "more than `minimum_m`");
        }
        bounds.shares(&[
            ("short_probability", self.short_probability),
            ("lost_probability", self.lost_probability),
        ])?;
        for (key, value) in [
            ("air_celsius", self.air_celsius),
            ("calibrated_celsius", self.calibrated_celsius),
        ] {
            if !(-90.0..=60.0).contains(&value) {
                return bounds.wrong(key, value, "-90 to 60");
            }
        }
        self.check_firing()
    }

    fn check_firing(&self) -> Result<()> {
        let wrong = |fault: String| Err(Error::usage(format!("sonar: `firing` {fault}")));
        if self.firing.is_empty() {
            return Ok(());
        }
        if self.plain {
            return wrong("is given, but `plain` has no cross-talk; expected one of them".into());
        }
        let mut fired = vec![0_usize; self.beams];
        for &beam in self.firing.iter().flatten() {
            match fired.get_mut(beam) {
                Some(times) => *times += 1,
                None => {
                    return wrong(format!(
                        "names sonar {beam}; expected 0 to {}",
                        self.beams - 1
                    ));
                }
            }
        }
        match fired.iter().position(|&times| times != 1) {
            None => Ok(()),
            Some(beam) => wrong(format!(
                "names sonar {beam} {} times; expected each sonar once",
                fired[beam]
            )),
        }
    }

    /// When each sonar sends its pulse, seconds after the first one; `None` where each has quiet air to itself.
    pub(super) fn pulse_times_s(&self) -> Option<Vec<f64>> {
        let mut times_s = vec![0.0; self.beams];
        for (turn, group) in self.firing.iter().enumerate() {
            for &beam in group {
                times_s[beam] = turn as f64 * self.firing_interval_s;
            }
        }
        (!self.firing.is_empty()).then_some(times_s)
    }
}

/// Speed of sound in dry air, metres a second: that of an ideal gas, √(T / 273.15 K) times 331.3 m/s.
pub(super) fn speed_of_sound_m_per_s(celsius: f64) -> f64 {
    331.3 * (1.0 + celsius / 273.15).sqrt()
}
