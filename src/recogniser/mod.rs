//! Snapshot → response, without memory.

pub mod alignment;
pub mod angle_histogram;
pub mod histogram;
pub mod local_scan;
pub mod occupancy;
mod vectors;
