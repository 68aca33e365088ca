//! What all pictures share: size, fonts, colours, ranges of axes.

use crate::error::{Error, Result};
use plotters::{coord::Shift, prelude::*, style::RGBColor};
use std::ops::Range;

pub(super) type Canvas<'a> = DrawingArea<SVGBackend<'a>, Shift>;
/// What drawing returns: the backend's own error, made ours by [`picture`].
pub(super) type Drawn = std::result::Result<(), Box<dyn std::error::Error>>;

/// Width of every picture in pixels.
pub(super) const WIDTH: u32 = 900;
/// The backend knows whole numbers only: it draws at twice the size, for coordinates to half a pixel.
const FINENESS: u32 = 2;
pub(super) const INK: RGBColor = RGBColor(40, 40, 40);
pub(super) const GRID: RGBColor = RGBColor(225, 225, 225);

/// Okabe & Ito (2008), distinct for any kind of colour vision; without their yellow, too pale for a line on white.
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),   // blue
    RGBColor(213, 94, 0),    // vermilion
    RGBColor(0, 158, 115),   // bluish green
    RGBColor(204, 121, 167), // reddish purple
    RGBColor(230, 159, 0),   // orange
    RGBColor(86, 180, 233),  // sky blue
    RGBColor(0, 0, 0),
];
/// Dash and gap in pixels, for print without colours; the first is a full line. As many as are coprime to the colours,
/// so that 28 curves differ.
const DASHES: [Option<(u32, u32)>; 4] = [None, Some((9, 4)), Some((3, 3)), Some((16, 3))];

pub(super) fn colour(curve: usize) -> RGBColor {
    COLOURS[curve % COLOURS.len()]
}

pub(super) fn dash(curve: usize) -> Option<(u32, u32)> {
    DASHES[curve % DASHES.len()].map(|(dash, gap)| (px(dash), px(gap)))
}

/// The colours as a browser names them, in the order of the curves.
pub(super) fn colours_in_words() -> Vec<String> {
    let word = |c: &RGBColor| format!("#{:02X}{:02X}{:02X}", c.0, c.1, c.2);
    COLOURS.iter().map(word).collect()
}

/// Dash and gap of each curve in turn, in pixels; empty for a full line.
pub(super) fn dashes() -> Vec<Vec<u32>> {
    let lengths =
        |dash: &Option<(u32, u32)>| dash.map_or(Vec::new(), |(dash, gap)| vec![dash, gap]);
    DASHES.iter().map(lengths).collect()
}

/// Pixels of the picture in the backend's finer units.
pub(super) const fn px(pixels: u32) -> u32 {
    pixels * FINENESS
}

/// The same, for coordinates.
pub(super) const fn at(pixels: u32) -> i32 {
    px(pixels) as i32
}

/// A sans-serif font of that size in pixels, chosen by the program that shows the picture.
pub(super) fn font(size: u32) -> TextStyle<'static> {
    ("sans-serif", px(size)).into_font().color(&INK)
}

/// A white picture with a title, as SVG text.
pub(super) fn picture(
    height: u32,
    title: &str,
    content: impl FnOnce(&Canvas<'_>) -> Drawn,
) -> Result<String> {
    let mut svg = String::new();
    let drawn = || -> Drawn {
        let canvas = SVGBackend::with_string(&mut svg, (px(WIDTH), px(height))).into_drawing_area();
        canvas.fill(&WHITE)?;
        canvas.draw(&Text::new(shortened(title, 88), (at(14), at(12)), font(20)))?;
        let (_, below_title) = canvas.split_vertically(px(40));
        content(&below_title)?;
        canvas.present()?;
        Ok(())
    }();
    drawn.map_err(|e| Error::work(format!("cannot draw `{title}`: {e}")))?;
    let fine = format!("width=\"{}\" height=\"{}\"", px(WIDTH), px(height));
    let svg = svg.replacen(&fine, &format!("width=\"{WIDTH}\" height=\"{height}\""), 1);
    Ok(svg.replace(is_no_xml, "\u{fffd}"))
}

/// Names from files may hold characters that no XML may, not even escaped (XML 1.0, 2.2).
fn is_no_xml(c: char) -> bool {
    (c.is_control() && !['\t', '\n', '\r'].contains(&c)) || ['\u{fffe}', '\u{ffff}'].contains(&c)
}

/// At most that many characters, the rest replaced by an ellipsis.
pub(super) fn shortened(text: &str, characters: usize) -> String {
    match text.char_indices().nth(characters) {
        Some(_) => text.chars().take(characters - 1).chain(['…']).collect(),
        None => text.to_string(),
    }
}

/// May this number be drawn? Beyond that size a plot shows nothing and its arithmetic fails.
pub(super) fn drawable(value: f64) -> bool {
    value.abs() < 1e15
}

/// Least and greatest drawable value with a margin, never empty; down to 0 where values are positive and `from_zero`.
pub(super) fn range(values: impl Iterator<Item = f64>, margin: f64, from_zero: bool) -> Range<f64> {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for value in values.filter(|&value| drawable(value)) {
        (low, high) = (low.min(value), high.max(value));
    }
    if low > high {
        return 0.0..1.0;
    }
    let zero = from_zero && low >= 0.0;
    if zero {
        low = 0.0;
    }
    let size = low.abs().max(high.abs());
    if high - low <= 1e-9 * size || size == 0.0 {
        let half = if size == 0.0 { 0.5 } else { 0.1 * size };
        (low, high) = (if zero { 0.0 } else { low - half }, high + half);
    }
    let space = margin * (high - low);
    (if zero { 0.0 } else { low - space })..high + space
}

/// A tick's number with as many decimals as the range calls for.
pub(super) fn tick(value: f64, range: &Range<f64>) -> String {
    let decimals = (1.0 - (range.end - range.start).log10().floor()).clamp(0.0, 12.0) as usize;
    let text = format!("{value:.decimals$}");
    if text
        .trim_start_matches('-')
        .bytes()
        .all(|b| matches!(b, b'0' | b'.'))
    {
        return text.trim_start_matches('-').to_string();
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_never_empty() {
        let axis = |values: &[f64], zero| range(values.iter().copied(), 0.0, zero);
        assert_eq!(axis(&[], false), 0.0..1.0);
        assert_eq!(axis(&[f64::NAN, f64::INFINITY, 1e300], true), 0.0..1.0);
        assert_eq!(axis(&[2.0, 4.0], false), 2.0..4.0);
        assert_eq!(axis(&[2.0, 4.0], true), 0.0..4.0);
        assert_eq!(axis(&[0.0], true), 0.0..0.5);
        let flat = axis(&[1e14], false);
        assert!(flat.start < flat.end);
    }

    #[test]
    fn ticks_are_short() {
        assert_eq!(tick(0.1 + 0.2, &(0.0..1.0)), "0.3");
        assert_eq!(tick(-0.0, &(0.0..89.0)), "0");
        assert_eq!(tick(20.0, &(0.0..89.0)), "20");
        assert_eq!(shortened("abcdef", 4), "abc…");
    }
}
