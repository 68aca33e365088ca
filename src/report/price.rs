//! What is had for which price, the price on a logarithmic axis, as SVG.

use super::canvas::{GRID, INK, at, colour, drawable, font, picture, px, range, shortened, tick};
use crate::error::Result;
use plotters::{
    prelude::*,
    style::text_anchor::{HPos, Pos, VPos},
};

/// Something with a price.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Priced {
    /// What stands beside its point.
    pub name: String,
    /// Above 0; it is left out otherwise.
    pub price: f64,
    /// What was had for it, each time: small points above one another, and a large one at their mean.
    pub worth: Vec<f64>,
}

const HEIGHT: u32 = 480;
/// Least distance between the lines that names stand on, pixels.
const LINE: f64 = 18.0;

/// Points with their names beside them, over the logarithm of their prices.
///
/// ```
/// use ballmark::report::{Priced, price_plot};
/// let of = |name: &str, price, worth: &[f64]| Priced { name: name.into(), price, worth: worth.to_vec() };
/// let svg = price_plot("Quality against cost", "time a match (µs)", "U(L|R)", &[
///     of("nearest", 1.0, &[0.65, 0.72, 0.55, 0.35]),
///     of("histogram_match", 31.0, &[0.81, 0.85, 0.63, 0.44]),
/// ])?;
/// assert!(svg.contains("histogram_match"));
/// # Ok::<(), ballmark::Error>(())
/// ```
///
/// # Errors
/// None that a caller can cause.
pub fn price_plot(title: &str, price: &str, worth: &str, all: &[Priced]) -> Result<String> {
    let shown: Vec<(usize, &Priced, Vec<f64>)> = all
        .iter()
        .enumerate()
        .map(|(index, one)| {
            let worth = one.worth.iter().copied().filter(|&value| drawable(value));
            (index, one, worth.collect())
        })
        .filter(|(_, one, worth): &(_, _, Vec<f64>)| {
            one.price > 0.0 && drawable(one.price) && !worth.is_empty()
        })
        .collect();
    let decades = |end: fn(f64, f64) -> f64, start: f64| {
        let logs = shown.iter().map(|(_, one, _)| one.price.log10());
        logs.fold(start, end)
    };
    let (low, high) = match shown.is_empty() {
        true => (0.0, 1.0),
        false => (
            decades(f64::min, f64::INFINITY) - 0.2,
            decades(f64::max, f64::NEG_INFINITY) + 0.2,
        ),
    };
    let x_range = 10f64.powf(low)..10f64.powf(high);
    let y_range = range(
        shown.iter().flat_map(|(_, _, worth)| worth.iter().copied()),
        0.05,
        true,
    );
    picture(HEIGHT, title, |canvas| {
        let mut chart = ChartBuilder::on(canvas)
            .margin_top(px(8))
            .margin_bottom(px(6))
            .margin_left(px(14))
            .margin_right(px(150))
            .set_label_area_size(LabelAreaPosition::Left, px(66))
            .set_label_area_size(LabelAreaPosition::Bottom, px(46))
            .build_cartesian_2d(x_range.clone().log_scale(), y_range.clone())?;
        chart
            .configure_mesh()
            .x_labels(8)
            .y_labels(8)
            .max_light_lines(0)
            .bold_line_style(ShapeStyle::from(&GRID).stroke_width(px(1)))
            .axis_style(ShapeStyle::from(&INK).stroke_width(px(1)))
            .label_style(font(15))
            .axis_desc_style(font(16))
            .x_label_formatter(&|x| digits(*x))
            .y_label_formatter(&|y| tick(*y, &y_range))
            .x_desc(price)
            .y_desc(worth)
            .draw()?;
        let mut names: Vec<(i32, f64, usize, &str)> = Vec::new();
        for (index, one, worth) in &shown {
            let ink = colour(*index);
            let mean = worth.iter().sum::<f64>() / worth.len() as f64;
            let small = worth
                .iter()
                .map(|&value| Circle::new((one.price, value), at(2), ink.mix(0.6).filled()));
            chart.draw_series(small)?;
            chart.draw_series([Circle::new((one.price, mean), at(5), ink.filled())])?;
            let (x, y) = chart.backend_coord(&(one.price, mean));
            names.push((x, f64::from(y), *index, &one.name));
        }
        // From the top down, each name at its point's height or below the one above it.
        names.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.2.cmp(&b.2)));
        let mut last = f64::NEG_INFINITY;
        for (x, y, index, name) in names {
            let line = y.max(last + f64::from(at(1)) * LINE);
            last = line;
            let ink = colour(index);
            let style = font(15).color(&ink);
            let style = style.pos(Pos::new(HPos::Left, VPos::Center));
            // The chart's coordinates are those of the whole picture; its title stands above this part of it.
            let (left, top) = canvas.get_base_pixel();
            let place = (x + at(9) - left, line as i32 - top);
            canvas.draw(&Text::new(shortened(name, 24), place, style))?;
        }
        Ok(())
    })
}

/// A tick of a logarithmic axis: its first two digits tell all.
fn digits(value: f64) -> String {
    match value.log10() {
        log if (-3.0..6.0).contains(&log) => {
            let decimals = (1.0 - log.floor()).max(0.0) as usize;
            let text = format!("{value:.decimals$}");
            match text.contains('.') {
                true => text.trim_end_matches('0').trim_end_matches('.').to_string(),
                false => text,
            }
        }
        _ => format!("{value:.0e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn priced(name: &str, price: f64, worth: &[f64]) -> Priced {
        Priced {
            name: name.into(),
            price,
            worth: worth.to_vec(),
        }
    }

    #[test]
    fn what_has_no_price_or_worth_is_left_out() {
        let all = [
            priced("a < b", 2.0, &[0.5, f64::NAN]),
            priced("free", 0.0, &[0.5]),
            priced("unknown price", f64::NAN, &[0.5]),
            priced("worthless", 1.0, &[f64::INFINITY]),
        ];
        let svg = price_plot("t", "x", "y", &all).unwrap();
        assert!(svg.contains("a &lt; b"), "{svg}");
        for name in ["free", "unknown price", "worthless"] {
            assert!(!svg.contains(name));
        }
        assert_eq!(svg.matches("<circle").count(), 2); // the value and the mean
        assert!(
            price_plot("t", "x", "y", &[])
                .unwrap()
                .ends_with("</svg>\n")
        );
    }

    #[test]
    fn names_of_points_at_one_place_stand_below_one_another() {
        let all: Vec<Priced> = (0..4)
            .map(|k| priced(&format!("name{k}"), 1.0, &[0.5]))
            .collect();
        let svg = price_plot("t", "x", "y", &all).unwrap();
        let heights: Vec<i32> = (0..4)
            .map(|k| {
                let before = svg.split(&format!("\nname{k}\n")).next().unwrap();
                let text = before.rsplit("<text ").next().unwrap();
                let y = text.split(" y=\"").nth(1).unwrap();
                y.split('"').next().unwrap().parse().unwrap()
            })
            .collect();
        assert!(heights.windows(2).all(|w| w[1] - w[0] >= 30), "{heights:?}");
    }

    #[test]
    fn ticks_are_short() {
        let ticks = [0.01, 0.30000000000000004, 1.0, 2.5, 20.0, 1000.0, 1e7];
        assert_eq!(
            ticks.map(digits),
            ["0.01", "0.3", "1", "2.5", "20", "1000", "1e7"]
        );
    }
}
