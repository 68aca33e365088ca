use super::*;

fn record(config: &Ruizmayor2006Config) -> Ruizmayor2006Record {
    let folder = tempfile::tempdir().unwrap();
    Paper::Ruizmayor2006.unpack(folder.path()).unwrap();
    run(config, folder.path(), &mut |_, _, _| ()).unwrap()
}

#[test]
fn a_correction_makes_most_priors_better_and_worse_readings_fewer() {
    let config = Ruizmayor2006Config {
        heading_steps_deg: vec![10.0, 40.0],
        range_noise_m: vec![0.0, 0.4],
        longest_readings_m: vec![40.0],
        pilasters_every_m: vec![2.0],
        ..Ruizmayor2006Config::default().toy()
    };
    let made = record(&config);
    let [printed, coarse, noisy, far, structured] = &made.experiments[..] else {
        panic!("{}", made.experiments.len());
    };
    // 49 positions within 0.4 m of the centre, nine headings (R06 4.1); one estimate a snapshot (4.2).
    assert_eq!((printed.poses, coarse.poses), (49 * 9, 49 * 3));
    let n: Vec<usize> = printed.figures.iter().map(|figures| figures.n).collect();
    assert_eq!(n, [141, 18, 62, 61]);
    assert_eq!(printed.together.overall.n, 3 * 141);
    let all = |experiment: &ExperimentRecord| experiment.figures[0].clone();
    assert!(all(printed).not_worse[0].mean > 0.7, "{:?}", all(printed));
    assert!(all(printed).not_worse[1].mean > 0.8);
    assert!(all(noisy).not_worse[0].mean < all(printed).not_worse[0].mean);
    // A bare corridor tells how far along it he is to nobody, however far he sees; one with pilasters does.
    let corridor = |experiment: &ExperimentRecord| experiment.figures[3].not_worse[0].mean;
    assert!((corridor(far) - corridor(printed)).abs() < 0.1);
    assert!(corridor(structured) > corridor(printed) + 0.1);
    assert!(all(coarse).p95_deg.mean > all(printed).p95_deg.mean);
    // Priors reach what they may, and no farther.
    let prior = &printed.together.overall.prior;
    assert!(prior.position_m.percentiles.p100 <= 0.5 && prior.position_m.percentiles.p100 > 0.4);
    assert!(
        prior.heading_deg.percentiles.p100 <= 45.0 && prior.heading_deg.percentiles.p100 > 38.0
    );
    assert_eq!(made, record(&config));
}

#[test]
fn what_makes_no_sense_is_named() {
    let faults = [
        (
            Ruizmayor2006Config {
                repetitions: 0,
                ..Default::default()
            },
            "repetitions",
        ),
        (
            Ruizmayor2006Config {
                noise_m: -1.0,
                ..Default::default()
            },
            "noise_m",
        ),
        (
            Ruizmayor2006Config {
                heading_steps_deg: Vec::new(),
                ..Default::default()
            },
            "heading_steps_deg",
        ),
        (
            Ruizmayor2006Config {
                position_step_m: 0.0,
                ..Default::default()
            },
            "position_step_m",
        ),
        (
            Ruizmayor2006Config {
                longest_readings_m: vec![0.0],
                ..Default::default()
            },
            "longest_readings_m",
        ),
        (
            Ruizmayor2006Config {
                range_noise_m: vec![f64::NAN],
                ..Default::default()
            },
            "range_noise_m",
        ),
    ];
    for (config, key) in faults {
        let fault = run(&config, Path::new(""), &mut |_, _, _| ()).unwrap_err();
        assert!(
            fault.is_usage() && fault.to_string().contains(key),
            "{fault}"
        );
    }
}
