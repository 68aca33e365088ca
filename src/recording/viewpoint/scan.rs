//! What a range scan would have been from beside: the scan drawn anew for a sensor that was shifted and turned.
//!
//! A scan is more than the distances along its beams: the ends of neighbouring beams lie on surfaces, and surfaces can be
//! looked at from elsewhere. So one recorded scan stands for many that the robot might have taken close by. The scan is
//! taken for a chain of straight pieces, one from the end of every beam to the end of the next; the pieces are carried
//! into the frame of the moved sensor; along each of its beams the nearest piece counts. Three things a scan can't tell:
//!
//! - *Depth edges.* Where one beam ends far behind its neighbour there is no surface between the two; the chain is torn
//!   there, and each side goes on at its own range for half the way to the other.
//! - *What was hidden.* From beside, a bearing may look at nothing that the scan has seen. It copies the nearest bearing
//!   that does.
//! - *No return.* Such a beam counts as open at least as far as the sensor reaches: surfaces may hide it, and where none
//!   does, the moved sensor gets no return either.
//!
//! Sensors on a ring count their ranges from where they sit ([`Viewpoint::with_offset_m`]); their height is left out.

use crate::{
    error::{Error, Result},
    geometry::Displacement,
};
use std::f64::consts::{PI, TAU};

#[cfg(test)]
mod tests;

/// Where a sensor without a stated maximum has its open space begin, in metres.
const OPEN_FROM_M: f64 = 30.0;
/// Range of what gave no return: beyond everything that did.
const OPEN: f64 = 1e30;
/// Range of a bearing that nothing is known about.
const UNSEEN: f64 = f64::INFINITY;
/// A reading of 0 has no direction to be carried along; so near counts as this.
const NEAREST_M: f64 = 1e-3;

/// Ranges may differ by this much before a surface is torn, in metres, …
const STEP_M: f64 = 0.3;
/// … and besides by this share of the nearer. On real laser logs neither matters much: anything from 0.1 to 1 m and from
/// 5 to 20 % draws the same scans to a few millimetres.
const SLOPE: f64 = 0.1;
/// Beams this many times further apart than is usual in the sensor are no neighbours, …
const GAP: f64 = 2.5;
/// … nor are any with more than this between them, in radians.
const WIDEST_GAP_RAD: f64 = 1.1;
/// How far beside its axis a lone beam speaks for the surface that it met, in radians at most.
const BESIDE_RAD: f64 = PI / 8.0;
/// Two directions closer than this are the same.
const SAME: f64 = 1e-9;

type Vector = [f64; 2];

fn cross(a: Vector, b: Vector) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn towards(bearing_rad: f64) -> Vector {
    [bearing_rad.cos(), bearing_rad.sin()]
}

/// A stand-in for the angle of a direction that costs one division: grows with it, from 0 ahead to 4 once round.
fn round(v: Vector) -> f64 {
    let (size, share) = (v[0].abs() + v[1].abs(), v[1].abs());
    if size == 0.0 {
        return 0.0;
    }
    let turned = match (v[0] >= 0.0, v[1] >= 0.0) {
        (true, true) => share / size,
        (false, true) => 2.0 - share / size,
        (false, false) => 2.0 + share / size,
        (true, false) => 4.0 - share / size,
    };
    if turned >= 4.0 { 0.0 } else { turned }
}

/// A range sensor's beams, ready to have its scans drawn from elsewhere.
///
/// ```
/// use ballmark::{geometry::Displacement, recording::viewpoint::Viewpoint};
/// // Five beams over 40° look at a wall 4 m ahead.
/// let bearing_rad: Vec<f64> = [-20.0_f64, -10.0, 0.0, 10.0, 20.0].map(f64::to_radians).to_vec();
/// let scan: Vec<f32> = bearing_rad.iter().map(|b| (4.0 / b.cos()) as f32).collect();
/// let step = Displacement { forward_m: 1.0, left_m: 0.0, turn_rad: 0.0 };
///
/// let mut seen = vec![0.0; 5];
/// Viewpoint::new(&bearing_rad, None)?.render(&scan, step, &mut seen);
/// assert!((seen[2] - 3.0).abs() < 1e-6);
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Viewpoint {
    /// Once round from straight ahead.
    beams: Vec<Beam>,
    /// First beam in each of equal parts of the round, and the number of beams at the end.
    first: Vec<usize>,
    /// Reading from which on there was no return.
    maximum_m: Option<f64>,
}

/// One beam, and how it goes with the next one counter-clockwise.
#[derive(Debug, Clone)]
struct Beam {
    /// Its place in the scan.
    index: usize,
    bearing_rad: f64,
    /// How far out along its bearing ranges count from, metres.
    offset_m: f64,
    direction: Vector,
    /// [`round`] of the direction.
    round: f64,
    /// How far to the right and to the left it speaks for the surface that it met: as directions.
    edges: [Vector; 2],
    /// Is the next one a neighbour?
    neighbours: bool,
}

/// A point on something seen, as the moved sensor has it.
#[derive(Clone, Copy)]
struct Point {
    at: Vector,
    range_m: f64,
    round: f64,
}

impl Viewpoint {
    /// For beams at these bearings (radians in the sensor's frame, counter-clockwise, 0 ahead, in any order), of which
    /// readings from `maximum_m` on had no return.
    ///
    /// # Errors
    /// Where there is no bearing, or one is not a finite number.
    pub fn new(bearing_rad: &[f64], maximum_m: Option<f64>) -> Result<Self> {
        if bearing_rad.is_empty() {
            return Err(Error::work("bearings: none; expected one a beam"));
        }
        if let Some(beam) = bearing_rad.iter().position(|b| !b.is_finite()) {
            let message = format!("bearings: that of beam {beam} is not a finite number");
            return Err(Error::work(message));
        }
        let mut beams: Vec<Beam> = bearing_rad
            .iter()
            .enumerate()
            .map(|(index, &bearing_rad)| {
                let direction = towards(bearing_rad);
                Beam {
                    index,
                    offset_m: 0.0,
                    bearing_rad: direction[1].atan2(direction[0]).rem_euclid(TAU),
                    direction,
                    round: round(direction),
                    edges: [direction; 2],
                    neighbours: false,
                }
            })
            .collect();
        beams.sort_by(|a, b| a.round.total_cmp(&b.round));
        connect(&mut beams);
        // About half a beam a part: whatever the bearings, few steps lead from a direction to the first beam after it.
        let parts = (2 * beams.len()).next_power_of_two();
        let first = (0..=parts)
            .map(|part| beams.partition_point(|b| b.round < 4.0 * part as f64 / parts as f64))
            .collect();
        let maximum_m = maximum_m.filter(|m| m.is_finite() && *m > 0.0);
        Ok(Self {
            beams,
            first,
            maximum_m,
        })
    }

    /// The same where ranges count from so far out along each beam, one number a beam in the order of the bearings; a beam
    /// without one counts from the middle. Steps are the middle's.
    pub fn with_offset_m(mut self, offset_m: &[f64]) -> Self {
        for beam in &mut self.beams {
            beam.offset_m = offset_m.get(beam.index).copied().unwrap_or(0.0);
        }
        self
    }

    /// Number of beams of a scan.
    pub fn beams(&self) -> usize {
        self.beams.len()
    }

    /// The scan `ranges` (metres, NaN = no return, one a beam in the order of the bearings) as the sensor would have had
    /// it after `step`, given in its own frame. `out` gets one range a beam at the same bearings, NaN = no return.
    ///
    /// # Panics
    /// Where `ranges` or `out` has another length than there are beams: a slip of the caller, never of the data.
    pub fn render(&self, ranges: &[f32], step: Displacement, out: &mut [f32]) {
        let n = self.beams();
        assert!(
            ranges.len() == n && out.len() == n,
            "a scan has {n} ranges, one a beam"
        );
        let limit = self.maximum_m.unwrap_or(OPEN);
        let open_from = self.maximum_m.unwrap_or(OPEN_FROM_M);
        // What each beam met: its range, and the range to draw it at.
        let met: Vec<(f64, f64)> = self
            .beams
            .iter()
            .map(|beam| match f64::from(ranges[beam.index]) {
                range if range.is_finite() && range < limit => {
                    let range = range.max(NEAREST_M) + beam.offset_m;
                    (range, range)
                }
                _ => (OPEN, open_from + beam.offset_m),
            })
            .collect();
        let (sin, cos) = step.turn_rad.sin_cos();
        let carried = |direction: Vector, (kind, range_m): (f64, f64)| {
            let x = range_m * direction[0] - step.forward_m;
            let y = range_m * direction[1] - step.left_m;
            let at = [cos * x + sin * y, cos * y - sin * x];
            let far = if kind == OPEN {
                OPEN
            } else {
                at[0].hypot(at[1])
            };
            Point {
                at,
                range_m: far,
                round: round(at),
            }
        };
        let ends: Vec<Point> = self
            .beams
            .iter()
            .zip(&met)
            .map(|(beam, &met)| carried(beam.direction, met))
            .collect();
        let mut seen = vec![UNSEEN; n];
        for (i, beam) in self.beams.iter().enumerate() {
            let next = if i + 1 == n { 0 } else { i + 1 };
            if beam.joins(met[i].0, met[next].0) {
                self.draw(ends[i], ends[next], &mut seen);
            } else {
                let after = &self.beams[next];
                self.draw(ends[i], carried(beam.edges[1], met[i]), &mut seen);
                self.draw(carried(after.edges[0], met[next]), ends[next], &mut seen);
            }
        }
        self.fill(&mut seen);
        for (beam, &range) in self.beams.iter().zip(&seen) {
            let range = range - beam.offset_m;
            out[beam.index] = if range >= limit {
                f32::NAN
            } else {
                range.max(0.0) as f32
            };
        }
    }

    /// Lets the beams that meet the straight piece between two points see it, where they see nothing nearer.
    fn draw(&self, a: Point, b: Point, seen: &mut [f64]) {
        // From the right to the left end, as the moved sensor has them: it may look at the back of a piece.
        let (right, left) = if cross(a.at, b.at) >= 0.0 {
            (a, b)
        } else {
            (b, a)
        };
        let (mut from, mut to) = (right.round - SAME, left.round + SAME);
        if to < from {
            to += 4.0;
        }
        let edge_on = to - from < 4.0 * SAME;
        if from < 0.0 {
            (from, to) = (from + 4.0, to + 4.0);
        }
        let along = [left.at[0] - right.at[0], left.at[1] - right.at[1]];
        let area = cross(right.at, left.at);
        let (near, far) = (
            right.range_m.min(left.range_m),
            right.range_m.max(left.range_m),
        );
        let part = (from / 4.0 * (self.first.len() - 1) as f64) as usize;
        let mut j = self.first[part];
        while j < self.beams.len() && self.beams[j].round < from {
            j += 1;
        }
        let mut rounds = 0.0;
        for _ in 0..self.beams.len() {
            if j == self.beams.len() {
                (j, rounds) = (0, rounds + 4.0);
            }
            let beam = &self.beams[j];
            if beam.round + rounds > to {
                break;
            }
            let range = if near == OPEN {
                OPEN
            } else if edge_on {
                near
            } else {
                // t · direction = right + s · along, solved for t
                // (rounding may carry it past the ends of a piece looked at almost along itself)
                let t = area / cross(beam.direction, along);
                if t >= 0.0 { t.min(far) } else { near }
            };
            seen[j] = seen[j].min(range);
            j += 1;
        }
    }

    /// Bearings that see nothing copy the nearest that does.
    fn fill(&self, seen: &mut [f64]) {
        let n = seen.len();
        let Some(start) = seen.iter().position(|&range| range != UNSEEN) else {
            return;
        };
        let angle = |from: usize, to: usize| {
            (self.beams[to].bearing_rad - self.beams[from].bearing_rad).rem_euclid(TAU)
        };
        let mut last = start;
        for j in (start + 1..n).chain(0..=start) {
            if seen[j] == UNSEEN {
                continue;
            }
            let between = if j > last { j - last } else { j + n - last } - 1;
            for k in (1..=between).map(|k| (last + k) % n) {
                let nearest = if angle(last, k) <= angle(k, j) {
                    last
                } else {
                    j
                };
                seen[k] = seen[nearest];
            }
            last = j;
        }
    }
}

impl Beam {
    /// Did this beam and the next meet the same surface, or both nothing? Given their ranges.
    fn joins(&self, own: f64, next: f64) -> bool {
        self.neighbours && (own - next).abs() <= STEP_M + SLOPE * own.min(next)
    }
}

/// Finds out which beams are neighbours, and what lies between them.
fn connect(beams: &mut [Beam]) {
    let n = beams.len();
    let gaps: Vec<f64> = (0..n)
        .map(|i| (beams[(i + 1) % n].bearing_rad - beams[i].bearing_rad).rem_euclid(TAU))
        .collect();
    let mut sorted: Vec<f64> = gaps.iter().copied().filter(|&gap| gap > SAME).collect();
    sorted.sort_by(f64::total_cmp);
    let usual = sorted.get(sorted.len().saturating_sub(1) / 2).copied();
    let usual = usual.unwrap_or(TAU);
    for (i, &gap) in gaps.iter().enumerate() {
        let next = (i + 1) % n;
        let neighbours = next != i && gap <= (GAP * usual).min(WIDEST_GAP_RAD);
        let beside = if neighbours { gap } else { usual } / 2.0;
        let beside = beside.min(BESIDE_RAD);
        beams[i].edges[1] = towards(beams[i].bearing_rad + beside);
        beams[next].edges[0] = towards(beams[next].bearing_rad - beside);
        beams[i].neighbours = neighbours;
    }
}
