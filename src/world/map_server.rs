//! The outline of a ROS map's occupied cells as walls. What is unknown is no wall.

mod outline;
#[cfg(test)]
mod tests;

use super::{Material, Wall};
use crate::{
    error::Result,
    mapping::{Occupancy, RosMap},
};
use std::path::Path;

/// The walls of a map: every edge between an occupied cell and one that isn't, edges in line with each other joined.
///
/// ```
/// use ballmark::world::{Material, map_server};
/// let folder = tempfile::tempdir().unwrap();
/// let yaml = folder.path().join("cell.yaml");
/// std::fs::write(&yaml, "image: cell.pgm\nresolution: 0.5\norigin: [-1.0, 2.0, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n").unwrap();
/// std::fs::write(folder.path().join("cell.pgm"), "P2 3 3 255\n254 254 254\n254 0 254\n254 254 254\n").unwrap();
/// let walls = map_server::walls(&yaml, Material::PLAIN)?;
/// assert_eq!(walls.len(), 4); // the sides of one occupied cell
/// assert_eq!((walls[0].from, walls[0].to), ([-0.5, 2.5].into(), [0.0, 2.5].into()));
/// # Ok::<(), ballmark::Error>(())
/// ```
///
/// # Errors
/// Where the YAML or the picture can't be read, a key is missing or out of bounds, or no cell is occupied; the message
/// names the file and the key.
pub fn walls(file: &Path, material: Material) -> Result<Vec<Wall>> {
    let map = RosMap::read(file)?;
    let occupied = map.cells().mapv(|cell| cell == Occupancy::Occupied);
    let placed = |corner: [usize; 2]| {
        let corner = corner.map(|cells| cells as f64 * map.resolution_m());
        map.to_world() * nalgebra::Point2::from(corner)
    };
    let walls = outline::edges(&occupied)
        .into_iter()
        .map(|[from, to]| Wall::new(placed(from), placed(to), material));
    Ok(walls.collect())
}
