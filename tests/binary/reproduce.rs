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
fn a_paper_that_nobody_knows_is_refused() {
    let place = Workplace::new();
    let answer = place.ballmark(&["reproduce", "thrun1899"]);
    assert_eq!(answer.status, 2);
    assert!(
        answer.stderr.contains("duckett1998, duckett2000"),
        "{}",
        answer.stderr
    );
    let file = place.write("taken", "a file");
    let file = file.to_str().unwrap();
    place
        .ballmark(&["reproduce", "duckett1998", "--toy", "--out", file])
        .refused(1, &["taken"]);
}
