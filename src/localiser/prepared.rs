//! What single snapshots say, worked out once for a recording and looked up by the snapshot's number: for localisers whose
//! answers, or parts of them, do not depend on the trial.

use super::{Estimate, Step, TrialRunner};
use crate::{
    error::{Error, Result},
    geometry::Pose,
    seed::Stream,
};

/// One value for each of some snapshots of a recording.
///
/// ```
/// use ballmark::localiser::prepared::Prepared;
/// let prepared = Prepared::new(&[30, 7], vec!["door", "hall"]);
/// assert_eq!(prepared.get(7)?, &"hall");
/// assert!(prepared.get(8).is_err());
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Prepared<T> {
    /// Snapshot and value, in rising order of the snapshots.
    values: Vec<(usize, T)>,
}

impl<T> Prepared<T> {
    /// From snapshots in any order and their values; of a snapshot given twice either value will do, they are the same.
    pub fn new(snapshots: &[usize], values: Vec<T>) -> Self {
        let mut values: Vec<(usize, T)> = snapshots.iter().copied().zip(values).collect();
        values.sort_by_key(|(snapshot, _)| *snapshot);
        Self { values }
    }

    /// The value of a snapshot.
    ///
    /// # Errors
    /// Where nothing was prepared for that snapshot.
    pub fn get(&self, snapshot: usize) -> Result<&T> {
        let found = self.values.binary_search_by_key(&snapshot, |(k, _)| *k);
        match found {
            Ok(at) => Ok(&self.values[at].1),
            Err(_) => Err(Error::work(format!(
                "snapshot {snapshot} of a trial: not among those prepared"
            ))),
        }
    }
}

/// A player whose answer to a snapshot is always the same class, whatever the trial.
#[derive(Debug, Clone)]
pub struct Answers(pub Prepared<Option<usize>>);

impl TrialRunner for Answers {
    fn play(&self, trial: &[usize], _: Option<Pose>, _: &mut Stream) -> Result<Vec<Step>> {
        let step = |&k: &usize| {
            Ok(Step {
                estimate: self.0.get(k)?.map(Estimate::Class),
                ..Step::default()
            })
        };
        trial.iter().map(step).collect()
    }
}
