//! Somebody else's program as one of the localisers here: it is run for every trial that anybody plays.

use super::{
    answers,
    command::{self, Asked},
    config::ExternalConfig,
    trial_files::{Start, observed, times},
};
use crate::{
    error::{Error, Result},
    geometry::Pose,
    localiser::{Localiser, Step, TrialRunner},
    recording::{Channel, Recording},
    seed::Stream,
};
use rand::RngExt;

/// A command that answers trials, such as those of the standard experiment. It keeps no places that anybody knows of.
#[derive(Debug)]
pub struct CommandLocaliser {
    config: ExternalConfig,
}

impl CommandLocaliser {
    /// By a configuration with a command; none where its answers were given beforehand, to other trials.
    pub fn new(config: &ExternalConfig) -> Option<Self> {
        (!config.command.is_empty()).then(|| Self {
            config: config.clone(),
        })
    }
}

impl Localiser for CommandLocaliser {
    fn name(&self) -> &str {
        "external"
    }

    fn places(&self) -> usize {
        0
    }

    fn bytes_per_place(&self) -> usize {
        0
    }

    fn check_channels(&self, _: &[Channel]) -> Result<()> {
        Ok(()) // it is given what there is
    }

    fn prepare<'a>(
        &'a self,
        recording: &'a Recording,
        _: &[usize],
    ) -> Result<Box<dyn TrialRunner + 'a>> {
        Ok(Box::new(Runner {
            config: &self.config,
            recording,
        }))
    }
}

struct Runner<'a> {
    config: &'a ExternalConfig,
    recording: &'a Recording,
}

impl TrialRunner for Runner<'_> {
    fn play(&self, trial: &[usize], start: Option<Pose>, stream: &mut Stream) -> Result<Vec<Step>> {
        let folder = tempfile::tempdir()
            .map_err(|e| Error::io("cannot make a temporary folder", std::env::temp_dir(), e))?;
        let asked = Asked {
            name: "trial",
            start: match start {
                Some(_) => Start::Known,
                None => Start::Unknown,
            },
            pose: start.unwrap_or_default(),
            observed: &observed(self.recording, trial)?,
            seed: u64::from(stream.random::<u32>()), // as large as programs take
        };
        command::answer(self.config, &asked, folder.path())?;
        let times_s = times(self.recording, trial);
        answers::read(folder.path(), asked.name, &times_s, self.config)
    }
}
