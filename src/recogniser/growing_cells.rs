//! Growing cell structures: cells on a net of triangles follow the snapshots, and the net grows where these are many.
//!
//! Fritzke, *Growing cell structures – a self-organizing network for unsupervised and supervised learning*, Neural Networks
//! 7(9), 1994 (below F94), unsupervised, with k = 2: adaptation, insertion with redistribution of the signal counters, and
//! removal of superfluous cells. [`net`] has the network; here it learns from a recording, and answers.

pub mod net;

use super::{
    Learn, ReadyToMatch, Recogniser, Response,
    signature::{Layout, SignatureConfig},
};
use crate::{
    error::{Error, Result},
    recording::{Channel, Observation, Recording},
    seed::Seed,
};
use net::{Net, Rates};
use rand::{RngExt, seq::SliceRandom};
use serde::{Deserialize, Serialize};

/// The constants of the network. D00 prints none; the defaults are those customary with F94, but where said.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GrowingCellsConfig {
    /// What of a snapshot is looked at.
    pub signature: SignatureConfig,
    /// ε_b: how far the best-matching cell moves towards a snapshot.
    pub best: f64,
    /// ε_n: and how far its neighbours do.
    pub neighbour: f64,
    /// α: what all signal counters lose at each snapshot; 1/α snapshots are remembered. Ours: as many as lie between two
    /// insertions. With much fewer than the net has cells, most would seem superfluous.
    pub decay: f64,
    /// λ: snapshots, drawn from the mapping part, between two insertions.
    pub interval: usize,
    /// η: a cell is superfluous where the density of snapshots is below this share of that in the net as a whole. For
    /// inputs that fill an area of 1 the mean density is 1 too, and this is F94's η. 0 removes nothing.
    pub removal: f64,
    /// Number of cells of the full net, which is the number of responses.
    pub cells: usize,
}

impl Default for GrowingCellsConfig {
    fn default() -> Self {
        Self {
            signature: SignatureConfig::default(),
            best: 0.06,
            neighbour: 0.002,
            decay: 0.005,
            interval: 200,
            removal: 0.09,
            cells: 32,
        }
    }
}

/// A slip of the keyboard does not ask for days: more cells than any of these robots has snapshots.
const MAX_CELLS: usize = 100_000;

impl GrowingCellsConfig {
    /// # Errors
    /// Where a constant makes no sense; the message names its key.
    pub fn check(&self) -> Result<()> {
        let share = |v: f64| (0.0..=1.0).contains(&v);
        let (density, interval) = (self.removal, self.interval);
        let wrong = |key: &str, value: f64, expected: &str| {
            Err(Error::usage(format!(
                "growing_cells.{key} = {value}: expected {expected}"
            )))
        };
        for (key, value) in [
            ("best", self.best),
            ("neighbour", self.neighbour),
            ("decay", self.decay),
        ] {
            if !share(value) {
                return wrong(key, value, "0 to 1");
            }
        }
        if !(density.is_finite() && density >= 0.0) {
            return wrong("removal", density, "0 or more");
        }
        if interval == 0 {
            return wrong("interval", 0.0, "at least 1 snapshot");
        }
        match (3..=MAX_CELLS).contains(&self.cells) {
            true => Ok(()),
            false => wrong(
                "cells",
                self.cells as f64,
                &format!("3, a first triangle, to {MAX_CELLS}"),
            ),
        }
    }
}

/// A net that has grown: cells and the triangles between them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GrowingCells {
    layout: Layout,
    net: Net,
}

/// How often a net of full size has its superfluous cells removed, and grows again in their stead. F94 removes as it
/// grows; but with a cell between two clusters goes the bridge, and of a small net with it all that lies beyond.
const PRUNINGS: usize = 3;

impl Learn for GrowingCells {
    type Config = GrowingCellsConfig;

    /// The first three cells are snapshots drawn from stream "first cells" of the seed, all that follow are drawn, with
    /// replacement, from "cell signals".
    ///
    /// # Errors
    /// Besides a constant that makes no sense: where there are fewer than three snapshots.
    fn learn(
        config: &GrowingCellsConfig,
        recording: &Recording,
        snapshots: &[usize],
        seed: Seed,
    ) -> Result<Self> {
        config.check()?;
        let layout = Layout::fit(&config.signature, recording, snapshots)?;
        let signature = |&k: &usize| layout.of(recording.channels(), &recording.observation(k));
        let wide = |signature: Vec<f32>| signature.into_iter().map(f64::from).collect();
        let signals: Vec<Vec<f64>> = snapshots.iter().filter_map(signature).map(wide).collect();
        let mut first: Vec<usize> = (0..signals.len()).collect();
        first.shuffle(&mut seed.stream("first cells"));
        let &[a, b, c, ..] = first.as_slice() else {
            return Err(Error::work(format!(
                "growing_cells: {} snapshots to learn from; expected at least 3, the corners of a triangle",
                signals.len()
            )));
        };
        let mut net = Net::triangle([&signals[a], &signals[b], &signals[c]].map(Clone::clone));
        let rates = Rates {
            best: config.best,
            neighbour: config.neighbour,
            decay: config.decay,
        };
        let mut random = seed.stream("cell signals");
        let mut present = |net: &mut Net| {
            for _ in 0..config.interval {
                net.adapt(&signals[random.random_range(0..signals.len())], &rates);
            }
        };
        for pruning in 0..=PRUNINGS {
            while net.len() < config.cells {
                present(&mut net);
                net.insert();
            }
            // So that the last cell is adapted too, and its signals are counted.
            present(&mut net);
            if pruning == PRUNINGS || net.remove_superfluous(config.removal) == 0 {
                break;
            }
        }
        Ok(Self { layout, net })
    }

    fn check(&self) -> Result<()> {
        self.layout.check()?;
        self.net.check(self.layout.width())
    }
}

impl Recogniser for GrowingCells {
    fn name(&self) -> &'static str {
        "growing_cells"
    }

    fn responses(&self) -> usize {
        self.net.len()
    }

    fn matches(&self) -> usize {
        self.net.len()
    }

    fn bytes_per_place(&self) -> usize {
        self.net.bytes_per_cell()
    }

    fn check_channels(&self, channels: &[Channel]) -> Result<()> {
        self.layout.check_channels(channels)
    }

    /// The best-matching cell; the fit is minus its distance from the signature.
    fn respond(&self, channels: &[Channel], observation: &Observation) -> Option<Response> {
        Some(self.best_of(&self.signal(channels, observation)?))
    }

    fn ready<'a>(
        &'a self,
        channels: &'a [Channel],
        observation: &'a Observation<'a>,
    ) -> ReadyToMatch<'a> {
        let signal = self.signal(channels, observation);
        Box::new(move || Some(self.best_of(signal.as_ref()?)))
    }
}

impl GrowingCells {
    fn signal(&self, channels: &[Channel], observation: &Observation) -> Option<Vec<f64>> {
        let signature = self.layout.of(channels, observation)?;
        Some(signature.into_iter().map(f64::from).collect())
    }

    fn best_of(&self, signal: &[f64]) -> Response {
        let (class, square) = self.net.best_matching(signal);
        Response {
            class,
            fit: -square.sqrt(),
        }
    }
}
