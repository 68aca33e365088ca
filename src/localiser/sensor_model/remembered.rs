//! What a sensor model said, kept for as long as the same snapshots are played again and again.

use super::PreparedSensorModel;
use crate::{belief::Belief, error::Result, seed::Stream};
use std::{
    collections::HashMap,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

/// Values that a memory has room for by default: 100 MB.
const MOST_VALUES: usize = 12 << 20;

/// What a sensor model said of the snapshots of one recording, as long as there is room.
#[derive(Debug)]
pub struct Memory {
    most_values: usize,
    said: Mutex<Said>,
}

#[derive(Debug, Default)]
struct Said {
    of_snapshot: HashMap<usize, Arc<[f64]>>,
    values: usize,
}

impl Default for Memory {
    fn default() -> Self {
        Self::new(MOST_VALUES)
    }
}

impl Memory {
    /// With room for so many log-likelihoods, 8 bytes each.
    pub fn new(most_values: usize) -> Self {
        Self {
            most_values,
            said: Mutex::default(),
        }
    }

    fn of_snapshot(&self, snapshot: usize) -> Option<Arc<[f64]>> {
        self.said().of_snapshot.get(&snapshot).cloned()
    }

    fn keep(&self, snapshot: usize, answer: &[f64]) {
        let mut said = self.said();
        let is_new = !said.of_snapshot.contains_key(&snapshot); // two threads may have asked at once
        if is_new && said.values + answer.len() <= self.most_values {
            said.values += answer.len();
            said.of_snapshot.insert(snapshot, answer.into());
        }
    }

    fn said(&self) -> MutexGuard<'_, Said> {
        // Whoever panicked with the lock in hand had at most an answer less to show for it.
        self.said.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A sensor model that is asked once for each snapshot, however often that is played, as long as the answers find room in a [`Memory`]; one that
/// [depends on the belief](PreparedSensorModel::depends_on_belief) is asked every time. The answers are the same.
pub struct Remembered<'a> {
    model: &'a dyn PreparedSensorModel,
    memory: &'a Memory,
}

impl<'a> Remembered<'a> {
    /// `model`, with a memory that no other model over other cells, and none of another recording, has written to.
    pub fn new(model: &'a dyn PreparedSensorModel, memory: &'a Memory) -> Self {
        Self { model, memory }
    }
}

impl PreparedSensorModel for Remembered<'_> {
    fn log_likelihood(
        &self,
        snapshot: usize,
        belief: &Belief,
        stream: &mut Stream,
    ) -> Result<Vec<f64>> {
        if self.depends_on_belief() {
            return self.model.log_likelihood(snapshot, belief, stream);
        }
        let known = self.memory.of_snapshot(snapshot);
        if let Some(known) = known.filter(|known| known.len() == belief.mass().len()) {
            return Ok(known.to_vec());
        }
        let answer = self.model.log_likelihood(snapshot, belief, stream)?;
        self.memory.keep(snapshot, &answer);
        Ok(answer)
    }

    fn depends_on_belief(&self) -> bool {
        self.model.depends_on_belief()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{belief::Places, error::Error, seed::Seed};
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// Says the snapshot's number of every cell, and counts how often it is asked.
    struct Number {
        asked: AtomicUsize,
        depends: bool,
    }

    impl PreparedSensorModel for Number {
        fn log_likelihood(&self, k: usize, belief: &Belief, _: &mut Stream) -> Result<Vec<f64>> {
            self.asked.fetch_add(1, Ordering::Relaxed);
            match k {
                9 => Err(Error::work("not prepared")),
                k => Ok(vec![k as f64; belief.mass().len()]),
            }
        }

        fn depends_on_belief(&self) -> bool {
            self.depends
        }
    }

    fn belief(cells: usize) -> Belief {
        Belief::uniform(&Arc::new(Places::Route(vec![0.0; cells]))).unwrap()
    }

    fn asked(depends: bool, most_values: usize, snapshots: &[usize]) -> usize {
        let number = Number {
            asked: AtomicUsize::new(0),
            depends,
        };
        let memory = Memory::new(most_values);
        let remembered = Remembered::new(&number, &memory);
        for &k in snapshots {
            let stream = &mut Seed(0).stream("unused");
            let said = remembered.log_likelihood(k, &belief(3), stream).unwrap();
            assert_eq!(said, [k as f64; 3]);
        }
        number.asked.into_inner()
    }

    #[test]
    fn every_snapshot_is_asked_once_where_there_is_room_and_nothing_else_counts() {
        let snapshots = [5, 6, 5, 6, 7, 5];
        assert_eq!(asked(false, 100, &snapshots), 3);
        assert_eq!(asked(false, 6, &snapshots), 3); // 7 is seen once
        assert_eq!(asked(false, 5, &snapshots), 4); // 6 finds no room
        assert_eq!(asked(true, 100, &snapshots), 6);
    }

    #[test]
    fn faults_and_other_grids_are_not_answered_from_memory() {
        let number = Number {
            asked: AtomicUsize::new(0),
            depends: false,
        };
        let memory = Memory::new(100);
        let remembered = Remembered::new(&number, &memory);
        let say = |k, cells| {
            let stream = &mut Seed(0).stream("unused");
            remembered.log_likelihood(k, &belief(cells), stream)
        };
        assert!(say(9, 3).is_err() && say(9, 3).is_err());
        assert_eq!(say(1, 3).unwrap().len(), 3);
        assert_eq!(say(1, 4).unwrap().len(), 4);
    }
}
