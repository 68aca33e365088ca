//! `ballmark score` on good and bad files.

use crate::support::Workplace;
use serde_json::Value;

/// Duckett & Nehmzow 1998, Fig. 3: rows are responses, columns locations.
const FIGURE_3: [[usize; 5]; 5] = [
    [0, 2, 15, 0, 1],
    [10, 10, 0, 0, 0],
    [0, 2, 1, 0, 19],
    [5, 7, 3, 1, 1],
    [0, 0, 0, 23, 0],
];

fn figure_3() -> String {
    let mut csv = String::from("response,location\n");
    for (response, times_at) in FIGURE_3.iter().enumerate() {
        for (location, &times) in times_at.iter().enumerate() {
            csv.push_str(&format!("R{response},L{location}\n").repeat(times));
        }
    }
    csv
}

fn json(place: &Workplace, csv: &str, more: &[&str]) -> Value {
    place.write("r.csv", csv);
    let answer = place.ballmark(&[&["score", "r.csv", "--json"], more].concat());
    serde_json::from_str(&answer.done().stdout).expect("one JSON object")
}

#[track_caller]
fn near(value: &Value, expected: f64) {
    let value = value.as_f64().expect("a number");
    assert!((value - expected).abs() < 1e-6, "{value} is not {expected}");
}

#[test]
fn figure_3_of_duckett_and_nehmzow() {
    let result = json(&Workplace::new(), &figure_3(), &[]);
    assert_eq!(
        (&result["n"], &result["locations"], &result["responses"]),
        (&100.into(), &5.into(), &5.into())
    );
    near(&result["entropy_of_location"], 1.598087);
    near(&result["entropy_of_location_given_response"], 0.577551);
    near(&result["uncertainty_coefficient"], 0.638598);
    // (1.598087 − .577551 − .086942) / (1.598087 − .086942), E[I] by scikit-learn 1.9.1
    near(&result["uncertainty_coefficient_corrected"], 0.617806);
    near(&result["permutation_p"], 0.001);
    let (low, high) = (
        result["ci95"][0].as_f64().unwrap(),
        result["ci95"][1].as_f64().unwrap(),
    );
    assert!(
        0.4 < low && low < 0.617 && 0.618 < high && high < 0.8,
        "{low} {high}"
    );
    assert_eq!(result["ci95_over"], "rows");
    assert_eq!(result["logarithm"], "natural");
}

#[test]
fn a_table_for_people_names_every_figure() {
    let place = Workplace::new();
    place.write("r.csv", figure_3());
    let answer = place.ballmark(&["score", "r.csv"]);
    let text = &answer.done().stdout;
    for part in [
        "H(L|R)",
        "0.577551",
        "0.638598",
        "0.617806",
        "0.001000",
        "natural logarithm",
        "over rows",
    ] {
        assert!(text.contains(part), "`{part}` is missing in:\n{text}");
    }
}

#[test]
fn labels_may_hold_anything_and_the_header_any_order() {
    let plain = json(
        &Workplace::new(),
        "response,location\na,x\nb,y\na,x\nb,x\n",
        &[],
    );
    let odd = "\u{feff}note,location,response\r\n1,\"x, \"\"left\"\"\",0\r\n2,ÿ,7\r\n,\"x, \"\"left\"\"\", 0\r\n4,\"x, \"\"left\"\"\",7\r\n";
    assert_eq!(plain, json(&Workplace::new(), odd, &[]));
}

#[test]
fn trials_and_distances_are_used() {
    let mut csv = String::from("trial,distance_m,location,response\n");
    for trial in 0..24 {
        let location = trial % 4;
        csv.push_str(&format!(
            "t{trial},0,{location},none\nt{trial},2.50,{location},{location}\n"
        ));
    }
    let result = json(&Workplace::new(), &csv, &[]);
    assert_eq!(
        (&result["ci95_over"], &result["trials"]),
        (&"trials".into(), &24.into())
    );
    let rows = result["by_distance"].as_array().unwrap();
    assert_eq!(rows.len(), 2);
    assert_eq!(
        (&rows[0]["distance_m"], &rows[0]["n"]),
        (&0.0.into(), &24.into())
    );
    assert_eq!(rows[0]["uncertainty_coefficient"], 0.0);
    assert_eq!(rows[1]["distance_m"], 2.5);
    assert_eq!(rows[1]["uncertainty_coefficient"], 1.0);
}

#[test]
fn same_seed_same_bytes_with_any_number_of_threads() {
    let place = Workplace::new();
    place.write("r.csv", figure_3());
    let with = |seed: &str, threads: &str| {
        let mut command = std::process::Command::new(crate::support::binary());
        command
            .args(["score", "--json", "--seed", seed])
            .arg(place.path("r.csv"));
        crate::support::answer(command.env("RAYON_NUM_THREADS", threads))
            .done()
            .stdout
            .clone()
    };
    assert_eq!(with("5", "1"), with("5", "4"));
    let interval = |text: &str| serde_json::from_str::<Value>(text).unwrap()["ci95"].clone();
    assert_ne!(interval(&with("5", "1")), interval(&with("6", "1")));
}

#[test]
fn one_location_has_no_coefficient() {
    let place = Workplace::new();
    let result = json(&place, "response,location\na,x\nb,x\n", &[]);
    assert_eq!(result["entropy_of_location"], 0.0);
    for key in [
        "uncertainty_coefficient",
        "uncertainty_coefficient_corrected",
        "permutation_p",
        "ci95",
    ] {
        assert_eq!(result[key], Value::Null, "{key}");
    }
    assert!(
        result["notes"][0]
            .as_str()
            .unwrap()
            .contains("one location")
    );
    let text = place.ballmark(&["score", "r.csv"]).done().stdout.clone();
    assert!(text.contains('–') && !text.contains("NaN"), "{text}");
}

#[test]
fn no_permutations_no_p_and_no_resamples_no_interval() {
    let result = json(
        &Workplace::new(),
        &figure_3(),
        &["--permutations", "0", "--bootstrap", "0"],
    );
    assert_eq!(
        (&result["permutation_p"], &result["ci95"]),
        (&Value::Null, &Value::Null)
    );
    near(&result["uncertainty_coefficient"], 0.638598);
}

#[test]
fn bad_files_are_refused_in_one_line() {
    let bad: [(&[u8], &[&str]); 12] = [
        (b"", &["empty", "response,location"]),
        (b" \n\n", &["empty"]),
        (b"response,location\n", &["no rows"]),
        (
            b"response,place\na,x\n",
            &["line 1", "no column `location`", "place"],
        ),
        (
            b"location,location,response\nx,x,a\n",
            &["line 1", "two columns `location`"],
        ),
        (
            b"response,location\na,x\nb\n",
            &["line 3", "1 fields; expected 2"],
        ),
        (
            b"response,location\n\na,x\n\nb,y,z\n",
            &["line 5", "3 fields; expected 2"],
        ),
        (b"response,location\na,x\n\xff,y\n", &["line 3", "UTF-8"]),
        (
            b"response,location\na,\n",
            &["line 2", "`location` is empty"],
        ),
        (
            b"response,location\na,x\nb,\"y\nc,z\n",
            &["line 3", "quotes closed"],
        ),
        (
            b"response,location,distance_m\na,x,1\nb,y,far\n",
            &["line 3", "`distance_m` holds `far`"],
        ),
        (
            b"response,location,distance_m\na,x,NaN\n",
            &["line 2", "`distance_m` holds `NaN`"],
        ),
    ];
    for (content, parts) in bad {
        let place = Workplace::new();
        place.write("r.csv", content);
        place
            .ballmark(&["score", "r.csv"])
            .refused(1, &[parts, &["r.csv"]].concat());
        assert_eq!(place.files(), ["r.csv"]);
    }
}

#[test]
fn what_is_no_file_is_refused() {
    let place = Workplace::new();
    place
        .ballmark(&["score", "none.csv"])
        .refused(1, &["none.csv", "cannot read"]);
    std::fs::create_dir(place.path("folder")).unwrap();
    place
        .ballmark(&["score", "folder"])
        .refused(1, &["folder", "expected a file"]);
}

#[test]
fn a_wrong_call_is_told_from_bad_input() {
    let place = Workplace::new();
    assert_eq!(place.ballmark(&["score"]).status, 2);
    assert_eq!(
        place.ballmark(&["score", "r.csv", "--seed", "-1"]).status,
        2
    );
    assert_eq!(
        place
            .ballmark(&["score", "r.csv", "--permutations", "2000000"])
            .status,
        2
    );
}
