//! Maps of ROS's map_server: a YAML file beside a picture; the outline of occupied cells becomes walls.
//!
//! Meant as map_server's own loader means them: a dark cell is occupied (a bright one with `negate`), the picture's lower
//! left corner lies at `origin` and is turned about it by the origin's yaw. What is unknown is no wall.

mod outline;
#[cfg(test)]
mod tests;

use super::{Material, Wall};
use crate::{
    error::{Error, Result},
    storage,
};
use image::{DynamicImage, ImageReader, Limits};
use ndarray::Array2;
use serde::Deserialize;
use std::{io::Cursor, path::Path};

/// The YAML file; keys that map_server doesn't know are passed over, as it does.
#[derive(Debug, Clone, PartialEq, Deserialize)]
struct MapConfig {
    image: String,
    resolution: f64,
    origin: [f64; 3],
    #[serde(default)]
    negate: Negate,
    occupied_thresh: f64,
    free_thresh: f64,
    #[serde(default)]
    mode: Mode,
}

/// Written as 0 or 1, or as a truth value.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(untagged)]
enum Negate {
    Number(i64),
    Truth(bool),
}

impl Default for Negate {
    fn default() -> Self {
        Self::Number(0)
    }
}

/// What a cell's brightness says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Mode {
    /// Occupied, free, or else unknown; transparency counts as one more colour.
    #[default]
    Trinary,
    /// The same with degrees in between, transparent cells unknown.
    Scale,
    /// The occupancy in percent, as it stands; above 100 unknown.
    Raw,
}

/// Most picture cells, and most bytes that decoding may take.
const MAX_CELLS: u64 = 100_000_000;
const MAX_BYTES: u64 = 2 << 30;

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
    let config = MapConfig::read(file)?;
    let picture_file = file.with_file_name("").join(&config.image);
    let occupied = config.occupied(&picture(&picture_file)?);
    if !occupied.iter().any(|&cell| cell) {
        return Err(Error::file(
            &picture_file,
            "no cell is occupied by the map's thresholds; expected walls",
        ));
    }
    let edges = outline::edges(&occupied);
    let [x_m, y_m, yaw_rad] = config.origin;
    let to_world = nalgebra::Isometry2::new(nalgebra::Vector2::new(x_m, y_m), yaw_rad);
    let placed = |corner: [usize; 2]| {
        let corner = corner.map(|cells| cells as f64 * config.resolution);
        to_world * nalgebra::Point2::from(corner)
    };
    let walls = edges
        .into_iter()
        .map(|[from, to]| Wall::new(placed(from), placed(to), material));
    Ok(walls.collect())
}

impl MapConfig {
    fn read(file: &Path) -> Result<Self> {
        let text = String::from_utf8(read_ordinary(file)?)
            .map_err(|_| Error::file(file, "not UTF-8 text; expected a map's YAML"))?;
        let config: Self = serde_saphyr::from_str(&text).map_err(|e| {
            let message = e.to_string();
            let first = message.lines().next().unwrap_or("no YAML");
            let first = first.trim().trim_start_matches("error: ");
            Error::file(file, format!("{first}; expected a map_server map"))
        })?;
        let wrong = |key: &str, value: String, expected: &str| {
            Err(Error::input(
                file,
                format!("`{key}`"),
                format!("is {value}; expected {expected}"),
            ))
        };
        let Self {
            resolution,
            origin,
            occupied_thresh,
            free_thresh,
            ..
        } = config;
        if !(resolution > 1e-4 && resolution <= 100.0) {
            let expected = "metres a cell, above 0.0001 up to 100";
            return wrong("resolution", resolution.to_string(), expected);
        }
        if let Some(number) = origin.iter().find(|number| !(-1e6..=1e6).contains(*number)) {
            return wrong("origin", number.to_string(), "finite x, y and yaw");
        }
        if !(0.0 <= free_thresh && free_thresh < occupied_thresh && occupied_thresh <= 1.0) {
            let expected =
                format!("0 up to `occupied_thresh`, which is {occupied_thresh}, up to 1");
            return wrong("free_thresh", free_thresh.to_string(), &expected);
        }
        if let Negate::Number(other) = config.negate
            && !(0..=1).contains(&other)
        {
            return wrong("negate", other.to_string(), "0 or 1");
        }
        Ok(config)
    }

    /// Which cells are occupied, `[row from below, column]`.
    fn occupied(&self, picture: &DynamicImage) -> Array2<bool> {
        let colour = picture.color();
        let (colours, alpha) = match (colour.has_color(), colour.has_alpha()) {
            (true, alpha) => (3, alpha),
            (false, alpha) => (1, alpha),
        };
        let pixels = picture.to_rgba32f();
        let (width, height) = (pixels.width() as usize, pixels.height() as usize);
        Array2::from_shape_fn((height, width), |(row, column)| {
            // Both fit: they come from the picture's own 32 bit size.
            let pixel = pixels.get_pixel(column as u32, (height - 1 - row) as u32).0;
            let sum: f32 = pixel[..colours].iter().sum();
            let shade = if alpha && self.mode == Mode::Trinary {
                (sum + pixel[3]) / (colours + 1) as f32
            } else {
                sum / colours as f32
            };
            self.is_occupied(f64::from(shade))
        })
    }

    /// Is a cell of this brightness, from 0 to 1, occupied?
    fn is_occupied(&self, shade: f64) -> bool {
        let negated = matches!(self.negate, Negate::Number(1) | Negate::Truth(true));
        let shade = if negated { 1.0 - shade } else { shade };
        let occupancy = match self.mode {
            Mode::Trinary | Mode::Scale => 1.0 - shade,
            Mode::Raw => {
                let percent = (shade * 255.0).round();
                if percent > 100.0 {
                    return false;
                }
                percent / 100.0
            }
        };
        occupancy > self.occupied_thresh
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

fn picture(file: &Path) -> Result<DynamicImage> {
    let bytes = read_ordinary(file)?;
    let wrong =
        |fault: String| Error::file(file, format!("{fault}; expected a PGM or PNG picture"));
    let mut reader = ImageReader::new(Cursor::new(&bytes))
        .with_guessed_format()
        .map_err(|e| wrong(e.to_string()))?;
    let mut limits = Limits::default();
    limits.max_alloc = Some(MAX_BYTES);
    reader.limits(limits);
    let undecodable = |e: image::ImageError| {
        let fault = e.to_string().replace('\n', " ");
        wrong(fault)
    };
    let size = ImageReader::new(Cursor::new(&bytes))
        .with_guessed_format()
        .map_err(|e| wrong(e.to_string()))?
        .into_dimensions()
        .map_err(undecodable)?;
    if u64::from(size.0) * u64::from(size.1) > MAX_CELLS {
        return Err(wrong(format!(
            "{} × {} cells, more than {MAX_CELLS}",
            size.0, size.1
        )));
    }
    reader.decode().map_err(undecodable)
}
