//! Sensors that no plan predicts, from a table to trials: readings of the last metres as inputs.

use crate::support::Workplace;
use std::fmt::Write;

/// Receivers along a hall that is driven eight times; what they hear comes and goes.
fn table() -> String {
    let mut csv = String::from("time_s,run,x_m,y_m,heading_rad,rssi.0[dBm],rssi.1[dBm]\n");
    for k in 0..8 * 48 {
        let (run, at_m) = (k / 48, 0.25 * f64::from(k % 48));
        let noise = f64::from(k * 7919 % 13) / 6.0 - 1.0;
        let heard = -40.0 - 3.0 * (at_m - 6.0).abs() + noise;
        let faint = match k % 11 {
            0 => String::new(),
            _ => format!("{:.1}", -50.0 - (at_m * 1.3).sin() * 5.0 - noise),
        };
        writeln!(
            csv,
            "{k},{run},{at_m},{},0,{heard:.1},{faint}",
            0.02 * f64::from(run)
        )
        .unwrap();
    }
    csv
}

const CONFIG: &str = "
[train]
features = 8
uncertainty = 'global'
[train.descent]
steps = 60
validate_every = 20
[train.split]
test_fold = 0
[localise]
trials = 6
shortest_m = 4.0
resamples = 10
";

#[test]
fn readings_of_the_last_metres_are_inputs_from_training_to_trials() {
    let place = Workplace::new();
    place.write("hall.csv", table());
    place.write("c.toml", CONFIG);
    place
        .ballmark(&["import", "hall.csv", "-o", "hall.npz"])
        .done();
    let train = |output: &str, more: &[&str]| {
        let arguments = ["train", "hall.npz", "-o", output, "--config", "c.toml"];
        place.ballmark(&[&arguments[..], more].concat())
    };
    let trained = train("m.safetensors", &[]);
    let told = &trained.done().stdout;
    assert!(
        told.contains("inputs: readings of now and of [0.5, 1.0, 2.0] m back"),
        "{told}"
    );
    // Both trainings, without these readings and with them, are the work that is shown.
    assert!(trained.stderr.contains("120 of 120"), "{}", trained.stderr);
    // A training that has ended is known again, whatever it chose.
    let again = train("m.safetensors", &["--resume"]);
    assert!(again.done().stderr.contains("nothing is learned anew"));
    assert!(!place.path("m.safetensors.checkpoint").exists());
    assert!(!place.path("m.safetensors.checkpoint.history").exists());

    let features = ["features", "m.safetensors", "hall.npz", "-o", "f.csv"];
    let features = place.ballmark(&features);
    assert!(features.done().stdout.contains("384 snapshots, 8 features"));
    let localise = |models: &[&str]| {
        let rest = ["hall.npz", "--config", "c.toml"];
        place.ballmark(&[&["localise"], models, &rest].concat())
    };
    let trials = localise(&["m.safetensors"]);
    let told = &trials.done().stdout;
    assert!(told.contains("readings of the last 2 m as well"), "{told}");
    assert!(told.contains("raw-scan kernel") && told.contains("signal field"));

    place.write(
        "plain.toml",
        format!("{CONFIG}[train.input]\nhistory_m = []\n"),
    );
    let plain = [
        "train",
        "hall.npz",
        "-o",
        "p.safetensors",
        "--config",
        "plain.toml",
    ];
    let plain = place.ballmark(&plain);
    assert!(!plain.done().stdout.contains("m back"));
    let both = localise(&["m.safetensors", "p.safetensors"]);
    let told = &both.done().stdout;
    assert!(
        told.contains("8 learned") && told.contains("raw-scan kernel"),
        "{told}"
    );

    // In a comparison a model of a file remembers for itself.
    place.write(
        "compare.toml",
        "[[dataset]]\nfile = 'hall.npz'\n[[system]]\nkind = 'bayes'\nlandmarks = [{ kind = 'learned', model = 'm.safetensors' }]\n\
         [protocol]\nmapping = 'split'\nsplit = { test_fold = 0 }\n\
         [localisation]\ntrials = 4\nshortest_m = 4.0\nresamples = 10\n",
    );
    let compared = place.ballmark(&["compare", "compare.toml", "--out", "c"]);
    assert!(compared.done().stdout.contains("recall %"));

    place.write(
        "bad.toml",
        format!("{CONFIG}[train.input]\nhistory_m = [2.0, 1.0]\n"),
    );
    let bad = place.ballmark(&[
        "train",
        "hall.npz",
        "-o",
        "b.safetensors",
        "--config",
        "bad.toml",
    ]);
    bad.refused(2, &["rising distances in metres"]);
    assert!(!place.path("b.safetensors").exists());
}
