use super::*;
use crate::{
    belief::{MapConfig, Nearness},
    geometry::Pose,
    seed::Seed,
};
use ndarray::Array2;
use rand::RngExt;

/// The nearest mapping snapshots alone, and next to nothing by chance: what the hand-worked values take for granted.
fn exact(k: usize) -> ErrorReductionConfig {
    ErrorReductionConfig {
        map: MapConfig {
            nearness: Nearness {
                k,
                ..Nearness::default()
            },
            unmodelled_probability: 1e-12,
            ..MapConfig::default()
        },
        ..ErrorReductionConfig::default()
    }
}

/// Two runs over the same places, so many metres long, a snapshot every eighth: the first tests, the second maps. Eighths
/// have no rounding, so a place at the very end of a window is in it whoever reckons.
struct Corridor {
    places: Places,
    metres: Vec<f64>,
    mapping: Vec<usize>,
    testing: Vec<usize>,
}

fn corridor(metres: usize) -> Corridor {
    let n = 8 * metres;
    let along: Vec<f64> = (0..2 * n).map(|k| (k % n) as f64 / 8.0).collect();
    Corridor {
        places: Places::Route(along.clone()),
        metres: along,
        mapping: (n..2 * n).collect(),
        testing: (0..n).collect(),
    }
}

impl Corridor {
    fn by_classes(
        &self,
        class: impl Fn(usize) -> Option<usize>,
        config: &ErrorReductionConfig,
    ) -> Curve {
        let class: Vec<Option<usize>> = (0..self.metres.len()).map(class).collect();
        by_classes(&self.places, &self.mapping, &self.testing, &class, config).unwrap()
    }

    fn by_bits(&self, bits: usize, bit: impl Fn(f64, usize) -> bool) -> Curve {
        let answers = Array2::from_shape_fn((self.metres.len(), bits), |(k, i)| {
            f64::from(u8::from(bit(self.metres[k], i)))
        });
        let config = exact(1);
        let (mapping, testing) = (&self.mapping, &self.testing);
        by_probabilities(&self.places, mapping, testing, answers.view(), &config).unwrap()
    }
}

fn global(curve: &Curve) -> f64 {
    curve.at(Uncertainty::Global).unwrap().error_reduction
}

fn reductions(curve: &Curve) -> Vec<f64> {
    let scores = curve.points.iter().map(|point| &point.score);
    scores.map(|score| score.error_reduction).collect()
}

#[test]
fn who_knows_every_place_loses_all_error_and_who_knows_none_keeps_it() {
    let corridor = corridor(60);
    let perfect = corridor.by_classes(|k| Some(k % 480), &exact(1));
    assert_eq!(perfect.points.len(), 6);
    assert!(reductions(&perfect).iter().all(|&r| r > 0.9999));
    // Shifted labels are labels as good as any.
    let renamed = corridor.by_classes(|k| Some(1_000 - k % 480), &exact(1));
    assert_eq!(perfect, renamed);
    let silent = corridor.by_classes(|_| None, &ErrorReductionConfig::default());
    let constant = corridor.by_classes(|_| Some(3), &ErrorReductionConfig::default());
    assert_eq!(silent, constant);
    assert!(reductions(&silent).iter().all(|r| r.abs() < 1e-12));
    // Guesses misled by the map's own guesses: a little worse than nothing.
    let guess: Vec<usize> = {
        let mut random = Seed(4).stream("guesses");
        (0..960).map(|_| random.random_range(0..4)).collect()
    };
    let guessing = reductions(&corridor.by_classes(|k| Some(guess[k]), &exact(5)));
    assert!(
        guessing.iter().all(|r| (-0.6..0.02).contains(r)),
        "{guessing:?}"
    );
}

/// Hand-worked: one bit that knows the first quarter leaves 10/48 of 16/48 of the length; 2^n equal segments told apart
/// leave one 2^n-th.
#[test]
fn quarters_and_equal_segments_give_the_hand_worked_reductions() {
    let corridor = corridor(64);
    let quarter = |x: f64| x < 16.0;
    let class = |k: usize| Some(usize::from(quarter(corridor.metres[k])));
    assert!((global(&corridor.by_classes(class, &exact(1))) - 0.375).abs() < 1e-4);
    assert!((global(&corridor.by_bits(1, |x, _| quarter(x))) - 0.375).abs() < 1e-4);
    for n in 1..=4 {
        let segment = |x: f64| (x / 64.0 * f64::from(1 << n)) as usize;
        let expected = 1.0 - 0.5_f64.powi(n);
        let classes = corridor.by_classes(|k| Some(segment(corridor.metres[k])), &exact(1));
        let bits = corridor.by_bits(n as usize, |x, i| segment(x) >> i & 1 == 1);
        assert!((global(&classes) - expected).abs() < 1e-4, "{n}");
        // Certain answers are judged alike as classes and as bits, under every prior.
        for (a, b) in classes.points.iter().zip(&bits.points) {
            assert_eq!(a.prior, b.prior);
            assert_eq!(a.score.snapshots, b.score.snapshots);
            let apart = a.score.error_reduction - b.score.error_reduction;
            assert!(apart.abs() < 1e-6, "{n} {} {apart}", a.prior);
        }
    }
}

/// Two places d apart, an answer given to 9 in 10 of the snapshots at one and 2 in 10 at the other: E = 25/99·d.
#[test]
fn uncertain_answers_give_the_hand_worked_error() {
    let metres: Vec<f64> = (0..40)
        .map(|k| if k % 20 < 10 { 0.0 } else { 99.0 })
        .collect();
    let places = Places::Route(metres);
    let (mapping, testing): (Vec<usize>, Vec<usize>) = ((0..20).collect(), (20..40).collect());
    let given = |k: usize| k % 20 < 9 || (10..12).contains(&(k % 20));
    let class: Vec<Option<usize>> = (0..40).map(|k| given(k).then_some(5)).collect();
    let curve = by_classes(&places, &mapping, &testing, &class, &exact(10)).unwrap();
    let score = curve.at(Uncertainty::Global).unwrap();
    assert!((score.prior_error_m - 49.5).abs() < 1e-9);
    assert!((score.posterior_error_m - 25.0).abs() < 1e-9, "{score:?}");
    assert_eq!(score.snapshots, 20);
    // Under narrow priors all candidates are at the one place: no error to reduce, so no point.
    assert_eq!(curve.points.len(), 1);

    let answers = Array2::from_shape_fn((40, 1), |(k, _)| if k % 20 < 10 { 0.9 } else { 0.2 });
    let curve = by_probabilities(&places, &mapping, &testing, answers.view(), &exact(10)).unwrap();
    let score = curve.at(Uncertainty::Global).unwrap();
    assert!((score.posterior_error_m - 25.0).abs() < 1e-9, "{score:?}");
}

#[test]
fn no_answer_tells_as_much_as_any_and_a_new_one_nothing() {
    let corridor = corridor(40);
    let second_half = |k: usize| corridor.metres[k] >= 20.0;
    let halves = corridor.by_classes(|k| second_half(k).then_some(0), &exact(1));
    assert!((global(&halves) - 0.5).abs() < 1e-3);
    let strange = |k: usize| {
        if k >= 320 {
            Some(usize::from(second_half(k)))
        } else {
            Some(9)
        }
    };
    let curve = corridor.by_classes(strange, &exact(1));
    assert!(reductions(&curve).iter().all(|r| r.abs() < 1e-12));
    // An answer that was only given far away leaves a narrow prior as it was.
    let misplaced = |k: usize| Some(usize::from(second_half(k) == (k < 320)));
    let curve = corridor.by_classes(misplaced, &exact(1));
    let narrow = curve.at("2m".parse().unwrap()).unwrap();
    assert!(narrow.error_reduction.is_finite() && narrow.error_reduction > -0.1);
    assert!(global(&curve) < -0.4);
}

#[test]
fn only_mapped_places_with_two_candidates_count() {
    let pose = |x_m: f64, heading_rad: f64| Pose::new(x_m, 0.0, heading_rad);
    let mapped = (0..20).map(|k| pose(0.2 * f64::from(k), 0.0));
    // Two beside the map, one too far from it, one that looks the other way.
    let asked = [(1.05, 0.1), (3.3, 0.0), (7.0, 0.0), (2.0, 3.0)];
    let poses = mapped.chain(asked.map(|(x, heading)| pose(x, heading)));
    let places = Places::Plane(poses.collect());
    let (mapping, testing): (Vec<usize>, Vec<usize>) = ((0..20).collect(), (20..24).collect());
    let class = vec![Some(1); 24];
    let mut config = exact(3);
    config.priors = ["0.05m", "0.5m", "global"]
        .map(|p| p.parse().unwrap())
        .to_vec();
    let curve = by_classes(&places, &mapping, &testing, &class, &config).unwrap();
    let counted: Vec<(String, usize)> = curve
        .points
        .iter()
        .map(|point| (point.prior.to_string(), point.score.snapshots))
        .collect();
    // Within 5 cm there is never a second candidate, and the curve has no such point.
    assert_eq!(counted, [("0.5m".into(), 2), ("global".into(), 2)]);
    assert!(curve.at("0.05m".parse().unwrap()).is_none());
}

#[test]
fn what_makes_no_sense_is_told() {
    let corridor = corridor(5);
    let class = vec![None; 80];
    let refusal = |mapping: &[usize], testing: &[usize], class: &[Option<usize>], config: &_| {
        by_classes(&corridor.places, mapping, testing, class, config).unwrap_err()
    };
    let config = ErrorReductionConfig::default();
    let (mapping, testing) = (&corridor.mapping, &corridor.testing);
    let few = refusal(mapping, testing, &class[1..], &config);
    assert_eq!(
        few.to_string(),
        "error reduction: 79 answers; expected 80, one a snapshot"
    );
    assert!(
        refusal(mapping, &[80], &class, &config)
            .to_string()
            .contains("snapshot 80")
    );
    assert!(
        refusal(&[40, 41], testing, &class, &config)
            .to_string()
            .contains("at least k = 5")
    );
    assert!(
        refusal(mapping, &[], &class, &config)
            .to_string()
            .contains("none of 0 test snapshots")
    );
    let mut odd = config.clone();
    odd.priors.clear();
    assert!(refusal(mapping, testing, &class, &odd).is_usage());
    odd = config.clone();
    odd.map.unmodelled_probability = 0.0;
    assert!(
        odd.check()
            .unwrap_err()
            .to_string()
            .contains("unmodelled_probability")
    );
    odd = config.clone();
    odd.map.nearness.k = 0;
    assert!(odd.check().unwrap_err().is_usage());
    config.check().unwrap();
}

#[test]
fn threads_do_not_change_the_curve() {
    let corridor = corridor(30);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let class = |k: usize| Some(k * k % 13);
        pool.install(|| corridor.by_classes(class, &ErrorReductionConfig::default()))
    };
    assert_eq!(with(1), with(4));
}
