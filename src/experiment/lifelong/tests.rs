use super::*;

fn toy() -> (LifelongConfig, Recipe, AdaptConfig) {
    let mut recipe = Recipe {
        features: 4,
        uncertainty: "global".parse().unwrap(),
        ..Recipe::default()
    };
    recipe.descent.steps = 30;
    let mut adapt = AdaptConfig::default();
    adapt.update.steps = 4;
    let config = LifelongConfig {
        seeds: 1,
        ..LifelongConfig::default().toy()
    };
    (config, recipe, adapt)
}

#[test]
fn every_robot_is_judged_before_it_learns_and_the_threads_do_not_matter() {
    let (config, recipe, adapt) = toy();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| lifelong(&config, &recipe, &adapt, &mut |_| {}))
            .unwrap()
    };
    let record = on(2);
    assert_eq!(record, on(1));
    for world in &record.worlds {
        assert_eq!(world.robots.len(), ROBOTS.len());
        let at = |kind: RobotKind| {
            world
                .robots
                .iter()
                .find(|robot| robot.kind == kind)
                .unwrap()
        };
        let frozen = at(RobotKind::Frozen);
        assert_eq!(frozen.error_at_10m_m_change.mean, 0.0);
        // On its first evening no robot has learned anything yet.
        for robot in &world.robots[..8] {
            assert_eq!(robot.days[0].error_at_10m_m, frozen.days[0].error_at_10m_m);
            assert_eq!(robot.days.len(), config.days - 1);
        }
        let truth = &at(RobotKind::TrueLabels).days[0];
        assert_eq!(
            (truth.labels_kept, truth.labels_wrong),
            (Some(1.0), Some(0.0))
        );
        assert_ne!(at(RobotKind::TrueLabels).days[1], frozen.days[1]);
        assert_eq!(at(RobotKind::Ungated).days[0].labels_kept, Some(1.0));
        assert!(at(RobotKind::AdaptedByMoment).days[0].labels_kept < Some(1.0));
        // A run is believed or it isn't: one mode is all that a label is asked then.
        let by_run = at(RobotKind::Adapted).days[0].labels_kept;
        assert!(by_run >= at(RobotKind::AdaptedByMoment).days[0].labels_kept);
        assert_eq!(frozen.days[0].labels_kept, None);
    }
}

/// A run of a still world differs from the one before in noise alone, one of a world that changes in what stands there.
#[test]
fn one_world_changes_and_one_does_not() {
    let config = LifelongConfig {
        days: 6,
        runs: 1,
        spacing_m: 1.0,
        ..LifelongConfig::default()
    };
    let differ = |change: Change| {
        let days = world::days(&config, change, 3).unwrap();
        assert_eq!(days.len(), 6);
        let (first, last) = (days[0].values(), days[5].values());
        let rows = first.nrows().min(last.nrows());
        let pairs = (0..rows).flat_map(|k| first.row(k).into_iter().zip(last.row(k)));
        let off = pairs.map(|(a, b)| (a - b).abs());
        let off: Vec<f32> = off.filter(|off| off.is_finite()).collect(); // no return twice
        off.iter().sum::<f32>() / off.len() as f32
    };
    let (changing, still) = (differ(Change::Changing), differ(Change::Still));
    assert!(changing > 1.15 * still, "{changing} {still}");
}

#[test]
fn values_out_of_range_are_refused_by_name() {
    let refused = |change: fn(&mut LifelongConfig), key: &str| {
        let mut config = LifelongConfig::default();
        change(&mut config);
        let fault = config.check().unwrap_err();
        assert!(
            fault.is_usage() && fault.to_string().contains(key),
            "{fault}"
        );
    };
    refused(|c| c.seeds = 0, "lifelong.seeds");
    refused(|c| c.set = "d9".into(), "lifelong.set");
    refused(|c| c.days = 1, "lifelong.days");
    refused(|c| c.runs = 0, "lifelong.runs");
    refused(|c| c.kept = 1.1, "lifelong.kept");
    refused(|c| c.lit = f64::NAN, "lifelong.lit");
    refused(|c| c.trials = 0, "lifelong.trials");
    refused(|c| c.longest_m = 5.0, "lifelong.longest_m");
    refused(|c| c.spacing_m = 0.0, "lifelong.spacing_m");
    assert!(LifelongConfig::default().check().is_ok());
}
