//! Maps of ROS's map_server: a YAML file beside a picture.
//!
//! Meant as map_server's own loader means them: a dark cell is occupied (a bright one with `negate`), the picture's lower
//! left corner lies at `origin` and is turned about it by the origin's yaw.

mod picture;
#[cfg(test)]
mod tests;
mod write;
mod yaml;

use super::occupancy_map::{Occupancy, OccupancyMap};
use crate::{
    error::{Error, Result},
    storage,
};
use nalgebra::{Isometry2, Point2, Vector2};
use ndarray::Array2;
use picture::picture;
use std::path::Path;
use yaml::MapFile;

/// A map as its file has it: cells in a frame that may be turned.
///
/// ```
/// use ballmark::mapping::{Occupancy, RosMap};
/// let folder = tempfile::tempdir().unwrap();
/// let yaml = folder.path().join("cell.yaml");
/// std::fs::write(&yaml, "image: cell.pgm\nresolution: 0.5\norigin: [-1.0, 2.0, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n").unwrap();
/// std::fs::write(folder.path().join("cell.pgm"), "P2 3 2 255\n254 254 205\n254 0 254\n").unwrap();
/// let map = RosMap::read(&yaml)?.occupancy_map()?;
/// assert_eq!(map.at(-0.3, 2.2), Occupancy::Occupied);
/// assert_eq!(map.at(-0.3, 2.7), Occupancy::Free);
/// assert_eq!(map.at(0.2, 2.7), Occupancy::Unknown);
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct RosMap {
    resolution_m: f64,
    to_world: Isometry2<f64>,
    /// `[row from below, column]`.
    cells: Array2<Occupancy>,
}

impl RosMap {
    /// Reads the YAML file and the picture that it names.
    ///
    /// # Errors
    /// Where the YAML or the picture can't be read, a key is missing or out of bounds, or no cell is occupied; the message
    /// names the file and the key.
    pub fn read(file: &Path) -> Result<Self> {
        let config = MapFile::read(file)?;
        let folder = file.with_file_name("");
        let picture_file = folder.join(&config.image);
        let cells = config.cells(&picture(&picture_file).map_err(|e| {
            // Maps are copied from robot to robot, and their YAML goes on naming the place on the first.
            let name = Path::new(&config.image).file_name();
            match name.filter(|name| e.is_io() && folder.join(name).is_file()) {
                Some(name) => {
                    let name = name.to_string_lossy();
                    e.followed_by(format!(
                        "`{name}` lies beside {}: name it so under `image`",
                        file.display()
                    ))
                }
                None => e,
            }
        })?);
        if !cells.iter().any(|cell| *cell == Occupancy::Occupied) {
            return Err(Error::file(
                &picture_file,
                "no cell is occupied by the map's thresholds; expected walls",
            ));
        }
        let [x_m, y_m, yaw_rad] = config.origin;
        Ok(Self {
            resolution_m: config.resolution,
            to_world: Isometry2::new(Vector2::new(x_m, y_m), yaw_rad),
            cells,
        })
    }

    /// Edge of a cell, in metres.
    pub fn resolution_m(&self) -> f64 {
        self.resolution_m
    }

    /// From the map's own frame, whose origin is the lower left corner of its first cell, to the world's.
    pub fn to_world(&self) -> &Isometry2<f64> {
        &self.to_world
    }

    /// What is known of each cell, `[row from below, column]`.
    pub fn cells(&self) -> &Array2<Occupancy> {
        &self.cells
    }

    /// The map in cells along the world's axes. A map that is turned is asked at the middle of each of them; where the middle of
    /// an occupied cell comes to lie is occupied in any case, so that thin walls have no gaps.
    ///
    /// # Errors
    /// None: a map that was read has an occupied cell.
    pub fn occupancy_map(&self) -> Result<OccupancyMap> {
        let (height, width) = self.cells.dim();
        let translation = self.to_world.translation.vector;
        if self.to_world.rotation.angle() == 0.0 {
            let cells = self.cells.iter().copied().collect();
            return OccupancyMap::from_cells(
                self.resolution_m,
                [translation.x, translation.y],
                width,
                cells,
            );
        }
        let corners = [(0, 0), (width, 0), (0, height), (width, height)].map(|(column, row)| {
            let corner = [column, row].map(|cells| cells as f64 * self.resolution_m);
            self.to_world * Point2::from(corner)
        });
        let least = |axis: usize| {
            corners
                .iter()
                .map(|c| c[axis])
                .fold(f64::INFINITY, f64::min)
        };
        let most = |axis: usize| {
            corners
                .iter()
                .map(|c| c[axis])
                .fold(f64::NEG_INFINITY, f64::max)
        };
        let low = [0, 1].map(least);
        let size = [0, 1].map(|axis| {
            let cells = (most(axis) - low[axis]) / self.resolution_m;
            // A quarter turn is one, whatever its last bit.
            (cells - 1e-6).ceil().max(1.0) as usize
        });
        let turned = (0..size[0] * size[1]).map(|index| {
            let place = [index % size[0], index / size[0]];
            let middle =
                [0, 1].map(|axis| low[axis] + (place[axis] as f64 + 0.5) * self.resolution_m);
            let own = self.to_world.inverse_transform_point(&Point2::from(middle));
            let [column, row] = [own.x, own.y].map(|m| (m / self.resolution_m).floor());
            let within = column >= 0.0 && row >= 0.0;
            let cell = within.then(|| self.cells.get((row as usize, column as usize)));
            cell.flatten().copied().unwrap_or(Occupancy::Unknown)
        });
        let mut turned: Vec<Occupancy> = turned.collect();
        for ((row, column), cell) in self.cells.indexed_iter() {
            if *cell == Occupancy::Occupied {
                let own = [column, row].map(|cells| (cells as f64 + 0.5) * self.resolution_m);
                let middle = self.to_world * Point2::from(own);
                let place = [0, 1].map(|axis| {
                    let cells = (middle[axis] - low[axis]) / self.resolution_m;
                    (cells.max(0.0) as usize).min(size[axis] - 1)
                });
                turned[place[1] * size[0] + place[0]] = Occupancy::Occupied;
            }
        }
        OccupancyMap::from_cells(self.resolution_m, low, size[0], turned)
    }
}

/// A file's bytes; not those of a device or a pipe, which need never end.
fn read_ordinary(file: &Path) -> Result<Vec<u8>> {
    match std::fs::metadata(file) {
        Ok(metadata) if !metadata.is_file() && !metadata.is_dir() => {
            Err(Error::file(file, "is no ordinary file; expected one"))
        }
        _ => storage::read_file(file),
    }
}
