//! The picture of a ROS map.

use super::read_ordinary;
use crate::error::{Error, Result};
use image::{DynamicImage, ImageReader, Limits};
use std::{io::Cursor, path::Path};

/// Most picture cells, and most bytes that decoding may take.
const MAX_CELLS: u64 = 100_000_000;
const MAX_BYTES: u64 = 2 << 30;

/// The picture in a file.
pub(super) fn picture(file: &Path) -> Result<DynamicImage> {
    let bytes = read_ordinary(file)?;
    let wrong = |fault: String| {
        Error::file(
            file,
            format!("{fault}; expected a PGM, PNG, BMP or JPEG picture"),
        )
    };
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
