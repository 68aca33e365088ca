//! What the rows of one time say together: an answer, and how probable which places are held.

use crate::{
    error::{Error, Result},
    localiser::{Estimate, Probable, Step},
};
use std::path::Path;

/// How far from 1 the probabilities of a belief may sum: cells that a program left out as next to nothing.
const SUM: f64 = 1e-3;
/// Rings and rays of places that stand for a Gaussian, all as probable.
const RINGS: usize = 16;
/// See [`RINGS`].
const RAYS: usize = 16;
/// Edge of the square that holds most of the particles and whose mean is the answer, in metres.
const SQUARE_M: f64 = 1.0;

/// What was said at one time.
pub(super) struct Said {
    pub time_s: f64,
    pub step: Step,
}

/// Which columns a belief stands in.
#[derive(Clone, Copy)]
pub(super) enum Belief {
    Covariance([usize; 3]),
    Weight(usize),
    Probability(usize),
}

/// One row of a table.
pub(super) struct Row {
    pub place: [f64; 2],
    pub heading_rad: Option<f64>,
    /// Weight or probability; else 1.
    pub weight: f64,
    pub covariance: Option<[f64; 3]>,
}

/// What the rows of one time say together; the first of them stands on that line.
///
/// # Errors
/// Where there are several rows for one answer, or weights or probabilities have no sound sum.
pub(super) fn together(
    file: &Path,
    belief: Option<Belief>,
    time_s: f64,
    line: u64,
    rows: &[Row],
) -> Result<Said> {
    let wrong = |fault: String| Error::input(file, format!("line {line}"), fault);
    let sum: f64 = rows.iter().map(|row| row.weight).sum();
    let one = |rows: &[Row]| match rows {
        [one] => Ok((one.place, one.heading_rad)),
        _ => Err(wrong(format!(
            "{} rows at {time_s} s; expected one answer a time, or a column `weight` or `probability`",
            rows.len()
        ))),
    };
    let step = match belief {
        None => {
            let (place, heading_rad) = one(rows)?;
            Step {
                estimate: Some(Estimate::Place(place)),
                heading_rad,
                posterior: Vec::new(),
            }
        }
        Some(Belief::Covariance(_)) => {
            let (place, heading_rad) = one(rows)?;
            Step {
                estimate: Some(Estimate::Place(place)),
                heading_rad,
                posterior: gaussian(place, rows[0].covariance.unwrap_or_default()),
            }
        }
        Some(Belief::Weight(_)) => {
            if !(sum > 0.0 && sum.is_finite()) {
                return Err(wrong(format!(
                    "weights at {time_s} s sum to {sum}; expected more than 0"
                )));
            }
            let (place, heading_rad) = densest(rows);
            Step {
                estimate: Some(Estimate::Place(place)),
                heading_rad,
                posterior: shares(rows, sum),
            }
        }
        Some(Belief::Probability(_)) => {
            if (sum - 1.0).abs() > SUM {
                return Err(wrong(format!(
                    "probabilities at {time_s} s sum to {sum}; expected 1 ± {SUM}"
                )));
            }
            let likelier = |a: &&Row, b: &&Row| a.weight.total_cmp(&b.weight);
            // As where a localiser's posterior is its answer: of several as likely the last.
            let likeliest = rows.iter().max_by(likelier);
            Step {
                estimate: likeliest.map(|row| Estimate::Place(row.place)),
                heading_rad: likeliest.and_then(|row| row.heading_rad),
                posterior: shares(rows, sum),
            }
        }
    };
    Ok(Said { time_s, step })
}

/// Shares of the whole; those that sum to 1 but for rounding are taken as they stand, so that what was equal stays equal.
fn shares(rows: &[Row], sum: f64) -> Vec<Probable> {
    let sum = if (sum - 1.0).abs() < 1e-9 { 1.0 } else { sum };
    let held = rows.iter().filter(|row| row.weight > 0.0);
    held.map(|row| (row.place, row.weight / sum)).collect()
}

/// The mean of the particles in the square that holds most of their weight, the first of several with as much.
fn densest(rows: &[Row]) -> ([f64; 2], Option<f64>) {
    let square = |row: &Row| row.place.map(|m| (m / SQUARE_M).floor());
    let mut sorted: Vec<&Row> = rows.iter().collect();
    let order = |a: &&Row, b: &&Row| {
        let (a, b) = (square(a), square(b));
        a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1]))
    };
    sorted.sort_by(order);
    let weight = |rows: &[&Row]| rows.iter().map(|row| row.weight).sum::<f64>();
    let squares = sorted.chunk_by(|a, b| square(a) == square(b));
    let mut heaviest: (&[&Row], f64) = (&[], 0.0);
    for rows in squares {
        let weight = weight(rows);
        if weight > heaviest.1 {
            heaviest = (rows, weight);
        }
    }
    let (rows, all) = heaviest;
    let mean =
        |of: &dyn Fn(&Row) -> f64| rows.iter().map(|row| row.weight * of(row)).sum::<f64>() / all;
    let heading = rows.iter().all(|row| row.heading_rad.is_some()).then(|| {
        let of = |part: fn(f64) -> f64| mean(&|row| part(row.heading_rad.unwrap_or(0.0)));
        of(f64::sin).atan2(of(f64::cos))
    });
    (
        [mean(&|row| row.place[0]), mean(&|row| row.place[1])],
        heading,
    )
}

/// Places as probable as each other that stand for a Gaussian: on the middle radii of rings of one mass each.
pub(super) fn gaussian([x, y]: [f64; 2], [xx, xy, yy]: [f64; 3]) -> Vec<Probable> {
    // Cholesky's root of the covariance.
    let a = xx.sqrt();
    let b = if a > 0.0 { xy / a } else { 0.0 };
    let c = (yy - b * b).max(0.0).sqrt();
    let share = 1.0 / (RINGS * RAYS) as f64;
    let on_ring = |ring: usize| {
        let outside = 1.0 - (ring as f64 + 0.5) / RINGS as f64;
        let radius = (-2.0 * outside.ln()).sqrt();
        (0..RAYS).map(move |ray| {
            let angle = std::f64::consts::TAU * (ray as f64 + 0.5) / RAYS as f64;
            let (u, v) = (radius * angle.cos(), radius * angle.sin());
            ([x + a * u, y + b * u + c * v], share)
        })
    };
    (0..RINGS).flat_map(on_ring).collect()
}
