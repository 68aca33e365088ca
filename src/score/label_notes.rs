//! Labels that may not mean what they are counted as: values that stand for none, and one number written in two ways.

use std::collections::{BTreeMap, BTreeSet};

/// How programs write that there is no value.
const NO_VALUE: [&str; 8] = ["nan", "na", "n/a", "<na>", "nat", "null", "#n/a", "missing"];
/// Letters of a label that a note quotes.
const SHOWN: usize = 20;

/// Notes on the labels of one column, whose name stands in them; `kind` is what each label counts as.
pub(super) fn of(labels: &[String], column: &str, kind: &str) -> Vec<String> {
    let mut notes = Vec::new();
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for label in labels {
        *counts.entry(label).or_default() += 1;
    }
    for (label, n) in &counts {
        if NO_VALUE.contains(&label.to_lowercase().as_str()) {
            let rows = if *n == 1 { "row has" } else { "rows have" };
            notes.push(format!(
                "{n} {rows} the {column} `{label}`, counted as {kind} of its own; leave out rows where it means that there is none"
            ));
        }
    }
    let mut spellings: BTreeMap<u64, BTreeSet<&str>> = BTreeMap::new();
    for label in counts.keys() {
        if let Some(number) = label.parse::<f64>().ok().filter(|n| n.is_finite()) {
            // −0 and 0 are one number.
            spellings
                .entry((number + 0.0).to_bits())
                .or_default()
                .insert(label);
        }
    }
    let several = spellings.values().filter(|all| all.len() > 1);
    let n = several.clone().count();
    if let Some(example) = several.clone().next() {
        let shown = example.iter().take(2).map(|label| {
            let cut: String = label.chars().take(SHOWN).collect();
            format!("`{cut}`")
        });
        let shown: Vec<String> = shown.collect();
        let numbers = if n == 1 {
            "1 number is"
        } else {
            &format!("{n} numbers are")
        };
        notes.push(format!(
            "{numbers} written in more than one way among the {column}s, such as {}, and count as different labels",
            shown.join(" and ")
        ));
    }
    notes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn notes(labels: &[&str]) -> Vec<String> {
        let labels: Vec<String> = labels.iter().map(|label| label.to_string()).collect();
        of(&labels, "location", "a place")
    }

    #[test]
    fn what_stands_for_no_value_is_noted() {
        assert!(notes(&["hall", "none", "1", "2.5", "nave"]).is_empty());
        let said = notes(&["NaN", "hall", "NaN", "NA"]);
        assert!(said[0].starts_with("1 row has the location `NA`"));
        assert!(said[1].starts_with("2 rows have the location `NaN`, counted as a place"));
    }

    #[test]
    fn one_number_written_in_two_ways_is_noted() {
        let said = notes(&["3", "3.0", "4", "-0", "0", "1e1", "x"]);
        assert_eq!(said.len(), 1);
        assert!(
            said[0].starts_with("2 numbers are written in more than one way")
                && said[0].contains("`-0` and `0`")
        );
        assert!(notes(&["3", "3.0"])[0].starts_with("1 number is"));
    }
}
