//! Answers against true places as heat maps, of those who tell most.

use super::Picture;
use crate::{
    error::Result,
    experiment::{
        compare::{ComparisonRecord, Section, StandardCell},
        recognition::RecognitionRecord,
    },
    report::answers_plot,
    score::{AnswerCount, Judgement},
};

/// Most pictures of a section: a comparison of many datasets and systems has no use for hundreds.
const MOST: usize = 6;

/// One system on one dataset.
struct Answered<'a> {
    dataset: usize,
    system: usize,
    judgement: &'a Judgement,
    answers: &'a [AnswerCount],
}

/// Of recognition, and of the standard experiment at its trials' end: everybody where they are few, else whoever tells most on each dataset,
/// corrected for chance.
///
/// # Errors
/// Where drawing fails.
pub(super) fn pictures(record: &ComparisonRecord) -> Result<Vec<Picture>> {
    let recognition = record.recognition.as_ref().map(|section| {
        all(section, |cell: &RecognitionRecord| {
            (&cell.judgement, &cell.answers[..])
        })
    });
    let standard = record.standard.as_ref().map(|section| {
        all(section, |cell: &StandardCell| {
            (&cell.record.at_end, &cell.record.answers_at_end[..])
        })
    });
    let datasets = record.file_names();
    let systems = record.system_file_names();
    let mut pictures = Vec::new();
    for (section, answered) in [("recognition", recognition), ("standard", standard)] {
        for of in shown(answered.unwrap_or_default()) {
            let title = format!(
                "{}, {}: {}",
                record.datasets[of.dataset].name,
                record.systems[of.system].name,
                in_short(of.judgement)
            );
            let name = format!(
                "contingency-{section}-{}-{}",
                datasets[of.dataset], systems[of.system]
            );
            pictures.push((name, answers_plot(&title, of.answers)?));
        }
    }
    Ok(pictures)
}

fn all<C, T>(
    section: &Section<C, T>,
    answered: fn(&T) -> (&Judgement, &[AnswerCount]),
) -> Vec<Answered<'_>> {
    let rows = section.systems.iter().zip(&section.cells);
    let cells = rows.flat_map(|(&system, row)| {
        let done = row.iter().enumerate();
        done.filter_map(move |(dataset, cell)| Some((dataset, system, cell.done()?)))
    });
    let answered = cells.map(|(dataset, system, cell)| {
        let (judgement, answers) = answered(cell);
        Answered {
            dataset,
            system,
            judgement,
            answers,
        }
    });
    answered.filter(|of| !of.answers.is_empty()).collect()
}

/// U, what chance leaves of it with its interval, and how often chance reaches it.
fn in_short(judgement: &Judgement) -> String {
    let number = |value: Option<f64>| value.map_or("none".to_string(), |v| format!("{v:.2}"));
    let interval = judgement.ci95.map_or(String::new(), |[low, high]| {
        format!(" ({low:.2} to {high:.2})")
    });
    let p = judgement.permutation_p;
    format!(
        "U {}, corrected {}{interval}{}",
        number(judgement.uncertainty_coefficient),
        number(judgement.uncertainty_coefficient_corrected),
        p.map_or(String::new(), |p| format!(", p {p:.3}"))
    )
}

fn shown(mut answered: Vec<Answered>) -> Vec<Answered> {
    answered.sort_by_key(|of| (of.dataset, of.system));
    if answered.len() > MOST {
        let worth = |of: &Answered| {
            let corrected = of.judgement.uncertainty_coefficient_corrected;
            corrected.unwrap_or(f64::NEG_INFINITY)
        };
        answered.sort_by(|a, b| (a.dataset.cmp(&b.dataset)).then(worth(b).total_cmp(&worth(a))));
        answered.dedup_by_key(|of| of.dataset); // the first of each dataset stays
        answered.truncate(MOST);
    }
    answered
}
