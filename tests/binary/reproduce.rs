//! `ballmark reproduce`: the papers' tables from the program alone.

use super::support::Workplace;

#[test]
fn the_papers_figures_stand_beside_ours() {
    let place = Workplace::new();
    let answer = place.ballmark(&["reproduce", "duckett1998", "--toy", "--out", "r"]);
    let text = &answer.done().stdout;
    for part in [
        "evidence-based localisation: distance to U = 0.9 (m)",
        "paper",
        "here",
        "13.6",
    ] {
        assert!(text.contains(part), "`{part}` is missing in: {text}");
    }
    let table = std::fs::read_to_string(place.path("r/paper_tables_1_2.csv")).unwrap();
    let rows: Vec<Vec<&str>> = table.lines().map(|row| row.split(',').collect()).collect();
    // Bins of our worlds are counted, the paper's are printed.
    assert_eq!(rows[0][2..], ["A", "B", "C", "D", "E", "F"]);
    assert_eq!(
        rows[1],
        ["location bins", "paper", "24", "14", "40", "8", "14", "14"]
    );
    assert!(
        rows[2][2..]
            .iter()
            .all(|bins| bins.parse::<f64>().unwrap() > 5.0)
    );
    for name in ["comparison.json", "config.json", "paper_tables_1_2.tex"] {
        assert!(place.path("r").join(name).exists(), "{name}");
    }
    // Nothing is left but the report.
    assert_eq!(place.files(), ["r"]);
}

#[test]
fn thruns_figures_stand_beside_ours() {
    let place = Workplace::new();
    let answer = place.ballmark(&["reproduce", "thrun1998", "--quick", "--out", "r"]);
    let text = &answer.done().stdout;
    for part in [
        "Table 3: one snapshot at ±2 m",
        "14.9 ± 1.3",
        "held out",
        "Fig. 6: global localisation",
        "Readings for one bit",
        "one set a step, by least expected error",
        "which camera to mount",
    ] {
        assert!(text.contains(part), "`{part}` is missing in: {text}");
    }
    let table = std::fs::read_to_string(place.path("r/reductions.csv")).unwrap();
    let rows: Vec<Vec<&str>> = table.lines().map(|row| row.split(',').collect()).collect();
    assert_eq!(
        rows[0][..5],
        ["set", "approach", "features", "trained_for", "judged_at"]
    );
    let four = rows
        .iter()
        .find(|row| row[1] == "ball" && row[2] == "4")
        .unwrap();
    let share: f64 = four[8].parse().unwrap();
    assert!((0.1..0.9).contains(&share), "{four:?}");
    let names = [
        "thrun1998.json",
        "table_3.csv",
        "table_3.md",
        "table_3.tex",
        "figure_3_d1.svg",
        "figure_4_d1.svg",
        "figure_5.svg",
        "figure_6_d1.svg",
        "figure_7.svg",
        "figure_8.svg",
        "errors.csv",
    ];
    for name in names {
        assert!(place.path("r").join(name).exists(), "{name}");
    }
    assert_eq!(place.files(), ["r"]);
    let answer = place.ballmark(&["reproduce", "thrun1998", "--quick", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&answer.done().stdout).unwrap();
    assert_eq!(json["sets"][0]["name"], "d1");
}

#[test]
fn the_metric_of_a_correction_stands_beside_the_papers() {
    let place = Workplace::new();
    let answer = place.ballmark(&["reproduce", "ruizmayor2006", "--quick", "--out", "r"]);
    let text = &answer.done().stdout;
    for part in ["C_XYT", "53.2", "20.4", "s_T (°)", "noise (m)"] {
        assert!(text.contains(part), "`{part}` is missing in: {text}");
    }
    let table = std::fs::read_to_string(place.path("r/figures.csv")).unwrap();
    let first = table.lines().nth(1).unwrap();
    assert_eq!(first, "estimates of a repetition,141,141,18,62,61");
    for name in [
        "ruizmayor2006.json",
        "by_prior_error.md",
        "by_heading_step.tex",
        "figure_8.svg",
        "figure_9.svg",
    ] {
        assert!(place.path("r").join(name).exists(), "{name}");
    }
    assert_eq!(place.files(), ["r"]);
    // Again, to the last byte, but for the times.
    place
        .ballmark(&["reproduce", "ruizmayor2006", "--quick", "--out", "again"])
        .done();
    let read = |folder: &str, name: &str| std::fs::read(place.path(folder).join(name)).unwrap();
    for entry in std::fs::read_dir(place.path("r")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        if !name.starts_with("timing") && name != "ruizmayor2006.json" {
            assert_eq!(read("r", &name), read("again", &name), "{name}");
        }
    }
}

#[test]
fn a_paper_that_nobody_knows_is_refused() {
    let place = Workplace::new();
    let answer = place.ballmark(&["reproduce", "thrun1899"]);
    assert_eq!(answer.status, 2);
    assert!(
        answer
            .stderr
            .contains("thrun1998, duckett1998, duckett2000, ruizmayor2006"),
        "{}",
        answer.stderr
    );
    let file = place.write("taken", "a file");
    let file = file.to_str().unwrap();
    place
        .ballmark(&["reproduce", "duckett1998", "--toy", "--out", file])
        .refused(1, &["taken"]);
}
