//! Names of curves, beside the frame.

use super::canvas::{Canvas, Drawn, at, colour, dash, font, px, shortened};
use plotters::{
    prelude::*,
    style::text_anchor::{HPos, Pos, VPos},
};

/// Most characters of a name that the legend shows.
const LONGEST_NAME: usize = 34;

/// How much room it takes, in pixels.
pub(super) fn legend_width(names: &[&str]) -> u32 {
    let longest = names
        .iter()
        .map(|name| name.chars().count().min(LONGEST_NAME))
        .max();
    longest.map_or(0, |characters| 62 + 8 * characters as u32)
}

/// Draws it, a curve a line.
pub(super) fn draw_legend(area: &Canvas<'_>, names: &[&str]) -> Drawn {
    for (index, name) in names.iter().enumerate() {
        let middle = at(24 + 24 * index as u32);
        let ink = ShapeStyle::from(&colour(index)).stroke_width(px(2));
        let line = [(at(4), middle), (at(38), middle)];
        match dash(index) {
            None => area.draw(&PathElement::new(line, ink))?,
            Some((dash, gap)) => area.draw(&plotters::element::DashedPathElement::new(
                line, dash, gap, ink,
            ))?,
        }
        let beside = font(15).pos(Pos::new(HPos::Left, VPos::Center));
        area.draw(&Text::new(
            shortened(name, LONGEST_NAME),
            (at(46), middle),
            beside,
        ))?;
    }
    Ok(())
}
