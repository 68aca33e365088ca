//! A ROS map as walls: the outline of its occupied cells, and a bound where the free ones end in what is unknown.
//!
//! Most maps of real buildings are open: the robot that drew them looked into rooms that it didn't enter. What is unknown
//! there, or past the picture's edge, is no wall, so rays go on; but a robot doesn't drive where the map knows nothing, so it is
//! stopped by a bound on the floor that no sensor sees.

mod outline;
#[cfg(test)]
mod tests;

use super::{Material, Wall};
use crate::{
    error::{Error, Result},
    mapping::{Occupancy, RosMap},
};
use std::path::Path;

/// Most edges of a map: a building's has some ten thousand, a photograph millions.
const MOST_EDGES: usize = 1_000_000;
/// Height of the bound around what is known to be free: sensors see over it.
const BOUND_M: f64 = 0.001;

/// The walls of a map: every edge between an occupied cell and one that isn't, edges in line with each other joined; and, a
/// millimetre high, every edge between a free cell and one that is unknown or lies past the picture's edge.
///
/// ```
/// use ballmark::world::{Material, map_server};
/// let folder = tempfile::tempdir().unwrap();
/// let yaml = folder.path().join("cell.yaml");
/// std::fs::write(&yaml, "image: cell.pgm\nresolution: 0.5\norigin: [-1.0, 2.0, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n").unwrap();
/// std::fs::write(folder.path().join("cell.pgm"), "P2 3 3 255\n254 254 254\n254 0 254\n254 254 254\n").unwrap();
/// let walls = map_server::walls(&yaml, Material::PLAIN)?;
/// assert_eq!(walls.len(), 8); // the sides of one occupied cell, and of the picture
/// assert!(walls[0].stands_at(0.3) && !walls[4].stands_at(0.3));
/// assert_eq!((walls[0].from, walls[0].to), ([-0.5, 2.5].into(), [0.0, 2.5].into()));
/// # Ok::<(), ballmark::Error>(())
/// ```
///
/// # Errors
/// Where the YAML or the picture can't be read, a key is missing or out of bounds, no cell is occupied, or the outline has
/// more than a million edges; the message names the file and the key.
pub fn walls(file: &Path, material: Material) -> Result<Vec<Wall>> {
    let map = RosMap::read(file)?;
    let is = |cell: Option<Occupancy>, kind| cell == Some(kind);
    let outline = |a, b| is(a, Occupancy::Occupied) != is(b, Occupancy::Occupied);
    let unknown = |cell: Option<Occupancy>| cell.is_none_or(|cell| cell == Occupancy::Unknown);
    let bound = |a, b| is(a, Occupancy::Free) && unknown(b) || unknown(a) && is(b, Occupancy::Free);
    let too_many = || {
        Error::file(
            file,
            format!(
                "its cells have more than {MOST_EDGES} edges; expected a map of walls, not a photograph"
            ),
        )
    };
    let outline = outline::edges(map.cells(), outline, MOST_EDGES).ok_or_else(too_many)?;
    let left = MOST_EDGES - outline.len();
    let bound = outline::edges(map.cells(), bound, left).ok_or_else(too_many)?;
    let placed = |corner: [usize; 2]| {
        let corner = corner.map(|cells| cells as f64 * map.resolution_m());
        map.to_world() * nalgebra::Point2::from(corner)
    };
    let wall = |[from, to]: outline::Edge| Wall::new(placed(from), placed(to), material);
    let bound = bound
        .into_iter()
        .map(|edge| wall(edge).between(0.0, BOUND_M));
    Ok(outline.into_iter().map(wall).chain(bound).collect())
}
