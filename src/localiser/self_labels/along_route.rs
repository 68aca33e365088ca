//! Where in the plane a coordinate along a route lies.

use crate::geometry::{Pose, wrapped};

/// The mapped places in their order along the route.
pub(super) struct RouteInPlane(Vec<(f64, Pose)>);

impl RouteInPlane {
    /// From the poses of a map, of which there is one at least, and their coordinates in metres.
    pub(super) fn new(pose: &[Pose], route_m: &[f64]) -> Self {
        let mut places: Vec<(f64, Pose)> =
            route_m.iter().copied().zip(pose.iter().copied()).collect();
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self(places)
    }

    /// On the straight line between the mapped places before and behind, turned as far as it is on the way from one to the other; past
    /// an end, the end.
    pub(super) fn at(&self, route_m: f64) -> Pose {
        let places = &self.0;
        let behind = places.partition_point(|place| place.0 < route_m);
        let (from_m, from) = places[behind.saturating_sub(1)];
        let (to_m, to) = places[behind.min(places.len() - 1)];
        let share = match to_m > from_m {
            true => ((route_m - from_m) / (to_m - from_m)).clamp(0.0, 1.0),
            false => 0.0,
        };
        let turn_rad = wrapped(to.heading_rad - from.heading_rad);
        Pose::new(
            from.x_m + share * (to.x_m - from.x_m),
            from.y_m + share * (to.y_m - from.y_m),
            wrapped(from.heading_rad + share * turn_rad),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn a_coordinate_lies_between_its_neighbours() {
        let pose = [(4.0, PI - 0.1), (0.0, 3.0), (2.0, -PI + 0.1)];
        let pose = pose.map(|(x, h)| Pose::new(x, 1.0, h));
        let route = RouteInPlane::new(&pose, &[9.0, 1.0, 5.0]);
        let middle = route.at(7.0);
        assert!((middle.x_m - 3.0).abs() < 1e-12 && (middle.y_m - 1.0).abs() < 1e-12);
        assert!((middle.heading_rad.abs() - PI).abs() < 1e-12, "{middle:?}");
        assert_eq!(route.at(0.0).x_m, 0.0);
        assert_eq!(route.at(99.0).x_m, 4.0);
        assert_eq!(route.at(5.0).x_m, 2.0);
    }
}
