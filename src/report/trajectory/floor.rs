//! The traces of a run on the floor, as SVG: R06 3.2 asks for them.

use crate::{
    error::Result,
    geometry::Pose,
    report::{
        canvas::{WIDTH, at, colour, dash, drawable, picture, px, range},
        legend::draw_legend,
        plane::axes,
    },
    score::trajectory::RunTraces,
};
use plotters::{element::DashedPathElement, prelude::*};

const HEIGHT: u32 = 560;
const BESIDE: u32 = 180;

/// Real poses, estimates before correction and after, seen from above, both axes to one scale; the way begins at the dot.
///
/// # Errors
/// Where drawing fails.
///
/// ```
/// use ballmark::{Pose, report::traces_plot, score::trajectory::RunTraces};
/// let real: Vec<Pose> = (0..9).map(|k| Pose::new(f64::from(k), 0.0, 0.0)).collect();
/// let posterior = real.iter().map(|pose| Pose { y_m: 0.1, ..*pose }).collect();
/// let traces = RunTraces { real, posterior, ..RunTraces::default() };
/// assert!(traces_plot("R1", &traces)?.contains("estimate"));
/// # Ok::<(), ballmark::Error>(())
/// ```
pub fn traces_plot(title: &str, traces: &RunTraces) -> Result<String> {
    let prior: Vec<Pose> = traces.prior.iter().flatten().copied().collect();
    let all = || traces.real.iter().chain(&traces.posterior).chain(&prior);
    let (wide, high) = (
        range(all().map(|pose| pose.x_m), 0.04, false),
        range(all().map(|pose| pose.y_m), 0.04, false),
    );
    let point = |pose: &Pose| (pose.x_m, pose.y_m);
    let is_drawable = |pose: &&Pose| drawable(pose.x_m) && drawable(pose.y_m);
    picture(HEIGHT, title, |canvas| {
        let (frame, beside) = canvas.split_horizontally(px(WIDTH - BESIDE));
        let mut chart = axes(&frame, wide, high)?;
        let ink = |curve: usize| ShapeStyle::from(&colour(curve));
        for (curve, poses) in [&traces.real, &traces.posterior].into_iter().enumerate() {
            let way: Vec<_> = poses.iter().filter(is_drawable).map(point).collect();
            let style = ink(curve).stroke_width(px(2));
            match dash(curve) {
                None => chart.draw_series([PathElement::new(way, style)])?,
                Some((dash, gap)) => {
                    let line = DashedPathElement::new(way, dash, gap, style);
                    chart.draw_series([line])?
                }
            };
        }
        let places = prior.iter().filter(is_drawable);
        chart.draw_series(places.map(|pose| Circle::new(point(pose), at(2), ink(2).filled())))?;
        let start = traces.real.first().filter(|pose| is_drawable(pose));
        chart.draw_series(start.map(|pose| Circle::new(point(pose), at(5), ink(0).filled())))?;
        let mut names = vec!["real", "estimate"];
        names.extend((!prior.is_empty()).then_some("before correction"));
        draw_legend(&beside, &names)
    })
}
