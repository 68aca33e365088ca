//! Figs. 3 to 8 of Thrun (1998) as pictures.

use super::{LOCAL_FEATURES, bank::titled as bank_titled, curve_rows, named, titled};
use crate::{
    error::Result,
    experiment::thrun1998::{
        GlobalRecord, Moment, ReductionRow, SetRecord, Thrun1998Record, priors, words,
    },
    report::{Curve, Panel, Trace, category_plot, framed_plot, stacked_plot},
    score::MeanInterval,
};

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
    if let Some(bank) = &record.bank {
        let shares = bank.shares.iter().map(|share| &share.approach);
        let shown: Vec<&String> = bank.best_alone.iter().chain(shares).collect();
        let approaches = bank.approaches.iter();
        let curve = |approach: &GlobalRecord| Curve {
            name: bank_titled(&approach.approach),
            band: None, // seven of them would hide one another
            ..error_curve(approach)
        };
        let panel = Panel {
            y_label: "mean error (m)".into(),
            curves: approaches
                .filter(|approach| shown.contains(&&approach.approach))
                .map(curve)
                .collect(),
            y_range: None,
        };
        let title = format!("{}: a bank of filters, and its best set", named(&bank.set));
        let picture = framed_plot(&title, "distance travelled (m)", &panel)?;
        pictures.push(("bank".into(), picture));
    }
    if let Some(belief) = &record.belief {
        let panel = |moment: &Moment| Panel {
            y_label: format!("after {}", moment.snapshots),
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
    let mut curve = curve(titled(&global.approach, LOCAL_FEATURES), x, &means, 1.0);
    // Few runs make an interval that reaches below 0, where no error lies.
    if let Some((low, _)) = &mut curve.band {
        low.iter_mut().for_each(|low| *low = low.max(0.0));
    }
    curve
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
