//! Tables and pictures by name, and a whole comparison, as parts of a page.

use super::{Picture, Reader, Sheet, localisation, pictures, sheets};
use crate::{
    error::Result,
    experiment::compare::Comparison,
    report::{
        Part,
        localisation::{belief_parts, page_summary},
    },
};

/// Longest table for programs that a page has, folded away.
const LONGEST: usize = 80;

/// What came of localisation trials in words, a dataset after the other; nothing where there were none.
pub fn comparison_summary(comparison: &Comparison) -> Vec<String> {
    let record = &comparison.record;
    let all = localisation::records(record);
    let several = all.len() > 1;
    let of_dataset = |(dataset, _, localised): (usize, String, _)| {
        let name = &record.datasets[dataset].name;
        let lines = page_summary(localised).into_iter();
        let named = move |line| match several {
            true => format!("{name}: {line}"),
            false => line,
        };
        lines.map(named).collect::<Vec<_>>()
    };
    all.into_iter().flat_map(of_dataset).collect()
}

/// All tables and pictures of a comparison, and the beliefs that were kept; what holds for all tables stands in `captions`.
///
/// # Errors
/// None with a record that was made by an experiment.
pub fn comparison_parts(comparison: &Comparison, captions: &[String]) -> Result<Vec<Part>> {
    let mut parts = sheet_parts(&sheets(comparison), pictures(comparison)?, captions);
    let record = &comparison.record;
    for (dataset, _, localised) in localisation::records(record) {
        let name = &record.datasets[dataset].name;
        let beliefs = belief_parts(name, localised)?;
        parts.extend(beliefs.into_iter().map(|part| match part {
            Part::Heading(words) => Part::Heading(format!("{words}: {name}")),
            part => part,
        }));
    }
    Ok(parts)
}

/// Tables for readers, then pictures, then tables for programs that are short enough, folded away.
pub fn sheet_parts(sheets: &[Sheet], pictures: Vec<Picture>, captions: &[String]) -> Vec<Part> {
    let mut parts = vec![Part::Heading("Tables".into())];
    let shown = sheets
        .iter()
        .filter(|sheet| sheet.reader == Reader::Everyone);
    parts.extend(shown.map(|sheet| Part::table(&sheet.title, sheet.table.clone())));
    parts.extend(captions.iter().cloned().map(Part::Words));
    if !pictures.is_empty() {
        parts.push(Part::Heading("Pictures".into()));
    }
    parts.extend(pictures.into_iter().map(|(name, svg)| {
        let words = caption(&name);
        let alt = format!("{words}. The figures are in the tables");
        Part::picture(format!("{words}."), alt, svg)
    }));
    let others = sheets.iter().filter(|sheet| match sheet.reader {
        Reader::Everyone => false,
        Reader::Documents => true,
        Reader::Programs => sheet.table.len() <= LONGEST,
    });
    let others: Vec<Part> = others
        .map(|sheet| Part::folded(&sheet.title, sheet.table.clone()))
        .collect();
    if !others.is_empty() {
        parts.push(Part::Heading("More figures".into()));
        parts.extend(others);
    }
    parts
}

/// What pictures show, by the beginning of their names.
const CAPTIONS: [(&str, &str); 14] = [
    (
        "standard",
        "How much the answers tell about the place, U(L|R), against the metres travelled since the start of a trial",
    ),
    (
        "contingency",
        "Where each answer was given: a row a bin of the true place, a column an answer; the darker, the larger the share of that answer",
    ),
    (
        "error-by-distance",
        "Mean expected error against the metres travelled from a start anywhere; bands are 95 % intervals",
    ),
    (
        "found-by-distance",
        "Share of all trials that are found by the metres travelled from a start anywhere; bands are 95 % intervals",
    ),
    (
        "tracking-error",
        "Mean expected error against the metres travelled from a known start; bands are 95 % intervals",
    ),
    (
        "risk-coverage",
        "Point error at the trials' end against the share of trials that are rejected for lack of confidence",
    ),
    (
        "quality-against-cost",
        "Quality against cost (Duckett & Nehmzow 2000, Fig. 6): the further up and left, the better",
    ),
    (
        "error-reduction",
        "Share of the prior error that one snapshot takes away, against the prior uncertainty",
    ),
    ("figure_3", "Fig. 3 of the paper, here"),
    ("figure_4", "Fig. 4 of the paper, here"),
    (
        "figure_5",
        "Fig. 5 of the paper, here: the belief at some instants of a trial",
    ),
    ("figure_6", "Fig. 6 of the paper, here"),
    (
        "figure_7",
        "Fig. 7 of the paper, here: the output of one filter along the route",
    ),
    (
        "figure_8",
        "Fig. 8 of the paper, here: the outputs of several filters along the route",
    ),
];

fn caption(name: &str) -> String {
    let known = CAPTIONS.iter().find(|(start, _)| name.starts_with(start));
    match known {
        Some((start, words)) => match name[start.len()..].trim_start_matches(['-', '_']) {
            "" => (*words).to_string(),
            of => format!("{words} ({of})"),
        },
        None => name.replace(['-', '_'], " "),
    }
}
