use super::*;

#[test]
fn all_that_is_reported_is_there_at_toy_size_and_the_same_again() {
    let config = Thrun1998Config {
        steps: 12,
        trials: 3,
        doubled: true,
        choice_seeds: 1,
        ..Thrun1998Config::default().toy()
    };
    let mut calls = Vec::new();
    let record = run(&config, &mut |done, all, what| {
        calls.push((done, all, what.to_string()))
    })
    .unwrap();
    assert_eq!(calls.len(), 4 + config.bank_runs + config.choice_seeds);
    assert!(calls.iter().all(|(done, all, _)| done < all));
    let set = &record.sets[0];
    // Doors and the kernel under six priors, one feature for each, two and three for ±2 m, four of them judged under all.
    assert_eq!(set.rows.len(), 6 + 6 + 6 + 2 + 6);
    for row in &set.rows {
        assert_eq!(row.objective.is_none(), row.approach == "kernel");
        let held_out = row.held_out.unwrap();
        assert!(held_out.count == 2 && held_out.mean < 1.0, "{row:?}");
    }
    let local = window(2.0);
    let of = |n| {
        set.row("ball", n, Some(local), local)
            .unwrap()
            .objective
            .unwrap()
    };
    let doors = set.row("door", 1, None, local).unwrap().objective.unwrap();
    assert!(of(4).mean > of(1).mean && of(1).mean > doors.mean);
    assert!((0.0..1.0).contains(&set.correlation.mean));
    // 89 m: a robot without any idea is off by a third of it.
    assert!(
        (set.prior_error_m - 29.67).abs() < 0.5,
        "{}",
        set.prior_error_m
    );
    let outputs: Vec<usize> = set.outputs.iter().map(|output| output.features).collect();
    assert_eq!(outputs, [1, 1, 1, 4]);
    assert!(set.outputs.iter().all(|output| output.route_m.is_sorted()));

    let [doors, ball] = &record.global[..] else {
        panic!("{:?}", record.global);
    };
    assert_eq!(
        (doors.approach.as_str(), ball.approach.as_str()),
        ("door", "ball")
    );
    assert_eq!(ball.error_by_distance.len(), 62);
    assert!(ball.error_at_m(30.0).unwrap() < doors.error_at_m(0.0).unwrap());
    let belief = record.belief.as_ref().unwrap();
    assert_eq!(belief.moments.len(), 9);
    for moment in &belief.moments {
        assert!((moment.mass.iter().sum::<f64>() - 1.0).abs() < 1e-9);
        assert_eq!(moment.mass.len(), belief.route_m.len());
    }
    assert!(belief.moments[8].expected_error_m < belief.moments[0].expected_error_m);
    // Twice the corridor takes longer, if not by how much the bits foretell.
    let readings = record.readings.as_ref().unwrap();
    assert!(readings.readings > 1.0 && readings.predicted_by_error > readings.readings);
    assert!(readings.found_in_doubled.unwrap() > 1.0);
    has_a_bank(record.bank.as_ref().unwrap());
    has_choices(&record.choices);
    assert_eq!(run(&config, &mut |_, _, _| ()).unwrap(), record);
}

fn has_a_bank(bank: &BankRecord) {
    let names: Vec<&str> = bank
        .approaches
        .iter()
        .map(|a| a.approach.as_str())
        .collect();
    let sets = ["1m", "2m", "5m", "10m", "50m", "global"];
    let banks = [
        "bank_by_error",
        "bank_of_2_by_error",
        "bank",
        "bank_of_2",
        "bank_of_3",
        "all_sets",
    ];
    assert_eq!(names, [&sets[..], &banks[..]].concat());
    let shares: Vec<&str> = bank.shares.iter().map(|s| s.approach.as_str()).collect();
    assert_eq!(shares, banks);
    let first = &bank.used[0].share;
    assert!((first.values().sum::<f64>() - 1.0).abs() < 1e-9);
    // Whatever is chosen by least expected error is best after the first reading, where all were asked by the same belief.
    let after_first = |name: &str| {
        let approach = bank.approaches.iter().find(|a| a.approach == name).unwrap();
        approach.error_at_m(0.0).unwrap()
    };
    let least = sets
        .map(after_first)
        .into_iter()
        .fold(f64::INFINITY, f64::min);
    assert!((after_first("bank_by_error") - least).abs() < 0.2 * least);
}

fn has_choices(choices: &[ChoiceRecord]) {
    assert_eq!(choices.len(), 6);
    for choice in choices {
        assert_eq!(choice.seeds, 1);
        let difference = choice.chosen_m.mean - choice.chance_m.mean;
        assert!((choice.less_than_chance_m.mean - difference).abs() < 1e-9);
        // Whoever looks where most is expected knows more than who looks anywhere.
        assert!(
            choice.question != "heading" || difference < -1.0,
            "{choice:?}"
        );
        // A robot that is sure stays sure, wherever it goes.
        assert!(
            choice.question != "action_control" || choice.chosen_m.mean < 1.0,
            "{choice:?}"
        );
    }
}

#[test]
fn what_makes_no_sense_is_named() {
    for (config, key) in [
        (
            Thrun1998Config {
                sets: Vec::new(),
                ..Default::default()
            },
            "sets",
        ),
        (
            Thrun1998Config {
                sets: vec!["d4".into()],
                ..Default::default()
            },
            "sets",
        ),
        (
            Thrun1998Config {
                sets: vec!["d1".into(), "d1".into()],
                ..Default::default()
            },
            "sets",
        ),
        (
            Thrun1998Config {
                runs: 1,
                ..Default::default()
            },
            "runs",
        ),
        (
            Thrun1998Config {
                bank_runs: 1,
                ..Default::default()
            },
            "bank_runs",
        ),
        (
            Thrun1998Config {
                steps: 0,
                ..Default::default()
            },
            "steps",
        ),
    ] {
        let fault = run(&config, &mut |_, _, _| ()).unwrap_err().to_string();
        assert!(fault.contains(key), "{fault}");
    }
}
