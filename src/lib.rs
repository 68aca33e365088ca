//! Learn a robot's own landmarks, localise with them, and judge the result.
//!
//! Sensing makes a robot less uncertain about where it is; how much less depends on the features that it recognises in its
//! readings. BaLL (Thrun 1998) learns such features: n networks g_i turn a snapshot s of the sensors into stochastic binary
//! features f, and are trained to minimise the localisation error that is left,
//!
//! ```text
//! E = Σ_k* P(ξ_k*) Σ_f P(f | s_k*) · Σ_k e(ξ_k*, ξ_k) Bel(ξ_k) P(f | ξ_k) / Σ_k Bel(ξ_k) P(f | ξ_k)      (eq. 36)
//! ```
//!
//! | term | what | where |
//! |---|---|---|
//! | s_k at ξ_k | labelled snapshots | [`recording`], simulated ones from [`world`] |
//! | P(f \| s) | the features of a snapshot | [`detector`] |
//! | Bel, e | the prior uncertainty, and the distance of one place from another | [`belief::prior`], [`belief::places`] |
//! | P(f \| ξ) | the map: what is recognised where | [`belief::map`] |
//! | E, ∂E/∂g | the objective, and descending it | [`learning`] |
//!
//! [`Training`] learns from a [`Recording`] and yields a [`Model`]. A [`localiser`] replays a run that training never saw, with
//! the Bayes filter of [`belief::bayes`]; [`experiment`] compares its answers with the truth and with baselines; [`score`]
//! says how much the answers of any system tell about the place; [`report`] makes tables and plots; [`cli`] is the command
//! `ballmark`. Detectors, recognisers and localisers are traits, so your own take part in comparisons as the built-in ones
//! do. Every key of a configuration, and its default, is in `docs/reference/`.
//!
//! ```
//! use ballmark::{Detector, Recipe, Seed, Training, world::corridor};
//!
//! // Eight runs along a simulated corridor, a snapshot a metre.
//! let config = corridor::CorridorConfig { runs: 8, spacing_m: 1.0, ..Default::default() };
//! let recording = corridor::thrun1998(Seed(1), &config)?;
//!
//! // One filter for a robot that knows its place to ±5 m.
//! let mut recipe = Recipe { features: 1, uncertainty: "5m".parse()?, ..Recipe::default() };
//! recipe.descent.steps = 60;
//! let learned = Training::new(&recipe, &recording).run()?;
//! assert!(learned.report.scores.train.error_reduction > 0.05);
//!
//! let model = learned.model;
//! assert_eq!(model.detector().probabilities(&recording)?.dim(), (recording.len(), 1));
//! # Ok::<(), ballmark::Error>(())
//! ```
#![forbid(unsafe_code)]
#![warn(missing_docs)]

// ground: what everyone stands on
pub mod delimited;
pub mod error;
pub mod geometry;
pub mod seed;
mod simd;
pub mod storage;
pub mod toml_file;

// arrays by name in one file
pub mod archive;

// what a robot saw, and the files it comes in
pub mod recording;

// the plan that range sensors draw
pub mod mapping;

// constants of systems that can learn; members that share a trait, from one list
pub mod registry;

// simulated buildings and robots that yield Recordings
pub mod world;

// where the robot may be
pub mod belief;

// snapshot → P(f_i = 1)
pub mod detector;

// making detectors better
pub mod learning;

// a trained model as a file
pub mod model;

// snapshot → response, no memory
pub mod recogniser;

// run → responses, with memory
pub mod localiser;

// judgement, knows no robot
pub mod score;

// the loop that knows everyone
pub mod experiment;

// Records → tables, pictures
pub mod report;

// arguments in, exit status out
#[cfg(feature = "cli")]
pub mod cli;

// what most programs need, by its short name
pub use belief::{Belief, Uncertainty};
pub use detector::Detector;
pub use error::{Error, Result};
pub use geometry::Pose;
pub use learning::Recipe;
pub use localiser::{LiveLocaliser, Localiser};
pub use model::{Model, Training};
pub use recogniser::Recogniser;
pub use recording::{Observation, Recording};
pub use seed::Seed;

// crates whose types stand in this interface, in the versions that it speaks
pub use {nalgebra, ndarray};

/// The README's programs run as doc-tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
