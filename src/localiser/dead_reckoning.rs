//! Uncorrected dead reckoning: from the true start of the trial it adds up what odometry says.

use super::{Estimate, Learn, Localiser, Step, TrialRunner};
use crate::{
    error::Result,
    geometry::Pose,
    recording::{Channel, Recording},
    seed::{Seed, Stream},
};
use serde::{Deserialize, Serialize};

/// Dead reckoning has no constants.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DeadReckoningConfig {}

impl DeadReckoningConfig {
    /// # Errors
    /// Never.
    pub fn check(&self) -> Result<()> {
        Ok(())
    }
}

/// "Position and orientation offsets from the initialised values at the start of the trial", applied to the recording's raw
/// odometry (Duckett & Nehmzow 1998, 7.1).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DeadReckoning {}

struct Reckoner<'a>(&'a Recording);

impl TrialRunner for Reckoner<'_> {
    /// Without a start it has nothing to add to, and no answer.
    fn play(&self, trial: &[usize], start: Option<Pose>, _: &mut Stream) -> Result<Vec<Step>> {
        let odometry = |k: usize| self.0.observation(k).odometry;
        let reckoned = |&k: &usize| {
            let pose =
                start.map(|start| start.after(odometry(trial[0]).displacement_to(&odometry(k))));
            Step {
                estimate: pose.map(|pose| Estimate::Place([pose.x_m, pose.y_m])),
                heading_rad: pose.map(|pose| pose.heading_rad),
                ..Step::default()
            }
        };
        Ok(trial.iter().map(reckoned).collect())
    }
}

impl Localiser for DeadReckoning {
    fn name(&self) -> &'static str {
        "dead_reckoning"
    }

    fn places(&self) -> usize {
        0
    }

    fn bytes_per_place(&self) -> usize {
        0
    }

    fn asks_for_the_start(&self) -> bool {
        true
    }

    fn is_blind(&self) -> bool {
        true
    }

    fn check_channels(&self, _: &[Channel]) -> Result<()> {
        Ok(())
    }

    fn prepare<'a>(
        &'a self,
        recording: &'a Recording,
        _: &[usize],
    ) -> Result<Box<dyn TrialRunner + 'a>> {
        Ok(Box::new(Reckoner(recording)))
    }
}

impl Learn for DeadReckoning {
    type Config = DeadReckoningConfig;

    fn learn(_: &DeadReckoningConfig, _: &Recording, _: &[usize], _: Seed) -> Result<Self> {
        Ok(Self {})
    }

    fn check(&self) -> Result<()> {
        Ok(())
    }
}
