//! Beliefs of a comparison, which stand in a file of their own beside the record.

use super::{Comparison, Outcome};
use crate::experiment::belief_traces::BeliefTraces;

impl Comparison {
    /// What was kept of beliefs, one entry a dataset.
    pub fn beliefs(&self) -> Vec<Option<&BeliefTraces>> {
        let section = self.record.localisation.as_ref();
        let records = section.map_or(&[][..], |section| &section.records);
        let done = records.iter().map(Outcome::done);
        done.map(|record| record?.beliefs.as_ref()).collect()
    }

    /// Puts them back into a record that was read without them.
    ///
    /// # Errors
    /// Where they are not those of this comparison, in words.
    pub fn set_beliefs(&mut self, all: Vec<Option<BeliefTraces>>) -> Result<(), String> {
        let section = self.record.localisation.as_mut();
        let records = section.map_or(&mut [][..], |section| &mut section.records);
        if records.len() != all.len() {
            let (count, datasets) = (all.len(), records.len());
            return Err(format!(
                "beliefs of {count} datasets; the record has {datasets}"
            ));
        }
        for (outcome, beliefs) in records.iter_mut().zip(all) {
            let (Outcome::Done(record), Some(beliefs)) = (outcome, beliefs) else {
                continue;
            };
            beliefs.check()?;
            let results = record.results.iter().map(|result| &result.name);
            if !results.eq(beliefs.systems.iter().map(|system| &system[0])) {
                return Err("beliefs of other systems than the record's".into());
            }
            record.beliefs = Some(beliefs);
        }
        Ok(())
    }
}
