//! Learn a robot's own landmarks, localise with them, and judge the result.
//!
//! A robot that is uncertain where it is senses, and is less uncertain. How much less depends on what it recognises in
//! what it senses. BaLL (Thrun 1998) learns what to recognise: n small networks g_i turn a snapshot s into stochastic
//! binary features f, and are trained to minimise the error that is left,
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
//! Trained filters are a [`model`]; a [`localiser`] replays a run that training never saw, with the Bayes filter of
//! [`belief::bayes`]; [`experiment`] holds its answers against the truth and beside baselines; [`score`] judges answers
//! of any system by what they tell about the place; [`report`] shows it all; [`cli`] is the command `ballmark`.
//!
//! ```
//! use ballmark::{detector::Detector, learning::{Recipe, training_set::TrainingSet, trainer}, model::Model, seed::Seed, world::corridor};
//!
//! // Eight runs along a simulated corridor, a snapshot a metre.
//! let config = corridor::CorridorConfig { runs: 8, spacing_m: 1.0, ..Default::default() };
//! let recording = corridor::thrun1998(Seed(1), &config)?;
//!
//! // One filter for a robot that knows its place to ±5 m.
//! let mut recipe = Recipe { features: 1, uncertainty: "5m".parse()?, ..Recipe::default() };
//! recipe.descent.steps = 60;
//! let training_set = TrainingSet::prepare(&recipe, &recording, &recipe.split.split(&recording)?)?;
//! let trained = trainer::train(&recipe, &training_set, None, false, "", &mut |_| ())?;
//! assert!(trained.train.error_reduction > 0.05);
//!
//! let model = Model::new(&recipe, &recording, &training_set, trained);
//! assert_eq!(model.detector().probabilities(&recording)?.dim(), (recording.len(), 1));
//! # Ok::<(), ballmark::Error>(())
//! ```
#![forbid(unsafe_code)]
#![warn(missing_docs)]

// ground: what everyone stands on
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

// members that share a trait: configurations, names and files from one list
mod registry;

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
pub use model::Model;
pub use recogniser::Recogniser;
pub use recording::{Observation, Recording};
pub use seed::Seed;

// crates whose types stand in this interface, in the versions that it speaks
pub use {nalgebra, ndarray};
