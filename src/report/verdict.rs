//! The verdict on a file of responses as tables.

use super::{Cell, Table};
use crate::score::{AtDistance, Verdict};

/// The tables of a verdict: one of all rows and, where the file has distances, one with a row a distance.
pub fn verdict_tables(verdict: &Verdict) -> Vec<Table> {
    let mut tables = vec![overall(verdict)];
    tables.extend(verdict.by_distance.as_deref().map(by_distance));
    tables
}

/// The verdict in a sentence: U with its null and its interval.
pub fn verdict_in_words(verdict: &Verdict) -> String {
    let overall = &verdict.overall;
    let Some(coefficient) = overall.uncertainty_coefficient else {
        return "All rows have one location: there is nothing to tell about it.".into();
    };
    let mut words = format!(
        "The responses take away {:.1} % of what is unknown of the location (U(L|R) = {coefficient:.3}, {} rows)",
        100.0 * coefficient,
        overall.n
    );
    if let Some(corrected) = overall.uncertainty_coefficient_corrected {
        words += &format!("; corrected for chance U = {corrected:.3}");
    }
    if let Some([low, high]) = overall.ci95 {
        words += &format!(", 95 % interval {low:.3} to {high:.3}");
    }
    if let Some(p) = overall.permutation_p {
        words += &match p < 0.001 {
            true => "; paired at random, as much is rarer than p = 0.001".to_string(),
            false => format!("; paired at random, as much comes with p = {p:.3}"),
        };
    }
    words + "."
}

fn overall(verdict: &Verdict) -> Table {
    let overall = &verdict.overall;
    let mut table = Table::new(["quantity", "value"]);
    let mut row = |name: &str, cell| table.row([Cell::Text(name.into()), cell]);
    row("n", Cell::Count(overall.n as u64));
    row("locations", Cell::Count(overall.locations as u64));
    row("responses", Cell::Count(overall.responses as u64));
    row(
        "entropy_of_location H(L) (nats)",
        Cell::Number(overall.entropy_of_location, 6),
    );
    row(
        "entropy_of_location_given_response H(L|R) (nats)",
        Cell::Number(overall.entropy_of_location_given_response, 6),
    );
    row(
        "uncertainty_coefficient U(L|R)",
        Cell::number(overall.uncertainty_coefficient, 6),
    );
    row(
        "uncertainty_coefficient_corrected",
        Cell::number(overall.uncertainty_coefficient_corrected, 6),
    );
    row("permutation_p", Cell::number(overall.permutation_p, 6));
    row(
        "ci95 low (of the corrected, bootstrap)",
        Cell::number(overall.ci95.map(|c| c[0]), 6),
    );
    row("ci95 high", Cell::number(overall.ci95.map(|c| c[1]), 6));
    let over = verdict.ci95_over;
    table.caption(format!(
        "natural logarithm; {} permutations, {} bootstrap resamples over {over}, seed {}",
        verdict.permutations, verdict.bootstrap, verdict.seed
    ));
    verdict
        .notes
        .iter()
        .for_each(|note| table.caption(format!("note: {note}")));
    table
}

fn by_distance(rows: &[AtDistance]) -> Table {
    let mut table = Table::new([
        "distance (m)",
        "n",
        "H(L|R) (nats)",
        "U(L|R)",
        "U(L|R), corrected",
        "95 % interval of the corrected, low",
        "high",
        "permutation p",
    ]);
    for AtDistance {
        distance_m,
        judgement,
    } in rows
    {
        table.row([
            Cell::Number(*distance_m, 3),
            Cell::Count(judgement.n as u64),
            Cell::Number(judgement.entropy_of_location_given_response, 4),
            Cell::number(judgement.uncertainty_coefficient, 4),
            Cell::number(judgement.uncertainty_coefficient_corrected, 4),
            Cell::number(judgement.ci95.map(|c| c[0]), 4),
            Cell::number(judgement.ci95.map(|c| c[1]), 4),
            Cell::number(judgement.permutation_p, 4),
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        score::{Effort, Responses},
        seed::Seed,
    };

    fn verdict(location: [&str; 4], distance_m: Option<[f64; 4]>) -> Verdict {
        let labels = |all: [&str; 4]| all.map(String::from).to_vec();
        let (response, distance_m) = (labels(["1", "1", "2", "2"]), distance_m.map(Vec::from));
        let responses = Responses::new(labels(location), response, None, distance_m).unwrap();
        Verdict::new(&responses, Effort::default(), Seed(1))
    }

    #[test]
    fn one_location_leaves_nothing_to_tell() {
        let one = verdict_in_words(&verdict(["hall"; 4], None));
        assert!(one.contains("nothing to tell"), "{one}");
        let two = verdict_in_words(&verdict(["hall", "hall", "door", "door"], None));
        assert!(two.contains("100.0 %") && two.contains("4 rows"), "{two}");
    }

    #[test]
    fn distances_have_a_row_each() {
        let verdict = verdict(["hall", "door", "hall", "door"], Some([0.0, 0.0, 2.5, 2.5]));
        let tables = verdict_tables(&verdict);
        let text = tables[1].text();
        assert!(
            tables.len() == 2 && text.contains("0.000") && text.contains("2.500"),
            "{text}"
        );
    }
}
