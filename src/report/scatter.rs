//! Values at places in the plane, shown by colour, as SVG.

use super::{
    canvas::{WIDTH, at, drawable, font, picture, px, range, shortened, tick},
    plane::axes,
};
use crate::error::{Error, Result};
use plotters::{
    prelude::*,
    style::RGBColor,
    style::text_anchor::{HPos, Pos, VPos},
};
use std::ops::Range;

/// From dark blue over grey to yellow: lightness rises all the way, and blue and yellow are distinct for any kind of
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
        let mut chart = axes(
            &frame,
            range(x_m.iter().copied(), 0.04, false),
            range(y_m.iter().copied(), 0.04, false),
        )?;
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
