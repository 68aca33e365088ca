//! The operator's windows, and the error bound of its cells.

use super::*;
use crate::{geometry::Pose, seed::Seed};
use rand::RngExt;

fn plane(x: &[f64]) -> Places {
    Places::Plane(x.iter().map(|&x_m| Pose::new(x_m, 0.0, 0.0)).collect())
}

#[test]
fn window_sizes_come_in_the_order_of_the_truths() {
    let (truths, candidates) = ([9.0, 0.0, 5.0], [5.5, 0.5, 4.5, 5.0]);
    let window: Uncertainty = "1m".parse().unwrap();
    let route = PriorOperator::new(
        window,
        &Places::Route(truths.to_vec()),
        &Places::Route(candidates.to_vec()),
    );
    assert_eq!(route.window_sizes(), [0, 1, 3]);
    let plane = PriorOperator::new(window, &plane(&truths), &plane(&candidates));
    assert_eq!(plane.window_sizes(), [0, 1, 3]);
}

/// Poses anywhere in a hall of 20 m by 12 m.
fn hall(name: &str, k: usize) -> Places {
    let mut random = Seed(5).stream(name);
    let mut uniform = |width: f64| width * random.random::<f64>() - 3.0;
    Places::Plane(
        (0..k)
            .map(|_| Pose::new(uniform(20.0), uniform(12.0), uniform(6.0)))
            .collect(),
    )
}

#[test]
fn no_error_between_cells_is_off_by_more_than_their_diagonal() {
    let truths = hall("truths", 200);
    for side_m in [0.25, 0.5, 2.0] {
        let diagonal_m = side_m * 2f64.sqrt();
        let mut worst = 0.0f64;
        // With one candidate alone, the prior error is the error of the pair.
        for number in 0..20 {
            let candidate = hall(&format!("candidate {number}"), 1);
            let prior = PriorOperator::everywhere_in_cells(&truths, &candidate, side_m).unwrap();
            for (truth, e) in prior.prior_error_m().iter().enumerate() {
                worst = worst.max((e - truths.distance_m(truth, &candidate, 0)).abs());
            }
        }
        assert!(worst <= diagonal_m, "cells of {side_m} m: off by {worst}");
        assert!(
            worst > 0.3 * diagonal_m,
            "cells of {side_m} m hold no places apart: {worst}"
        );
    }
}

#[test]
fn many_places_in_the_plane_are_taken_by_cells() {
    let (few, many) = (hall("few", 10), hall("many", MAX_EXACT_PLACES + 1));
    let shape = |c| PriorOperator::new(Uncertainty::Global, &few, c).shape;
    assert!(matches!(shape(&few), Shape::AllPairs(_)));
    assert!(matches!(shape(&many), Shape::Cells(_)));
}

#[test]
fn cells_and_distances_need_the_plane() {
    let (route, hall) = (Places::Route(vec![0.0]), hall("few", 3));
    assert!(PriorOperator::everywhere(&route, &hall).is_err());
    assert!(PriorOperator::everywhere_in_cells(&hall, &route, 1.0).is_err());
    for side_m in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let made = PriorOperator::everywhere_in_cells(&hall, &hall, side_m);
        assert!(made.err().is_some_and(|e| e.is_usage()), "{side_m}");
    }
}
