//! The YAML file of a ROS map, and what a cell's brightness says by it.

use super::read_ordinary;
use crate::{
    error::{Error, Result},
    mapping::Occupancy,
};
use image::DynamicImage;
use ndarray::Array2;
use serde::{Deserialize, Deserializer, de::Error as _};
use std::path::Path;

/// The YAML file; keys that map_server doesn't know are passed over, as it does.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub(super) struct MapFile {
    pub image: String,
    pub resolution: f64,
    #[serde(deserialize_with = "origin")]
    pub origin: [f64; 3],
    #[serde(default)]
    pub negate: Negate,
    pub occupied_thresh: f64,
    pub free_thresh: f64,
    #[serde(default)]
    pub mode: Mode,
}

/// Three numbers; what isn't one is named by its place. Read as text, since map_server writes `-nan` in the C language's way
/// where it had no yaw, which YAML doesn't know.
fn origin<'de, D: Deserializer<'de>>(input: D) -> std::result::Result<[f64; 3], D::Error> {
    let written = <[String; 3]>::deserialize(input)?;
    let mut numbers = [0.0; 3];
    for ((number, text), name) in numbers.iter_mut().zip(&written).zip(["x", "y", "the yaw"]) {
        let plain = text.strip_prefix(['-', '+']).unwrap_or(text);
        let special = plain
            .strip_prefix('.')
            .filter(|word| word.starts_with(char::is_alphabetic));
        *number = special.unwrap_or(text).parse().map_err(|_| {
            let shown: String = text.chars().take(20).collect();
            D::Error::custom(format!(
                "`origin`: {name} is `{}`; expected x, y and yaw as numbers",
                shown.escape_debug()
            ))
        })?;
    }
    Ok(numbers)
}

/// Written as 0 or 1, or as a truth value.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(untagged)]
pub(super) enum Negate {
    Number(i64),
    Truth(bool),
}

impl Default for Negate {
    fn default() -> Self {
        Self::Number(0)
    }
}

/// What a cell's brightness says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Mode {
    /// Occupied, free, or else unknown; transparency counts as one more colour.
    #[default]
    Trinary,
    /// The same with degrees in between, transparent cells unknown.
    Scale,
    /// The occupancy in percent, as it stands; above 100 unknown.
    Raw,
}

/// Capital or small, as nav2 takes it.
impl<'de> Deserialize<'de> for Mode {
    fn deserialize<D: Deserializer<'de>>(input: D) -> std::result::Result<Self, D::Error> {
        let word = String::deserialize(input)?;
        match word.to_ascii_lowercase().as_str() {
            "trinary" => Ok(Self::Trinary),
            "scale" => Ok(Self::Scale),
            "raw" => Ok(Self::Raw),
            _ => {
                let shown: String = word.chars().take(20).collect();
                Err(D::Error::custom(format!(
                    "`mode` is `{}`; expected one of trinary, scale, raw",
                    shown.escape_debug()
                )))
            }
        }
    }
}

impl MapFile {
    pub fn read(file: &Path) -> Result<Self> {
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
        if let Some((number, name)) = origin
            .iter()
            .zip(["x", "y", "yaw"])
            .find(|(number, _)| !(-1e6..=1e6).contains(*number))
        {
            return wrong(
                "origin",
                format!("{number} in {name}"),
                "finite x, y and yaw",
            );
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

    /// What the picture says of each cell, `[row from below, column]`.
    pub fn cells(&self, picture: &DynamicImage) -> Array2<Occupancy> {
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
            // As nav2's loader has it: what shows through is not known, whatever its colour.
            match self.mode == Mode::Scale && pixel[3] < 1.0 {
                true => Occupancy::Unknown,
                false => self.of_shade(f64::from(shade)),
            }
        })
    }

    /// What a brightness from 0 to 1 says.
    pub fn of_shade(&self, shade: f64) -> Occupancy {
        let negated = matches!(self.negate, Negate::Number(1) | Negate::Truth(true));
        let shade = if negated { 1.0 - shade } else { shade };
        let occupancy = match self.mode {
            Mode::Trinary | Mode::Scale => 1.0 - shade,
            Mode::Raw => {
                let percent = (shade * 255.0).round();
                if percent > 100.0 {
                    return Occupancy::Unknown;
                }
                percent / 100.0
            }
        };
        // What the mode with degrees rounds to 100 % is occupied too.
        let above = occupancy - self.free_thresh;
        let share = above / (self.occupied_thresh - self.free_thresh);
        let full = self.mode == Mode::Scale && (100.0 * share).round() >= 100.0;
        match occupancy {
            o if o > self.occupied_thresh || full => Occupancy::Occupied,
            o if o < self.free_thresh => Occupancy::Free,
            _ => Occupancy::Unknown,
        }
    }
}
