//! Curves with bands, in one frame or in several stacked above one another, as SVG.

use super::{
    canvas::{
        Canvas, Drawn, GRID, INK, WIDTH, at, colour, dash, drawable, font, picture, px, range,
        shortened, tick,
    },
    legend::{draw_legend, legend_width},
};
use crate::error::{Error, Result};
use plotters::prelude::*;
use std::ops::Range;

/// One curve: y over x, with a band such as a 95 % interval around it where there is one. A value that is not finite
/// leaves a gap.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Curve {
    /// What the legend calls it.
    pub name: String,
    /// In the unit of the x axis, in the order to be joined.
    pub x: Vec<f64>,
    /// In the unit of the y axis, one an x.
    pub y: Vec<f64>,
    /// Lower and upper edge of the band, one an x each.
    pub band: Option<(Vec<f64>, Vec<f64>)>,
}

/// One of several frames that share the x axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Label of its y axis, with the unit.
    pub y_label: String,
    /// What it shows; the first curve of each panel has the same colour, and so on.
    pub curves: Vec<Curve>,
    /// Ends of the y axis; `None`: as the values call for.
    pub y_range: Option<(f64, f64)>,
}

/// How neighbouring points are joined.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Trace {
    /// By straight lines.
    Line,
    /// A value holds until the next point.
    Step,
}

/// A plot of curves, as the text of an SVG file; the legend stands beside the frame and covers nothing.
///
/// # Errors
/// Where a curve's `x`, `y` and band differ in length.
///
/// ```
/// use ballmark::report::{Curve, line_plot};
/// let error = Curve { name: "filters".into(), x: vec![0.0, 1.0, 2.0], y: vec![29.7, 12.0, 0.4], band: None };
/// let svg = line_plot("Global localisation", "distance travelled (m)", "expected error (m)", &[error])?;
/// assert!(svg.starts_with("<svg") && svg.contains("expected error (m)"));
/// # Ok::<(), ballmark::Error>(())
/// ```
pub fn line_plot(title: &str, x_label: &str, y_label: &str, curves: &[Curve]) -> Result<String> {
    let panel = Panel {
        y_label: y_label.into(),
        curves: curves.to_vec(),
        y_range: None,
    };
    framed_plot(title, x_label, &panel)
}

/// The same of a panel, whose y axis may have stated ends.
///
/// # Errors
/// As [`line_plot`].
pub fn framed_plot(title: &str, x_label: &str, panel: &Panel) -> Result<String> {
    let axis = XAxis {
        label: x_label,
        names: &[],
    };
    panels(
        title,
        &axis,
        std::slice::from_ref(panel),
        Trace::Line,
        FRAME,
    )
}

/// Curves over named steps, such as prior uncertainties from narrow to none: step i stands at x = i, the steps equally far
/// apart.
///
/// # Errors
/// As [`line_plot`].
pub fn category_plot(
    title: &str,
    x_label: &str,
    names: &[String],
    panel: &Panel,
) -> Result<String> {
    let axis = XAxis {
        label: x_label,
        names,
    };
    panels(
        title,
        &axis,
        std::slice::from_ref(panel),
        Trace::Line,
        FRAME,
    )
}

/// Height of a frame that stands alone, in pixels.
const FRAME: u32 = 440;

/// The x axis that all panels share.
struct XAxis<'a> {
    label: &'a str,
    /// Where not empty, what stands at 0, 1, … in place of numbers.
    names: &'a [String],
}

impl XAxis<'_> {
    fn range(&self, x: impl Iterator<Item = f64>) -> Range<f64> {
        match self.names.len() {
            0 => range(x, 0.0, false),
            n => -0.3..n as f64 - 0.7,
        }
    }

    fn tick(&self, x: f64, range: &Range<f64>) -> String {
        if self.names.is_empty() {
            return tick(x, range);
        }
        let name = self.names.get(x.round().max(0.0) as usize);
        name.filter(|_| (x - x.round()).abs() < 1e-6)
            .map_or(String::new(), |name| shortened(name, 12))
    }
}

/// Panels above one another with one x axis, such as every feature's output along a route.
///
/// # Errors
/// As [`line_plot`].
pub fn stacked_plot(title: &str, x_label: &str, all: &[Panel], trace: Trace) -> Result<String> {
    let axis = XAxis {
        label: x_label,
        names: &[],
    };
    panels(title, &axis, all, trace, 120)
}

fn panels(title: &str, axis: &XAxis, all: &[Panel], trace: Trace, each: u32) -> Result<String> {
    let curves = || all.iter().flat_map(|panel| &panel.curves);
    for curve in curves() {
        let band = curve
            .band
            .as_ref()
            .map_or((curve.y.len(), curve.y.len()), |(l, h)| (l.len(), h.len()));
        if curve.x.len() != curve.y.len() || band != (curve.y.len(), curve.y.len()) {
            let name = &curve.name;
            return Err(Error::work(format!(
                "curve `{name}`: x, y and band differ in length; expected one each a point"
            )));
        }
    }
    let x_range = axis.range(curves().flat_map(|curve| curve.x.iter().copied()));
    let most = all.iter().max_by_key(|panel| panel.curves.len());
    let names: Vec<&str> = match most {
        Some(panel) if panel.curves.len() > 1 => {
            panel.curves.iter().map(|c| c.name.as_str()).collect()
        }
        _ => Vec::new(),
    };
    let legend_rows = 30 + 24 * names.len() as u32;
    let height = (each * all.len().max(1) as u32).max(legend_rows) + 40 + X_AXIS;
    picture(height, title, |canvas| {
        let legend_width = legend_width(&names);
        let (frames, legend) = canvas.split_horizontally(px(WIDTH - legend_width));
        let frame_height = (height - 40 - X_AXIS) / all.len().max(1) as u32;
        for (index, panel) in all.iter().enumerate() {
            let last = index + 1 == all.len();
            let top = index as u32 * frame_height;
            let bottom = top + frame_height + if last { X_AXIS } else { 0 };
            let (above, _) = frames.split_vertically(px(bottom));
            let (_, frame) = above.split_vertically(px(top));
            draw_panel(&frame, panel, &x_range, (axis, last), trace)?;
        }
        draw_legend(&legend, &names)
    })
}

/// Height of the x axis with its numbers and label, in pixels.
const X_AXIS: u32 = 52;

fn draw_panel(
    frame: &Canvas<'_>,
    panel: &Panel,
    x_range: &Range<f64>,
    (axis, is_last): (&XAxis, bool),
    trace: Trace,
) -> Drawn {
    let x_label = is_last.then_some(axis.label);
    let y_range = match panel.y_range {
        Some((low, high)) if drawable(low) && drawable(high) && low < high => low..high,
        _ => {
            let bands = panel.curves.iter().filter_map(|curve| curve.band.as_ref());
            let edges = bands.flat_map(|(low, high)| low.iter().chain(high));
            let values = panel.curves.iter().flat_map(|curve| &curve.y).chain(edges);
            range(values.copied(), 0.05, true)
        }
    };
    let mut chart = ChartBuilder::on(frame)
        .margin_top(px(8))
        .margin_bottom(px(if x_label.is_some() { 6 } else { 14 }))
        .margin_left(px(14))
        .margin_right(px(20))
        .set_label_area_size(LabelAreaPosition::Left, px(66))
        .set_label_area_size(
            LabelAreaPosition::Bottom,
            if x_label.is_some() { px(X_AXIS - 6) } else { 0 },
        )
        .build_cartesian_2d(x_range.clone(), y_range.clone())?;
    let tall = frame.dim_in_pixel().1 > px(250);
    let (x_tick, y_tick) = (
        |x: &f64| axis.tick(*x, x_range),
        |y: &f64| tick(*y, &y_range),
    );
    let mut mesh = chart.configure_mesh();
    mesh.x_labels(axis.names.len().max(10))
        .y_labels(if tall { 8 } else { 4 })
        .max_light_lines(0)
        .bold_line_style(ShapeStyle::from(&GRID).stroke_width(px(1)))
        .axis_style(ShapeStyle::from(&INK).stroke_width(px(1)))
        .label_style(font(15))
        .axis_desc_style(font(16))
        .x_label_formatter(&x_tick)
        .y_label_formatter(&y_tick)
        .y_desc(shortened(&panel.y_label, if tall { 48 } else { 14 }));
    if let Some(label) = x_label {
        mesh.x_desc(label);
    }
    mesh.draw()?;

    for (index, curve) in panel.curves.iter().enumerate() {
        if let Some((low, high)) = &curve.band {
            let edges: Vec<(f64, f64)> = low.iter().copied().zip(high.iter().copied()).collect();
            for part in stretches(&curve.x, |k| drawable(edges[k].0) && drawable(edges[k].1)) {
                let lower = part.clone().map(|k| (curve.x[k], edges[k].0));
                let upper = part.rev().map(|k| (curve.x[k], edges[k].1));
                let outline: Vec<(f64, f64)> = lower.chain(upper).collect();
                chart.draw_series([Polygon::new(outline, colour(index).mix(0.18))])?;
            }
        }
    }
    for (index, curve) in panel.curves.iter().enumerate() {
        let ink = ShapeStyle::from(&colour(index)).stroke_width(px(2));
        for part in stretches(&curve.x, |k| drawable(curve.y[k])) {
            let points = joined(curve, part, trace);
            if let [only] = points[..] {
                chart.draw_series([Circle::new(only, at(2), ink.filled())])?;
                continue;
            }
            match dash(index) {
                None => chart.draw_series([PathElement::new(points, ink)])?,
                Some((dash, gap)) => {
                    chart.draw_series([plotters::element::DashedPathElement::new(
                        points, dash, gap, ink,
                    )])?
                }
            };
        }
    }
    Ok(())
}

/// Unbroken stretches of points that can be drawn.
fn stretches(x: &[f64], can: impl Fn(usize) -> bool) -> Vec<Range<usize>> {
    let can = |k: usize| k < x.len() && drawable(x[k]) && can(k);
    let starts = (0..x.len()).filter(|&k| can(k) && (k == 0 || !can(k - 1)));
    let end = |start: usize| (start..=x.len()).find(|&k| !can(k)).unwrap_or(x.len());
    starts.map(|start| start..end(start)).collect()
}

fn joined(curve: &Curve, part: Range<usize>, trace: Trace) -> Vec<(f64, f64)> {
    let mut points: Vec<(f64, f64)> = Vec::with_capacity(2 * part.len());
    for k in part {
        if let (Trace::Step, Some(&(_, held))) = (trace, points.last()) {
            points.push((curve.x[k], held));
        }
        points.push((curve.x[k], curve.y[k]));
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(name: &str, y: &[f64]) -> Curve {
        Curve {
            name: name.into(),
            x: (0..y.len()).map(|k| k as f64).collect(),
            y: y.to_vec(),
            band: None,
        }
    }

    #[test]
    fn gaps_cut_a_curve_and_lonely_points_are_dots() {
        let plot = |y: &[f64]| line_plot("t", "x (m)", "y (m)", &[curve("a", y)]).unwrap();
        let in_colour = |svg: &str, tag: &str| {
            svg.lines()
                .filter(|l| l.starts_with(tag) && l.contains("#0072B2"))
                .count()
        };
        assert_eq!(in_colour(&plot(&[1.0, 2.0, 3.0, 4.0]), "<polyline"), 1);
        let broken = plot(&[1.0, 2.0, f64::NAN, 4.0, 5.0, f64::INFINITY, 7.0]);
        assert_eq!(
            (
                in_colour(&broken, "<polyline"),
                in_colour(&broken, "<circle")
            ),
            (2, 1)
        );
    }

    #[test]
    fn nothing_to_draw_is_an_empty_frame() {
        for curves in [
            vec![],
            vec![curve("a", &[])],
            vec![curve("a", &[f64::NAN; 3])],
            vec![curve("a", &[1e300, -1e300])],
        ] {
            assert!(
                line_plot("t", "x", "y", &curves)
                    .unwrap()
                    .ends_with("</svg>\n")
            );
        }
        assert!(
            stacked_plot("t", "x", &[], Trace::Step)
                .unwrap()
                .ends_with("</svg>\n")
        );
    }

    #[test]
    fn the_same_bytes_each_time_and_words_escaped() {
        let curves = [curve("a < b & \"c\"", &[1.0, 2.0]), curve("d", &[2.0, 1.0])];
        let plot = || line_plot("t", "x", "y", &curves).unwrap();
        assert_eq!(plot(), plot());
        assert!(plot().contains("a &lt; b &amp; &quot;c&quot;"));
    }

    #[test]
    fn lengths_must_agree() {
        let mut uneven = curve("odd", &[1.0, 2.0]);
        uneven.band = Some((vec![0.0], vec![1.0, 2.0]));
        let error = line_plot("t", "x", "y", &[uneven]).unwrap_err().to_string();
        assert!(error.contains("`odd`"), "{error}");
    }

    #[test]
    fn a_step_holds_its_value() {
        let points = joined(&curve("a", &[0.0, 1.0]), 0..2, Trace::Step);
        assert_eq!(points, [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)]);
    }
}
