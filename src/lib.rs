//! Learn a robot's own landmarks, localise with them, and judge the result.
#![forbid(unsafe_code)]
#![warn(missing_docs)]

// ground: what everyone stands on
pub mod error;
pub mod geometry;
pub mod seed;
pub mod storage;

// arrays by name in one file
pub mod archive;

// what a robot saw, and the files it comes in
pub mod recording;

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

// run → responses, with memory
pub mod localiser;

// judgement, knows no robot
pub mod score;

// the loop that knows everyone
pub mod experiment;

// Records → tables, pictures
pub mod report;

// arguments in, exit status out
pub mod cli;

pub use error::{Error, Result};
