//! The trials of a comparison for somebody else's localiser, and what it may map.

use super::{CompareConfig, dataset::LoadedDataset};
use crate::{
    error::{Error, Result},
    experiment::{
        external::{Start, names, observed},
        mapped::Mapped,
        methods::MethodContext,
        parts::Parts,
        sequences::drawn,
    },
    geometry::Pose,
    recording::{Recording, degraded::Degraded},
};
use std::path::Path;

/// A trial as it is given away.
#[derive(Debug, Clone)]
pub struct TrialOfSet {
    /// Its name in files.
    pub name: String,
    /// How it starts.
    pub start: Start,
    /// The pose that it starts at, where that is known.
    pub pose: Option<Pose>,
    /// What may be seen of it.
    pub observed: Recording,
}

/// All that somebody else needs to play the trials of `[localisation]` on one dataset, and nothing of the truth.
#[derive(Debug, Clone)]
pub struct TrialSet {
    /// What may be mapped, with its poses.
    pub mapping: Recording,
    /// The trials, by their names: those from anywhere first.
    pub trials: Vec<TrialOfSet>,
    /// What holds for them.
    pub notes: Vec<String>,
}

impl TrialSet {
    /// The trials of a comparison's first dataset, the very ones that its systems play.
    ///
    /// # Errors
    /// Where the dataset can't be read, the protocol can't be applied to it, or there is room for no trial.
    pub fn new(config: &CompareConfig, folder: &Path, starts: &[Start]) -> Result<Self> {
        let Some(dataset) = config.dataset.first() else {
            return Err(Error::usage("no [[dataset]]; expected one"));
        };
        let loaded = LoadedDataset::open(dataset, folder, config.seed, &config.degraded)?;
        let protocol = loaded.protocol(config)?;
        let parts = Parts::of_protocol(&protocol);
        let trials = config.trials().beside(folder);
        // Those of [degraded] are there already.
        let people = match config.degraded.people {
            Some(_) => 0.0,
            None => trials.people(),
        };
        let crowded = parts.disturbed(people, &Degraded::default(), trials.seed())?;
        let parts = match &crowded {
            Some(crowded) => parts.with_run(crowded),
            None => parts,
        };
        let source = parts.source.as_ref();
        let source =
            source.ok_or_else(|| Error::work("nothing to map; expected a mapping part"))?;
        let context = MethodContext::over(Mapped::of(source), &parts, &trials)?;
        let drawn = drawn(&context)?;
        let mut all = Vec::new();
        for &start in starts {
            for (name, trial) in names(start, drawn.len(), context.seed())
                .into_iter()
                .zip(&drawn)
            {
                let first = parts.run.poses()[trial.snapshots[0]];
                all.push(TrialOfSet {
                    name,
                    start,
                    pose: (start == Start::Known).then_some(first),
                    observed: observed(parts.run, &trial.snapshots)?,
                });
            }
        }
        all.sort_by(|a, b| (a.start, &a.name).cmp(&(b.start, &b.name)));
        let mut notes = loaded.notes.clone();
        notes.extend(protocol.notes.iter().cloned());
        Ok(Self {
            mapping: protocol.recording.select(&protocol.mapping)?,
            trials: all,
            notes,
        })
    }
}
