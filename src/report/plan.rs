//! A floor plan with lamps and the way that a robot took, as SVG.

use super::{
    canvas::{WIDTH, at, drawable, picture, px, range},
    plane::axes,
};
use crate::error::Result;
use plotters::{prelude::*, style::RGBColor};

/// A line of a plan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanLine {
    /// One end, metres.
    pub from: [f64; 2],
    /// The other end, metres.
    pub to: [f64; 2],
    /// Red, green and blue, each from 0 to 1; drawn darker, to stand out from white paper.
    pub colour: [f64; 3],
    /// Does light come out of it (a window)? Then it is drawn blue.
    pub window: bool,
    /// Is it above head height, or there only at times? Then it is drawn thin.
    pub thin: bool,
}

/// What a plan's picture shows.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Plan {
    /// Walls, doors, things.
    pub lines: Vec<PlanLine>,
    /// Corners of each lamp, metres, and whether it burns.
    pub lamps: Vec<([[f64; 2]; 4], bool)>,
    /// Places that the robot passed, metres.
    pub path: Vec<[f64; 2]>,
}

const PATH: RGBColor = RGBColor(0, 114, 178);
const WINDOW: RGBColor = RGBColor(86, 180, 233);
const LIT: RGBColor = RGBColor(240, 200, 60);
const DARK: RGBColor = RGBColor(150, 150, 150);
const LEAST_HEIGHT: u32 = 260;
const MAX_HEIGHT: u32 = 1100;

/// A plan, both axes to one scale; what is not finite is left out. The way begins at the dot.
///
/// ```
/// use ballmark::report::{Plan, PlanLine, plan_plot};
/// let wall = PlanLine { from: [0.0, 0.0], to: [9.0, 0.0], colour: [0.8; 3], window: false, thin: false };
/// let plan = Plan { lines: vec![wall], path: vec![[1.0, 2.0], [8.0, 2.0]], ..Plan::default() };
/// assert!(plan_plot("A wall", &plan)?.contains("A wall"));
/// # Ok::<(), ballmark::Error>(())
/// ```
///
/// # Errors
/// Where drawing fails.
pub fn plan_plot(title: &str, plan: &Plan) -> Result<String> {
    let ends = plan.lines.iter().flat_map(|line| [line.from, line.to]);
    let corners = plan.lamps.iter().flat_map(|(corners, _)| *corners);
    let places: Vec<[f64; 2]> = ends
        .chain(corners)
        .chain(plan.path.iter().copied())
        .collect();
    let along = |axis: usize| range(places.iter().map(|place| place[axis]), 0.02, false);
    let (wide, high) = (along(0), along(1));
    let (margins_x, margins_y) = (92, 104);
    let shape = (high.end - high.start) / (wide.end - wide.start);
    let height = (f64::from(WIDTH - margins_x) * shape) as u32;
    let height = height.clamp(LEAST_HEIGHT, MAX_HEIGHT) + margins_y;
    picture(height, title, |canvas| {
        let mut chart = axes(canvas, wide, high)?;
        let finite = |place: &[f64; 2]| place.iter().all(|&metres| drawable(metres));
        let point = |place: [f64; 2]| (place[0], place[1]);
        let lamps = plan
            .lamps
            .iter()
            .filter(|(corners, _)| corners.iter().all(finite));
        chart.draw_series(lamps.map(|(corners, lit)| {
            let fill = if *lit { LIT } else { DARK };
            Polygon::new(corners.map(point), ShapeStyle::from(&fill).filled())
        }))?;
        if let Some(start) = plan.path.iter().find(|place| finite(place)) {
            let way = plan.path.iter().filter(|place| finite(place)).copied();
            let style = ShapeStyle::from(&PATH).stroke_width(px(1));
            chart.draw_series([PathElement::new(way.map(point).collect::<Vec<_>>(), style)])?;
            let dot = Circle::new(point(*start), at(4), ShapeStyle::from(&PATH).filled());
            chart.draw_series([dot])?;
        }
        let lines = plan.lines.iter();
        let lines = lines.filter(|line| finite(&line.from) && finite(&line.to));
        chart.draw_series(lines.map(|line| {
            let dark = |share: f64| (share.clamp(0.0, 1.0) * 160.0) as u8;
            let [red, green, blue] = line.colour.map(dark);
            let ink = match line.window {
                true => WINDOW,
                false => RGBColor(red, green, blue),
            };
            let style = ShapeStyle::from(&ink).stroke_width(if line.thin { 1 } else { px(2) });
            PathElement::new(vec![point(line.from), point(line.to)], style)
        }))?;
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plan_shows_every_line_and_leaves_out_what_is_not_finite() {
        let line = |to: [f64; 2]| PlanLine {
            from: [0.0, 0.0],
            to,
            colour: [1.0, 0.0, 0.0],
            window: false,
            thin: false,
        };
        let lamp = [[1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0]];
        let plan = Plan {
            lines: vec![line([5.0, 0.0]), line([0.0, 5.0]), line([f64::NAN, 0.0])],
            lamps: vec![(lamp, true), (lamp, false)],
            path: vec![[1.0, 1.0], [f64::INFINITY, 0.0], [4.0, 1.0]],
        };
        let svg = plan_plot("t", &plan).unwrap();
        assert_eq!(svg.matches("#A00000").count(), 2); // red, darker
        assert_eq!(svg.matches("<polygon").count(), 2);
        assert_eq!(svg.matches("<circle").count(), 1);
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
        assert!(plan_plot("t", &Plan::default()).is_ok());
    }
}
