//! Snapshots between two places that are known: where odometry has them, corrected at both ends.

use crate::geometry::{Pose, wrapped};

/// Places of the snapshots after the first of `odometry`, which was taken at `from`. `to` is the next known place with its own odometry;
/// after the last one odometry alone tells. Along a route, places are coordinates in `x_m`, and every step counts with its length.
///
/// What odometry misses `to` by is shared out along the way, as by Duckett & Nehmzow (1998, 6.4).
pub(super) fn between(
    from: Pose,
    odometry: &[Pose],
    to: Option<(Pose, Pose)>,
    is_route: bool,
) -> Vec<Pose> {
    let Some(&first) = odometry.first() else {
        return Vec::new();
    };
    let mut travelled_m = vec![0.0];
    let ends = to.iter().map(|(_, odometry)| odometry);
    for pair in odometry.iter().chain(ends).collect::<Vec<_>>().windows(2) {
        let step = pair[0].displacement_to(pair[1]);
        let step_m = match is_route {
            true => step.along_route_m(),
            false => step.distance_m(),
        };
        travelled_m.push(travelled_m[travelled_m.len() - 1] + step_m);
    }
    let reckoned = |number: usize, odometry: &Pose| match is_route {
        true => Pose::new(from.x_m + travelled_m[number], 0.0, 0.0),
        false => from.after(first.displacement_to(odometry)),
    };
    let missed = to.map(|(place, odometry)| {
        let at = reckoned(travelled_m.len() - 1, &odometry);
        let turn_rad = wrapped(place.heading_rad - at.heading_rad);
        [place.x_m - at.x_m, place.y_m - at.y_m, turn_rad]
    });
    let [x_m, y_m, turn_rad] = missed.unwrap_or_default();
    let all_m = travelled_m[travelled_m.len() - 1];
    let places = odometry.iter().enumerate().skip(1);
    places
        .map(|(number, odometry)| {
            let at = reckoned(number, odometry);
            let share = if all_m == 0.0 {
                0.0
            } else {
                travelled_m[number] / all_m
            };
            Pose::new(
                at.x_m + share * x_m,
                at.y_m + share * y_m,
                wrapped(at.heading_rad + share * turn_rad),
            )
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn drift_is_shared_out_along_the_way() {
        // Odometry has the robot go north where it goes east, and a tenth too far.
        let odometry = [0.0, 1.1, 2.2].map(|y_m| Pose::new(5.0, y_m, FRAC_PI_2));
        let to = (Pose::new(14.0, 2.2, 0.0), Pose::new(5.0, 4.4, FRAC_PI_2));
        let places = between(Pose::new(10.0, 2.0, 0.0), &odometry, Some(to), false);
        assert_eq!(places.len(), 2);
        for (place, x_m, y_m) in [(places[0], 11.0, 2.05), (places[1], 12.0, 2.1)] {
            assert!((place.x_m - x_m).abs() < 1e-9 && (place.y_m - y_m).abs() < 1e-9);
        }
        let alone = between(Pose::new(10.0, 2.0, 0.0), &odometry, None, false);
        assert!((alone[1].x_m - 12.2).abs() < 1e-9 && (alone[1].y_m - 2.0).abs() < 1e-9);
    }

    #[test]
    fn along_a_route_lengths_count() {
        // Round a corner.
        let odometry = [(0.0, 0.0, 0.0), (1.0, 0.0, FRAC_PI_2)];
        let odometry = odometry.map(|(x, y, h)| Pose::new(x, y, h));
        let to = (Pose::new(32.2, 0.0, 0.0), Pose::new(1.0, 1.0, FRAC_PI_2));
        let places = between(Pose::new(30.0, 0.0, 0.0), &odometry, Some(to), true);
        assert!((places[0].x_m - 31.1).abs() < 1e-9, "{places:?}");
        assert!(between(Pose::default(), &[], None, true).is_empty());
        let stands = [Pose::default(); 2];
        let places = between(Pose::new(3.0, 0.0, 0.0), &stands, None, true);
        assert_eq!(places, [Pose::new(3.0, 0.0, 0.0)]);
    }
}
