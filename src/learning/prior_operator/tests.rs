//! The operator's windows, and the error bound of its cells.

use super::*;
use crate::geometry::Pose;

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
