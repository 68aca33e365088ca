//! Is a model's map one of this recording, and nothing more? Asked once, when the mapping part's labels are at hand.

use super::Known;
use crate::{
    belief::{Grid, Neighbours, Places},
    error::{Error, Result},
    geometry::{Pose, wrapped},
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

/// By how much the headings of the map are turned from those of the compass: the direction of the mean, over the mapping
/// part. None without a compass.
pub(super) fn compass_zero_rad(recording: &Recording, mapping: &[usize]) -> Option<f64> {
    let compass = recording.columns().compass_rad.as_ref()?;
    let turned = |&k: &usize| recording.poses()[k].heading_rad - compass[k];
    let (sin, cos) = mapping.iter().map(turned).fold((0.0, 0.0), |sum, turned| {
        (sum.0 + turned.sin(), sum.1 + turned.cos())
    });
    Some(wrapped(sin.atan2(cos)))
}

/// Where the sites of a grid lie in the plane, `[site]`. Along a route a site lies on the straight line between the mapped
/// places before and behind it.
pub(super) fn sites(grid: &Grid, known: &Known) -> Vec<[f64; 2]> {
    let sites = grid.len() / grid.headings();
    match &**grid.places() {
        Places::Plane(cells) => cells[..sites].iter().map(|p| [p.x_m, p.y_m]).collect(),
        Places::Route(cells) => {
            let route = known.route_m.iter().flatten();
            let mut on_route: Vec<(f64, &Pose)> = route.copied().zip(&known.pose).collect();
            on_route.sort_by(|a, b| a.0.total_cmp(&b.0));
            cells.iter().map(|&x_m| between(&on_route, x_m)).collect()
        }
    }
}

/// The point at `x_m` along the route; past an end, the end. `on_route` is sorted and not empty.
fn between(on_route: &[(f64, &Pose)], x_m: f64) -> [f64; 2] {
    let behind = on_route.partition_point(|place| place.0 < x_m);
    let (from, from_at) = on_route[behind.saturating_sub(1)];
    let (to, to_at) = on_route[behind.min(on_route.len() - 1)];
    let share = if to > from {
        ((x_m - from) / (to - from)).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let mixed = |from_m: f64, to_m: f64| from_m + share * (to_m - from_m);
    [mixed(from_at.x_m, to_at.x_m), mixed(from_at.y_m, to_at.y_m)]
}
