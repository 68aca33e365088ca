//! Axes of the plane: x and y in metres, both to one scale.

use super::canvas::{Canvas, GRID, INK, font, px, tick};
use plotters::{coord::types::RangedCoordf64, prelude::*};
use std::{error::Error, ops::Range};

/// A chart whose axes are x and y in metres.
pub(super) type Plane<'a, 'b> =
    ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// Draws the axes for places within two ranges, one of which is widened to the other's scale.
pub(super) fn axes<'a, 'b>(
    canvas: &'a Canvas<'b>,
    x: Range<f64>,
    y: Range<f64>,
) -> Result<Plane<'a, 'b>, Box<dyn Error>> {
    let (margin, left, bottom, right, top) = (px(14), px(62), px(48), px(16), px(8));
    let (width, height) = canvas.dim_in_pixel();
    let shape = f64::from(width - margin - left - right) / f64::from(height - bottom - top);
    let (x, y) = one_scale(x, y, shape);
    let mut chart = ChartBuilder::on(canvas)
        .margin_top(top)
        .margin_right(right)
        .margin_left(margin)
        .set_label_area_size(LabelAreaPosition::Left, left)
        .margin_bottom(px(6))
        .set_label_area_size(LabelAreaPosition::Bottom, bottom - px(6))
        .build_cartesian_2d(x.clone(), y.clone())?;
    chart
        .configure_mesh()
        .x_labels(10)
        .y_labels(8)
        .max_light_lines(0)
        .bold_line_style(ShapeStyle::from(&GRID).stroke_width(px(1)))
        .axis_style(ShapeStyle::from(&INK).stroke_width(px(1)))
        .label_style(font(15))
        .axis_desc_style(font(16))
        .x_label_formatter(&|metres| tick(*metres, &x))
        .y_label_formatter(&|metres| tick(*metres, &y))
        .x_desc("x (m)")
        .y_desc("y (m)")
        .draw()?;
    Ok(chart)
}

/// Widens one of two ranges so that a metre is as long on both axes of a frame `shape` times as wide as high.
fn one_scale(x: Range<f64>, y: Range<f64>, shape: f64) -> (Range<f64>, Range<f64>) {
    let wider = |range: Range<f64>, width: f64| {
        let more = 0.5 * (width - (range.end - range.start)).max(0.0);
        range.start - more..range.end + more
    };
    let (width, height) = (x.end - x.start, y.end - y.start);
    (wider(x, height * shape), wider(y, width / shape))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_metre_is_a_metre_on_both_axes() {
        let (x, y) = one_scale(0.0..10.0, 0.0..10.0, 2.0);
        assert_eq!((x, y), (-5.0..15.0, 0.0..10.0));
        let (x, y) = one_scale(0.0..10.0, 4.0..5.0, 2.0);
        assert_eq!((x, y), (0.0..10.0, 2.0..7.0));
    }
}
