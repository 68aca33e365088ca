//! What corrections are worth apart from predictions, and noise put on what is tested on, on the real binary.

use super::support::Workplace;
use serde_json::Value;
use std::path::Path;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Three runs of Ruiz-Mayor et al. (2006), each driven twice; the first maps.
fn comparison(noise: &str) -> String {
    let worlds = root().join("configs/worlds");
    let dataset = |run: &str| {
        let world = worlds.join(format!("ruizmayor2006-{run}.toml"));
        format!("[[dataset]]\nworld = '{}'\nruns = 2\n", world.display())
    };
    format!(
        "{}{}[[system]]\nname = 'local search'\nkind = 'local_grid'\n[[system]]\nkind = 'dead_reckoning'\n[protocol]\n\
         mapping = 'first_run'\n[localisation]\ntrials = 6\nresamples = 50\n{noise}",
        dataset("r1"),
        dataset("r3")
    )
}

fn compared(place: &Workplace, noise: &str) -> Value {
    place.write("c.toml", comparison(noise));
    let answer = place.ballmark(&["compare", "c.toml", "--json"]);
    serde_json::from_str(&answer.done().stdout).unwrap()
}

/// The figures of a system on the `dataset`-th run, from a known start.
fn correction(all: &Value, system: usize, dataset: usize) -> Value {
    let record = &all["localisation"]["records"][dataset]["done"];
    record["results"][system]["correction"].clone()
}

#[test]
fn a_local_search_corrects_what_noise_makes_of_its_priors() {
    let place = Workplace::new();
    let noise = "[degraded.noise]\nodometry_m = 0.4\nodometry_deg = 40\n";
    let (clean, noisy) = (compared(&place, ""), compared(&place, noise));
    let mean = |all: &Value, system: usize, which: &str| {
        let of = correction(all, system, 0);
        of[which]["position_m"]["mean"].as_f64().unwrap()
    };
    // Noise makes worse priors, which the search corrects; reckoning has nothing to correct by.
    assert!(mean(&noisy, 0, "prior") > 2.0 * mean(&clean, 0, "prior"));
    assert!(mean(&noisy, 0, "posterior") < 0.6 * mean(&noisy, 0, "prior"));
    let search = correction(&noisy, 0, 0);
    let c_xy = &search["correction"]["position"];
    assert!(c_xy["better"].as_f64().unwrap() > 0.7, "{c_xy}");
    assert_eq!(search["has_headings"], true);
    assert!(search["position_gain_m"].as_f64().unwrap() < 0.0);
    let reckoning = correction(&noisy, 1, 0);
    let position = &reckoning["correction"]["position"];
    assert_eq!(
        (&position["not_worse"], &position["better"]),
        (&1.0.into(), &0.0.into())
    );
    assert_eq!(position["unchanged"], reckoning["n"]);
    let notes = noisy["datasets"][0]["notes"].to_string();
    assert!(
        notes.contains("odometry off by up to 0.4 m and 40° every 0.5 m"),
        "{notes}"
    );
}

#[test]
fn the_table_and_its_file_have_a_row_each() {
    let place = Workplace::new();
    place.write("c.toml", comparison(""));
    let answer = place.ballmark(&["compare", "c.toml", "--out", "out"]);
    let said = &answer.done().stdout;
    for part in [
        "Prediction and correction",
        "C_XYT",
        "prior = the last answer moved",
    ] {
        assert!(said.contains(part), "{part} in\n{said}");
    }
    let wide = said.lines().find(|line| line.chars().count() > 100);
    assert_eq!(wide, None);
    let file = place.path("out/correction-figures-ruizmayor2006-r3.csv");
    let csv = std::fs::read_to_string(&file).unwrap();
    assert!(
        csv.contains("\nlocal search,") && csv.contains(",c_xyt_not_worse,"),
        "{csv}"
    );
}

#[test]
fn along_a_route_there_are_no_headings() {
    let place = Workplace::new();
    let data = root().join("datasets/corridor-small.npz");
    let data = data.to_str().unwrap();
    let model = [
        "train",
        data,
        "-o",
        "m.safetensors",
        "--steps",
        "20",
        "--test-fold",
        "3",
    ];
    place
        .ballmark(&[&model[..], &["--features", "2"]].concat())
        .done();
    let call = ["localise", "m.safetensors", data, "--trials", "4"];
    let text = place.ballmark(&call).done().stdout.clone();
    assert!(text.contains("from a known start"), "{text}");
    place.write(
        "noise.toml",
        "[degraded.noise]\nodometry_m = 0.4\nrange_m = 0.1",
    );
    let json = |more: &[&str]| -> Value {
        let answer = place.ballmark(&[&call[..], &["--json"], more].concat());
        serde_json::from_str(&answer.done().stdout).unwrap()
    };
    let (clean, noisy) = (json(&[]), json(&["--config", "noise.toml"]));
    let odometry = |all: &Value| {
        let systems = all["systems"].as_array().unwrap();
        let own = systems.iter().find(|s| s["name"] == "odometry").unwrap();
        own["correction"].clone()
    };
    assert_eq!(odometry(&clean)["has_headings"], false);
    let error_m = |all: &Value| {
        odometry(all)["posterior"]["position_m"]["mean"]
            .as_f64()
            .unwrap()
    };
    assert!(
        error_m(&noisy) > 1.5 * error_m(&clean),
        "{} {}",
        error_m(&noisy),
        error_m(&clean)
    );
    assert_eq!(clean["noise"], Value::Null);
    assert_eq!(noisy["noise"]["odometry_m"], 0.4);
    for part in ["prediction_ms", "correction_ms"] {
        assert!(clean["timing"][part]["learned"].as_f64().unwrap() >= 0.0);
    }
}

#[test]
fn what_makes_no_sense_is_refused() {
    let place = Workplace::new();
    let refused = |noise: &str, parts: &[&str]| {
        place.write("c.toml", comparison(noise));
        place.ballmark(&["compare", "c.toml"]).refused(2, parts);
    };
    refused(
        "[degraded.noise]\nodometry_m = -1\n",
        &["c.toml: line", "noise.odometry_m = -1"],
    );
    refused(
        "[degraded.noise]\nevery_m = 0\n",
        &["c.toml: line", "noise.every_m = 0"],
    );
    refused(
        "[degraded.noise]\nodometry = 1\n",
        &["unknown field `odometry`"],
    );
    // Who is given a plan needs a world.
    let data = root().join("datasets/corridor-small.npz");
    let of_file = format!(
        "[[dataset]]\nfile = '{}'\n{}",
        data.display(),
        comparison("")
    );
    place.write("f.toml", of_file);
    place.ballmark(&["compare", "f.toml"]).refused(
        2,
        &["local search", "`world`: none; expected", "corridor-small"],
    );
}
