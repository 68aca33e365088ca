//! What single snapshots tell, worked out once and looked up by the snapshot's number.

use super::{Estimate, Player, Step};
use crate::{
    error::{Error, Result},
    geometry::Pose,
    seed::Stream,
};

/// One value for each of some snapshots of a recording.
pub(super) struct Prepared<T> {
    /// Snapshot and value, in rising order of the snapshots.
    of: Vec<(usize, T)>,
}

impl<T> Prepared<T> {
    /// From snapshots in any order and their values; of a snapshot given twice either value will do, they are the same.
    pub fn new(snapshots: &[usize], values: Vec<T>) -> Self {
        let mut of: Vec<(usize, T)> = snapshots.iter().copied().zip(values).collect();
        of.sort_by_key(|(snapshot, _)| *snapshot);
        Self { of }
    }

    /// # Errors
    /// Where nothing was prepared for that snapshot.
    pub fn of(&self, snapshot: usize) -> Result<&T> {
        let found = self.of.binary_search_by_key(&snapshot, |(k, _)| *k);
        match found {
            Ok(at) => Ok(&self.of[at].1),
            Err(_) => Err(Error::work(format!(
                "snapshot {snapshot} of a trial: not among those prepared"
            ))),
        }
    }
}

/// The answer to each snapshot by itself, whatever the trial.
pub(super) struct Answers(pub Prepared<Option<usize>>);

impl Player for Answers {
    fn play(&self, trial: &[usize], _: Option<Pose>, _: &mut Stream) -> Result<Vec<Step>> {
        let step = |&k: &usize| {
            Ok(Step {
                estimate: self.0.of(k)?.map(Estimate::Class),
                posterior: Vec::new(),
            })
        };
        trial.iter().map(step).collect()
    }
}
