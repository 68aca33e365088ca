//! The maps that some scans may draw, and the ways to look at them, where the width of a sensor's beam is not known well.

use super::{
    occupancy_map::{OccupancyMap, OccupancyMapConfig},
    range_sensors::RangeSensors,
};
use crate::{error::Result, recording::Recording};

/// Openings of sonar and infrared cones that maps are drawn with, as shares of the whole: rays, and how far an echo's cause is
/// looked for to the sides.
const OPENINGS: [f64; 3] = [0.0, 0.5, 1.0];

/// Occupancy maps of some scans, to choose from: one where all beams are rays, and where there are cones, one for each share of
/// their openings.
///
/// # Errors
/// As [`OccupancyMap::from_scans`].
pub fn drawn_maps(
    recording: &Recording,
    snapshots: &[usize],
    sensors: &RangeSensors,
) -> Result<Vec<OccupancyMap>> {
    let drawn = |sensors: RangeSensors| {
        let config = OccupancyMapConfig {
            sensors,
            ..OccupancyMapConfig::default()
        };
        OccupancyMap::from_scans(recording, snapshots, &config)
    };
    match sensors.have_cones(recording.channels())? {
        true => OPENINGS
            .map(|share| drawn(sensors.narrowed(share)))
            .into_iter()
            .collect(),
        false => Ok(vec![drawn(sensors.clone())?]),
    }
}

/// The sensors as scans may be rendered with them: where there are cones, as rays and as cones.
///
/// # Errors
/// As [`RangeSensors::beams`].
pub fn rendered_as(recording: &Recording, sensors: &RangeSensors) -> Result<Vec<RangeSensors>> {
    Ok(match sensors.have_cones(recording.channels())? {
        true => vec![sensors.as_rays(), sensors.clone()],
        false => vec![sensors.clone()],
    })
}
