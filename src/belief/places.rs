//! The places where snapshots were taken, and how far apart they are.

use crate::{geometry::Pose, recording::Recording};

/// Labelled places ξ_1..ξ_K, given by one coordinate along a route or by poses in the plane.
///
/// The distance between two is the error e(ξ*, ξ) of taking one for the other: "the distance the robot must travel to
/// move from ξ* to ξ" (Thrun 1998, 5.1.5), along the route or straight.
///
/// ```
/// use ballmark::belief::Places;
/// let corridor = Places::Route(vec![0.0, 1.5, 89.0]);
/// assert_eq!(corridor.distance_m(0, &corridor, 2), 89.0);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub enum Places {
    /// Metres along a route.
    Route(Vec<f64>),
    /// Poses in the plane.
    Plane(Vec<Pose>),
}

impl Places {
    /// The places of a recording: along its route if it has one, else in the plane.
    pub fn of(recording: &Recording) -> Self {
        match recording.route_m() {
            Some(route) => Places::Route(route.to_vec()),
            None => Places::Plane(recording.poses().to_vec()),
        }
    }

    /// Number of places K.
    pub fn len(&self) -> usize {
        match self {
            Places::Route(route) => route.len(),
            Places::Plane(poses) => poses.len(),
        }
    }

    /// Is there no place at all?
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Place `index` as a pose; along a route `x_m` is its coordinate in metres and the rest is 0.
    pub fn pose(&self, index: usize) -> Pose {
        match self {
            Places::Route(route) => Pose::new(route[index], 0.0, 0.0),
            Places::Plane(poses) => poses[index],
        }
    }

    /// Some of the places, in the order given.
    pub fn select(&self, indices: &[usize]) -> Self {
        match self {
            Places::Route(route) => Places::Route(indices.iter().map(|&k| route[k]).collect()),
            Places::Plane(poses) => Places::Plane(indices.iter().map(|&k| poses[k]).collect()),
        }
    }

    /// e(ξ*, ξ): metres to travel from place `truth` of this set to place `other_index` of the other.
    ///
    /// # Panics
    /// Where one set lies along a route and the other in the plane: the two have no distance.
    pub fn distance_m(&self, truth: usize, other: &Places, other_index: usize) -> f64 {
        match (self, other) {
            (Places::Route(a), Places::Route(b)) => (a[truth] - b[other_index]).abs(),
            (Places::Plane(a), Places::Plane(b)) => a[truth].distance_m(&b[other_index]),
            // No number would be right, and every way in (`Neighbours::find`, `Parts::new`) has refused it with an error.
            _ => panic!("a place along a route has no distance to a pose in the plane"),
        }
    }

    /// Difference of the headings in [0, π]; 0 along a route, where heading plays no part.
    pub fn turn_rad(&self, truth: usize, other: &Places, other_index: usize) -> f64 {
        match (self, other) {
            (Places::Plane(a), Places::Plane(b)) => a[truth].turn_rad(&b[other_index]),
            _ => 0.0,
        }
    }
}
