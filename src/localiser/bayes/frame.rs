//! Is a model's map one of this recording, and nothing more? Asked once, when the mapping part's labels are at hand.

use super::Known;
use crate::{
    belief::{Neighbours, Places},
    error::{Error, Result},
    model::seen,
    recording::Recording,
};

/// Share of the mapping part that must lie at mapped places. A map in another frame may still cross it here and there.
const LEAST_MAPPED: f64 = 0.5;

/// What a model knows, for this recording: its map must know the places of the mapping part, in the recording's own frame,
/// and must not have been made from snapshots that are answered later. Where the map lies along a route that the recording
/// has not, or drives in laps or both ways, a place is its pose in the plane instead.
///
/// # Errors
/// Where the map is none of this recording's mapping part.
pub(super) fn fitted(known: Known, recording: &Recording, mapping: &[usize]) -> Result<Known> {
    let along = |_: &Vec<f64>| recording.route_m().is_some() && recording.goes_one_way();
    let known = Known {
        route_m: known.route_m.filter(along),
        ..known
    };
    let (map, mapped) = match (&known.route_m, recording.route_m()) {
        (Some(own), Some(route)) => (Places::Route(own.clone()), Places::Route(route.to_vec())),
        _ => {
            let poses = recording.poses().to_vec();
            (Places::Plane(known.pose.clone()), Places::Plane(poses))
        }
    };
    let near = Neighbours::find(&map, &mapped.select(mapping), &known.map.nearness)?;
    let at_mapped = (0..mapping.len()).filter(|&k| near.is_mapped(k)).count();
    if (at_mapped as f64) < LEAST_MAPPED * mapping.len() as f64 {
        return Err(Error::work(format!(
            "{at_mapped} of {} snapshots to learn from lie at places of the model's map; expected at least half: a model \
             trained on this recording, or in its frame",
            mapping.len()
        )));
    }
    let seen = seen::learned_poses(&known.pose, recording, mapping);
    if !seen::is_chance(seen) {
        return Err(Error::work(format!(
            "the model has learned from {seen} snapshots of this recording that are not among those to learn from; \
             expected one trained on these alone"
        )));
    }
    Ok(known)
}
