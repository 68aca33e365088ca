//! Values at places in the plane, told by colour, as SVG.

use super::canvas::{GRID, INK, WIDTH, at, drawable, font, picture, px, range, shortened, tick};
use crate::error::{Error, Result};
use plotters::{
    prelude::*,
    style::RGBColor,
    style::text_anchor::{HPos, Pos, VPos},
};
use std::ops::Range;

/// From dark blue over grey to yellow: lightness rises all the way, and blue and yellow are told apart with any kind of
/// colour vision (the idea of Nuñez, Anderton & Renslow 2018).
const SCALE: [RGBColor; 3] = [
    RGBColor(0, 32, 96),
    RGBColor(125, 124, 120),
    RGBColor(238, 205, 30),
];
const HEIGHT: u32 = 560;
const BAR_STEPS: u32 = 64;

/// Values over places (x, y) in metres, both axes to one scale; a value that is not finite is an empty circle, a place
/// that is not finite is left out. `value_range`: the ends of the colours; `None`: as the values call for.
///
/// # Errors
/// Where `x_m`, `y_m` and `value` differ in length.
///
/// ```
/// let svg = ballmark::report::scatter_plot("Feature 1", "P(f = 1)", &[0.0, 2.0], &[0.0, 1.0], &[0.1, 0.9], Some((0.0, 1.0)))?;
/// assert!(svg.contains("P(f = 1)"));
/// # Ok::<(), ballmark::Error>(())
/// ```
pub fn scatter_plot(
    title: &str,
    value_label: &str,
    x_m: &[f64],
    y_m: &[f64],
    value: &[f64],
    value_range: Option<(f64, f64)>,
) -> Result<String> {
    if x_m.len() != y_m.len() || x_m.len() != value.len() {
        return Err(Error::work(format!(
            "`{title}`: {} x, {} y and {} values; expected as many of each",
            x_m.len(),
            y_m.len(),
            value.len()
        )));
    }
    let values = match value_range {
        Some((low, high)) if drawable(low) && drawable(high) && low < high => low..high,
        _ => range(value.iter().copied(), 0.0, false),
    };
    picture(HEIGHT, title, |canvas| {
        let (frame, bar) = canvas.split_horizontally(px(WIDTH - 120));
        let (margin, left, bottom, right, top) = (px(14), px(62), px(48), px(16), px(8));
        let (width, height) = frame.dim_in_pixel();
        let shape = f64::from(width - margin - left - right) / f64::from(height - bottom - top);
        let (x_range, y_range) = one_scale(
            range(x_m.iter().copied(), 0.04, false),
            range(y_m.iter().copied(), 0.04, false),
            shape,
        );
        let mut chart = ChartBuilder::on(&frame)
            .margin_top(top)
            .margin_right(right)
            .margin_left(margin)
            .set_label_area_size(LabelAreaPosition::Left, left)
            .margin_bottom(px(6))
            .set_label_area_size(LabelAreaPosition::Bottom, bottom - px(6))
            .build_cartesian_2d(x_range.clone(), y_range.clone())?;
        chart
            .configure_mesh()
            .x_labels(10)
            .y_labels(8)
            .max_light_lines(0)
            .bold_line_style(ShapeStyle::from(&GRID).stroke_width(px(1)))
            .axis_style(ShapeStyle::from(&INK).stroke_width(px(1)))
            .label_style(font(15))
            .axis_desc_style(font(16))
            .x_label_formatter(&|x| tick(*x, &x_range))
            .y_label_formatter(&|y| tick(*y, &y_range))
            .x_desc("x (m)")
            .y_desc("y (m)")
            .draw()?;
        let places = (0..value.len()).filter(|&k| drawable(x_m[k]) && drawable(y_m[k]));
        chart.draw_series(places.map(|k| {
            let style = match drawable(value[k]) {
                true => ShapeStyle::from(&shade(value[k], &values)).filled(),
                false => ShapeStyle::from(&RGBColor(150, 150, 150)).stroke_width(px(1)),
            };
            Circle::new((x_m[k], y_m[k]), at(3), style)
        }))?;

        let (x, top, bottom) = (at(8), at(40), at(440));
        let step = (bottom - top) / BAR_STEPS as i32;
        for k in 0..BAR_STEPS {
            let share = f64::from(k) / f64::from(BAR_STEPS - 1);
            let low = bottom - step * k as i32;
            let box_ = [(x, low - step), (x + at(18), low)];
            let value = values.start + share * (values.end - values.start);
            bar.draw(&Rectangle::new(box_, shade(value, &values).filled()))?;
        }
        let beside = font(15).pos(Pos::new(HPos::Left, VPos::Center));
        for k in 0..5 {
            let share = f64::from(k) / 4.0;
            let height = bottom - (share * f64::from(step * BAR_STEPS as i32)) as i32;
            let value = values.start + share * (values.end - values.start);
            let fine = 0.0..0.1 * (values.end - values.start); // quarters need a decimal more than tenths
            bar.draw(&Text::new(
                tick(value, &fine),
                (x + at(24), height),
                beside.clone(),
            ))?;
        }
        bar.draw(&Text::new(
            shortened(value_label, 14),
            (x, at(10)),
            font(15),
        ))?;
        Ok(())
    })
}

/// Widens one of two ranges so that a metre is as long on both axes of a frame `shape` times as wide as high.
pub(super) fn one_scale(x: Range<f64>, y: Range<f64>, shape: f64) -> (Range<f64>, Range<f64>) {
    let wider = |range: Range<f64>, width: f64| {
        let more = 0.5 * (width - (range.end - range.start)).max(0.0);
        range.start - more..range.end + more
    };
    let (width, height) = (x.end - x.start, y.end - y.start);
    (wider(x, height * shape), wider(y, width / shape))
}

fn shade(value: f64, range: &Range<f64>) -> RGBColor {
    let share = ((value - range.start) / (range.end - range.start)).clamp(0.0, 1.0);
    let (from, to, part) = match share < 0.5 {
        true => (SCALE[0], SCALE[1], 2.0 * share),
        false => (SCALE[1], SCALE[2], 2.0 * share - 1.0),
    };
    let mix = |a: u8, b: u8| (f64::from(a) + part * (f64::from(b) - f64::from(a))).round() as u8;
    RGBColor(mix(from.0, to.0), mix(from.1, to.1), mix(from.2, to.2))
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

    #[test]
    fn the_scale_ends_at_its_ends() {
        assert_eq!(shade(-1.0, &(0.0..1.0)), SCALE[0]);
        assert_eq!(shade(0.5, &(0.0..1.0)), SCALE[1]);
        assert_eq!(shade(2.0, &(0.0..1.0)), SCALE[2]);
    }

    #[test]
    fn odd_values_and_none_are_drawn() {
        let nan = f64::NAN;
        let svg = scatter_plot(
            "t",
            "v",
            &[0.0, 1.0, nan],
            &[0.0, 1.0, 2.0],
            &[nan, 1.0, 2.0],
            None,
        )
        .unwrap();
        assert_eq!(svg.matches("<circle").count(), 2);
        assert!(scatter_plot("t", "v", &[], &[], &[], None).is_ok());
        assert!(scatter_plot("t", "v", &[1.0], &[], &[], None).is_err());
    }
}
