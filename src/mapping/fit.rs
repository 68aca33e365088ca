//! Does a map that was made elsewhere belong to a recording?

use super::{
    distance::distances,
    occupancy_map::{Occupancy, OccupancyMap},
    range_sensors::{RangeBeam, RangeSensors, thinned},
    ros_map::RosMap,
};
use crate::{
    error::{Error, Result},
    recording::Recording,
};
use std::{borrow::Cow, path::Path};

/// An end this near to something occupied is explained by it, in metres.
const NEAR_M: f64 = 0.3;
/// Scans that are asked, and beams of each.
const SCANS: usize = 200;
const BEAMS: usize = 36;
/// Of the beams that it doesn't explain when scans stand at each other's poses, a map that fits explains more than this share
/// when they stand at their own. Assumed.
const EXPLAINED: f64 = 0.3;
/// So much more, and another scale is the right one: in a small room, walls near to the origin fit at any.
const MORE_AT_ANOTHER_SCALE: f64 = 0.2;
/// Among so many scales, one that fits somewhat may do so by chance.
const EXPLAINED_AT_A_SCALE: f64 = 0.5;
/// Scales that maps come in by mistake: units, feet and inches among them, and resolutions of another map.
const SCALES: [f64; 14] = [
    0.001,
    0.01,
    0.0254,
    0.1,
    0.2,
    0.3048,
    0.5,
    2.0,
    1.0 / 0.3048,
    5.0,
    10.0,
    1.0 / 0.0254,
    100.0,
    1000.0,
];

/// A ROS map in a file, as it serves a recording.
///
/// # Errors
/// Where the file can't be read ([`RosMap::read`]) or its map does not fit ([`check_fits`]); the message begins with the file's name.
pub fn read_fitting(
    file: &Path,
    recording: &Recording,
    snapshots: &[usize],
    sensors: &RangeSensors,
) -> Result<OccupancyMap> {
    let map = RosMap::read(file)?.occupancy_map()?;
    let fits = check_fits(&map, recording, snapshots, sensors);
    fits.map_err(|error| error.in_file(file))?;
    Ok(map)
}

/// Refuses a map that doesn't fit to a recording: beams of the scans, put at their true poses, must end near to what is occupied
/// more often than those of scans put at other scans' poses do.
///
/// # Errors
/// Where there is no range sensor, no snapshot, or the map doesn't fit; the message says how far off it is, and whether another
/// scale would do.
pub fn check_fits(
    map: &OccupancyMap,
    recording: &Recording,
    snapshots: &[usize],
    sensors: &RangeSensors,
) -> Result<()> {
    let beams = thinned(&sensors.beams(recording.channels())?, BEAMS);
    let scans = Scans {
        recording,
        beams,
        asked: thinned(snapshots, SCANS),
    };
    if scans.asked.is_empty() {
        return Err(Error::work(
            "no snapshot to hold the map against; expected at least one",
        ));
    }
    let ends = Ends::of(map);
    let explained = scans.explained(&ends);
    let scaled = SCALES.into_iter().flat_map(|scale| {
        let about_origin = map.origin_m().map(|m| m * scale);
        [about_origin, map.origin_m()].map(|origin_m| (scale, ends.scaled(scale, origin_m)))
    });
    let better = scaled
        .map(|(scale, ends)| (scale, scans.explained(&ends)))
        .max_by(|a, b| a.1.more_than_chance().total_cmp(&b.1.more_than_chance()))
        .filter(|(_, other)| {
            let more = other.more_than_chance() - explained.more_than_chance();
            other.more_than_chance() > EXPLAINED_AT_A_SCALE && more > MORE_AT_ANOTHER_SCALE
        });
    if explained.fits() && better.is_none() {
        return Ok(());
    }
    let percent = |share: f64| (100.0 * share).round();
    let mut message = format!(
        "the map does not fit: {} % of the beams end within {NEAR_M} m of something occupied, {} % with scans at each other's \
         poses",
        percent(explained.own),
        percent(explained.others)
    );
    let poses = recording.poses();
    let off = |&&k: &&usize| map.at(poses[k].x_m, poses[k].y_m) != Occupancy::Free;
    let off = scans.asked.iter().filter(off).count();
    if off > 0 {
        let of = scans.asked.len();
        message += &format!("; {off} of {of} poses lie on no free ground of it");
    }
    message += &match better {
        Some((scale, explained)) => format!(
            "; expected metres: at {scale:.4} times its scale, {} m a cell, it would be {} %",
            (1e6 * map.cell_m() * scale).round() / 1e6,
            percent(explained.own)
        ),
        None => "; expected a map in the frame of the recording's poses, in metres".to_string(),
    };
    Err(Error::work(message))
}

/// The scans that are asked.
struct Scans<'a> {
    recording: &'a Recording,
    beams: Vec<RangeBeam>,
    asked: Vec<usize>,
}

impl Scans<'_> {
    /// How many beams end near to something occupied, the scans at their own poses and, from last to first, at each other's.
    fn explained(&self, ends: &Ends) -> Explained {
        let last = self.asked.len() - 1;
        let own = self.share(ends, |i| i);
        let others = match last {
            0 => 0.0, // a single scan can't be put anywhere else
            _ => self.share(ends, |i| last - i),
        };
        Explained { own, others }
    }

    fn share(&self, ends: &Ends, pose_of: impl Fn(usize) -> usize) -> f64 {
        let poses = self.recording.poses();
        let (mut near, mut all) = (0_u32, 0_u32);
        for (i, &k) in self.asked.iter().enumerate() {
            let pose = poses[self.asked[pose_of(i)]];
            let values = self.recording.observation(k).values;
            for beam in &self.beams {
                let range_m = f64::from(values[beam.value]);
                if range_m > 0.0 && range_m.is_finite() {
                    all += 1;
                    let end = beam.point_m(&pose, range_m);
                    near += u32::from(ends.off_occupied_m(end) <= NEAR_M);
                }
            }
        }
        f64::from(near) / f64::from(all).max(1.0)
    }
}

/// Shares of beams that a map explains.
struct Explained {
    own: f64,
    others: f64,
}

impl Explained {
    fn more_than_chance(&self) -> f64 {
        (self.own - self.others) / (1.0 - self.others).max(f64::EPSILON)
    }

    fn fits(&self) -> bool {
        self.more_than_chance() > EXPLAINED
    }
}

/// How far ends are from what is occupied.
struct Ends<'a> {
    cells: Cow<'a, [f32]>,
    width: usize,
    cell_m: f64,
    origin_m: [f64; 2],
}

impl Ends<'_> {
    fn of(map: &OccupancyMap) -> Self {
        let occupied = map.cells().iter().map(|c| *c == Occupancy::Occupied);
        let [width, _] = map.size();
        Self {
            cells: distances(&occupied.collect::<Vec<bool>>(), width).into(),
            width,
            cell_m: map.cell_m(),
            origin_m: map.origin_m(),
        }
    }

    fn scaled(&self, scale: f64, origin_m: [f64; 2]) -> Ends<'_> {
        Ends {
            cells: (&*self.cells).into(),
            width: self.width,
            cell_m: scale * self.cell_m,
            origin_m,
        }
    }

    fn off_occupied_m(&self, at: [f64; 2]) -> f64 {
        let [column, row] =
            [0, 1].map(|axis| ((at[axis] - self.origin_m[axis]) / self.cell_m).floor());
        if !(column >= 0.0 && column < self.width as f64 && row >= 0.0) {
            return f64::INFINITY;
        }
        let cells = self.cells.get(row as usize * self.width + column as usize);
        cells.map_or(f64::INFINITY, |&cells| f64::from(cells) * self.cell_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        geometry::Pose,
        mapping::{RenderConfig, Renderer},
        recording::{Channel, Columns},
    };
    use std::f64::consts::TAU;

    /// An L-shaped hall from (1, 2) on, walls a cell thick, and scans all over it.
    fn hall() -> (OccupancyMap, Recording) {
        let size = [200, 140];
        let inside = |column: i64, row: i64| {
            let [x, y] = [column, row].map(|cell| 0.05 * (cell as f64 + 0.5));
            (0.5..9.5).contains(&x) && (0.5..if x > 4.0 { 6.5 } else { 3.5 }).contains(&y)
        };
        let cells = (0..size[1]).flat_map(|row| (0..size[0]).map(move |column| (column, row)));
        let cells = cells.map(|(column, row)| {
            let beside = (-1..=1).any(|c| (-1..=1).any(|r| inside(column + c, row + r)));
            match (inside(column, row), beside) {
                (true, _) => Occupancy::Free,
                (false, true) => Occupancy::Occupied,
                (false, false) => Occupancy::Unknown,
            }
        });
        let map =
            OccupancyMap::from_cells(0.05, [1.0, 2.0], size[0] as usize, cells.collect()).unwrap();
        let laser = Channel {
            name: "laser".into(),
            width: 24,
            unit: "m".into(),
            bearing_rad: Some((0..24).map(|b| TAU * f64::from(b) / 24.0).collect()),
            maximum: None,
            offset_m: None,
        };
        let pose: Vec<Pose> = (0..60)
            .map(|k| {
                let way_m = f64::from(k) * 0.15;
                let y_m: f64 = if k < 30 { 3.5 } else { 5.5 };
                Pose::new(1.2 + way_m, y_m.min(2.8 + way_m), 0.3 * f64::from(k))
            })
            .filter(|pose| map.at(pose.x_m, pose.y_m) == Occupancy::Free)
            .collect();
        let renderer =
            Renderer::new(&map, std::slice::from_ref(&laser), &RenderConfig::default()).unwrap();
        let values = renderer.at_all_as(&pose, |_, rendered| rendered.reading_m());
        let recording = Recording::new(Columns {
            channels: vec![laser],
            values,
            stamp_s: (0..pose.len()).map(|k| k as f64).collect(),
            odometry: pose.clone(),
            run: vec![0; pose.len()],
            pose,
            ..Columns::default()
        });
        (map, recording.unwrap())
    }

    #[test]
    fn a_map_fits_its_own_scans_and_neither_shifted_nor_scaled() {
        let (map, recording) = hall();
        let all: Vec<usize> = (0..recording.len()).collect();
        assert!(all.len() > 40);
        let sensors = RangeSensors::default();
        let as_it_were = |scale: f64, moved_m: [f64; 2]| {
            let origin_m = [0, 1].map(|axis| scale * map.origin_m()[axis] + moved_m[axis]);
            let cells = map.cells().to_vec();
            let map =
                OccupancyMap::from_cells(scale * map.cell_m(), origin_m, map.size()[0], cells);
            check_fits(&map.unwrap(), &recording, &all, &sensors)
        };
        as_it_were(1.0, [0.0; 2]).unwrap();
        as_it_were(1.0, [0.1, -0.1]).unwrap();
        let fault = |scale, moved_m| as_it_were(scale, moved_m).unwrap_err().to_string();
        let moved = fault(1.0, [1.7, 2.3]);
        assert!(
            moved.contains("does not fit") && moved.contains("frame of the"),
            "{moved}"
        );
        let elsewhere = fault(1.0, [500.0, 0.0]);
        assert!(
            elsewhere.contains("poses lie on no free ground"),
            "{elsewhere}"
        );
        // A resolution that is not the map's own, its origin scaled with it or right.
        for (scale, expected) in [(2.0, "at 0.5000 times"), (0.1, "at 10.0000 times")] {
            let origin_m = [0, 1].map(|axis| (1.0 - scale) * map.origin_m()[axis]);
            for moved_m in [[0.0; 2], origin_m] {
                let scaled = fault(scale, moved_m);
                assert!(scaled.contains(expected), "{scaled}");
            }
        }
        let error = check_fits(&map, &recording, &[], &sensors).unwrap_err();
        assert!(error.to_string().contains("no snapshot"));
    }
}
