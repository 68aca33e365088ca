use super::*;
use crate::seed::Seed;
use ndarray::{Array1, array};
use rand::RngExt;

fn random(rows: usize, columns: usize, name: &str) -> Array2<f32> {
    let mut random = Seed(1).stream(name);
    Array2::from_shape_simple_fn((rows, columns), || random.random_range(0.01..0.99))
}

/// Word for word.
fn by_hand(g: &[f32], m: ndarray::ArrayView1<f32>) -> f64 {
    let terms = g.iter().zip(m).map(|(&g, &m)| {
        let (g, m) = (f64::from(g), f64::from(m));
        g * m.ln() + (1.0 - g) * (1.0 - m).ln()
    });
    terms.sum()
}

#[test]
fn probabilities_answer_as_the_formula_does() {
    // More cells than a block, not a whole number of blocks.
    let (m, g) = (random(1300, 13, "map"), random(1, 13, "answer"));
    let map = CodeMap::probabilities(m.view(), &[true; 1300]).unwrap();
    let l = map.log_likelihood(g.as_slice().unwrap()).unwrap();
    for (cell, l) in l.iter().enumerate() {
        let expected = by_hand(g.as_slice().unwrap(), m.row(cell));
        assert!((l - expected).abs() < 1e-4, "{cell}: {l}, {expected}");
    }
    assert_eq!(map.bytes_per_cell(), 52);
}

#[test]
fn a_bit_is_worth_what_the_examples_show() {
    // Of four examples the map's bit is 1 in three, two of which answer 1: (2 + 1) / (3 + 2). The other answers 0.2.
    let truth = array![[1.0], [1.0], [0.0], [0.2]];
    let there = array![[0.9], [0.8], [0.7], [0.1]];
    let map = CodeMap::bits(
        array![[0.51], [0.49], [0.3]].view(),
        &[true, true, false],
        (truth.view(), there.view()),
    )
    .unwrap();
    let l = map.log_likelihood(&[1.0]).unwrap();
    assert!((l[0] - 0.6_f64.ln()).abs() < 1e-6);
    assert!((l[1] - 0.4_f64.ln()).abs() < 1e-6);
    assert!((l[2] - 0.5 * (l[0] + l[1])).abs() < 1e-9);
    assert_eq!((map.bytes_per_cell(), map.unseen()), (1, &[2][..]));
    let kept = map.as_kept(array![[0.99], [0.01]].view());
    assert!((kept[[0, 0]] - 0.6).abs() < 1e-6 && (kept[[1, 0]] - 0.4).abs() < 1e-6);
}

#[test]
fn bits_of_many_features_answer_as_the_formula_does() {
    let (m, g) = (random(700, 21, "map"), random(1, 21, "answer"));
    let truth = random(50, 21, "truth");
    let map = CodeMap::bits(
        m.view(),
        &[true; 700],
        (truth.view(), m.slice_axis(ndarray::Axis(0), (0..50).into())),
    )
    .unwrap();
    let l = map.log_likelihood(g.as_slice().unwrap()).unwrap();
    let kept = map.as_kept(m.view());
    for (cell, l) in l.iter().enumerate() {
        let expected = by_hand(g.as_slice().unwrap(), kept.row(cell));
        assert!((l - expected).abs() < 1e-4, "{cell}: {l}, {expected}");
    }
    assert_eq!(map.bytes_per_cell(), 3);
}

#[test]
fn certain_maps_stay_finite() {
    let map = CodeMap::probabilities(array![[0.0, 1.0]].view(), &[true]).unwrap();
    let l = map.log_likelihood(&[1.0, 0.0]).unwrap();
    assert!(l[0].is_finite() && l[0] < -20.0);
}

#[test]
fn what_is_no_map_and_no_answer_is_refused() {
    let refused = |m: Array2<f32>, seen: &[bool]| {
        let fault = CodeMap::probabilities(m.view(), seen).unwrap_err();
        fault.to_string()
    };
    assert!(refused(array![[f32::NAN]], &[true]).contains("cell 0, feature 0 is NaN"));
    assert!(refused(array![[0.5]], &[]).contains("0 of which"));
    let map = CodeMap::probabilities(array![[0.5, 0.5]].view(), &[true]).unwrap();
    let fault = map.log_likelihood(&[0.5]).unwrap_err().to_string();
    assert!(fault.contains("1 activations for a map of 2"));
    let fault = map.log_likelihood(&[0.5, 1.5]).unwrap_err().to_string();
    assert!(fault.contains("feature 1 is 1.5"));
    let one = Array1::zeros(1).insert_axis(ndarray::Axis(0));
    let m = array![[0.5, 0.5]];
    assert!(CodeMap::bits(m.view(), &[true], (one.view(), one.view())).is_err());
}
