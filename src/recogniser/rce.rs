//! RCE: a snapshot belongs to the stored pattern it is nearest to, and whatever lies in no pattern's sphere is stored.
//!
//! Kurz, *Constructing maps for mobile robot navigation based on ultrasonic range data*, IEEE Trans. SMC-B 26(2) (1996), as
//! D00 uses it: normalised readings, compared by their dot product; "during training, a new pattern is created if the input
//! pattern fails to lie within a fixed sphere of any existing pattern". Spheres don't shrink and patterns don't move.

use super::{
    Learn, ReadyToMatch, Recogniser, Response, prototypes::Prototypes, signature::SignatureConfig,
};
use crate::{
    error::{Error, Result},
    recording::{Channel, Observation, Recording},
    seed::Seed,
};
use serde::{Deserialize, Serialize};

/// The one constant of RCE, and what it works from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RceConfig {
    /// What of a snapshot is looked at.
    pub signature: SignatureConfig,
    /// Radius r of the sphere round a pattern, as the distance of unit vectors: a·b ≥ 1 − r²/2 is inside. D00 sets it for
    /// the number of responses it wants and prints none; larger spheres make fewer patterns.
    pub radius: f64,
}

impl Default for RceConfig {
    fn default() -> Self {
        Self {
            signature: SignatureConfig::default(),
            radius: 0.6,
        }
    }
}

impl RceConfig {
    /// # Errors
    /// Where the radius is not in [0, 2], the distances of unit vectors.
    pub fn check(&self) -> Result<()> {
        match (0.0..=2.0).contains(&self.radius) {
            true => Ok(()),
            false => Err(Error::usage(format!(
                "rce.radius = {}: expected 0 to 2, a distance between unit vectors",
                self.radius
            ))),
        }
    }
}

/// Patterns that were stored because no sphere held them.
///
/// ```
/// use ballmark::{recogniser::{Learn, Recogniser, rce::{Rce, RceConfig}}, seed::Seed, world::corridor};
/// let config = corridor::CorridorConfig { runs: 2, spacing_m: 1.0, ..Default::default() };
/// let recording = corridor::thrun1998(Seed(1), &config)?;
/// let (first, second) = (recording.runs()[0].clone(), recording.runs()[1].clone());
/// let rce = Rce::learn(&RceConfig::default(), &recording, &first.collect::<Vec<_>>(), Seed(1))?;
/// let responses = rce.respond_all(&recording, &second.collect::<Vec<_>>());
/// assert!(responses.iter().flatten().all(|response| response.class < rce.responses()));
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rce {
    prototypes: Prototypes,
}

impl Learn for Rce {
    type Config = RceConfig;

    fn learn(
        config: &RceConfig,
        recording: &Recording,
        snapshots: &[usize],
        _seed: Seed,
    ) -> Result<Self> {
        config.check()?;
        let mut prototypes = Prototypes::new(&config.signature, recording, snapshots)?;
        let inside = 1.0 - config.radius.powi(2) / 2.0;
        for &k in snapshots {
            let signature = prototypes
                .layout()
                .of(recording.channels(), &recording.observation(k));
            let Some(signature) = signature else { continue };
            if prototypes
                .most_like(&signature)
                .is_none_or(|nearest| nearest.fit < inside)
            {
                prototypes.push(&signature);
            }
        }
        Ok(Self { prototypes })
    }

    fn check(&self) -> Result<()> {
        self.prototypes.check()
    }
}

impl Recogniser for Rce {
    fn name(&self) -> &'static str {
        "rce"
    }

    fn responses(&self) -> usize {
        self.prototypes.len()
    }

    fn matches(&self) -> usize {
        self.prototypes.len()
    }

    fn bytes_per_place(&self) -> usize {
        self.prototypes.bytes_each()
    }

    fn check_channels(&self, channels: &[Channel]) -> Result<()> {
        self.prototypes.layout().check_channels(channels)
    }

    /// The nearest pattern, whether its sphere holds the snapshot or not (D00, Figure 3); the fit is the dot product.
    fn respond(&self, channels: &[Channel], observation: &Observation) -> Option<Response> {
        self.prototypes.respond(channels, observation)
    }

    fn ready<'a>(
        &'a self,
        channels: &'a [Channel],
        observation: &'a Observation<'a>,
    ) -> ReadyToMatch<'a> {
        let signature = self.prototypes.layout().of(channels, observation);
        Box::new(move || self.prototypes.most_like(signature.as_ref()?))
    }

    fn respond_all(&self, recording: &Recording, snapshots: &[usize]) -> Vec<Option<Response>> {
        self.prototypes.respond_all(recording, snapshots)
    }
}
