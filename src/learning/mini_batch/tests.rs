use super::*;
use crate::{
    geometry::Pose,
    recording::{Channel, Columns, split::Split},
};

/// Three runs of 48 snapshots along a wall, seen by nine beams and a light sensor.
fn recording() -> Recording {
    let channel = |name: &str, width: usize, unit: &str, bearing_rad| Channel {
        name: name.into(),
        width,
        unit: unit.into(),
        bearing_rad,
        maximum: None,
        offset_m: None,
    };
    let bearing_rad: Vec<f64> = (0..9).map(|b| f64::from(b) * 0.2 - 0.8).collect();
    let pose: Vec<Pose> = (0..144)
        .map(|k| Pose::new(f64::from(k % 48) * 0.2, f64::from(k / 48), 0.0))
        .collect();
    let values = Array2::from_shape_fn((144, 10), |(k, c)| {
        2.0 + ((k % 48) as f32 * 0.1 + c as f32).sin()
    });
    Recording::new(Columns {
        channels: vec![
            channel("laser", 9, "m", Some(bearing_rad)),
            channel("light", 1, "lux", None),
        ],
        values,
        stamp_s: (0..144).map(f64::from).collect(),
        odometry: pose.clone(),
        pose,
        run: (0..144).map(|k| k / 48).collect(),
        ..Columns::default()
    })
    .unwrap()
}

fn recipe() -> Recipe {
    let mut recipe = Recipe {
        uncertainty: Uncertainty::Global,
        ..Recipe::default()
    };
    (
        recipe.descent.truths_per_step,
        recipe.descent.candidates_per_step,
    ) = (20, 48);
    recipe
}

fn with_lesson<T>(recipe: &Recipe, ask: impl FnOnce(&TrainingSet) -> T) -> T {
    let recording = recording();
    let everything = Split {
        train: (0..recording.len()).collect(),
        ..Split::default()
    };
    ask(&TrainingSet::prepare(recipe, &recording, &everything).unwrap())
}

#[test]
fn a_step_draws_the_same_again_and_another_one_draws_otherwise() {
    let recipe = recipe();
    with_lesson(&recipe, |training_set| {
        let inputs = |step| MiniBatch::new(&recipe, training_set, step).unwrap().inputs;
        assert_eq!(inputs(3), inputs(3));
        assert_ne!(inputs(3), inputs(4));
        assert_eq!(inputs(3).nrows(), 20 + 48);
    });
}

#[test]
fn truths_are_moved_and_candidates_are_not() {
    let known = |recipe: &Recipe| {
        with_lesson(recipe, |training_set| {
            let mini_batch = MiniBatch::new(recipe, training_set, 0).unwrap();
            let is_known = |row: usize| {
                let own = training_set.inputs.rows();
                own.into_iter().any(|own| own == mini_batch.inputs.row(row))
            };
            let all = mini_batch.inputs.nrows();
            let count = |rows: std::ops::Range<usize>| rows.filter(|&row| is_known(row)).count();
            (count(0..mini_batch.truths), count(mini_batch.truths..all))
        })
    };
    assert_eq!(known(&recipe()), (0, 48));
    let mut unmoved = recipe();
    (unmoved.augmentation.shift_m, unmoved.augmentation.turn_rad) = (0.0, 0.0);
    assert_eq!(known(&unmoved), (20, 48));
}

#[test]
fn people_stand_before_truths_and_not_before_candidates() {
    let inputs = |people: f64| {
        let mut recipe = recipe();
        recipe.augmentation = AugmentationConfig {
            input_noise: 0.0,
            shift_m: 0.0,
            turn_rad: 0.0,
            people: Some(people),
            ..AugmentationConfig::default()
        };
        with_lesson(&recipe, |training_set| {
            MiniBatch::new(&recipe, training_set, 0).unwrap().inputs
        })
    };
    let (empty, crowded) = (inputs(0.0), inputs(1.0));
    let differ = |row: &usize| empty.row(*row) != crowded.row(*row);
    assert!((0..20).filter(differ).count() > 15);
    // Nobody stands before a light sensor.
    let light = empty.ncols() - 1;
    assert!((0..20).all(|row| empty[(row, light)] == crowded[(row, light)]));
    let sum = |inputs: &Array2<f32>| inputs.slice_axis(Axis(0), (20..68).into()).sum();
    assert_eq!(empty.nrows(), crowded.nrows());
    // Which candidates are drawn does not hang on the people: they are drawn before.
    assert_eq!(sum(&empty), sum(&crowded));
}

#[test]
fn candidates_come_in_stretches_and_ascending() {
    let all = None;
    let pool = Pool::of(100, &all);
    let drawn = pool.stretches(40, &mut Seed(1).stream("draw"));
    assert!(
        drawn.is_sorted() && (34..=48).contains(&drawn.len()),
        "{drawn:?}"
    ); // the last stretch has four only
    let begins = drawn.iter().filter(|&&k| k % STRETCH == 0);
    assert_eq!(begins.count(), 3);
    assert_eq!(pool.stretches(100, &mut Seed(1).stream("draw")).len(), 100);
    let some = Some(vec![3, 5, 8]);
    assert_eq!(
        Pool::of(100, &some).some(9, &mut Seed(1).stream("draw")),
        [3, 5, 8]
    );
}

#[test]
fn a_run_that_is_left_out_is_none_of_the_candidates() {
    let mut recipe = recipe();
    recipe.descent.leave_run_out = true;
    (
        recipe.descent.truths_per_step,
        recipe.descent.candidates_per_step,
    ) = (200, 0);
    with_lesson(&recipe, |training_set| {
        let mini_batch = MiniBatch::new(&recipe, training_set, 0).unwrap();
        assert_eq!((mini_batch.truths, mini_batch.inputs.nrows()), (48, 144)); // one run, then the two others
    });
}

#[test]
fn uncertainties_are_mixed_as_asked() {
    let mut recipe = recipe();
    recipe.uncertainty = "2m".parse().unwrap();
    recipe.priors.stated = Some(0.5);
    let mut random = Seed(1).stream("priors");
    let drawn: Vec<Uncertainty> = (0..4000)
        .map(|_| draw_uncertainty(&recipe, &mut random))
        .collect();
    let share =
        |of: &dyn Fn(&Uncertainty) -> bool| drawn.iter().filter(|u| of(u)).count() as f64 / 4000.0;
    assert!((share(&|u| *u == recipe.uncertainty) - 0.5).abs() < 0.03);
    assert!((share(&|u| *u == Uncertainty::Global) - 0.2).abs() < 0.03);
    assert!(drawn.iter().all(|u| match u {
        Uncertainty::Window {
            half_width_m,
            half_turn_rad,
        } => (1.0..=12.0).contains(half_width_m) && *half_turn_rad == Some(DEFAULT_HALF_TURN_RAD),
        Uncertainty::Global => true,
    }));
    recipe.priors.stated = Some(1.0);
    assert_eq!(draw_uncertainty(&recipe, &mut random), recipe.uncertainty);
}

#[test]
fn beams_are_dropped_in_blocks_and_nothing_else_is() {
    let dropped = |share| {
        let values = drop_beams(recording(), share, &mut Seed(1).stream("blocks")).unwrap();
        values.values().clone()
    };
    let third = dropped(0.3);
    let lost = third.iter().filter(|v| v.is_nan()).count() as f64 / (144.0 * 9.0);
    assert!((lost - 0.3).abs() < 0.05, "{lost}");
    assert!(
        third.column(9).iter().all(|v| v.is_finite()),
        "a light sensor has no beams"
    );
    assert!(dropped(0.0).iter().all(|v| v.is_finite()));
}
