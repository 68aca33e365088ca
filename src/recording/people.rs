//! Range scans as they would have been with people before the robot: what the plan of a building does not predict.

use super::{Channel, Columns, Recording};
use crate::{
    error::{Error, Result},
    seed::{Seed, Stream},
};
use ndarray::{ArrayViewMut1, Axis};
use rand::RngExt;

/// Nearer than this nobody stands, in metres.
const NEAREST_M: f64 = 0.5;
/// Where a beam had no return and the channel has no maximum, people stand before this, in metres.
const OPEN_M: f64 = 20.0;
/// Angles that a person or a group takes of a scan, least and most, in radians: 3° to 20°.
const WIDTH_RAD: [f64; 2] = [0.05236, 0.34907];

impl Recording {
    /// The recording with people in the way of some snapshots' range beams: in every channel in metres that has bearings,
    /// stretches of 3° to 20° of a scan end before what they met, until `share` of its beams do. A stretch is shortened to half a
    /// metre and the same share, drawn evenly, of what was beyond, beam by beam; so does a group that hides what is behind.
    /// Other channels, other snapshots and all labels stay as they are; the same seed gives the same people.
    ///
    /// ```
    /// use ballmark::{seed::Seed, world::corridor};
    /// let config = corridor::CorridorConfig { runs: 1, spacing_m: 2.0 };
    /// let empty = corridor::thrun1998(Seed(1), &config)?;
    /// let crowded = empty.with_people(&[3], 0.3, Seed(1))?;
    /// let bits = |recording: &ballmark::recording::Recording, k, beam| recording.values()[(k, beam)].to_bits(); // NaN = no return
    /// let changed = |k: usize| (0..24).filter(|&beam| bits(&crowded, k, beam) != bits(&empty, k, beam)).count();
    /// assert!(changed(3) >= 6 && changed(4) == 0);
    /// # Ok::<(), ballmark::Error>(())
    /// ```
    ///
    /// # Errors
    /// A usage error where `share` is not between 0 and 1; an error where nobody can be in the way, as no channel in metres has
    /// bearings.
    pub fn with_people(&self, snapshots: &[usize], share: f64, seed: Seed) -> Result<Recording> {
        if !(0.0..=1.0).contains(&share) {
            return Err(Error::usage(format!(
                "people = {share}: expected the share of beams that they hide, 0 to 1"
            )));
        }
        if !self.channels().iter().any(Channel::is_scan) {
            return Err(Error::work(
                "people: no channel in metres has bearings; expected a range sensor whose beams' directions are known",
            ));
        }
        let mut columns = self.columns().clone();
        for &k in snapshots {
            let mut people = seed.numbered_stream("people in the way", k as u64);
            hide_in_row(&mut columns, k, share, &mut people);
        }
        Recording::new(columns)
    }

    /// The same for all snapshots, each with a share of its own, drawn evenly up to `most`.
    pub(crate) fn with_people_drawn(self, most: f64, random: &mut Stream) -> Result<Recording> {
        let mut columns = self.into_columns();
        for k in 0..columns.values.nrows() {
            let share = most * random.random_range(0.0..1.0);
            hide_in_row(&mut columns, k, share, random);
        }
        Recording::new(columns)
    }
}

/// Puts people before `share` of the beams of every range scan of a snapshot.
fn hide_in_row(columns: &mut Columns, k: usize, share: f64, people: &mut Stream) {
    let mut row = columns.values.row_mut(k);
    let mut first = 0;
    for channel in &columns.channels {
        if channel.is_scan() {
            let own = row.slice_axis_mut(Axis(0), (first..first + channel.width).into());
            hide(own, channel, share, people);
        }
        first += channel.width;
    }
}

/// Puts people before `share` of the beams of a scan.
fn hide(mut scan: ArrayViewMut1<f32>, channel: &Channel, share: f64, people: &mut Stream) {
    let beams = scan.len();
    let asked = (share * beams as f64).round() as usize;
    let apart_rad = apart_rad(channel.bearing_rad.as_deref().unwrap_or_default());
    let mut hidden = vec![false; beams];
    let mut count = 0;
    while count < asked {
        let width_rad = people.random_range(WIDTH_RAD[0]..WIDTH_RAD[1]);
        let width = ((width_rad / apart_rad) as usize).clamp(1, beams);
        // A stretch may begin before the first beam and end after the last.
        let start = people.random_range(0..beams + width - 1);
        let share_of_way: f64 = people.random_range(0.0..1.0);
        for beam in (start + 1).saturating_sub(width)..(start + 1).min(beams) {
            if hidden[beam] || count == asked {
                continue;
            }
            hidden[beam] = true;
            count += 1;
            let open_m = channel.maximum.unwrap_or(OPEN_M);
            let reading_m = f64::from(scan[beam]);
            let range_m = if reading_m.is_finite() {
                reading_m.min(open_m)
            } else {
                open_m
            };
            if range_m > NEAREST_M {
                scan[beam] = (NEAREST_M + share_of_way * (range_m - NEAREST_M)) as f32;
            }
        }
    }
}

/// Angle between neighbouring beams; half a turn for a single one.
fn apart_rad(bearing_rad: &[f64]) -> f64 {
    let (least, most) = bearing_rad.iter().fold(
        (f64::INFINITY, f64::NEG_INFINITY),
        |(least, most), &bearing| (least.min(bearing), most.max(bearing)),
    );
    match bearing_rad.len() {
        0 | 1 => std::f64::consts::PI,
        beams => ((most - least) / (beams - 1) as f64).max(1e-6),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;

    fn recording() -> Recording {
        let laser = Channel {
            name: "laser".into(),
            width: 180,
            unit: "m".into(),
            bearing_rad: Some((0..180).map(|b| f64::from(b).to_radians()).collect()),
            maximum: Some(8.0),
            offset_m: None,
        };
        let light = Channel {
            name: "light".into(),
            width: 2,
            unit: "lux".into(),
            bearing_rad: None,
            maximum: None,
            offset_m: None,
        };
        let mut values = ndarray::Array2::from_elem((3, 182), 4.0);
        values[(1, 7)] = f32::NAN; // no return
        values[(1, 8)] = 0.3;
        Recording::new(Columns {
            channels: vec![laser, light],
            values,
            stamp_s: vec![0.0, 1.0, 2.0],
            pose: vec![Pose::default(); 3],
            odometry: vec![Pose::default(); 3],
            run: vec![0; 3],
            ..Columns::default()
        })
        .unwrap()
    }

    #[test]
    fn so_many_beams_are_shortened_in_stretches_and_nothing_else_changes() {
        let empty = recording();
        let crowded = empty.with_people(&[1], 0.3, Seed(2)).unwrap();
        assert_eq!(crowded.values().row(0), empty.values().row(0));
        assert_eq!(crowded.values().row(2), empty.values().row(2));
        let scan = crowded.values().row(1);
        let hidden: Vec<bool> = (0..180)
            .map(|b| scan[b] != 4.0 && b != 7 && b != 8)
            .collect();
        let count = hidden.iter().filter(|hidden| **hidden).count();
        assert!((52..=54).contains(&count), "{count}"); // 30 % of 180, these two aside
        assert!(
            scan.iter()
                .take(180)
                .all(|&r| r.is_nan() || (0.3..=8.0).contains(&r))
        );
        let stretches = hidden.windows(2).filter(|pair| !pair[0] && pair[1]).count();
        assert!((2..=18).contains(&stretches), "{stretches}");
        assert_eq!((scan[180], scan[181]), (4.0, 4.0));
        assert_eq!(crowded.poses(), empty.poses());
        let again = empty.with_people(&[1], 0.3, Seed(2)).unwrap();
        let bits = |r: &Recording| r.values().mapv(f32::to_bits);
        assert_eq!(bits(&again), bits(&crowded));
        let other = empty.with_people(&[1], 0.3, Seed(3)).unwrap();
        assert_ne!(bits(&other), bits(&crowded));
    }

    #[test]
    fn everybody_or_nobody_and_no_more() {
        let empty = recording();
        let all = empty.with_people(&[0, 1, 2], 1.0, Seed(2)).unwrap();
        assert!(
            all.values()
                .row(0)
                .iter()
                .take(180)
                .all(|r| (0.5..4.0).contains(r))
        );
        assert!(all.values()[(1, 7)] <= 8.0); // before nothing within reach
        assert_eq!(all.values()[(1, 8)], 0.3); // nearer than anybody stands
        let none = empty.with_people(&[0, 2], 0.0, Seed(2)).unwrap();
        assert_eq!(none.values().row(0), empty.values().row(0));
        for share in [-0.1, 1.1, f64::NAN] {
            let error = empty.with_people(&[0], share, Seed(2)).unwrap_err();
            assert!(error.is_usage() && error.to_string().contains("people = "));
        }
        let mut blind = empty.into_columns();
        blind.channels[0].bearing_rad = None;
        let blind = Recording::new(blind).unwrap();
        let error = blind.with_people(&[0], 0.3, Seed(2)).unwrap_err();
        assert!(
            error
                .to_string()
                .contains("no channel in metres has bearings")
        );
    }
}
