//! What must be known to read the tables of a comparison.

use crate::{experiment::compare::ComparisonRecord, score::Caution};

/// Lines for below all tables: what was true, who mapped, the notes of each dataset, seed and version.
pub fn caption_lines(record: &ComparisonRecord) -> Vec<String> {
    let mut lines = vec![match record.truth.as_str() {
        "odometry" => "truth: compass-based odometry, corrected lap by lap".to_string(),
        _ => "truth: the recordings' poses".to_string(),
    }];
    let datasets = record.datasets.iter().enumerate();
    let notes =
        datasets.flat_map(|(number, dataset)| dataset.notes.iter().map(move |n| (number, n)));
    lines.extend(notes_by_dataset(record, notes));
    lines.push(format!("seed {}, ballmark {}", record.seed, record.version));
    lines
}

/// A line a caution, with the systems and datasets whose coefficients it is about: `(caution, dataset, system)`.
pub(super) fn cautions(
    record: &ComparisonRecord,
    cautions: &[(Caution, usize, usize)],
) -> Vec<String> {
    let lines = [
        (
            Caution::MostlyChance,
            "chance alone makes most of U, corrected it is less than half",
        ),
        (
            Caution::FewData,
            "fewer than 5 data points a bin flatter U, see corrected",
        ),
    ];
    let lines = lines.into_iter().filter_map(|(caution, words)| {
        let mut names: Vec<(usize, Vec<&str>)> = Vec::new();
        for &(_, dataset, system) in cautions.iter().filter(|(c, ..)| *c == caution) {
            let name = record.systems[system].name.as_str();
            match names.iter_mut().find(|(known, _)| *known == dataset) {
                Some((_, systems)) => systems.push(name),
                None => names.push((dataset, vec![name])),
            }
        }
        let names = names.into_iter().map(|(dataset, systems)| {
            format!("{} ({})", record.datasets[dataset].name, systems.join(", "))
        });
        let names = names.collect::<Vec<_>>().join("; ");
        (!names.is_empty()).then(|| format!("{words}: {names}"))
    });
    lines.collect()
}

/// One line a note, with the names of the datasets that it is about.
pub(super) fn notes_by_dataset<'a>(
    record: &ComparisonRecord,
    notes: impl IntoIterator<Item = (usize, &'a String)>,
) -> Vec<String> {
    let mut lines: Vec<(&String, Vec<usize>)> = Vec::new();
    for (dataset, note) in notes {
        match lines.iter_mut().find(|(known, _)| *known == note) {
            Some((_, datasets)) if datasets.contains(&dataset) => {}
            Some((_, datasets)) => datasets.push(dataset),
            None => lines.push((note, vec![dataset])),
        }
    }
    let all = record.datasets.len();
    let line = |(note, datasets): (&String, Vec<usize>)| {
        let names: Vec<&str> = datasets
            .iter()
            .map(|&d| record.datasets[d].name.as_str())
            .collect();
        match datasets.len() == all {
            true => note.clone(),
            false => format!("{}: {note}", names.join(", ")),
        }
    };
    lines.into_iter().map(line).collect()
}
