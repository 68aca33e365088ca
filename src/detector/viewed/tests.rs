use super::*;
use crate::recording::Recording;
use crate::world::corridor;
use ndarray::Axis;

/// Answers with the first reading, as a share of ten metres.
struct First;

impl Detector for First {
    fn features(&self) -> usize {
        1
    }

    fn detect_batch(&self, _: &[Channel], values: ArrayView2<f32>) -> Result<Array2<f32>> {
        let first = values.column(0).mapv(|m| m.clamp(0.0, 10.0) / 10.0);
        Ok(first.insert_axis(Axis(1)))
    }
}

fn corridor() -> Recording {
    let config = corridor::CorridorConfig {
        runs: 1,
        spacing_m: 1.0,
    };
    corridor::thrun1998(Seed(1), &config).unwrap()
}

#[test]
fn an_answer_is_the_mean_over_the_views() {
    let recording = corridor();
    let viewed = Viewed::new(First, 3, Seed(4));
    let answers = viewed.probabilities(&recording).unwrap();
    let (channels, values) = (recording.channels(), recording.values());
    let mut expected = First.detect_batch(channels, values.view()).unwrap();
    for &step in &viewed.steps {
        let moved = after_step(channels, values.view(), step).unwrap().unwrap();
        assert_ne!(moved, values);
        expected += &First.detect_batch(channels, moved.view()).unwrap();
    }
    expected /= 4.0;
    // NaN stays NaN: a reading that is none has no mean.
    let same = |(a, b): (&f32, &f32)| (a - b).abs() < 1e-6 || (a.is_nan() && b.is_nan());
    assert!(answers.iter().zip(&expected).all(same));
    assert!(answers.iter().any(|a| a.is_finite()));
}

#[test]
fn what_cannot_be_drawn_anew_is_answered_as_it_is() {
    let light = Channel {
        name: "light".into(),
        width: 2,
        unit: "lux".into(),
        bearing_rad: None,
        maximum: None,
        offset_m: None,
    };
    let values = ndarray::array![[3.0_f32, 1.0], [7.0, 2.0]];
    let viewed = Viewed::new(First, 3, Seed(4));
    let answers = viewed.detect_batch(&[light], values.view()).unwrap();
    assert_eq!(answers, ndarray::array![[0.3_f32], [0.7]]);
}
