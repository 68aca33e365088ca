//! How long work takes that nothing else disturbs.

use crate::error::{Error, Result};
use std::time::Instant;

/// Snapshots that are timed of many.
const TIMED_SNAPSHOTS: usize = 9;

/// Median milliseconds that `work` takes for a snapshot, alone and on one thread, over some of these spread evenly; 0 where
/// there are none.
///
/// # Errors
/// Where the work fails.
pub(super) fn ready_ms(
    snapshots: &[usize],
    work: impl Fn(usize) -> Result<()> + Sync,
) -> Result<f64> {
    let every = snapshots.len().div_ceil(TIMED_SNAPSHOTS).max(1);
    let some = || snapshots.iter().step_by(every);
    let timed = |&k: &usize| {
        let started = Instant::now();
        work(k)?;
        Ok(ms_since(started))
    };
    let times = on_one_thread(|| some().map(timed).collect::<Result<Vec<f64>>>())??;
    Ok(median(times).unwrap_or(0.0))
}

/// What parallel work there is in it is done by a single thread.
pub(super) fn on_one_thread<T: Send>(work: impl FnOnce() -> T + Send) -> Result<T> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let pool = pool.map_err(|e| Error::work(format!("a thread to time steps on: {e}")))?;
    Ok(pool.install(work))
}

pub(super) fn ms_since(started: Instant) -> f64 {
    started.elapsed().as_secs_f64() * 1e3
}

/// The upper one of the two in the middle, where there are two.
pub(super) fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::{sync::Mutex, thread::sleep, time::Duration};

    #[test]
    fn the_median_is_in_the_middle() {
        assert_eq!(median(vec![9.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(vec![4.0, 1.0]), Some(4.0));
        assert_eq!(median(vec![]), None);
    }

    #[test]
    fn some_snapshots_are_timed_on_one_thread() {
        let asked = Mutex::new(Vec::new());
        let snapshots: Vec<usize> = (100..120).collect();
        let ms = ready_ms(&snapshots, |k| {
            assert_eq!(rayon::current_num_threads(), 1);
            asked.lock().unwrap().push(k);
            // One is slow, which a median does not see; a mean would.
            sleep(Duration::from_millis(if k == 100 { 300 } else { 3 }));
            Ok(())
        });
        let ms = ms.unwrap();
        assert!((3.0..250.0).contains(&ms), "{ms}");
        let expected = [100, 103, 106, 109, 112, 115, 118];
        assert_eq!(asked.into_inner().unwrap(), expected);
        assert_eq!(ready_ms(&[], |_| Ok(())).unwrap(), 0.0);
        let failed = ready_ms(&snapshots, |_| Err(Error::work("no sensor")));
        assert_eq!(failed.unwrap_err().to_string(), "no sensor");
    }
}
