//! `ballmark localise`, `features` and `demo` on the real binary.

use super::support::Workplace;
use std::path::Path;

fn shipped(path: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join(path)
        .to_str()
        .unwrap()
        .to_string()
}

/// A model of the shipped dataset, of which a quarter is kept for testing.
fn trained(place: &Workplace) {
    let data = shipped("datasets/corridor-small.npz");
    let arguments = [
        "train",
        &data,
        "-o",
        "m.safetensors",
        "--steps",
        "20",
        "--test-fold",
        "3",
        "--features",
        "2",
    ];
    place.ballmark(&arguments).done();
}

#[test]
fn a_snapshot_may_be_looked_at_again_from_beside() {
    let place = Workplace::new();
    trained(&place);
    let data = shipped("datasets/corridor-small.npz");
    let errors = |views: usize| {
        place.write(
            "c.toml",
            format!("[localise]\ntrials = 2\nquery_views = {views}\n"),
        );
        let arguments = ["localise", "m.safetensors", &data, "--config", "c.toml"];
        let answer = place.ballmark(&[&arguments[..], &["--json"]].concat());
        if views > 64 {
            answer.refused(2, &["localise.query_views", "at most 64"]);
            return Default::default();
        }
        let result: serde_json::Value = serde_json::from_str(&answer.done().stdout).unwrap();
        result["systems"]
            .as_array()
            .expect("systems")
            .iter()
            .map(|m| (m["name"].to_string(), m["error_by_distance"].to_string()))
            .collect::<std::collections::BTreeMap<String, String>>()
    };
    let (once, again) = (errors(0), errors(2));
    let differ = |name: &str| once[name] != again[name];
    assert!(differ("\"learned\"") && !differ("\"kernel\""), "{once:?}");
    errors(65);
}

#[test]
fn every_contender_is_in_the_table_and_in_the_json() {
    let place = Workplace::new();
    trained(&place);
    let data = shipped("datasets/corridor-small.npz");
    let table = place.ballmark(&["localise", "m.safetensors", &data, "--trials", "4"]);
    for title in [
        "2 learned features",
        "2 learned features + map",
        "2 learned features + beams",
        "occupancy map",
        "raw-scan kernel",
        "kernel, 24 views",
        "2 random bits",
        "64 random bits",
        "odometry alone",
    ] {
        assert!(
            table.done().stdout.contains(title),
            "{title}: {}",
            table.stdout
        );
    }
    assert!(
        table.stdout.lines().all(|line| line.chars().count() <= 100),
        "{}",
        table.stdout
    );
    for words in ["* over fewer than 10 trials", "the robot is found"] {
        assert!(table.stdout.contains(words), "{words}: {}", table.stdout);
    }
    let json = place.ballmark(&[
        "localise",
        "m.safetensors",
        &data,
        "--trials",
        "4",
        "--json",
        "--out",
        "report",
    ]);
    let result: serde_json::Value = serde_json::from_str(&json.done().stdout).unwrap();
    let keys = [
        "converged_fraction",
        "distance_to_converge_m",
        "converged_fraction_ci95",
        "mean_error_below_1m_at_m",
        "error_by_distance",
        "error_at_10m_m",
        "error_at_10m_m_ci95",
        "tracked_error_m",
        "tracked_error_m_ci95",
        "recall_1m",
        "recall_1m_ci95",
        "recall_05m",
        "robot_bytes",
        "evidence_scale",
        "tracking",
        "success_at_end",
        "heading_within_5deg",
        "heading_within_5deg_ci95",
        "coverage",
        "risk_coverage",
        "risk_coverage_area_m",
        "risk_coverage_area_m_ci95",
        "point_error_at_10m_m",
        "point_error_at_10m_m_ci95",
        "tracked_point_error_m",
        "tracked_point_error_m_ci95",
        "recall_snapshots",
        "units",
    ];
    let systems = result["systems"].as_array().unwrap();
    let named = |name: &str| {
        let mut found = systems.iter().filter(|system| system["name"] == name);
        found.next().unwrap_or_else(|| panic!("no system {name}"))
    };
    let names = [
        "learned",
        "learned_bits",
        "learned+likelihood_field",
        "likelihood_field",
        "kernel",
        "kernel_views",
        "random_bits",
        "random_bits_64",
        "odometry",
    ];
    for contender in names.map(named).into_iter().chain([&result]) {
        for key in keys {
            assert!(
                contender.get(key).is_some(),
                "{key} is missing in {contender}"
            );
        }
        let rows = |key: &str| contender[key].as_array().unwrap().clone();
        let levels = |key: &str, of: &str| -> Vec<f64> {
            rows(key)
                .iter()
                .map(|row| row[of].as_f64().unwrap())
                .collect()
        };
        assert_eq!(levels("success_at_end", "within_m"), [0.2, 0.3, 0.5, 1.0]);
        assert_eq!(levels("coverage", "level"), [0.5, 0.9, 0.95, 0.99]);
        for key in ["success_at_end", "coverage"] {
            let shares = levels(key, "share");
            assert!(shares.is_sorted(), "{key}: {shares:?}");
            assert!(0.0 <= shares[0] && shares[shares.len() - 1] <= 1.0);
        }
        let left = levels("risk_coverage", "trials");
        assert_eq!(left, [4.0, 4.0, 4.0, 3.0, 3.0, 2.0, 2.0, 2.0, 1.0, 1.0]);
        // Nothing rejected: the same trials as those of success within 1 m.
        let success = levels("success_at_end", "share")[3];
        assert!((levels("risk_coverage", "within_1m")[0] - success).abs() < 1e-12);
        assert!(contender["heading_within_5deg"].is_null()); // along a route
        assert!(rows("success_at_end")[0]["share_within_5deg"].is_null());
        let risk = rows("risk_coverage");
        let error_m = risk[0]["point_error_m"].as_f64().unwrap();
        let ends = &risk[0]["point_error_m_ci95"];
        assert!(ends[0].as_f64() <= Some(error_m) && Some(error_m) <= ends[1].as_f64());
        assert_eq!(contender["is_uncertain"], true); // four trials
        let row = &contender["error_by_distance"][1];
        assert_eq!(row["distance_m"], 0.5);
        let (mean, interval) = (row["expected_error_m"].as_f64().unwrap(), &row["ci95_m"]);
        assert!(
            interval[0].as_f64().unwrap() <= mean + 1e-9
                && mean <= interval[1].as_f64().unwrap() + 1e-9,
            "{row}"
        );
    }
    let tests = result["paired_tests"].as_array().unwrap();
    let judged = systems.iter().filter(|system| system["fault"].is_null());
    assert_eq!(tests.len(), judged.count() - 1);
    for test in tests {
        assert_eq!(test["against"], systems[0]["name"]);
        for figure in ["found_difference", "distance_difference_m"] {
            assert!(test[figure].is_number(), "{figure}: {test}");
            assert!(
                test[format!("{figure}_ci95")].is_array(),
                "{figure}: {test}"
            );
        }
        assert_eq!(test["trials"], 4);
        // Four trials are too few.
        for key in ["p", "p_holm", "p_found", "p_found_holm", "p_distance_holm"] {
            assert_eq!(
                test.get(key),
                Some(&serde_json::Value::Null),
                "{key}: {test}"
            );
        }
    }
    for name in names {
        let step_ms = result["timing"]["step_ms"][name].as_f64();
        assert!(step_ms.is_some_and(|ms| ms > 0.0), "{name}: {step_ms:?}");
    }
    // 24 sonars, one reading each: a float a reading, in 25 views; bits; no map.
    for (contender, bytes) in [
        (&result, serde_json::json!(8)),
        (named("learned_bits"), serde_json::json!(1)),
        (named("likelihood_field"), serde_json::Value::Null),
        (named("learned+likelihood_field"), serde_json::json!(8)),
        (named("kernel"), serde_json::json!(96)),
        (named("kernel_views"), serde_json::json!(2400)),
        (named("random_bits"), serde_json::json!(1)),
        (named("random_bits_64"), serde_json::json!(8)),
        (named("odometry"), serde_json::Value::Null),
    ] {
        assert_eq!(contender["bytes_per_place"], bytes);
    }
    // Both together hold what each of them holds, but for the places, which the map needs along a route as poses.
    let number = |name: &str, key: &str| named(name)[key].as_f64().unwrap();
    let (learned, map) = (
        number("learned", "robot_bytes"),
        number("likelihood_field", "robot_bytes"),
    );
    assert_eq!(
        number("learned+likelihood_field", "robot_bytes"),
        learned + map
    );
    assert!(number("learned_bits", "robot_bytes") < learned);
    for name in ["learned", "likelihood_field", "kernel", "signal_field"] {
        let (near, far) = (number(name, "recall_05m"), number(name, "recall_1m"));
        assert!(
            0.0 <= near && near <= far && far <= 1.0,
            "{name}: {near} {far}"
        );
        let interval = &named(name)["recall_1m_ci95"];
        let end = |i: usize| interval[i].as_f64().unwrap();
        assert!(end(0) <= far && far <= end(1), "{name}: {interval} {far}");
        assert!(number(name, "evidence_scale") > 0.0);
    }
    // A field of the readings tells places of a corridor with doors apart, and far better than a handful of random bits.
    assert!(number("signal_field", "recall_1m") > number("random_bits", "recall_1m"));
    for key in ["recall_1m", "evidence_scale", "robot_bytes"] {
        assert!(named("odometry")[key].is_null(), "{key}");
    }
    let files = [
        "config-2m.json",
        "error_by_distance.csv",
        "error_by_distance.svg",
        "localisation.csv",
        "paired.csv",
        "risk_coverage.csv",
        "risk_coverage.svg",
        "tracking_error.svg",
    ];
    for file in files {
        assert!(
            place.path("report").join(file).metadata().unwrap().len() > 100,
            "{file}"
        );
    }
}

#[test]
fn the_same_call_gives_the_same_bytes_for_any_number_of_threads() {
    let place = Workplace::new();
    trained(&place);
    let data = shipped("datasets/corridor-small.npz");
    let arguments = [
        "localise",
        "m.safetensors",
        &data,
        "--trials",
        "4",
        "--evidence",
        "sampled",
        "--json",
    ];
    let with_threads = |threads: &str| {
        let mut call = std::process::Command::new(super::support::binary());
        call.args(arguments)
            .current_dir(place.path(""))
            .env("RAYON_NUM_THREADS", threads);
        let mut result: serde_json::Value =
            serde_json::from_str(&super::support::answer(&mut call).done().stdout).unwrap();
        result["timing"] = serde_json::Value::Null;
        result.to_string()
    };
    assert_eq!(with_threads("1"), with_threads("3"));
}

#[test]
fn a_part_that_training_saw_is_no_trial() {
    let place = Workplace::new();
    let data = shipped("datasets/corridor-small.npz");
    place.write("all.toml", "[train.split]\nvalidation_every = 0\n");
    place
        .ballmark(&[
            "train",
            &data,
            "-o",
            "m.safetensors",
            "--steps",
            "2",
            "--config",
            "all.toml",
        ])
        .done();
    place
        .ballmark(&["localise", "m.safetensors", &data])
        .refused(1, &["corridor-small.npz", "saw every snapshot"]);
}

#[test]
fn another_recording_is_all_unseen_and_baselines_need_what_it_learned_from() {
    let place = Workplace::new();
    let (model, data) = (
        shipped("models/corridor-2m.safetensors"),
        shipped("datasets/corridor-small.npz"),
    );
    let alone = place.ballmark(&["localise", &model, &data, "--trials", "3"]);
    assert!(
        alone.done().stderr.contains("--trained-on") && !alone.stdout.contains("kernel"),
        "{}",
        alone.stderr
    );
    let wrong = place.ballmark(&[
        "localise",
        &model,
        &data,
        "--trained-on",
        &data,
        "--trials",
        "3",
    ]);
    wrong.refused(1, &["--trained-on names another dataset"]);
}

#[test]
fn other_sensors_than_the_model_has_are_refused_by_name() {
    let place = Workplace::new();
    let csv: String = (0..40)
        .map(|k| format!("{k},{},0,0,{}\n", f64::from(k) * 0.5, k % 7))
        .collect();
    place.write(
        "light.csv",
        format!("time_s,x_m,y_m,heading_rad,light\n{csv}"),
    );
    place
        .ballmark(&["import", "light.csv", "-o", "light.npz"])
        .done();
    let model = shipped("models/corridor-2m.safetensors");
    place
        .ballmark(&["features", &model, "light.npz", "-o", "f.csv"])
        .refused(1, &["light.npz", "no channel `sonar`", "light"]);
    let answer = place.ballmark(&["localise", &model, "light.npz"]);
    answer.refused(1, &["light.npz", "along a route"]);
    assert_eq!(place.files(), ["light.csv", "light.npz"]);
}

#[test]
fn features_are_one_row_a_snapshot_between_0_and_1() {
    let place = Workplace::new();
    let (model, data) = (
        shipped("models/corridor-2m.safetensors"),
        shipped("datasets/corridor-small.npz"),
    );
    place
        .ballmark(&["features", &model, &data, "-o", "f.csv"])
        .done();
    let text = std::fs::read_to_string(place.path("f.csv")).unwrap();
    let mut lines = text.lines();
    assert_eq!(
        lines.next().unwrap(),
        "index,x_m,y_m,heading_rad,f1,f2,f3,f4"
    );
    let mut rows = 0;
    for (k, line) in lines.enumerate() {
        let numbers: Vec<f64> = line.split(',').map(|n| n.parse().unwrap()).collect();
        assert_eq!((numbers[0], numbers.len()), (k as f64, 8));
        assert!(
            numbers[4..].iter().all(|f| (0.0..=1.0).contains(f)),
            "{line}"
        );
        rows += 1;
    }
    assert!(rows > 500);
    assert!(
        std::fs::read_to_string(place.path("f.svg"))
            .unwrap()
            .starts_with("<svg")
    );
}

#[test]
fn of_a_wide_code_the_table_has_every_feature_and_the_plot_the_first_eight() {
    let place = Workplace::new();
    let data = shipped("datasets/corridor-small.npz");
    let train = [
        "train",
        &data,
        "-o",
        "m.safetensors",
        "--features",
        "11",
        "--steps",
        "3",
    ];
    place.ballmark(&train).done();
    let answer = place.ballmark(&["features", "m.safetensors", &data, "-o", "f.csv"]);
    assert!(answer.done().stdout.contains("plots: the first 8 features"));
    let read = |name| std::fs::read_to_string(place.path(name)).unwrap();
    assert!(read("f.csv").lines().next().unwrap().ends_with(",f10,f11"));
    let plot = read("f.svg");
    assert!(plot.contains("P(f8 = 1)") && !plot.contains("P(f9 = 1)"));
}

#[test]
fn the_demo_goes_all_the_way() {
    let place = Workplace::new();
    let answer = place.ballmark(&["demo", "--toy", "--out", "here"]);
    let lines: Vec<&str> = answer
        .done()
        .stdout
        .lines()
        .filter(|l| l.starts_with("4 learned, ") && !l.contains(" against "))
        .collect();
    // Of each prior: alone, with the map, its beam model and the field of the readings; alone and with the map once more among
    // people.
    assert_eq!(lines.len(), 8 + 4, "{}", answer.stdout);
    assert!(
        answer.stdout.contains("people before 30 % of the beams"),
        "{}",
        answer.stdout
    );
    for file in [
        "corridor.npz",
        "corridor-2m.safetensors",
        "features-global.svg",
        "error_by_distance.csv",
        "localisation_among_people.csv",
    ] {
        assert!(place.path("here").join(file).exists(), "{file}");
    }
    let html = super::page::stands_alone(
        &place.path("here/index.html"),
        &[
            "demo --toy --out here",
            "With people in the way",
            "What filters trained for ±2 m answer",
            "data:image/png",
        ],
    );
    // The systems of the table, in its order: one colour a system.
    let titles = super::page::played(&html)["traces"]["systems"].clone();
    let titles = titles
        .as_array()
        .unwrap()
        .iter()
        .map(|system| system[1].as_str().unwrap());
    let rows = answer
        .stdout
        .lines()
        .skip_while(|line| !line.starts_with("---"))
        .skip(1);
    for (title, row) in titles.zip(rows) {
        assert!(row.starts_with(title), "{title}: {row}");
    }
    // What `localise --people` plays; what was learned is tuned as it was.
    let played = [
        "localise",
        "here/corridor-2m.safetensors",
        "here/corridor-global.safetensors",
        "here/corridor.npz",
        "--trials",
        "8",
        "--people",
        "0.3",
    ];
    let played = place.ballmark(&played);
    let among_people = answer.stdout.split("people in the way").nth(1).unwrap();
    let words = |text: &str| -> Vec<String> {
        let mut maps = text.lines().filter(|l| l.starts_with("occupancy map"));
        let row = maps.next().unwrap().split_whitespace();
        row.map(String::from).collect()
    };
    assert_eq!(words(&played.done().stdout), words(among_people));
    place.write("file", "");
    place
        .ballmark(&["demo", "--toy", "--out", "file/here"])
        .refused(1, &["file/here", "cannot make the folder"]);
}

/// Runs of 30 m on a straight line, a light that tells places apart, one run a direction if asked.
fn corridor_csv(both_ways: bool, odometry: bool) -> String {
    let mut text = String::from("time_s,x_m,y_m,heading_rad,route_m,run,light.0,light.1");
    text += if odometry {
        ",odometry_x_m,odometry_y_m,odometry_heading_rad\n"
    } else {
        "\n"
    };
    for run in 0..8 {
        for k in 0..60 {
            let back = both_ways && run % 2 == 1;
            let way = f64::from(k) * 0.5;
            let x = if back { 30.0 - way } else { way } + 0.001 * f64::from(run);
            let heading = if back { std::f64::consts::PI } else { 0.0 };
            let (a, b) = ((x * 0.4).sin(), (x * 0.13).cos());
            text += &format!("{},{x},0,{heading},{x},{run},{a},{b}", run * 60 + k);
            text += &if odometry {
                format!(",{},0,0\n", way * 1.01)
            } else {
                "\n".to_string()
            };
        }
    }
    text
}

/// A few steps of training on a dataset of the place, a quarter of it kept for testing: `m.safetensors`.
fn learned(place: &Workplace, dataset: &str) {
    let call = format!("train {dataset} -o m.safetensors --steps 5 --test-fold 3");
    place.ballmark(&call.split(' ').collect::<Vec<_>>()).done();
}

#[test]
fn a_route_that_is_driven_both_ways_is_taken_by_its_poses() {
    let place = Workplace::new();
    place.write("both.csv", corridor_csv(true, true));
    place
        .ballmark(&["import", "both.csv", "-o", "both.npz"])
        .done();
    let call = "train both.npz -o m.safetensors --steps 5 --test-fold 3";
    let answer = place.ballmark(&call.split(' ').collect::<Vec<_>>());
    let note = "note: the array `route` is driven both ways";
    assert!(answer.done().stderr.contains(note), "{}", answer.stderr);
    let trials = ["localise", "m.safetensors", "both.npz", "--trials", "2"];
    place.ballmark(&trials).done();
}

/// Filters that know a route as a line can't be asked about the way back.
#[test]
fn the_way_back_along_a_known_route_is_refused() {
    let place = Workplace::new();
    for (name, both_ways) in [("there", false), ("both", true)] {
        place.write(&format!("{name}.csv"), corridor_csv(both_ways, true));
        let (log, dataset) = (format!("{name}.csv"), format!("{name}.npz"));
        place.ballmark(&["import", &log, "-o", &dataset]).done();
    }
    learned(&place, "there.npz");
    place
        .ballmark(&["localise", "m.safetensors", "both.npz"])
        .refused(1, &["both.npz", "`route`", "backwards"]);
}

/// A laser in a hall so wide that no wall is within the map's reach: there is no map, and everybody else plays.
#[test]
fn a_rival_that_cannot_be_made_is_a_named_failure_in_its_row() {
    let place = Workplace::new();
    let mut log = String::new();
    for run in 0..4 {
        for k in 0..30 {
            let x = f64::from(k) * 0.5 + 0.001 * f64::from(run);
            let range = |beam: i32| 55.0 + 8.0 * (x * 0.4 + f64::from(beam)).sin();
            let ranges: Vec<String> = (0..8).map(|beam| format!("{:.2}", range(beam))).collect();
            let (ranges, time) = (ranges.join(" "), 1000 * run + k);
            log += &format!("FLASER 8 {ranges} {x} 0 0 {x} 0 0 {time} robot {time}\n");
        }
    }
    place.write("hall.log", log);
    let mut import = vec!["import", "hall.log", "-o", "hall.npz"];
    import.extend(["--max-range", "80"]);
    place.ballmark(&import).done();
    learned(&place, "hall.npz");
    let call = ["localise", "m.safetensors", "hall.npz", "--trials", "2"];
    let table = place.ballmark(&call);
    let told = "occupancy map: left out: occupancy map: no cell is occupied";
    assert!(table.done().stdout.contains(told), "{}", table.stdout);
    assert!(table.stdout.contains("\nsignal field "), "{}", table.stdout);
    let json = place.ballmark(&[&call[..], &["--json"]].concat());
    let result: serde_json::Value = serde_json::from_str(&json.done().stdout).unwrap();
    let mut systems = result["systems"].as_array().unwrap().iter();
    let map = systems.find(|system| system["name"] == "likelihood_field");
    let fault = map.unwrap()["fault"].as_str().unwrap();
    assert!(fault.contains("no cell is occupied"), "{fault}");
}

#[test]
fn a_recording_counts_by_its_content() {
    let place = Workplace::new();
    let walk = corridor_csv(false, true);
    place.write("walk.csv", walk.clone());
    place.write("again.csv", walk.clone() + "\n");
    // The same places, other lights: what the model has learned is among them.
    let header_end = walk.find('\n').unwrap() + 1;
    let other = walk[header_end..].replace(",0.9", ",0.1");
    place.write("other.csv", walk[..header_end].to_string() + &other);
    for name in ["walk", "again", "other"] {
        let (log, dataset) = (format!("{name}.csv"), format!("{name}.npz"));
        place.ballmark(&["import", &log, "-o", &dataset]).done();
    }
    learned(&place, "walk.npz");
    let table = |dataset: &str| {
        let answer = place.ballmark(&["localise", "m.safetensors", dataset, "--trials", "4"]);
        assert!(!answer.done().stderr.contains("repeats its poses"));
        let lines = answer.stdout.lines().map(String::from);
        let has_seconds = |line: &String| line.starts_with("belief over");
        lines.filter(|line| !has_seconds(line)).collect::<Vec<_>>()
    };
    assert_eq!(table("again.npz"), table("walk.npz"));
    place
        .ballmark(&["localise", "m.safetensors", "other.npz"])
        .refused(1, &["other.npz", "the model has learned"]);
}

/// Filters for two priors in one table: the same trials, the baselines once.
#[test]
fn several_models_stand_in_one_table() {
    let place = Workplace::new();
    place.write("walk.csv", corridor_csv(false, true));
    place
        .ballmark(&["import", "walk.csv", "-o", "walk.npz"])
        .done();
    for (name, uncertainty, fold) in [("a", "2m", "3"), ("b", "global", "3"), ("c", "2m", "2")] {
        let model = format!("{name}.safetensors");
        let call = format!(
            "train walk.npz -o {model} --steps 5 --features 2 --test-fold {fold} --uncertainty {uncertainty}"
        );
        place.ballmark(&call.split(' ').collect::<Vec<_>>()).done();
    }
    let json = |models: &[&str]| -> serde_json::Value {
        let mut call = vec!["localise"];
        call.extend(models);
        call.extend(["walk.npz", "--trials", "4", "--json"]);
        serde_json::from_str(&place.ballmark(&call).done().stdout).unwrap()
    };
    let (alone, both) = (
        json(&["a.safetensors"]),
        json(&["a.safetensors", "b.safetensors"]),
    );
    let tracking = |all: &serde_json::Value, name: &str| {
        let mut systems = all["systems"].as_array().unwrap().iter();
        let found = systems.find(|system| system["name"] == name);
        found.unwrap_or_else(|| panic!("no system {name}"))["tracking"].clone()
    };
    for (one, of_both) in [
        ("learned", "learned_2m"),
        ("learned_bits", "learned_bits_2m"),
        ("random_bits", "random_bits"),
    ] {
        assert_eq!(tracking(&alone, one), tracking(&both, of_both), "{one}");
    }
    assert_eq!(alone["tracking"], tracking(&both, "learned_2m"));
    assert!(tracking(&both, "learned_global")["converged_fraction"].is_number());
    place
        .ballmark(&["localise", "a.safetensors", "c.safetensors", "walk.npz"])
        .refused(1, &["different places", "train.split"]);
}

#[test]
fn odometry_that_repeats_the_truth_is_noted() {
    let place = Workplace::new();
    place.write("walk.csv", corridor_csv(false, false));
    place
        .ballmark(&["import", "walk.csv", "-o", "walk.npz"])
        .done();
    learned(&place, "walk.npz");
    let answer = place.ballmark(&["localise", "m.safetensors", "walk.npz", "--trials", "4"]);
    assert!(
        answer.done().stderr.contains("odometry repeats its poses"),
        "{}",
        answer.stderr
    );
}

#[test]
fn a_table_is_not_written_over_by_its_own_plot() {
    let place = Workplace::new();
    let (model, data) = (
        shipped("models/corridor-2m.safetensors"),
        shipped("datasets/corridor-small.npz"),
    );
    place
        .ballmark(&["features", &model, &data, "-o", "f.svg"])
        .refused(2, &["f.svg", ".csv"]);
    assert!(place.files().is_empty());
}

#[test]
fn endless_settings_are_refused() {
    let place = Workplace::new();
    let (model, data) = (
        shipped("models/corridor-2m.safetensors"),
        shipped("datasets/corridor-small.npz"),
    );
    for (key, value) in [
        ("spacing_m", "1e-9"),
        ("spacing_m", "100.0"),
        ("trials", "1000000000"),
        ("shortest_m", "-1.0"),
    ] {
        place.write("c.toml", format!("[localise]\n{key} = {value}\n"));
        place
            .ballmark(&["localise", &model, &data, "--config", "c.toml"])
            .refused(2, &["localise.", "expected"]);
    }
}
