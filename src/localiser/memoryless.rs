//! Any recogniser as a localiser: its response to the snapshot of now is where the robot is.
//!
//! The baseline that Duckett & Nehmzow (1998), 7.2, hold evidence-based localisation against, for all recognisers.

use super::{
    Learn, Localiser, TrialRunner,
    prepared::{Answers, Prepared},
};
use crate::{
    error::Result,
    recogniser::{self, Recogniser},
    recording::{Channel, Recording},
    seed::Seed,
};
use serde::{Deserialize, Serialize};

/// Which recogniser, and its constants.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MemorylessConfig {
    /// `{ kind = "rce", radius = 0.9 }`; none named: the nearest neighbour.
    pub recogniser: recogniser::Config,
}

impl Default for MemorylessConfig {
    fn default() -> Self {
        Self {
            recogniser: recogniser::Kind::Nearest.default_config(),
        }
    }
}

impl MemorylessConfig {
    /// # Errors
    /// A usage error where a constant of the recogniser makes no sense; the message names its key.
    pub fn check(&self) -> Result<()> {
        self.recogniser.check()
    }
}

/// A recogniser that has learned.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Memoryless {
    recogniser: recogniser::Learned,
}

impl Memoryless {
    /// The recogniser.
    pub fn recogniser(&self) -> &dyn Recogniser {
        self.recogniser.as_recogniser()
    }
}

impl From<recogniser::Learned> for Memoryless {
    fn from(recogniser: recogniser::Learned) -> Self {
        Self { recogniser }
    }
}

impl Localiser for Memoryless {
    fn name(&self) -> &'static str {
        "memoryless"
    }

    /// Different responses that the recogniser can give.
    fn places(&self) -> usize {
        self.recogniser().responses()
    }

    /// Not known: recognisers keep what they like.
    fn bytes_per_place(&self) -> usize {
        self.recogniser().bytes_per_place()
    }

    fn check_channels(&self, channels: &[Channel]) -> Result<()> {
        self.recogniser().check_channels(channels)
    }

    fn prepare<'a>(
        &'a self,
        recording: &'a Recording,
        snapshots: &[usize],
    ) -> Result<Box<dyn TrialRunner + 'a>> {
        prepared(self.recogniser(), recording, snapshots)
    }
}

/// Its responses to these snapshots, as answers of a localiser.
fn prepared(
    recogniser: &dyn Recogniser,
    recording: &Recording,
    snapshots: &[usize],
) -> Result<Box<dyn TrialRunner>> {
    recogniser.check_channels(recording.channels())?;
    let responses = recogniser.respond_all(recording, snapshots);
    let classes = responses.into_iter().map(|r| r.map(|r| r.class)).collect();
    Ok(Box::new(Answers(Prepared::new(snapshots, classes))))
}

/// The same of any recogniser that has learned, also one of another crate.
pub struct AsLocaliser(pub Box<dyn Recogniser>);

impl Localiser for AsLocaliser {
    fn name(&self) -> &str {
        self.0.name()
    }

    fn places(&self) -> usize {
        self.0.responses()
    }

    fn bytes_per_place(&self) -> usize {
        self.0.bytes_per_place()
    }

    fn check_channels(&self, channels: &[Channel]) -> Result<()> {
        self.0.check_channels(channels)
    }

    fn prepare<'a>(
        &'a self,
        recording: &'a Recording,
        snapshots: &[usize],
    ) -> Result<Box<dyn TrialRunner + 'a>> {
        prepared(self.0.as_ref(), recording, snapshots)
    }
}

impl Learn for Memoryless {
    type Config = MemorylessConfig;

    fn learn(
        config: &MemorylessConfig,
        recording: &Recording,
        snapshots: &[usize],
        seed: Seed,
    ) -> Result<Self> {
        recogniser::learn(&config.recogniser, recording, snapshots, seed).map(Self::from)
    }

    fn check(&self) -> Result<()> {
        self.recogniser.check()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::localiser::Estimate;
    use crate::recogniser::{Kind, test_world::test_world};

    #[test]
    fn it_answers_what_its_recogniser_does() {
        let (room, first): (_, Vec<usize>) = (test_world(), (0..104).collect());
        for &kind in Kind::ALL.iter().filter(|kind| **kind != Kind::Ball) {
            let recogniser = kind.default_config();
            let config = MemorylessConfig { recogniser };
            let memoryless = Memoryless::learn(&config, &room, &first, Seed(2)).unwrap();
            let player = memoryless.prepare(&room, &[150, 120, 121]).unwrap();
            let mut stream = Seed(1).stream("not drawn from");
            let steps = player.play(&[120, 121, 150], None, &mut stream).unwrap();
            let alone = memoryless.recogniser().respond_all(&room, &[120, 121, 150]);
            let alone = alone.iter().map(|r| r.map(|r| Estimate::Class(r.class)));
            assert!(steps.iter().map(|step| step.estimate).eq(alone), "{kind}");
            let error = player.play(&[119], None, &mut stream).unwrap_err();
            assert!(error.to_string().contains("snapshot 119"), "{error}");
        }
    }

    #[test]
    fn a_recogniser_is_named_by_its_kind() {
        let text = "kind = 'memoryless'\nrecogniser = { kind = 'rce', radius = 2.5 }";
        let config: crate::localiser::Config = toml::from_str(text).unwrap();
        let error = config.check().unwrap_err();
        assert!(error.is_usage() && error.to_string().starts_with("rce.radius"));
    }
}
