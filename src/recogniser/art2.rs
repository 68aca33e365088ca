//! ART2: patterns compete for a snapshot, and a winner whose expectation does not match it is reset and the next is tried.
//!
//! Carpenter & Grossberg, *ART 2: self-organization of stable category recognition codes for analog input patterns*, Applied
//! Optics 26(23), 1987 (below CG87). The field F1 has M units in three loops, which here go round until they rest:
//!
//! ```text
//! w = I + a u      x = w/‖w‖      v = f(x) + b f(q)      u = v/‖v‖      p = u + g(y) z      q = p/‖p‖      (CG87 eq. 4–9)
//! f(x) = x where x > θ, else 0                                                                             (CG87 eq. 11)
//! T_j = Σ_i p_i z_ij, the largest T_J wins, g(y_J) = d, the others 0                                    (CG87 eq. 12–14)
//! ‖r‖ = ‖u + c p‖ / (‖u‖ + c ‖p‖), and J is reset where ‖r‖ < ρ                                         (CG87 eq. 20–21)
//! dz_J/dt = d (1 − d) [u/(1 − d) − z_J]                                                                 (CG87 eq. 18–19)
//! ```
//!
//! The paper's e ≪ 1, which keeps it from dividing by 0, is 0 here, and 0/0 counts as 0. Contrast enhancement by f makes
//! the *self-scaling* property: which parts of a snapshot are noise depends on its other parts, and a pattern that is a
//! subset of another does not match it. An even snapshot, all of whose units are at 1/√M ≤ θ, is nothing but noise: no
//! response.

use super::{
    Learn, ReadyToMatch, Recogniser, Response,
    signature::{Layout, SignatureConfig},
};
use crate::{
    error::{Error, Result},
    recording::{Channel, Observation, Recording},
    seed::Seed,
};
use serde::{Deserialize, Serialize};

/// The constants of ART2. D00 prints none; the defaults of a to d and θ are those customary since CG87's simulations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Art2Config {
    /// What of a snapshot is looked at.
    pub signature: SignatureConfig,
    /// a > 0: gain of u on w.
    pub a: f64,
    /// b > 0: gain of q on v.
    pub b: f64,
    /// c > 0, with c d/(1 − d) ≤ 1: weight of p in the match.
    pub c: f64,
    /// 0 < d < 1: activity of the winner.
    pub d: f64,
    /// θ in units of 1/√M, which is what an even snapshot has everywhere: at 1, the default, that is noise.
    pub threshold: f64,
    /// Vigilance ρ, 0 to 1: what D00 sets for the number of responses it wants. With the other defaults ‖r‖ lies between
    /// 0.746, for orthogonal patterns, and 1.
    pub vigilance: f64,
    /// The bottom-up weight of a unit that has not learned yet, as a share of CG87's bound 1/((1 − d)√M), 0 to 1. At 0 the
    /// units that have learned are all tried first, as D00 has it: "a new pattern is created if none of the stored
    /// patterns is similar enough". At 1 a new one also wins over those that are only a little similar.
    pub uncommitted: f64,
    /// How far z_J goes towards u/(1 − d) at each presentation, 0 to 1: 1 is CG87's fast learning; less is slow
    /// learning, 1 − e^(−d(1−d)t) for a presentation of length t. Ours.
    pub learning: f64,
    /// How often the mapping part is presented. Ours.
    pub presentations: usize,
}

impl Default for Art2Config {
    fn default() -> Self {
        Self {
            signature: SignatureConfig::default(),
            a: 10.0,
            b: 10.0,
            c: 0.1,
            d: 0.9,
            threshold: 1.0,
            vigilance: 0.93,
            uncommitted: 0.0,
            learning: 0.1,
            presentations: 1,
        }
    }
}

impl Art2Config {
    /// # Errors
    /// Where a constant is out of the bounds that CG87 gives it.
    pub fn check(&self) -> Result<()> {
        let positive = |v: f64| v.is_finite() && v > 0.0;
        let share = |v: f64| (0.0..=1.0).contains(&v);
        let constants = [
            ("a", self.a, positive(self.a), "a positive number"),
            ("b", self.b, positive(self.b), "a positive number"),
            ("d", self.d, self.d > 0.0 && self.d < 1.0, "between 0 and 1"),
            (
                "c",
                self.c,
                // At the bound itself 0.1 · 0.9 / (1 − 0.9) is a little more than it should be.
                positive(self.c) && self.c * self.d <= (1.0 - self.d) * (1.0 + 1e-9),
                "a positive number with c d/(1 − d) ≤ 1",
            ),
            (
                "threshold",
                self.threshold,
                self.threshold.is_finite() && self.threshold >= 0.0,
                "0 or more",
            ),
            ("vigilance", self.vigilance, share(self.vigilance), "0 to 1"),
            (
                "uncommitted",
                self.uncommitted,
                share(self.uncommitted),
                "0 to 1",
            ),
            (
                "learning",
                self.learning,
                share(self.learning) && self.learning > 0.0,
                "above 0, at most 1",
            ),
        ];
        if let Some((key, value, _, expected)) = constants.into_iter().find(|c| !c.2) {
            return Err(Error::usage(format!(
                "art2.{key} = {value}: expected {expected}"
            )));
        }
        match self.presentations {
            0 => Err(Error::usage("art2.presentations = 0: expected at least 1")),
            _ => Ok(()),
        }
    }
}

/// A network that has learned: the weights of its committed units. Bottom-up and top-down weights of a unit obey one law
/// (CG87 eq. 18, 19) and agree as soon as it has learned anything, so they are kept once.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Art2 {
    config: Art2Config,
    layout: Layout,
    /// z_j, one a committed unit, `[unit][value]`.
    units: Vec<Vec<f64>>,
}

/// F1 rests when no unit of u changes by more than this in a round, or after so many rounds.
const REST: f64 = 1e-10;
const MAX_ROUNDS: usize = 200;

/// What is at the threshold is noise, also where rounding lifts it a little above.
const ROUNDING: f64 = 1e-9;

/// How the search among the units ended.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Found {
    /// Unit J resonates, with this ‖r‖.
    Resonance(usize, f64),
    /// All committed units were reset, or a new one won: the snapshot is of a kind of its own.
    Novelty,
}

impl Art2 {
    /// F1 goes round until it rests, from the state u, q that it is in, while F2 reads out `expectation` = g(y_J) z_J;
    /// then its u. All 0 where the input is noise.
    fn settle(&self, input: &[f64], expectation: Option<&[f64]>, mut u: Vec<f64>) -> Vec<f64> {
        let Art2Config { a, b, .. } = self.config;
        let theta = (1.0 + ROUNDING) * self.config.threshold / (input.len() as f64).sqrt();
        let f = |x: f64| if x > theta { x } else { 0.0 };
        let mut q = unit(self.p(&u, expectation));
        for _ in 0..MAX_ROUNDS {
            let x = unit(input.iter().zip(&u).map(|(i, u)| i + a * u).collect());
            let v = x.iter().zip(&q).map(|(x, q)| f(*x) + b * f(*q)).collect();
            let next = unit(v);
            let change = next.iter().zip(&u).map(|(n, u)| (n - u).abs());
            let rests = change.fold(0.0, f64::max) <= REST;
            u = next;
            if rests {
                break;
            }
            q = unit(self.p(&u, expectation));
        }
        u
    }

    /// p = u + d z_J (CG87 eq. 15).
    fn p(&self, u: &[f64], expectation: Option<&[f64]>) -> Vec<f64> {
        match expectation {
            None => u.to_vec(),
            Some(z) => u
                .iter()
                .zip(z)
                .map(|(u, z)| u + self.config.d * z)
                .collect(),
        }
    }

    /// ‖r‖ as unit J's expectation is read out, before F1 has followed it: CG87's match, by which vigilance decides.
    fn matching(&self, u: &[f64], z: &[f64]) -> f64 {
        let c = self.config.c;
        let p = self.p(u, Some(z));
        let r: Vec<f64> = u.iter().zip(&p).map(|(u, p)| u + c * p).collect();
        norm(&r) / (norm(u) + c * norm(&p))
    }

    /// The units in the order of their T_j; each whose match is less than the vigilance is reset, and the next one tried.
    fn search(&self, u: &[f64]) -> Found {
        let total = |z: &Vec<f64>| -> f64 { u.iter().zip(z).map(|(p, z)| p * z).sum() };
        let mut order: Vec<(usize, f64)> = self.units.iter().map(total).enumerate().collect();
        // Stable: of equal totals, the unit that learned first.
        order.sort_by(|a, b| b.1.total_cmp(&a.1));
        // Σ p_i z_ij(0) of a unit that has not learned.
        let uncommitted = self.config.uncommitted * u.iter().sum::<f64>()
            / ((1.0 - self.config.d) * (u.len() as f64).sqrt());
        for (j, total) in order {
            if total < uncommitted {
                break;
            }
            let matching = self.matching(u, &self.units[j]);
            if matching >= self.config.vigilance {
                return Found::Resonance(j, matching);
            }
        }
        Found::Novelty
    }

    /// Shows the network a snapshot and lets it learn.
    fn learn_one(&mut self, input: &[f64]) {
        let u = self.settle(input, None, vec![0.0; input.len()]);
        if norm(&u) == 0.0 {
            return;
        }
        let equilibrium = |u: &f64| u / (1.0 - self.config.d);
        match self.search(&u) {
            // From top-down weights of 0, which match anything (‖r‖ = 1), straight to the equilibrium: were it slow, the
            // next snapshot would meet an expectation too weak to tell it from the first.
            Found::Novelty => self.units.push(u.iter().map(equilibrium).collect()),
            Found::Resonance(j, _) => {
                let u = self.settle(input, Some(&self.units[j]), u);
                let (learning, d) = (self.config.learning, self.config.d);
                for (z, u) in self.units[j].iter_mut().zip(&u) {
                    *z += learning * (u / (1.0 - d) - *z);
                }
            }
        }
    }

    fn recognise(&self, input: &[f64]) -> Option<Response> {
        let u = self.settle(input, None, vec![0.0; input.len()]);
        if norm(&u) == 0.0 {
            return None;
        }
        match self.search(&u) {
            Found::Resonance(class, fit) => Some(Response { class, fit }),
            Found::Novelty => None,
        }
    }

    fn input(&self, channels: &[Channel], observation: &Observation) -> Option<Vec<f64>> {
        let signature = self.layout.of(channels, observation)?;
        Some(signature.into_iter().map(f64::from).collect())
    }
}

impl Learn for Art2 {
    type Config = Art2Config;

    /// A mapping part that is all noise leaves a network without units: it never answers.
    fn learn(
        config: &Art2Config,
        recording: &Recording,
        snapshots: &[usize],
        _seed: Seed,
    ) -> Result<Self> {
        config.check()?;
        let mut network = Self {
            config: config.clone(),
            layout: Layout::fit(&config.signature, recording, snapshots)?,
            units: Vec::new(),
        };
        for _ in 0..config.presentations {
            for &k in snapshots {
                let input = network.input(recording.channels(), &recording.observation(k));
                if let Some(input) = input {
                    network.learn_one(&input);
                }
            }
        }
        Ok(network)
    }

    fn check(&self) -> Result<()> {
        self.config.check()?;
        self.layout.check()?;
        let width = self.layout.width();
        let sound = |z: &Vec<f64>| z.len() == width && z.iter().all(|z| z.abs() < 1e9);
        match self.units.iter().position(|z| !sound(z)) {
            Some(j) => Err(Error::work(format!(
                "art2: weights of unit {j}: expected {width} finite numbers"
            ))),
            None => Ok(()),
        }
    }
}

impl Recogniser for Art2 {
    fn name(&self) -> &'static str {
        "art2"
    }

    fn responses(&self) -> usize {
        self.units.len()
    }

    fn matches(&self) -> usize {
        self.units.len()
    }

    fn bytes_per_place(&self) -> usize {
        self.layout.width() * size_of::<f64>()
    }

    fn check_channels(&self, channels: &[Channel]) -> Result<()> {
        self.layout.check_channels(channels)
    }

    /// The unit that resonates, its ‖r‖ the fit; `None` where all are reset, or the snapshot is nothing but noise.
    fn respond(&self, channels: &[Channel], observation: &Observation) -> Option<Response> {
        self.recognise(&self.input(channels, observation)?)
    }

    fn ready<'a>(
        &'a self,
        channels: &'a [Channel],
        observation: &'a Observation<'a>,
    ) -> ReadyToMatch<'a> {
        let input = self.input(channels, observation);
        Box::new(move || self.recognise(input.as_ref()?))
    }
}

fn norm(values: &[f64]) -> f64 {
    values.iter().map(|v| v * v).sum::<f64>().sqrt()
}

/// Divided by the Euclidean norm; nothing but zeros stays so.
fn unit(mut values: Vec<f64>) -> Vec<f64> {
    let norm = norm(&values);
    if norm > 0.0 {
        values.iter_mut().for_each(|v| *v /= norm);
    }
    values
}

#[cfg(test)]
mod tests;
