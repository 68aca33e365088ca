//! Learn a robot's own landmarks, localise with them, and judge the result.
#![forbid(unsafe_code)]
#![warn(missing_docs)]

// ground: what everyone stands on
pub mod error;
pub mod geometry;
pub mod seed;
pub mod storage;

// what a robot saw, and the files it comes in
pub mod recording;

// where the robot may be
pub mod belief;

// judgement of responses, knows no robot
pub mod score;

// records to tables and pictures
pub mod report;

// arguments in, exit status out
pub mod cli;

pub use error::{Error, Result};
