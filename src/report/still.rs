//! A few instants of a belief, systems below one another: Thrun (1998), Fig. 5, for those who can't play it.

use super::canvas::{Canvas, Drawn, INK, WIDTH, at, colour, font, picture, px, shortened};
use crate::{
    error::Result,
    experiment::belief_traces::{BeliefTraces, TracedSystem, TracedTrial},
};
use plotters::{
    prelude::*,
    style::{
        RGBColor,
        text_anchor::{HPos, Pos, VPos},
    },
};

/// Instants that are shown.
const INSTANTS: usize = 4;
/// Ground where the robot can be.
const GROUND: RGBColor = RGBColor(225, 225, 225);
/// Shades that are told apart, so that squares side by side become one.
const SHADES: f64 = 8.0;

/// The first trial, a row a system, a column an instant.
///
/// # Errors
/// Where what was kept is damaged, or drawing fails.
pub(super) fn still(title: &str, traces: &BeliefTraces, shown: &[usize]) -> Result<String> {
    let frame = Frame::of(traces);
    let Some(trial) = traces.trials.first() else {
        return picture(60, title, |_| Ok(()));
    };
    let steps = trial.travelled_m.len();
    let instants = steps.clamp(1, INSTANTS);
    let at_step = |column: usize| match instants {
        1 => 0,
        // Close together at first, when most is found out.
        _ => column * column * (steps - 1) / ((instants - 1) * (instants - 1)),
    };
    let wide = (WIDTH - 20) / instants as u32 - 10;
    let high = match traces.is_route {
        true => 70,
        false => (f64::from(wide) * frame.up / frame.across).clamp(40.0, 320.0) as u32,
    };
    let rows: Vec<(usize, &TracedSystem)> = shown
        .iter()
        .filter_map(|&system| Some((system, trial.systems.get(system)?)))
        .collect();
    let row_high = high + 34;
    let mut levels = Vec::new();
    for (_, seen) in &rows {
        levels.push(traces.levels(seen)?);
    }
    picture(40 + 24 + row_high * rows.len() as u32, title, |canvas| {
        for column in 0..instants {
            let step = at_step(column);
            let left = 14 + column as u32 * (wide + 10);
            let words = format!("after {:.1} m", trial.travelled_m.get(step).unwrap_or(&0.0));
            canvas.draw(&Text::new(words, (at(left), at(2)), font(15)))?;
            for (row, (system, seen)) in rows.iter().enumerate() {
                let top = 24 + row as u32 * row_high;
                let panel = Panel {
                    traces,
                    frame: &frame,
                    corner: [f64::from(px(left)), f64::from(px(top + 20))],
                    size: [f64::from(px(wide)), f64::from(px(high))],
                    system: *system,
                };
                if column == 0 {
                    let title = shortened(&traces.systems[*system][1], 34);
                    let style = font(14).pos(Pos::new(HPos::Left, VPos::Top));
                    canvas.draw(&Text::new(title, (at(left), at(top)), style))?;
                }
                let levels = levels[row].get(step);
                panel.draw(
                    canvas,
                    levels.map_or(&[], Vec::as_slice),
                    (trial, seen),
                    step,
                )?;
            }
        }
        Ok(())
    })
}

/// What part of the plan or route is shown, in metres.
struct Frame {
    left: f64,
    across: f64,
    low: f64,
    up: f64,
}

impl Frame {
    fn of(traces: &BeliefTraces) -> Self {
        let ends = |axis: usize| {
            let places = traces.cells.iter().filter_map(|cell| cell.get(axis));
            let (low, high) = places.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), m| {
                (low.min(*m), high.max(*m))
            });
            match low <= high {
                true => (low - 0.5 * traces.cell_m, high - low + traces.cell_m),
                false => (0.0, 1.0),
            }
        };
        let ((left, across), (low, up)) = (ends(0), ends(1));
        Self {
            left,
            across,
            low,
            up,
        }
    }
}

/// One instant of one system.
struct Panel<'a> {
    traces: &'a BeliefTraces,
    frame: &'a Frame,
    /// Left and top, and width and height, in the backend's units.
    corner: [f64; 2],
    size: [f64; 2],
    system: usize,
}

impl Panel<'_> {
    fn draw(
        &self,
        canvas: &Canvas<'_>,
        levels: &[u8],
        (trial, seen): (&TracedTrial, &TracedSystem),
        step: usize,
    ) -> Drawn {
        let ink = ShapeStyle::from(&INK).stroke_width(px(1));
        let level = |cell: usize| levels.get(cell).map_or(0.0, |l| f64::from(*l) / 255.0);
        let truth = &trial.truth[step];
        let answer = seen.answer.get(step).cloned().flatten();
        if self.traces.is_route {
            let base = self.corner[1] + self.size[1];
            let shape = self
                .traces
                .cells
                .iter()
                .enumerate()
                .flat_map(|(cell, place)| {
                    let (from, to) = (
                        self.x(place[0] - 0.5 * self.traces.cell_m),
                        self.x(place[0] + 0.5 * self.traces.cell_m),
                    );
                    let y = (base - level(cell) * self.size[1]) as i32;
                    [(from, y), (to, y)]
                });
            let mut outline: Vec<(i32, i32)> = shape.collect();
            // Only corners are kept.
            outline.dedup_by(|b, a| a == b);
            let outline = corners(outline);
            let ends = [outline.first(), outline.last()];
            if let [Some(first), Some(last)] = ends {
                let mut closed = vec![(first.0, base as i32)];
                closed.extend(&outline);
                closed.push((last.0, base as i32));
                canvas.draw(&Polygon::new(closed, colour(self.system).filled()))?;
            }
            let x = self.x(truth[0]);
            canvas.draw(&PathElement::new(
                [
                    (self.x(self.frame.left), base as i32),
                    (self.x(self.frame.left + self.frame.across), base as i32),
                ],
                ink,
            ))?;
            let line = [(x, self.corner[1] as i32), (x, base as i32 + at(6))];
            canvas.draw(&PathElement::new(line, ink))?;
            return Ok(());
        }
        for (shade, [x, y, right]) in self.runs(|cell| (level(cell).sqrt() * SHADES).ceil()) {
            let edge = 0.5 * self.traces.cell_m;
            let box_ = [
                (self.x(x - edge), self.y(y + edge)),
                (self.x(right + edge), self.y(y - edge)),
            ];
            let style = match shade > 0.0 {
                true => colour(self.system).mix(shade / SHADES).filled(),
                false => ShapeStyle::from(&GROUND).filled(),
            };
            canvas.draw(&Rectangle::new(box_, style))?;
        }
        if let Some([x, y, ..]) = answer.as_deref() {
            let (x, y, d) = (self.x(*x), self.y(*y), at(4));
            let pen = ShapeStyle::from(&colour(self.system)).stroke_width(px(2));
            canvas.draw(&PathElement::new([(x - d, y - d), (x + d, y + d)], pen))?;
            canvas.draw(&PathElement::new([(x - d, y + d), (x + d, y - d)], pen))?;
        }
        let here = (self.x(truth[0]), self.y(truth[1]));
        canvas.draw(&Circle::new(here, at(5), ink))?;
        Ok(())
    }

    fn x(&self, metres: f64) -> i32 {
        (self.corner[0] + (metres - self.frame.left) / self.frame.across * self.size[0]) as i32
    }

    fn y(&self, metres: f64) -> i32 {
        let share = (metres - self.frame.low) / self.frame.up;
        (self.corner[1] + (1.0 - share) * self.size[1]) as i32
    }

    /// Squares of one shade side by side along x as one: the shade, x of the first, y, x of the last.
    fn runs(&self, shade: impl Fn(usize) -> f64) -> Vec<(f64, [f64; 3])> {
        let cells = &self.traces.cells;
        let mut order: Vec<usize> = (0..cells.len()).filter(|&c| cells[c].len() > 1).collect();
        let by = |a: &usize, b: &usize| {
            let rows = cells[*a][1].total_cmp(&cells[*b][1]);
            rows.then_with(|| cells[*a][0].total_cmp(&cells[*b][0]))
        };
        order.sort_by(by);
        let mut runs: Vec<(f64, [f64; 3])> = Vec::new();
        for cell in order {
            let (x, y, shade) = (cells[cell][0], cells[cell][1], shade(cell));
            match runs.last_mut() {
                Some((same, [_, row, right]))
                    if *same == shade && *row == y && x - *right < 1.5 * self.traces.cell_m =>
                {
                    *right = x;
                }
                _ => runs.push((shade, [x, y, x])),
            }
        }
        runs
    }
}

/// Points of a line without those in the middle of a level stretch.
fn corners(points: Vec<(i32, i32)>) -> Vec<(i32, i32)> {
    let mut kept: Vec<(i32, i32)> = Vec::new();
    for point in points {
        if let [.., before, last] = kept[..]
            && before.1 == last.1
            && last.1 == point.1
        {
            kept.pop();
        }
        kept.push(point);
    }
    kept
}
