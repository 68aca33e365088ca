//! The record: what is kept of beliefs, in the form that `player.json` has.

use crate::{
    error::{Error, Result},
    mapping::{Occupancy, OccupancyMap},
};
use base64::{Engine, prelude::BASE64_STANDARD};
use flate2::{Compression, read::ZlibDecoder, write::ZlibEncoder};
use serde::{Deserialize, Serialize};
use std::io::{Read, Write};

/// What all systems believed along a few trials.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct BeliefTraces {
    /// Do places lie along a route? Then a place is one coordinate, else x and y.
    pub is_route: bool,
    /// Edge of a square, or length of a piece of the route, in metres.
    pub cell_m: f64,
    /// Centres of the squares, metres.
    pub cells: Vec<Vec<f64>>,
    /// The map that the likelihood field uses; none where nobody has one.
    pub plan: Option<Plan>,
    /// The trials.
    pub trials: Vec<TracedTrial>,
    /// Keys and titles of the systems, in the order that they played.
    pub systems: Vec<[String; 2]>,
    /// Where errors are made: by square metre (metre of the route), over all trials from 10 m on.
    pub errors: Vec<ErrorsAt>,
}

/// An occupancy map.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Plan {
    /// Edge of a cell, in metres.
    pub cell_m: f64,
    /// Corner of the first cell with the least x and y, in metres.
    pub origin_m: [f64; 2],
    /// Cells along x and along y.
    pub size: [usize; 2],
    /// A byte a cell, rows along x from the least y up: 0 unknown, 1 free, 2 occupied. As zlib and base64 write it.
    pub cells: String,
}

/// One trial.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct TracedTrial {
    /// Its number among all.
    pub number: usize,
    /// Why it was kept.
    pub kept_as: Vec<String>,
    /// Its snapshots in the recording that it was played in, one a step; empty in older files.
    #[serde(default)]
    pub snapshots: Vec<usize>,
    /// Metres travelled, one a step.
    pub travelled_m: Vec<f64>,
    /// True place, one a step: along the route, or x, y (metres) and heading (radians).
    pub truth: Vec<Vec<f64>>,
    /// What each system believed, in the order of [`BeliefTraces::systems`].
    pub systems: Vec<TracedSystem>,
}

/// What one system believed along one trial, one entry a step.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct TracedSystem {
    /// Its answer, as the truth has it; null where it has none.
    pub answer: Vec<Option<Vec<f64>>>,
    /// Expected error in metres.
    pub expected_error_m: Vec<f64>,
    /// Distance of the answer from the truth, in metres.
    pub point_error_m: Vec<f64>,
    /// Entropy of the belief over all its cells in nats; null for whole localisers.
    pub entropy_nats: Vec<Option<f64>>,
    /// Does the robot say that it is lost? Null where it can't.
    pub is_lost: Vec<Option<bool>>,
    /// What each square holds: a byte a square, squares of one step side by side, 255 · √mass. As zlib and base64 write it;
    /// empty where there is no belief.
    pub mass: String,
}

/// Errors in one place.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ErrorsAt {
    /// Centre: metres along the route, or x and y.
    pub at: Vec<f64>,
    /// Steps of all trials there.
    pub steps: usize,
    /// Mean point error of each system there, in metres; null where it failed.
    pub point_error_m: Vec<Option<f64>>,
}

impl BeliefTraces {
    /// Keeps the systems of some names only.
    pub fn retain(&mut self, is_kept: impl Fn(&str) -> bool) {
        let kept: Vec<bool> = self.systems.iter().map(|[name, _]| is_kept(name)).collect();
        keep(&mut self.systems, &kept);
        self.trials
            .iter_mut()
            .for_each(|trial| keep(&mut trial.systems, &kept));
        self.errors
            .iter_mut()
            .for_each(|here| keep(&mut here.point_error_m, &kept));
    }

    /// Do the parts fit together?
    ///
    /// # Errors
    /// Where they don't, in words.
    pub fn check(&self) -> std::result::Result<(), String> {
        let numbers = if self.is_route { 1 } else { 2 };
        let short = |place: &Vec<f64>| place.len() < numbers;
        if self
            .cells
            .iter()
            .chain(self.errors.iter().map(|here| &here.at))
            .any(short)
        {
            return Err(format!("a place without {numbers} numbers"));
        }
        for trial in &self.trials {
            let steps = trial.travelled_m.len();
            let fits = |system: &TracedSystem| {
                let bytes = unpacked(&system.mass).map(|bytes| bytes.len()).ok();
                [
                    system.answer.len(),
                    system.expected_error_m.len(),
                    system.point_error_m.len(),
                ] == [steps; 3]
                    && [system.entropy_nats.len(), system.is_lost.len()] == [steps; 2]
                    && (bytes == Some(0) || bytes == Some(steps * self.cells.len()))
                    && !system.answer.iter().flatten().any(short)
            };
            if steps == 0 || trial.truth.len() != steps || trial.truth.iter().any(short) {
                return Err(format!("trial {}: steps without places", trial.number));
            }
            if ![0, steps].contains(&trial.snapshots.len()) {
                return Err(format!(
                    "trial {}: {} snapshots for {steps} steps",
                    trial.number,
                    trial.snapshots.len()
                ));
            }
            if trial.systems.len() != self.systems.len() || !trial.systems.iter().all(fits) {
                return Err(format!(
                    "trial {}: systems that don't fit to its {steps} steps",
                    trial.number
                ));
            }
        }
        self.plan.as_ref().map_or(Ok(()), |plan| {
            plan.bytes().map(drop).map_err(|e| e.to_string())
        })
    }

    /// What the squares hold after a step, each 0 to 255.
    ///
    /// # Errors
    /// Where the bytes are not those of a trace.
    pub fn levels(&self, system: &TracedSystem) -> Result<Vec<Vec<u8>>> {
        let bytes = unpacked(&system.mass)?;
        let cells = self.cells.len().max(1);
        Ok(bytes.chunks(cells).map(<[u8]>::to_vec).collect())
    }
}

fn keep<T>(all: &mut Vec<T>, kept: &[bool]) {
    let mut kept = kept.iter();
    all.retain(|_| kept.next().is_some_and(|kept| *kept));
}

impl Plan {
    /// Most cells: of a finer map so many side by side become one, which is occupied where one of them is.
    const MOST: usize = 400_000;

    /// A map as it is kept.
    pub(super) fn of(map: &OccupancyMap) -> Self {
        let map = &map.cropped();
        let [width, height] = map.size();
        let mut by = 1;
        while width.div_ceil(by) * height.div_ceil(by) > Self::MOST {
            by += 1;
        }
        let size = [width.div_ceil(by), height.div_ceil(by)];
        let mut cells = vec![0u8; size[0] * size[1]];
        for (index, cell) in map.cells().iter().enumerate() {
            let (x, y) = (index % width / by, index / width / by);
            let byte = match cell {
                Occupancy::Unknown => 0,
                Occupancy::Free => 1,
                Occupancy::Occupied => 2,
            };
            let here = &mut cells[y * size[0] + x];
            *here = (*here).max(byte);
        }
        Self {
            cell_m: map.cell_m() * by as f64,
            origin_m: map.origin_m(),
            size,
            cells: packed(&cells),
        }
    }

    /// A byte a cell.
    ///
    /// # Errors
    /// Where the bytes are not those of a map.
    pub fn bytes(&self) -> Result<Vec<u8>> {
        let bytes = unpacked(&self.cells)?;
        match bytes.len() == self.size[0] * self.size[1] {
            true => Ok(bytes),
            false => Err(Error::work(format!(
                "a plan of {} cells; expected {} by {}",
                bytes.len(),
                self.size[0],
                self.size[1]
            ))),
        }
    }
}

/// Bytes as text: compressed (zlib, RFC 1950), then base64 (RFC 4648).
pub(super) fn packed(bytes: &[u8]) -> String {
    let mut packer = ZlibEncoder::new(Vec::new(), Compression::best());
    let written = packer.write_all(bytes).and_then(|()| packer.finish());
    BASE64_STANDARD.encode(written.unwrap_or_default()) // writing to a Vec can't fail
}

/// Most bytes that a text may hold unpacked.
const MOST_BYTES: u64 = 1 << 28;

/// What [`packed`] made text of.
fn unpacked(text: &str) -> Result<Vec<u8>> {
    let wrong = |e: String| Error::work(format!("a kept belief or plan: {e}"));
    if text.is_empty() {
        return Ok(Vec::new());
    }
    let bytes = BASE64_STANDARD
        .decode(text)
        .map_err(|e| wrong(e.to_string()))?;
    let mut all = Vec::new();
    let read = ZlibDecoder::new(&bytes[..])
        .take(MOST_BYTES)
        .read_to_end(&mut all);
    read.map_err(|e| wrong(e.to_string()))?;
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_come_back() {
        let bytes: Vec<u8> = (0..2000).map(|i| (i * i % 251) as u8).collect();
        assert_eq!(unpacked(&packed(&bytes)).unwrap(), bytes);
        assert!(unpacked("no base64!").is_err());
        assert!(packed(&vec![0; 30_000]).len() < 100);
    }

    #[test]
    fn a_fine_map_is_made_coarser_and_keeps_its_walls() {
        let mut cells = vec![Occupancy::Free; 1000 * 1000];
        cells[999 * 1000 + 999] = Occupancy::Occupied;
        let map = OccupancyMap::from_cells(0.1, [1.0, 2.0], 1000, cells).unwrap();
        let plan = Plan::of(&map);
        assert!(plan.size == [500, 500] && (plan.cell_m - 0.2).abs() < 1e-12);
        let bytes = plan.bytes().unwrap();
        assert_eq!(bytes.iter().filter(|b| **b == 2).count(), 1);
        assert_eq!(bytes.last(), Some(&2));
    }
}
