//! The poses of a run that are compared.

use crate::geometry::Pose;

/// The poses of a run that were compared, seen from above, each with its stamp.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RunTraces {
    /// Stamps of the reference; none where poses were paired in order.
    pub stamp_s: Option<Vec<f64>>,
    /// RP: the real poses.
    pub real: Vec<Pose>,
    /// PEpost: the estimates, moved onto the reference.
    pub posterior: Vec<Pose>,
    /// PEprio: the estimates before correction, likewise; none where they are not known.
    pub prior: Vec<Option<Pose>>,
}

impl RunTraces {
    /// Real, prior and posterior poses where all three are known.
    pub(super) fn with_prior(&self) -> [Vec<Pose>; 3] {
        let mut all: [Vec<Pose>; 3] = Default::default();
        for (k, prior) in self.prior.iter().enumerate() {
            if let Some(prior) = prior {
                let poses = [self.real[k], *prior, self.posterior[k]];
                all.iter_mut()
                    .zip(poses)
                    .for_each(|(trace, pose)| trace.push(pose));
            }
        }
        all
    }
}
