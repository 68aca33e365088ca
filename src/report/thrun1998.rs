//! The figures of Thrun (1998), ours beside what is printed.

use super::{
    Cell, Curve, Panel, Table, Trace, category_plot,
    comparison::{Reader, Sheet},
    framed_plot, stacked_plot,
};
use crate::{
    error::Result,
    experiment::{
        printed::{THRUN_1998_FIG_3, THRUN_1998_FIG_6, THRUN_1998_TABLE_3},
        thrun1998::{
            GlobalRecord, Prior, ReductionRow, SetRecord, Thrun1998Record, local, priors, words,
        },
    },
    score::MeanInterval,
};

/// Features of Fig. 4 and Fig. 6.
const LOCAL_FEATURES: usize = 4;

/// Its tables.
pub fn sheets(record: &Thrun1998Record) -> Vec<Sheet> {
    let mut sheets = vec![
        table_3(record),
        by_uncertainty(
            record,
            "figure_3",
            "Fig. 3: one feature, trained for the prior that it is judged under",
            1,
        ),
        by_uncertainty(
            record,
            "figure_4",
            "Fig. 4: four features trained for ±2 m, under other priors",
            LOCAL_FEATURES,
        ),
        figure_6(record),
    ];
    sheets.extend(readings(record));
    sheets.extend(harder(record));
    sheets.push(all_reductions(record));
    sheets.push(all_errors(record));
    sheets
}

/// Its figures, by name, as SVG.
///
/// # Errors
/// Where a figure can't be drawn.
pub fn pictures(record: &Thrun1998Record) -> Result<Vec<(String, String)>> {
    let mut pictures = Vec::new();
    for set in &record.sets {
        for (figure, features) in [(3, 1), (4, LOCAL_FEATURES)] {
            let title = format!("{}, n = {features}", named(&set.name));
            let picture = reduction_curves(set, features, &title)?;
            pictures.push((format!("figure_{figure}_{}", set.name), picture));
        }
        let of_set = record.global.iter().filter(|global| global.set == set.name);
        let curves: Vec<Curve> = of_set.map(error_curve).collect();
        let panel = Panel {
            y_label: "mean error (m)".into(),
            curves,
            y_range: None,
        };
        let title = format!("{}: from a start anywhere", named(&set.name));
        let picture = framed_plot(&title, "distance travelled (m)", &panel)?;
        pictures.push((format!("figure_6_{}", set.name), picture));
    }
    if let Some(belief) = &record.belief {
        let panel = |moment: &crate::experiment::thrun1998::Moment| Panel {
            y_label: format!("{} seen", moment.snapshots),
            curves: vec![
                Curve {
                    name: "belief".into(),
                    x: belief.route_m.clone(),
                    y: moment.mass.clone(),
                    band: None,
                },
                Curve {
                    name: "truth".into(),
                    x: vec![moment.truth_m; 2],
                    y: vec![0.0, moment.mass.iter().copied().fold(0.0, f64::max)],
                    band: None,
                },
            ],
            y_range: None,
        };
        let shown = belief
            .moments
            .iter()
            .filter(|m| m.snapshots <= 4 || m.snapshots == 8);
        let panels: Vec<Panel> = shown.map(panel).collect();
        let picture = stacked_plot(
            "Belief after some snapshots, 0.5 m apart",
            "along the corridor (m)",
            &panels,
            Trace::Step,
        )?;
        pictures.push(("figure_5".into(), picture));
    }
    if let Some(set) = record.sets.first() {
        pictures.push(("figure_7".into(), outputs(set, 1)?));
        pictures.push(("figure_8".into(), outputs(set, LOCAL_FEATURES)?));
    }
    Ok(pictures)
}

/// As the paper calls a data set.
fn named(set: &str) -> String {
    set.replacen('d', "D-", 1)
}

/// As tables call an approach.
fn titled(approach: &str, features: usize) -> String {
    match approach {
        "door" => "doors".into(),
        "ceiling_light" => "ceiling lights".into(),
        "kernel" => "raw-scan kernel".into(),
        _ => format!("BaLL, n = {features}"),
    }
}

/// A share in per cent.
fn bare_percent(mean: Option<MeanInterval>) -> Cell {
    Cell::number(mean.map(|mean| 100.0 * mean.mean), 1)
}

/// A share in per cent, with half of its interval.
fn percent(mean: Option<MeanInterval>) -> Cell {
    let Some(mean) = mean else {
        return Cell::Missing;
    };
    let shown = 100.0 * mean.mean;
    Cell::Text(match mean.ci95 {
        Some([low, high]) => format!("{shown:.1} ± {:.1}", 50.0 * (high - low)),
        None => format!("{shown:.1}"),
    })
}

fn text(text: impl Into<String>) -> Cell {
    Cell::Text(text.into())
}

fn sheet(name: &str, title: &str, table: Table, reader: Reader) -> Sheet {
    Sheet {
        name: name.into(),
        title: title.into(),
        table,
        reader,
    }
}

/// Table 3: ±2 m.
fn table_3(record: &Thrun1998Record) -> Sheet {
    let sets = record.sets.iter().map(|set| named(&set.name));
    let headers = ["approach", "from"].map(String::from).into_iter();
    let mut table = Table::new(headers.chain(sets));
    let prior = Some(local());
    let row_of = |set: &'_ SetRecord, approach: &str, features: usize| -> Option<ReductionRow> {
        let trained_for = prior.filter(|_| approach == "ball");
        set.row(approach, features, trained_for, prior?).cloned()
    };
    for printed in THRUN_1998_TABLE_3 {
        let (approach, n) = (printed.approach, printed.features);
        let paper = record.sets.iter().map(|set| {
            let number = ["d1", "d2", "d3"].iter().position(|name| *name == set.name);
            match number.and_then(|number| printed.reduction[number]) {
                Some([mean, half]) => text(format!("{mean:.1} ± {half:.1}")),
                None => Cell::Missing,
            }
        });
        let name = titled(approach, n);
        table.row([text(name), text("paper")].into_iter().chain(paper));
        let by_objective = record
            .sets
            .iter()
            .map(|set| percent(row_of(set, approach, n).and_then(|row| row.objective)));
        table.row([text(""), text("here")].into_iter().chain(by_objective));
        let held_out = record
            .sets
            .iter()
            .map(|set| percent(row_of(set, approach, n).and_then(|row| row.held_out)));
        table.row([text(""), text("held out")].into_iter().chain(held_out));
    }
    let kernel = record
        .sets
        .iter()
        .map(|set| percent(row_of(set, "kernel", 0).and_then(|row| row.held_out)));
    table.row(
        [text(titled("kernel", 0)), text("held out")]
            .into_iter()
            .chain(kernel),
    );
    let correlation = record
        .sets
        .iter()
        .map(|set| Cell::Number(set.correlation.mean, 2));
    table.row(
        [text("|correlation| of two of four features"), text("here")]
            .into_iter()
            .chain(correlation),
    );
    table.caption("share of the error that one snapshot takes away, %, ± half of the 95 % interval over the runs judged on");
    table.caption("here: eq. 42 on the snapshots of the run that is judged on, as the paper; held out: by the map of the");
    table.caption("  other runs, which is what a robot has");
    table.caption("the kernel is not in the paper; of six bandwidths it has the best on the very run that is judged on");
    sheet(
        "table_3",
        "Table 3: one snapshot at ±2 m",
        table,
        Reader::Everyone,
    )
}

/// Rows of one of the curves over priors.
fn curve_rows<'r>(
    set: &'r SetRecord,
    features: usize,
) -> Vec<(String, Vec<Option<&'r ReductionRow>>)> {
    let of = |approach: &str, n: usize| -> Vec<Option<&'r ReductionRow>> {
        let row = |prior: Prior| {
            let trained_for = match (approach, n) {
                ("ball", 1) => Some(prior),
                ("ball", _) => Some(local()),
                _ => None,
            };
            set.row(approach, n, trained_for, prior)
        };
        priors().into_iter().map(row).collect()
    };
    let chosen = match set.name.as_str() {
        "d3" => "ceiling_light",
        _ => "door",
    };
    [(chosen, 1), ("ball", features), ("kernel", 0)]
        .map(|(approach, n)| (approach.to_string(), of(approach, n)))
        .to_vec()
}

fn by_uncertainty(record: &Thrun1998Record, name: &str, title: &str, features: usize) -> Sheet {
    let headers = ["data set", "approach", "from"]
        .map(String::from)
        .into_iter();
    let mut table = Table::new(headers.chain(priors().into_iter().map(words)));
    for set in &record.sets {
        for (approach, rows) in curve_rows(set, features) {
            let n = if approach == "ball" { features } else { 1 };
            let label = titled(&approach, n);
            let printed = |prior: Prior| {
                let number = ["d1", "d2", "d3"].iter().position(|name| *name == set.name);
                let mut all = THRUN_1998_FIG_3.iter();
                let known = all.find(|(of, name, half_width_m, _)| {
                    Some(*of) == number
                        && *name == approach
                        && words(prior) == format!("±{half_width_m} m")
                });
                Cell::number(known.map(|known| known.3), 1)
            };
            if features == 1 && approach != "kernel" {
                let cells = priors().into_iter().map(printed);
                table.row(
                    [text(named(&set.name)), text(label.clone()), text("paper")]
                        .into_iter()
                        .chain(cells),
                );
            }
            if approach != "kernel" {
                let cells = rows
                    .iter()
                    .map(|row| bare_percent(row.and_then(|row| row.objective)));
                table.row(
                    [text(named(&set.name)), text(label.clone()), text("here")]
                        .into_iter()
                        .chain(cells),
                );
            }
            let cells = rows
                .iter()
                .map(|row| bare_percent(row.and_then(|row| row.held_out)));
            table.row(
                [text(named(&set.name)), text(label), text("held out")]
                    .into_iter()
                    .chain(cells),
            );
        }
    }
    table.caption("%, as in Table 3, whose intervals are as wide; all are in `reductions.csv`. Of the paper, what its text tells");
    sheet(name, title, table, Reader::Everyone)
}

fn figure_6(record: &Thrun1998Record) -> Sheet {
    let mut table = Table::new([
        "data set",
        "approach",
        "4 m",
        "9.5 m",
        "30 m",
        "below 1 m",
        "as landmarks",
    ]);
    let [below_1m_m, doors_m, as_good_m] = THRUN_1998_FIG_6;
    let number = Cell::Number;
    table.row([
        text("D-1, paper"),
        text("doors"),
        Cell::Missing,
        Cell::Missing,
        number(doors_m, 2),
        Cell::Missing,
        Cell::Missing,
    ]);
    table.row([
        text("D-1, paper"),
        text("BaLL, n = 4"),
        number(doors_m, 2),
        text("below 1"),
        Cell::Missing,
        number(below_1m_m, 1),
        number(as_good_m, 1),
    ]);
    for global in &record.global {
        let chosen = record
            .global
            .iter()
            .find(|other| other.set == global.set && other.approach != "ball");
        let as_good = chosen
            .filter(|_| global.approach == "ball")
            .and_then(|chosen| global.below_m(chosen.error_at_m(30.0)?));
        table.row([
            text(named(&global.set)),
            text(titled(&global.approach, LOCAL_FEATURES)),
            Cell::number(global.error_at_m(4.0), 2),
            Cell::number(global.error_at_m(9.5), 2),
            Cell::number(global.error_at_m(30.0), 2),
            Cell::number(global.below_1m_at_m, 1),
            Cell::number(as_good, 1),
        ]);
    }
    table.caption(format!(
        "mean expected error (m) after so many metres, of {} trials on each of {} runs, from a start anywhere",
        record.config.trials, record.config.runs
    ));
    table.caption("below 1 m: after how many metres that is so of the mean; as landmarks: after how many metres BaLL is as");
    table.caption("  accurate as the landmarks are after 30 m; –: not told, or never");
    sheet(
        "figure_6",
        "Fig. 6: global localisation",
        table,
        Reader::Everyone,
    )
}

fn readings(record: &Thrun1998Record) -> Option<Sheet> {
    let here = record.readings.as_ref()?;
    let mut table = Table::new(["quantity", "paper", "here"]);
    let mut row = |name: &str, paper: f64, here: Option<f64>, decimals: usize| {
        table.row([
            text(name),
            Cell::Number(paper, decimals),
            Cell::number(here, decimals),
        ]);
    };
    row(
        "readings until the mean error is below 1 m",
        19.0,
        Some(here.readings),
        0,
    );
    row(
        "bits: log2 of the length in metres",
        6.48,
        Some(here.bits_of_length),
        2,
    );
    row(
        "bits: log2 of the mean error at the start",
        5.4,
        Some(here.bits_of_error),
        2,
    );
    row(
        "readings a bit, by length",
        2.93,
        Some(here.readings / here.bits_of_length),
        2,
    );
    row(
        "readings a bit, by error",
        3.52,
        Some(here.readings / here.bits_of_error),
        2,
    );
    row(
        "predicted for twice the length, by length",
        21.93,
        Some(here.predicted_by_length),
        1,
    );
    row(
        "predicted for twice the length, by error",
        22.52,
        Some(here.predicted_by_error),
        1,
    );
    table.row([
        text("found in twice the length"),
        Cell::Missing,
        Cell::number(here.found_in_doubled, 0),
    ]);
    table.caption("the paper predicts 23 and did not try; –: not tried, or never below 1 m");
    Some(sheet(
        "readings",
        "Readings for one bit (5.2.4)",
        table,
        Reader::Everyone,
    ))
}

/// Why the corridor is easier than the paper's.
fn harder(record: &Thrun1998Record) -> Option<Sheet> {
    let set = record.sets.first()?;
    let mut table = Table::new(["corridor", "approach", "here (%)", "held out (%)"]);
    let chosen = if set.name == "d3" {
        "ceiling_light"
    } else {
        "door"
    };
    for (approach, features) in [(chosen, 1), ("ball", 1), ("ball", LOCAL_FEATURES)] {
        let trained_for = Some(local()).filter(|_| approach == "ball");
        let row = set.row(approach, features, trained_for, local())?;
        let name = titled(approach, features);
        let cells = [percent(row.objective), percent(row.held_out)];
        table.row([text("as it is"), text(name)].into_iter().chain(cells));
    }
    for harder in &record.harder {
        let cells = [
            percent(Some(harder.objective)),
            percent(Some(harder.held_out)),
        ];
        let name = titled(&harder.approach, harder.features);
        table.row([text(&harder.name), text(name)].into_iter().chain(cells));
    }
    table.caption(format!(
        "{}, ±2 m; the paper's figures stand in Table 3",
        named(&set.name)
    ));
    let title = "Why more than the paper's: guesses tried";
    (!record.harder.is_empty()).then(|| sheet("harder", title, table, Reader::Everyone))
}

/// Every row, for other programs.
fn all_reductions(record: &Thrun1998Record) -> Sheet {
    let mut table = Table::new([
        "set",
        "approach",
        "features",
        "trained_for",
        "judged_at",
        "objective",
        "objective_low",
        "objective_high",
        "held_out",
        "held_out_low",
        "held_out_high",
    ]);
    for set in &record.sets {
        for row in &set.rows {
            let trained_for = row
                .trained_for
                .map_or(Cell::Missing, |prior| text(prior.to_string()));
            let cells = [row.objective, row.held_out]
                .into_iter()
                .flat_map(of_interval);
            let names = [
                text(&set.name),
                text(&row.approach),
                Cell::Count(row.features as u64),
                trained_for,
                text(row.judged_at.to_string()),
            ];
            table.row(names.into_iter().chain(cells));
        }
    }
    sheet("reductions", "Error reductions", table, Reader::Programs)
}

fn all_errors(record: &Thrun1998Record) -> Sheet {
    let mut table = Table::new([
        "set",
        "approach",
        "distance_m",
        "expected_error_m",
        "low",
        "high",
    ]);
    for global in &record.global {
        for row in &global.error_by_distance {
            let names = [
                text(&global.set),
                text(&global.approach),
                Cell::Number(row.distance_m, 1),
            ];
            table.row(
                names
                    .into_iter()
                    .chain(of_interval(Some(row.expected_error_m))),
            );
        }
    }
    sheet("errors", "Errors over distance", table, Reader::Programs)
}

fn of_interval(mean: Option<MeanInterval>) -> [Cell; 3] {
    let ci95 = mean.and_then(|mean| mean.ci95);
    [
        mean.map(|mean| mean.mean),
        ci95.map(|ci| ci[0]),
        ci95.map(|ci| ci[1]),
    ]
    .map(|value| Cell::number(value, 4))
}

fn reduction_curves(set: &SetRecord, features: usize, title: &str) -> Result<String> {
    let names: Vec<String> = priors().into_iter().map(words).collect();
    let mut curves = Vec::new();
    for (approach, rows) in curve_rows(set, features) {
        let of = |row: &Option<&ReductionRow>| match approach.as_str() {
            "kernel" => row.and_then(|row| row.held_out),
            _ => row.and_then(|row| row.objective),
        };
        let label = match approach.as_str() {
            "kernel" => "raw-scan kernel, held out".into(),
            _ => titled(&approach, features),
        };
        let means: Vec<Option<MeanInterval>> = rows.iter().map(of).collect();
        curves.push(curve(
            label,
            (0..names.len()).map(|i| i as f64).collect(),
            &means,
            100.0,
        ));
    }
    let panel = Panel {
        y_label: "error reduction (%)".into(),
        curves,
        y_range: None,
    };
    category_plot(title, "prior uncertainty", &names, &panel)
}

fn error_curve(global: &GlobalRecord) -> Curve {
    let rows = &global.error_by_distance;
    let means: Vec<Option<MeanInterval>> =
        rows.iter().map(|row| Some(row.expected_error_m)).collect();
    let x = rows.iter().map(|row| row.distance_m).collect();
    curve(titled(&global.approach, LOCAL_FEATURES), x, &means, 1.0)
}

/// Means with their intervals as a band; NaN leaves a gap.
fn curve(name: String, x: Vec<f64>, means: &[Option<MeanInterval>], scale: f64) -> Curve {
    let of = |value: fn(&MeanInterval) -> f64| -> Vec<f64> {
        let values = means
            .iter()
            .map(|mean| mean.as_ref().map_or(f64::NAN, value));
        values.map(|value| scale * value).collect()
    };
    Curve {
        name,
        x,
        y: of(|mean| mean.mean),
        band: Some((
            of(|mean| mean.ci95.map_or(mean.mean, |ci| ci[0])),
            of(|mean| mean.ci95.map_or(mean.mean, |ci| ci[1])),
        )),
    }
}

/// What networks of so many features answer along the corridor.
fn outputs(set: &SetRecord, features: usize) -> Result<String> {
    let mut panels = Vec::new();
    for output in set
        .outputs
        .iter()
        .filter(|output| output.features == features)
    {
        for (number, activation) in output.activation.iter().enumerate() {
            let name = match features {
                1 => words(output.trained_for),
                _ => format!("feature {}", number + 1),
            };
            panels.push(Panel {
                y_label: name,
                curves: vec![Curve {
                    name: "P(f = 1 | s)".into(),
                    x: output.route_m.clone(),
                    y: activation.clone(),
                    band: None,
                }],
                y_range: Some((0.0, 1.0)),
            });
        }
    }
    let title = match features {
        1 => format!(
            "{}: one feature, by the prior trained for",
            named(&set.name)
        ),
        _ => format!("{}: four features trained for ±2 m", named(&set.name)),
    };
    stacked_plot(&title, "along the corridor (m)", &panels, Trace::Line)
}
