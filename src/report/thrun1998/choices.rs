//! What a robot should do so as to find out where it is, by the expected error of each answer.

use crate::{
    experiment::thrun1998::{ChoiceRecord, Thrun1998Record},
    report::{
        Cell, Table,
        comparison::Sheet,
        paper::{sheet, text},
    },
    score::MeanInterval,
};

/// A question in words.
fn titled(question: &str) -> &str {
    match question {
        "heading" => "which way to look at the next step",
        "heading_control" => "  control: which of three copies of a camera",
        "mount" => "which camera to mount",
        "mount_control" => "  control: which of three copies of one",
        "action" => "drive ahead or back",
        "action_control" => "  control: the same, sure of the place",
        other => other,
    }
}

/// A difference with its interval.
fn difference(mean: &MeanInterval) -> Cell {
    match mean.ci95 {
        Some([low, high]) => text(format!("{:+.2} ({low:+.2} to {high:+.2})", mean.mean)),
        None => Cell::Number(mean.mean, 2),
    }
}

/// The questions and what the answers are worth.
pub(super) fn choices(record: &Thrun1998Record) -> Option<Sheet> {
    let seeds = record.choices.first()?.seeds;
    let mut table = Table::new([
        "question",
        "chosen",
        "chance",
        "less chance",
        "best always",
        "less best",
    ]);
    for choice in &record.choices {
        let ChoiceRecord {
            chosen_m,
            chance_m,
            best_fixed_m,
            ..
        } = choice;
        table.row([
            text(titled(&choice.question)),
            Cell::Number(chosen_m.mean, 2),
            Cell::Number(chance_m.mean, 2),
            difference(&choice.less_than_chance_m),
            text(format!("{:.2} {}", best_fixed_m.mean, choice.best_fixed)),
            difference(&choice.less_than_best_fixed_m),
        ]);
    }
    table.caption(format!(
        "mean expected error (m) over the readings of a trial, of {seeds} worlds, each simulated and learned anew; (95 % interval of"
    ));
    table.caption("  the mean difference, world by world); chosen: by least expected error before sensing; best always: the one answer");
    table.caption("  that is best in the mean of all worlds, which nobody knows beforehand");
    Some(sheet(
        "choices",
        "What to do to find out where one is (section 7)",
        table,
    ))
}
