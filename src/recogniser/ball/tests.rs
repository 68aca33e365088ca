use super::*;
use crate::recording::npz;
use ndarray::array;
use std::path::Path;

/// A recogniser that knows these patterns; its networks don't matter.
fn knowing(patterns: Vec<Vec<bool>>) -> Ball {
    Ball {
        patterns,
        ..shipped(None)
    }
}

/// The corridor's model that the crate comes with, having seen the first two runs of its small dataset.
fn shipped(most_patterns: Option<usize>) -> Ball {
    let recording = corridor();
    let mapping: Vec<usize> = (0..recording.runs()[1].end).collect();
    let config = BallConfig {
        model: Path::new(env!("CARGO_MANIFEST_DIR")).join("models/corridor-2m.safetensors"),
        most_patterns,
    };
    Ball::learn(&config, &recording, &mapping, Seed(0)).unwrap()
}

fn corridor() -> Recording {
    npz::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("datasets/corridor-small.npz")).unwrap()
}

#[test]
fn the_class_is_the_likeliest_pattern_and_a_known_one_is_itself() {
    let ball = knowing(vec![
        vec![true, true],
        vec![false, false],
        vec![false, true],
    ]);
    // Rounded, these are 11, 00 and 01.
    for (class, g) in [[0.9, 0.6], [0.4, 0.1], [0.1, 0.51]].iter().enumerate() {
        let answer = ball.likeliest(array![g[0], g[1]].view()).unwrap();
        assert_eq!(answer.class, class);
    }
    // 10 is unknown: P(11) = .8 · .4, P(00) = .2 · .6, P(01) = .2 · .4.
    let answer = ball.likeliest(array![0.8, 0.4].view()).unwrap();
    assert_eq!(answer.class, 0);
    assert!((answer.fit - 0.32f64.sqrt()).abs() < 1e-7, "{answer:?}");
    // Certain to the end of f32, and wrong about all it knows.
    let answer = knowing(vec![vec![false, true]]).likeliest(array![1.0, 0.0].view());
    assert!(answer.unwrap().fit > 0.0);
}

#[test]
fn a_shipped_model_answers_with_its_most_frequent_patterns() {
    let recording = corridor();
    let rest: Vec<usize> = (recording.runs()[1].end..recording.len()).collect();
    let (full, few) = (shipped(None), shipped(Some(3)));
    assert!(full.responses() > 3, "{}", full.responses());
    assert_eq!(few.responses(), 3);
    assert_eq!(full.patterns[..3], few.patterns[..]);
    let answers = few.respond_all(&recording, &rest);
    assert!(answers.iter().all(|a| a.is_some_and(|a| a.class < 3)));
}

#[test]
fn a_model_must_be_named_and_be_there() {
    let error = BallConfig::default().check().unwrap_err();
    assert!(error.is_usage() && error.to_string().contains("ball.model"));
    let config = BallConfig {
        model: "no-such-model.safetensors".into(),
        most_patterns: Some(0),
    };
    assert!(
        config
            .check()
            .unwrap_err()
            .to_string()
            .contains("most_patterns")
    );
    let config = BallConfig {
        most_patterns: None,
        ..config
    };
    let error = Ball::learn(&config, &corridor(), &[0], Seed(0)).unwrap_err();
    assert!(error.to_string().contains("no-such-model"), "{error}");
}
