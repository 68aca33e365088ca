//! What became of everything a log held: used, passed over, odd, or lost.

use std::collections::BTreeMap;

/// Damaged records named one by one; the rest is only counted, so that a broken log of a million lines stays readable.
const NAMED: usize = 5;

/// Different message names kept apart; what comes after is counted as `others`, so that a binary file can't fill the
/// memory with names.
const KINDS: usize = 64;

/// The books of an import: nothing that a log holds disappears without an entry.
///
/// ```
/// use ballmark::recording::import_report::ImportReport;
/// let mut account = ImportReport::default();
/// account.passed_over("NEFF");
/// account.lost("line 7: `FLASER` ends after 12 of 180 readings".into());
/// assert_eq!(account.lost_count(), 1);
/// assert_eq!(account.passed_over_counts()["NEFF"], 1);
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ImportReport {
    used: BTreeMap<String, usize>,
    passed_over: BTreeMap<String, usize>,
    warnings: BTreeMap<String, usize>,
    lost: usize,
    lost_records: Vec<String>,
    notes: Vec<String>,
}

impl ImportReport {
    /// A message that became part of the recording.
    pub fn used(&mut self, kind: &str) {
        count(&mut self.used, kind, 1);
    }

    /// A message that nothing here needs.
    pub fn passed_over(&mut self, kind: &str) {
        count(&mut self.passed_over, kind, 1);
    }

    /// Something odd that cost no data, such as a time stamp that runs backwards.
    pub fn warning(&mut self, what: &str) {
        count(&mut self.warnings, what, 1);
    }

    /// Something that the user should know about the log as a whole, in a sentence.
    pub fn note(&mut self, what: String) {
        if self.notes.len() < KINDS && !self.notes.contains(&what) {
            self.notes.push(what);
        }
    }

    /// Records after the one at fault that were lost with it, without a name of their own.
    pub fn lost_with_it(&mut self, records: usize) {
        self.lost += records;
    }

    /// A record that had to be dropped: where it stood, its fault and what was expected.
    pub fn lost(&mut self, record: String) {
        self.lost += 1;
        if self.lost_records.len() < NAMED {
            self.lost_records.push(record);
        }
    }

    /// Messages used, by kind.
    pub fn used_counts(&self) -> &BTreeMap<String, usize> {
        &self.used
    }

    /// Messages passed over, by kind.
    pub fn passed_over_counts(&self) -> &BTreeMap<String, usize> {
        &self.passed_over
    }

    /// Oddities, by what they are.
    pub fn warning_counts(&self) -> &BTreeMap<String, usize> {
        &self.warnings
    }

    /// Number of records dropped.
    pub fn lost_count(&self) -> usize {
        self.lost
    }

    /// The first few of the records dropped.
    pub fn lost_records(&self) -> &[String] {
        &self.lost_records
    }

    /// Sentences about the log as a whole.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Adds the books of another log, whose name is put before its lost records.
    pub fn add(&mut self, log: &str, other: &ImportReport) {
        for (mine, theirs) in [
            (&mut self.used, &other.used),
            (&mut self.passed_over, &other.passed_over),
            (&mut self.warnings, &other.warnings),
        ] {
            for (kind, n) in theirs {
                count(mine, kind, *n);
            }
        }
        for note in &other.notes {
            self.note(format!("{log}: {note}"));
        }
        self.lost += other.lost;
        let room = NAMED.saturating_sub(self.lost_records.len());
        let named = other.lost_records.iter().take(room);
        self.lost_records
            .extend(named.map(|record| format!("{log}: {record}")));
    }
}

fn count(counts: &mut BTreeMap<String, usize>, kind: &str, n: usize) {
    if let Some(known) = counts.get_mut(kind) {
        *known += n;
    } else if counts.len() < KINDS {
        counts.insert(kind.to_string(), n);
    } else {
        *counts.entry("others".to_string()).or_default() += n;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_faults_are_counted_but_only_the_first_named() {
        let mut account = ImportReport::default();
        for line in 0..100 {
            account.lost(format!("line {line}"));
        }
        assert_eq!(
            (account.lost_count(), account.lost_records().len()),
            (100, NAMED)
        );
        let mut all = ImportReport::default();
        all.add("walk.log", &account);
        assert_eq!(all.lost_count(), 100);
        assert_eq!(all.lost_records()[0], "walk.log: line 0");
    }

    #[test]
    fn endless_new_names_do_not_fill_the_memory() {
        let mut account = ImportReport::default();
        for kind in 0..1000 {
            account.passed_over(&kind.to_string());
        }
        assert_eq!(account.passed_over_counts().len(), KINDS + 1);
        assert_eq!(account.passed_over_counts().values().sum::<usize>(), 1000);
    }
}
