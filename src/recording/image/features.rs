//! An image in 140 numbers (Thrun 1998, 5.1.3): ten rows and ten columns, seven values each.

use super::{COLUMNS, Image, ROWS};
use crate::recording::Channel;
use std::ops::Range;

/// Rows, and columns, that an image is cut into.
const STRIPS: usize = 10;
/// Values a strip: brightness, three colours, three textures.
const VALUES: usize = 7;

/// The channel `camera` that [`features`] fill.
pub fn channel() -> Channel {
    Channel {
        name: "camera".into(),
        width: 2 * STRIPS * VALUES,
        unit: "standard deviations of the image".into(),
        bearing_rad: None,
        maximum: None,
        offset_m: None,
    }
}

/// The 140 values that stand for an image (Thrun 1998, 5.1.3).
///
/// The image is subsampled to 60 × 64 pixels, and shifted and scaled so that all its values, of the three colours
/// together, have mean 0 and variance 1; so a lamp's strength drops out and hue stays. (An image of one grey all over
/// becomes 0.) Then come ten rows from the top, and ten columns from the left, as near to equal in size as whole pixels
/// allow, each with: mean brightness, i.e. that of the three colours; mean red, green and blue; and for red, green and
/// blue the mean absolute difference of two pixels side by side or one above the other, both in the strip.
///
/// ```
/// use ballmark::recording::image::{Image, features};
/// // Black above white.
/// let half = 30 * 64 * 3;
/// let image = Image::new(60, 64, [vec![0; half], vec![255; half]].concat())?;
/// let values = features(&image);
/// assert_eq!(values.len(), 140);
/// assert_eq!(values[..7], [-1.0, -1.0, -1.0, -1.0, 0.0, 0.0, 0.0]); // the topmost row of ten
/// # Ok::<(), ballmark::Error>(())
/// ```
pub fn features(image: &Image) -> Vec<f32> {
    of_strips(&image.subsampled(ROWS, COLUMNS))
}

/// The features of an image as it is: at least ten pixels high and wide.
fn of_strips(image: &Image) -> Vec<f32> {
    let (rows, columns) = (image.rows(), image.columns());
    let normal = Normal::of(image);
    let strip = |index: usize, all: usize| index * all / STRIPS..(index + 1) * all / STRIPS;
    let across = (0..STRIPS).map(|index| (strip(index, rows), 0..columns));
    let down = (0..STRIPS).map(|index| (0..rows, strip(index, columns)));
    across
        .chain(down)
        .flat_map(|(rows, columns)| of_strip(image, &normal, rows, columns))
        .collect()
}

/// What an image's values are shifted and divided by.
struct Normal {
    mean: f64,
    deviation: f64,
}

impl Normal {
    fn of(image: &Image) -> Self {
        // Whole numbers: exact, whatever the order of the sum.
        let (sum, squares) = image
            .values()
            .iter()
            .fold((0_u64, 0_u64), |(sum, squares), v| {
                let value = u64::from(*v);
                (sum + value, squares + value * value)
            });
        let count = image.values().len() as f64;
        let mean = sum as f64 / count;
        // n Σ v² − (Σ v)² is a whole number too, 0 exactly where all values are the same.
        let count = image.values().len() as u64;
        let spread = count * squares - sum * sum;
        Self {
            mean,
            deviation: (spread as f64).sqrt() / count as f64,
        }
    }

    /// A difference of values in standard deviations.
    fn scaled(&self, difference: f64) -> f64 {
        if self.deviation > 0.0 {
            difference / self.deviation
        } else {
            0.0
        }
    }
}

/// The seven values of one strip.
fn of_strip(
    image: &Image,
    normal: &Normal,
    rows: Range<usize>,
    columns: Range<usize>,
) -> [f32; VALUES] {
    let (mut sum, mut pixels) = ([0_u64; 3], 0_u64);
    let (mut differences, mut pairs) = ([0_u64; 3], 0_u64);
    let mut compare = |one: [u8; 3], other: [u8; 3]| {
        (0..3).for_each(|c| differences[c] += u64::from(one[c].abs_diff(other[c])));
        pairs += 1;
    };
    for row in rows.clone() {
        for column in columns.clone() {
            let pixel = image.pixel(row, column);
            (0..3).for_each(|c| sum[c] += u64::from(pixel[c]));
            pixels += 1;
            if column + 1 < columns.end {
                compare(pixel, image.pixel(row, column + 1));
            }
            if row + 1 < rows.end {
                compare(pixel, image.pixel(row + 1, column));
            }
        }
    }
    let colour = sum.map(|sum| normal.scaled(sum as f64 / pixels as f64 - normal.mean));
    let texture = differences.map(|sum| normal.scaled(sum as f64 / pairs as f64));
    let brightness = colour.iter().sum::<f64>() / 3.0;
    let [red, green, blue] = colour;
    let [in_red, in_green, in_blue] = texture;
    [brightness, red, green, blue, in_red, in_green, in_blue].map(|value| value as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An image whose pixels a function of row and column gives.
    fn image(rows: usize, columns: usize, pixel: impl Fn(usize, usize) -> [u8; 3]) -> Image {
        let places = (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
        let rgb = places.flat_map(|(row, column)| pixel(row, column));
        Image::new(rows, columns, rgb.collect()).unwrap()
    }

    #[track_caller]
    fn close(found: &[f32], expected: &[f64]) {
        let apart = found
            .iter()
            .zip(expected)
            .map(|(f, e)| (f64::from(*f) - e).abs());
        assert!(apart.fold(0.0, f64::max) < 1e-6, "{found:?} {expected:?}");
        assert_eq!(found.len(), expected.len());
    }

    #[test]
    fn one_grey_all_over_is_0() {
        for grey in [0, 7, 255] {
            let values = features(&image(60, 64, |_, _| [grey; 3]));
            assert_eq!(values, [0.0; 140]);
        }
        // One colour all over is not: its channels differ. 30, 60, 90: mean 60, standard deviation √600.
        let values = features(&image(60, 64, |_, _| [30, 60, 90]));
        let one = 30.0 / 600_f64.sqrt();
        for strip in values.chunks(7) {
            close(strip, &[0.0, -one, 0.0, one, 0.0, 0.0, 0.0]);
        }
    }

    #[test]
    fn stripes_by_hand() {
        // 20 × 10 pixels, upright stripes of grey, one pixel wide: −1, +1, −1, … when normalised. A row of ten is two
        // pixels high: 2 · 9 neighbours aside differ by 2, 10 above each other by 0. A column of ten is one pixel wide
        // and 20 high: it has its own brightness, and no texture.
        let stripes = image(20, 10, |_, column| {
            [if column % 2 == 0 { 100 } else { 120 }; 3]
        });
        let values = of_strips(&stripes);
        let texture = 2.0 * 18.0 / 28.0;
        close(
            &values[3 * 7..4 * 7],
            &[0.0, 0.0, 0.0, 0.0, texture, texture, texture],
        );
        close(&values[70..77], &[-1.0, -1.0, -1.0, -1.0, 0.0, 0.0, 0.0]);
        close(&values[77..84], &[1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn a_red_spot_is_found_in_its_row_and_column_only() {
        // 10 × 10 pixels, all black but one at row 2, column 5 with red 60. Of 300 values one is 60: mean 0.2, variance
        // 60²/300 − 0.2² = 11.96.
        let deviation = 11.96_f64.sqrt();
        let spot = image(10, 10, |row, column| {
            if (row, column) == (2, 5) {
                [60, 0, 0]
            } else {
                [0; 3]
            }
        });
        let values = of_strips(&spot);
        let dark = -0.2 / deviation;
        // In its strip of 10 pixels red is 6 in the mean; 2 of 9 pairs differ by 60.
        let red = (6.0 - 0.2) / deviation;
        let of_spot = [
            (red + 2.0 * dark) / 3.0,
            red,
            dark,
            dark,
            2.0 * 60.0 / 9.0 / deviation,
            0.0,
            0.0,
        ];
        for (strip, found) in values.chunks(7).enumerate() {
            if strip == 2 || strip == 15 {
                close(found, &of_spot);
            } else {
                close(found, &[dark, dark, dark, dark, 0.0, 0.0, 0.0]);
            }
        }
    }

    #[test]
    fn light_that_only_grows_stronger_changes_nothing() {
        let pattern = |row: usize, column: usize| ((row * 7 + column * 13) % 60) as u8;
        let dim = image(60, 64, |row, column| [pattern(row, column), 20, 40]);
        let bright = image(60, 64, |row, column| {
            [3 * pattern(row, column) + 9, 69, 129]
        });
        let apart = features(&dim).into_iter().zip(features(&bright));
        assert!(apart.into_iter().all(|(a, b)| (a - b).abs() < 1e-5));
    }
}
