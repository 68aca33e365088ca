//! What a detector is fed at poses where no snapshot was taken: scans rendered in a map, in place of recorded ones.

use super::input::Input;
use crate::{
    error::{Error, Result},
    geometry::Pose,
    mapping::{OccupancyMap, RangeSensors, RenderConfig, Rendered, Renderer},
    recording::Channel,
};
use ndarray::{Array2, ArrayView2, Axis};

/// A pose counts as seen where a map says of at least this share of its beams what they would meet. Assumed.
const LEAST_SEEN: f64 = 0.25;

/// Poses that are rendered at once: what is held of raw scans stays small whatever is asked for.
const AT_ONCE: usize = 16_384;

/// An occupancy map, and how wide the beams are that look at it.
#[derive(Debug, Clone, PartialEq)]
pub struct SensedMap {
    /// In the frame of the recording's poses.
    pub map: OccupancyMap,
    /// The sensors that rendered scans are of.
    pub sensors: RangeSensors,
}

/// Inputs of a detector at any pose of a map, for sensors that all measure ranges.
///
/// A beam that leaves what is known reads as far as it was followed: no return is what a sensor says of open ground, and
/// nobody knows the ground to be open.
///
/// ```
/// use ballmark::detector::{input::{Input, InputConfig}, rendered::{RenderedInputs, SensedMap}};
/// use ballmark::mapping::{OccupancyMap, OccupancyMapConfig, RangeSensors};
/// use ballmark::{seed::Seed, world::corridor};
/// let config = corridor::CorridorConfig { runs: 1, spacing_m: 0.5 };
/// let recording = corridor::thrun1998(Seed(1), &config)?;
/// let all: Vec<usize> = (0..recording.len()).collect();
/// let sonar = InputConfig { channels: vec!["sonar".into()], ..InputConfig::default() };
/// let input = Input::fit(&sonar, &recording, &all)?;
///
/// let map = OccupancyMap::from_scans(&recording, &all, &OccupancyMapConfig::default())?;
/// let sensed = SensedMap { map, sensors: RangeSensors::default() };
/// let rendered = RenderedInputs::new(&sensed, recording.channels(), &input)?;
/// let at = rendered.at(&recording.poses()[..3])?;
/// assert_eq!(at.values.dim(), (3, input.width()));
/// assert!(at.seen.iter().all(|&seen| seen));
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct RenderedInputs {
    renderer: Renderer,
    channels: Vec<Channel>,
    input: Input,
}

/// What there is at some poses: what a detector is fed, or what it answers.
#[derive(Debug, Clone, PartialEq)]
pub struct AtPoses {
    /// `[pose, input]`, normalised, or `[pose, feature]`.
    pub values: Array2<f32>,
    /// Whether the map says enough of what is to be seen from there, `[pose]`.
    pub seen: Vec<bool>,
}

impl RenderedInputs {
    /// For the inputs that a model works from: the sensors are those of `input`.
    ///
    /// # Errors
    /// Where an input comes from a sensor that is no range sensor with known bearings.
    pub fn new(sensed: &SensedMap, channels: &[Channel], input: &Input) -> Result<Self> {
        let SensedMap { map, sensors } = sensed;
        input.check_channels(channels)?;
        let config = RenderConfig {
            sensors: RangeSensors {
                channels: input.channel_names().map(String::from).collect(),
                ..sensors.clone()
            },
            ..RenderConfig::default()
        };
        let renderer = Renderer::new(map, channels, &config)?;
        let is_input = |channel: &&Channel| input.channel_names().any(|name| name == channel.name);
        let readings: usize = channels.iter().filter(is_input).map(|c| c.width).sum();
        if renderer.beams().len() < readings {
            return Err(Error::work(format!(
                "rendered scans: {} of {readings} readings are ranges in known directions; expected all, for a map knows \
                 nothing of the others",
                renderer.beams().len()
            )));
        }
        Ok(Self {
            renderer,
            channels: channels.to_vec(),
            input: input.clone(),
        })
    }

    /// Inputs at some poses, on all threads; the same for any number of them.
    ///
    /// # Errors
    /// As [`Input::transform_values`]; not where [`RenderedInputs::new`] found the channels sound.
    pub fn at(&self, poses: &[Pose]) -> Result<AtPoses> {
        self.at_as(poses, self.input.width(), |inputs| Ok(inputs.to_owned()))
    }

    /// The same, the inputs of some thousand poses at a time turned into so many values a pose: what networks answer, as a rule.
    ///
    /// # Errors
    /// Where `of` fails, and as [`RenderedInputs::at`].
    pub fn at_as(
        &self,
        poses: &[Pose],
        width_of: usize,
        of: impl Fn(ArrayView2<f32>) -> Result<Array2<f32>>,
    ) -> Result<AtPoses> {
        let mut at = AtPoses {
            values: Array2::zeros((poses.len(), width_of)),
            seen: vec![false; poses.len()],
        };
        // Headings of one place are rendered together: they share what is met in each direction.
        let mut order: Vec<usize> = (0..poses.len()).collect();
        order.sort_by_key(|&k| [poses[k].x_m, poses[k].y_m].map(f64::to_bits));
        let width: usize = self.channels.iter().map(|channel| channel.width).sum();
        for some in order.chunks(AT_ONCE) {
            let their_poses: Vec<Pose> = some.iter().map(|&k| poses[k]).collect();
            let readings = self
                .renderer
                .at_all_as(&their_poses, |_, rendered| reading(rendered));
            let mut values = Array2::from_elem((some.len(), width), f32::NAN);
            for (beam, readings) in self.renderer.beams().iter().zip(readings.columns()) {
                let mut column = values.column_mut(beam.value);
                column.zip_mut_with(&readings, |value, (range_m, _)| *value = *range_m);
            }
            let inputs = self.input.transform_values(&self.channels, values.view())?;
            let values = of(inputs.view())?;
            for ((&k, values), readings) in some.iter().zip(values.rows()).zip(readings.rows()) {
                at.values.index_axis_mut(Axis(0), k).assign(&values);
                let known = readings.iter().filter(|(_, known)| *known).count();
                at.seen[k] = known as f64 >= LEAST_SEEN * readings.len() as f64;
            }
        }
        Ok(at)
    }
}

/// What a beam reads, in metres (NaN: no return), and whether the map knows it.
fn reading(rendered: Rendered) -> (f32, bool) {
    match rendered {
        Rendered::Hit(range_m) => (range_m, true),
        Rendered::Free => (f32::NAN, true),
        Rendered::Unknown(from_m) => (from_m, false),
    }
}

#[cfg(test)]
mod tests;
