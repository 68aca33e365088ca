use super::*;

/// Round a rectangle of 12 m × 5 m, a point every `step` metres, each lap moved and stretched by drift.
fn rounds(laps: f64, step: f64, drift: [f64; 2]) -> Trace {
    let at = |m: f64| match m % 34.0 {
        m if m < 12.0 => [m, 0.0],
        m if m < 17.0 => [12.0, m - 12.0],
        m if m < 29.0 => [29.0 - m, 5.0],
        m => [0.0, 34.0 - m],
    };
    let points = (0..).map(|k| f64::from(k) * step);
    let points = points.take_while(|&m| m <= 34.0 * laps);
    let drifted = |m| [0, 1].map(|axis| at(m)[axis] + drift[axis] * m);
    Trace::new(points.map(drifted).collect())
}

#[test]
fn laps_are_found_whatever_the_drift_and_the_spacing() {
    for (step, drift) in [
        (0.122, [0.0, 0.0]),
        (0.5, [0.03, -0.02]),
        (0.2, [-0.05, 0.01]),
    ] {
        let trace = rounds(3.4, step, drift);
        let laps = trace.laps(&LapsConfig::default()).unwrap();
        assert_eq!(laps.starts_m.len(), 4, "{laps:?}");
        // A drifting trace is longer or shorter than the way, but each lap by as much.
        let off = |(lap, start): (usize, &f64)| (start - laps.length_m * lap as f64).abs();
        assert!(
            laps.starts_m
                .iter()
                .enumerate()
                .map(off)
                .all(|off| off < 0.3),
            "{laps:?}"
        );
        assert!((laps.length_m - 34.0).abs() < 0.8, "{laps:?}");
    }
}

#[test]
fn drift_is_taken_out_and_laps_lie_on_each_other() {
    let trace = rounds(3.4, 0.25, [0.03, -0.02]);
    let corrected = trace.without_drift(&trace.laps(&LapsConfig::default()).unwrap());
    let truth = rounds(3.4, 0.25, [0.0, 0.0]).points;
    let worst = |a: &[[f64; 2]]| {
        a.iter()
            .zip(&truth)
            .map(|(a, b)| apart(*a, *b))
            .fold(0.0, f64::max)
    };
    assert!(worst(&trace.points) > 4.0);
    assert!(worst(&corrected) < 0.3, "{}", worst(&corrected));
}

#[test]
fn laps_told_by_hand_are_kept_and_what_comes_before_them_drifts_as_the_first() {
    let trace = rounds(2.6, 0.25, [0.02, 0.0]);
    let laps = trace.laps_at(&[20, 20 + 136]);
    assert_eq!(trace.first_points(&laps), [20, 156]);
    let corrected = trace.without_drift(&laps);
    assert!(apart(corrected[156], corrected[20]) < 0.05);
    assert!(apart(corrected[136], corrected[0]) < 0.3);
}

#[test]
fn a_way_that_is_no_round_has_no_laps() {
    let line = Trace::new((0..400).map(|k| [0.25 * f64::from(k), 0.0]).collect());
    let spiral = (0..900).map(|k| f64::from(k) * 0.05);
    let spiral = Trace::new(spiral.map(|t| [t * t.cos(), t * t.sin()]).collect());
    let result = Trace::new(vec![[1.0, 2.0]; 50]);
    for trace in [rounds(1.2, 0.25, [0.0, 0.0]), line, spiral, result] {
        let error = trace.laps(&LapsConfig::default()).unwrap_err().to_string();
        assert!(
            error.contains("split") && error.contains("first_run"),
            "{error}"
        );
    }
}

#[test]
fn constants_that_make_no_sense_are_named() {
    for (config, key) in [
        ("shortest_m = 0.0", "laps.shortest_m"),
        ("likeness = nan", "laps.likeness"),
        ("starts_s = [3.0]", "laps.starts_s"),
        ("starts_s = [3.0, 2.0]", "laps.starts_s"),
        ("starts_s = [3.0, nan]", "laps.starts_s"),
    ] {
        let config: LapsConfig = toml::from_str(config).unwrap();
        let error = config.check().unwrap_err();
        assert!(
            error.is_usage() && error.to_string().starts_with(key),
            "{error}"
        );
    }
}
