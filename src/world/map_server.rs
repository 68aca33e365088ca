//! Maps of ROS's map_server: a YAML file beside a picture; the outline of occupied cells becomes walls.

use super::{Material, Wall};
use crate::error::{Error, Result};
use std::path::Path;

/// Walls of a map.
pub fn walls(_file: &Path, _material: Material) -> Result<Vec<Wall>> {
    Err(Error::work("not there yet"))
}
