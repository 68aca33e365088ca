//! A colour picture, and the few numbers that stand for it in a recording.

mod features;
mod frame;

pub use features::{channel, features};
pub(super) use frame::{decoded, read as read_frame};

use crate::error::{Error, Result};
use ::image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};

/// Rows of a camera image once it is subsampled (Thrun 1998, 5.1.3).
pub const ROWS: usize = 60;
/// Columns of a camera image once it is subsampled.
pub const COLUMNS: usize = 64;

/// Red, green and blue of every pixel in 8 bits each, `[row, column, colour]`; row 0 is at the top.
///
/// ```
/// use ballmark::recording::image::Image;
/// let image = Image::new(1, 2, vec![255, 0, 0, 0, 0, 80])?; // red beside dark blue
/// assert_eq!(image.pixel(0, 1), [0, 0, 80]);
/// assert_eq!(image.subsampled(1, 1).pixel(0, 0), [128, 0, 40]);
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Image {
    rows: usize,
    columns: usize,
    rgb: Vec<u8>,
}

impl Image {
    /// An image from its values, row by row.
    ///
    /// # Errors
    /// Where there is no row or no column, or their number doesn't fit the values.
    pub fn new(rows: usize, columns: usize, rgb: Vec<u8>) -> Result<Self> {
        let expected = rows.checked_mul(columns).and_then(|n| n.checked_mul(3));
        if rgb.is_empty() || expected != Some(rgb.len()) {
            return Err(Error::work(format!(
                "image: {} values for {rows} × {columns} pixels; expected three a pixel, and at least one pixel",
                rgb.len()
            )));
        }
        Ok(Self { rows, columns, rgb })
    }

    /// An image from values that are known to be three for each of at least one pixel.
    pub(crate) fn from_values(rows: usize, columns: usize, rgb: Vec<u8>) -> Self {
        debug_assert!(!rgb.is_empty() && rgb.len() == 3 * rows * columns);
        Self { rows, columns, rgb }
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of columns.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// All values `[row, column, colour]`, row by row.
    pub fn values(&self) -> &[u8] {
        &self.rgb
    }

    /// Red, green and blue of a pixel.
    pub fn pixel(&self, row: usize, column: usize) -> [u8; 3] {
        let at = 3 * (row * self.columns + column);
        [self.rgb[at], self.rgb[at + 1], self.rgb[at + 2]]
    }

    /// The same view in so many rows and columns, at least one each: every pixel the mean of those it covers. Of a
    /// smaller image pixels are repeated.
    pub fn subsampled(&self, rows: usize, columns: usize) -> Self {
        if (rows, columns) == (self.rows, self.columns) {
            return self.clone();
        }
        let covered = |index: usize, parts: usize, all: usize| {
            let (first, end) = (index * all / parts, (index + 1) * all / parts);
            first..end.max(first + 1)
        };
        let mut rgb = Vec::with_capacity(3 * rows * columns);
        for row in 0..rows {
            for column in 0..columns {
                let (mut sum, mut count) = ([0_u64; 3], 0);
                for from_row in covered(row, rows, self.rows) {
                    for from_column in covered(column, columns, self.columns) {
                        let pixel = self.pixel(from_row, from_column);
                        (0..3).for_each(|colour| sum[colour] += u64::from(pixel[colour]));
                        count += 1;
                    }
                }
                // A rounded mean of bytes is a byte.
                rgb.extend(sum.map(|sum| ((sum + count / 2) / count) as u8));
            }
        }
        Self { rows, columns, rgb }
    }

    /// The image as a PNG file's content.
    ///
    /// # Errors
    /// Where it has more rows or columns than the format can say.
    pub fn to_png(&self) -> Result<Vec<u8>> {
        let wrong =
            |fault: String| Error::work(format!("image: cannot be written as PNG: {fault}"));
        let side = |pixels: usize| u32::try_from(pixels).map_err(|e| wrong(e.to_string()));
        let mut file = Vec::new();
        PngEncoder::new(&mut file)
            .write_image(
                &self.rgb,
                side(self.columns)?,
                side(self.rows)?,
                ExtendedColorType::Rgb8,
            )
            .map_err(|e| wrong(e.to_string()))?;
        Ok(file)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn subsampling_takes_the_mean_of_what_a_pixel_covers() {
        // Three columns to two: the first covers one of them, the second two.
        let image = Image::new(1, 3, vec![10, 0, 0, 20, 0, 0, 31, 0, 0]).unwrap();
        let halved = image.subsampled(1, 2);
        assert_eq!((halved.pixel(0, 0)[0], halved.pixel(0, 1)[0]), (10, 26));
        // And to six: each twice.
        let doubled: Vec<u8> = (0..6)
            .map(|column| image.subsampled(2, 6).pixel(1, column)[0])
            .collect();
        assert_eq!(doubled, [10, 10, 20, 20, 31, 31]);
    }

    #[test]
    fn values_that_fit_no_shape_are_told() {
        for (rows, columns, values) in [(0, 0, 0), (2, 2, 11), (usize::MAX, 2, 12)] {
            let error = Image::new(rows, columns, vec![0; values]).unwrap_err();
            assert!(error.to_string().contains("three a pixel"), "{error}");
        }
    }

    #[test]
    fn a_png_holds_the_same_pixels() {
        let image = Image::new(2, 1, vec![1, 2, 3, 250, 0, 9]).unwrap();
        let file = image.to_png().unwrap();
        assert_eq!(frame::decoded(&file).unwrap(), image);
    }
}
