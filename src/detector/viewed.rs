//! A snapshot as seen from where it was taken and from beside: what a detector answers does not hang on where in a cell the
//! robot stands.

use super::Detector;
use crate::{
    error::Result,
    geometry::Displacement,
    recording::{
        Channel,
        viewpoint::{Moves, after_step},
    },
    seed::Seed,
};
use ndarray::{Array2, ArrayView2};

/// How far beside a snapshot it is looked at again, in metres …
const SHIFT_M: f64 = 0.05;
/// … and how far turned, in radians: standard deviations. Wider views cost recall where people are in the way.
const TURN_RAD: f64 = 0.03;

/// Most views of a snapshot that configurations take: each costs another answer.
pub const MOST_VIEWS: usize = 64;

/// A detector whose answer is the mean of its answers to a snapshot and to the same, drawn anew, from places beside. Readings that
/// can't be drawn anew are answered as they are.
///
/// ```
/// use ballmark::{detector::{Detector, Viewed, door::{Door, DoorConfig}}, seed::Seed, world::corridor};
/// let config = corridor::CorridorConfig { runs: 1, spacing_m: 0.5 };
/// let recording = corridor::thrun1998(Seed(1), &config)?;
/// let all: Vec<usize> = (0..recording.len()).collect();
/// let doors = Door::fit(&DoorConfig::default(), &recording, &all)?;
/// let looked_at_again = Viewed::new(doors, 8, Seed(1));
/// assert_eq!(looked_at_again.probabilities(&recording)?.dim(), (recording.len(), 1));
/// # Ok::<(), ballmark::Error>(())
/// ```
pub struct Viewed<D> {
    detector: D,
    steps: Vec<Displacement>,
}

impl<D: Detector> Viewed<D> {
    /// So many views besides the snapshot itself, the same of every snapshot.
    pub fn new(detector: D, views: usize, seed: Seed) -> Self {
        let moves = Moves {
            shift_m: SHIFT_M,
            turn_rad: TURN_RAD,
        };
        Self {
            detector,
            steps: moves.draw(views, &mut seed.stream("views of a snapshot")),
        }
    }
}

impl<D: Detector> Detector for Viewed<D> {
    fn features(&self) -> usize {
        self.detector.features()
    }

    fn detect_batch(&self, channels: &[Channel], values: ArrayView2<f32>) -> Result<Array2<f32>> {
        let mut sum = self.detector.detect_batch(channels, values)?;
        let mut seen = 1.0;
        for &step in &self.steps {
            let Some(moved) = after_step(channels, values, step)? else {
                break;
            };
            sum += &self.detector.detect_batch(channels, moved.view())?;
            seen += 1.0;
        }
        Ok(sum / seen)
    }
}

#[cfg(test)]
mod tests;
