use super::*;
use crate::{geometry::Pose, seed::Seed};
use ndarray::Array2;
use std::sync::Arc;

fn corridor(cells: usize) -> Arc<Places> {
    Arc::new(Places::Route((0..cells).map(|c| 0.5 * c as f64).collect()))
}

/// The same places as poses along a line.
fn line(route: &Places) -> Arc<Places> {
    let poses = (0..route.len()).map(|c| route.pose(c));
    Arc::new(Places::Plane(poses.collect()))
}

fn random_map(cells: usize, features: usize, name: &str) -> GridMap {
    let mut stream = Seed(5).stream(name);
    let values = Array2::from_shape_fn((cells, features), |_| stream.random::<f64>());
    GridMap::new(values).unwrap()
}

fn bumpy(places: &Arc<Places>) -> Belief {
    let mass = (0..places.len()).map(|c| 1.0 + (c as f64 * 0.7).sin());
    Belief::from_mass(places, mass.collect()).unwrap()
}

fn e(belief: &Belief, answers: &GridMap, map: &GridMap, approximation: Approximation) -> f64 {
    let mut stream = Seed(2).stream("features");
    expected_posterior_error_m(belief, answers, map, approximation, &mut stream).unwrap()
}

/// The module's equation, word for word.
fn by_hand(belief: &Belief, answers: &GridMap, map: &GridMap) -> f64 {
    let (places, cells) = (belief.places(), belief.mass().len());
    let p = |map: &GridMap, cell: usize, f: usize| -> f64 {
        let row = map.probability();
        let bits = row.row(cell).to_vec();
        let bits = bits.iter().enumerate();
        bits.map(|(i, m)| if f >> i & 1 == 1 { *m } else { 1.0 - m })
            .product()
    };
    let mut sum = 0.0;
    for f in 0..1 << map.features() {
        let d: f64 = (0..cells).map(|c| belief.mass()[c] * p(map, c, f)).sum();
        for truth in 0..cells {
            let n: f64 = (0..cells)
                .map(|c| places.distance_m(truth, places, c) * belief.mass()[c] * p(map, c, f))
                .sum();
            sum += belief.mass()[truth] * p(answers, truth, f) * n / d;
        }
    }
    sum
}

#[test]
fn sums_along_a_route_and_over_pairs_are_the_equation() {
    let corridor = corridor(23);
    let (answers, map) = (random_map(23, 3, "answers"), random_map(23, 3, "map"));
    for places in [corridor.clone(), line(&corridor)] {
        for belief in [Belief::uniform(&places).unwrap(), bumpy(&places)] {
            let expected = by_hand(&belief, &answers, &map);
            let all = Approximation::default();
            assert!((e(&belief, &answers, &map, all) - expected).abs() < 1e-12);
        }
    }
}

#[test]
fn few_places_and_drawn_features_come_near_the_sum() {
    let corridor = corridor(400);
    let places = line(&corridor);
    let smooth = |i: usize, cell: usize| 0.5 + 0.45 * (cell as f64 * 0.05 * (i + 1) as f64).sin();
    let map = |features| {
        let values = Array2::from_shape_fn((400, features), |(cell, i)| smooth(i, cell));
        GridMap::new(values).unwrap()
    };
    let belief = bumpy(&places);
    let (four, ten) = (map(4), map(10));
    let exact = e(&bumpy(&corridor), &four, &four, Approximation::default());
    let some = e(&belief, &four, &four, Approximation::default());
    assert!((some / exact - 1.0).abs() < 0.02, "{some} of {exact}");
    let exact = e(&bumpy(&corridor), &ten, &ten, Approximation::default());
    let drawn = e(&belief, &ten, &ten, Approximation::default());
    assert!((drawn / exact - 1.0).abs() < 0.1, "{drawn} of {exact}");
}

#[test]
fn a_sharp_belief_leaves_no_error_and_dull_features_take_none_away() {
    let places = corridor(30);
    let dull = GridMap::new(Array2::from_elem((30, 2), 0.5)).unwrap();
    let mut mass = vec![0.0; 30];
    mass[7] = 1.0;
    let sure = Belief::from_mass(&places, mass).unwrap();
    assert_eq!(e(&sure, &dull, &dull, Approximation::default()), 0.0);
    let lost = Belief::uniform(&places).unwrap();
    let prior: f64 = (0..30)
        .map(|c| lost.expected_error_m(&places, c) / 30.0)
        .sum();
    assert!((e(&lost, &dull, &dull, Approximation::default()) - prior).abs() < 1e-12);
}

#[test]
fn quantiles_share_the_belief_out() {
    let places = Arc::new(Places::Plane(vec![Pose::default(); 1000]));
    let belief = bumpy(&places);
    let some = quantiles(&belief, 50);
    assert!(some.len() <= 50);
    assert!((some.iter().map(|(_, mass)| mass).sum::<f64>() - 1.0).abs() < 1e-12);
    assert_eq!(quantiles(&belief, 2000).len(), believed(&belief).len());
}

#[test]
fn other_cells_and_features_are_refused() {
    let belief = Belief::uniform(&corridor(4)).unwrap();
    let (four, five) = (random_map(4, 2, "a"), random_map(5, 2, "a"));
    let mut stream = Seed(1).stream("features");
    let mut of = |answers, map| {
        expected_posterior_error_m(&belief, answers, map, Approximation::default(), &mut stream)
    };
    assert!(of(&four, &five).is_err());
    assert!(of(&four, &random_map(4, 3, "b")).is_err());
}
