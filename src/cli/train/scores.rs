//! What came of a training, for people and programs.

use crate::{
    learning::{ErrorReduction, trainer::StoppedBy},
    model::{Learned, Note, Scores},
    recording::degraded::Degradation,
    report::{Cell, Table},
};

pub(super) fn json(learned: &Learned, degraded: Option<&Degradation>, seconds: f64) -> String {
    let mut value = json_of(learned, degraded);
    value["timing"] = serde_json::json!({ "seconds": seconds });
    format!("{value}\n")
}

pub(super) fn json_of(learned: &Learned, degraded: Option<&Degradation>) -> serde_json::Value {
    let report = &learned.report;
    let notes: Vec<String> = report.notes.iter().map(Note::to_string).collect();
    serde_json::json!({
        "uncertainty": learned.model.header.prior,
        "train": report.scores.train,
        "validation": report.scores.validation,
        "began_with": report.began_with,
        "steps": report.steps,
        "evaluations": report.evaluations,
        "stopped_by": report.stopped_by,
        "resumed_at": report.resumed_at,
        "notes": notes,
        "evidence_scale": learned.model.header.evidence_scale,
        "recipe": learned.model.header.recipe,
        "degraded": degraded,
    })
}

/// What the rows of validation are about.
pub(super) const VALIDATION: &str =
    "validation: unseen snapshots at places seen in training; the map from training snapshots only";

/// A table of scores without rows.
pub(super) fn scores_table(part: &str) -> Table {
    Table::new([
        part,
        "snapshots",
        "prior error (m)",
        "posterior error (m)",
        "error reduction (%)",
    ])
}

/// Adds the scores of a training, `of` before the name of each part.
pub(super) fn score_rows(table: &mut Table, of: &str, scores: &Scores) {
    let mut row = |part: &str, score: Option<&ErrorReduction>| {
        let number =
            |get: fn(&ErrorReduction) -> f64, decimals| Cell::number(score.map(get), decimals);
        table.row([
            Cell::Text(format!("{of}{part}")),
            score.map_or(Cell::Missing, |s| Cell::Count(s.snapshots as u64)),
            number(|s| s.prior_error_m, 3),
            number(|s| s.posterior_error_m, 3),
            number(|s| 100.0 * s.error_reduction, 1),
        ]);
    };
    row("training", Some(&scores.train));
    row("validation", scores.validation.as_ref());
}

pub(super) fn table(learned: &Learned, seconds: Option<f64>) -> Table {
    let report = &learned.report;
    let mut table = scores_table("part");
    score_rows(&mut table, "", &report.scores);
    let recipe = &learned.model.header.recipe;
    let why = match report.stopped_by {
        StoppedBy::Validation => "no better on the validation part",
        StoppedBy::Steps => "all steps taken",
        StoppedBy::NothingLearned => "stopped: nothing learned that holds on the validation part",
        StoppedBy::Callback => "stopped early",
    };
    let seconds = seconds.map_or(String::new(), |seconds| format!(", {seconds:.1} s"));
    table.caption(format!(
        "{} filters for uncertainty {}, seed {}; {} steps ({why}){seconds}",
        recipe.features, recipe.uncertainty, recipe.seed, report.steps
    ));
    if let Some(name) = &report.began_with {
        table.caption(format!(
            "began with networks pre-trained on other buildings: {name} (--from none: with random ones)"
        ));
    }
    if let [.., _] = learned.model.history_m() {
        table.caption(format!(
            "inputs: readings of now and of {:?} m back ([train.input] history_m)",
            learned.model.history_m()
        ));
    }
    table.caption(VALIDATION);
    let rendered = learned.model.header.occupancy.is_some();
    let people = recipe.augmentation.most_people(rendered);
    if people > 0.0 && report.scores.validation.is_some() {
        table.caption(format!(
            "each as it was and once more with people before {:.0} % of the beams ([train.augmentation] people)",
            100.0 * people
        ));
    }
    if let Some(scale) = learned.model.header.evidence_scale {
        table.caption(format!(
            "evidence of a snapshot counts to the power {scale:.3} in the filter: tuned on validation sequences"
        ));
    }
    table
}
