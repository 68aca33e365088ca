//! One line of a CARMEN log: which message it is, and its fields.
//!
//! ```text
//! ODOM x y θ tv rv accel time host time
//! FLASER n r1..rn x y θ odom_x odom_y odom_θ time host time          (RLASER the same)
//! SONAR n r1..rn [x y θ odom_x odom_y odom_θ] time host time
//! ROBOTLASER1 type start fov step max accuracy remission n r1..rn m e1..em laser(x y θ) robot(x y θ) 5 numbers time host time
//! RAWLASER1 type start fov step max accuracy remission n r1..rn m e1..em time host time
//! VERTEX2 id x y θ                     (g2o: VERTEX_SE2)
//! ```
//!
//! Metres and radians. `time` is the message's own, the second one the logger's.

use crate::geometry::Pose;
use std::f64::consts::{FRAC_PI_2, PI};

/// What a line says.
#[derive(Debug)]
pub(super) enum Message {
    Odometry { pose: Pose, stamp_s: f64 },
    Vertex(Pose),
    Scan(Scan),
}

/// Range readings of one sensor at one moment.
#[derive(Debug)]
pub(super) struct Scan {
    pub kind: &'static str,
    pub ranges: Vec<f32>,
    /// Where beam 0 points and by how much the next one is turned, in radians.
    pub fan: Option<(f64, f64)>,
    /// Pose of the robot as the line has it.
    pub pose: Option<Pose>,
    /// The line's second pose, its odometry.
    pub odometry: Option<Pose>,
    pub stamp_s: f64,
}

/// Reads a line: `Ok(None)` for a message that nothing here needs, `Err` with the fault for one that is damaged.
pub(super) fn parse(line: &[u8]) -> Result<Option<Message>, String> {
    let mut fields = Fields::new(line);
    let message = match fields.kind {
        b"ODOM" => {
            let pose = fields.pose()?;
            fields.numbers(3)?;
            let stamp_s = fields.stamp()?;
            Message::Odometry { pose, stamp_s }
        }
        b"VERTEX2" | b"VERTEX_SE2" => {
            fields.numbers(1)?;
            Message::Vertex(fields.pose()?)
        }
        b"FLASER" => Message::Scan(fields.plain_scan("FLASER", -FRAC_PI_2)?),
        b"RLASER" => Message::Scan(fields.plain_scan("RLASER", FRAC_PI_2)?),
        b"SONAR" => Message::Scan(fields.sonar()?),
        b"ROBOTLASER1" => Message::Scan(fields.described_scan("ROBOTLASER1", true)?),
        b"RAWLASER1" => Message::Scan(fields.described_scan("RAWLASER1", false)?),
        _ => return Ok(None),
    };
    fields.end()?;
    Ok(Some(message))
}

/// Do these bytes start a message that CARMEN logs and pose graphs are made of?
pub(super) fn is_known(kind: &[u8]) -> bool {
    const KNOWN: [&[u8]; 16] = [
        b"PARAM",
        b"SYNC",
        b"ODOM",
        b"FLASER",
        b"RLASER",
        b"SONAR",
        b"NEFF",
        b"TRUEPOS",
        b"VERTEX2",
        b"VERTEX_SE2",
        b"EDGE2",
        b"BUMPER",
        b"SCANMARK",
        b"LASER",
        b"ROBOTLASER2",
        b"RAWLASER2",
    ];
    KNOWN.contains(&kind) || kind == b"ROBOTLASER1" || kind == b"RAWLASER1"
}

/// First word of a line.
pub(super) fn kind(line: &[u8]) -> &[u8] {
    words(line).next().unwrap_or(b"")
}

fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty())
}

struct Fields<'a> {
    kind: &'a [u8],
    rest: Box<dyn Iterator<Item = &'a [u8]> + 'a>,
    /// The line can't hold more words than this: a larger count in it is an error.
    most: usize,
}

impl<'a> Fields<'a> {
    fn new(line: &'a [u8]) -> Self {
        let mut rest = Box::new(words(line));
        Self {
            kind: rest.next().unwrap_or(b""),
            rest,
            most: line.len() / 2 + 1,
        }
    }

    fn fault(&self, fault: impl std::fmt::Display) -> String {
        format!("`{}`: {fault}", String::from_utf8_lossy(self.kind))
    }

    fn word(&mut self) -> Result<&'a [u8], String> {
        let word = self.rest.next();
        word.ok_or_else(|| {
            self.fault("the line ends too early; expected all fields of the message")
        })
    }

    fn parsed<T: std::str::FromStr>(&mut self, expected: &str) -> Result<T, String> {
        let word = self.word()?;
        let value = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok());
        value.ok_or_else(|| {
            let shown: String = String::from_utf8_lossy(word).chars().take(20).collect();
            self.fault(format!(
                "holds `{}`; expected {expected}",
                shown.escape_debug()
            ))
        })
    }

    fn number(&mut self) -> Result<f64, String> {
        let value: f64 = self.parsed("a number")?;
        if value.is_finite() {
            Ok(value)
        } else {
            Err(self.fault(format!("holds `{value}`; expected a finite number")))
        }
    }

    fn numbers(&mut self, n: usize) -> Result<(), String> {
        (0..n).try_for_each(|_| self.number().map(|_| ()))
    }

    fn pose(&mut self) -> Result<Pose, String> {
        Ok(Pose::new(self.number()?, self.number()?, self.number()?))
    }

    /// `n r1..rn`. A reading may be infinite or not a number: that is a way to say that nothing came back.
    fn readings(&mut self) -> Result<Vec<f32>, String> {
        let n: usize = self.parsed("the number of readings")?;
        if n > self.most {
            return Err(self.fault(format!("announces {n} readings, more than the line holds")));
        }
        let mut readings = Vec::with_capacity(n);
        for _ in 0..n {
            readings.push(self.parsed("a reading in metres")?);
        }
        Ok(readings)
    }

    /// `time host time`
    fn stamp(&mut self) -> Result<f64, String> {
        let stamp_s = self.number()?;
        self.word()?;
        self.number()?;
        Ok(stamp_s)
    }

    fn end(&mut self) -> Result<(), String> {
        match self.rest.next() {
            None => Ok(()),
            Some(_) => Err(self.fault(
                "the line goes on after its last field; expected as many readings as announced",
            )),
        }
    }

    fn plain_scan(&mut self, kind: &'static str, first_rad: f64) -> Result<Scan, String> {
        let ranges = self.readings()?;
        if ranges.is_empty() {
            return Err(self.fault("no readings; expected at least one"));
        }
        Ok(Scan {
            kind,
            fan: Some((first_rad, half_circle_step_rad(ranges.len()))),
            ranges,
            pose: Some(self.pose()?),
            odometry: Some(self.pose()?),
            stamp_s: self.stamp()?,
        })
    }

    fn sonar(&mut self) -> Result<Scan, String> {
        let ranges = self.readings()?;
        if ranges.is_empty() {
            return Err(self.fault("no readings; expected at least one"));
        }
        // With poses nine fields are left, without three; the word in the place of the host tells which.
        let rest: Vec<&[u8]> = self.rest.by_ref().collect();
        self.rest = Box::new(rest.clone().into_iter());
        let with_poses = rest.len() > 3;
        Ok(Scan {
            kind: "SONAR",
            ranges,
            fan: None,
            pose: with_poses.then(|| self.pose()).transpose()?,
            odometry: with_poses.then(|| self.pose()).transpose()?,
            stamp_s: self.stamp()?,
        })
    }

    fn described_scan(&mut self, kind: &'static str, with_poses: bool) -> Result<Scan, String> {
        self.numbers(1)?; // type
        let first_rad = self.number()?;
        self.numbers(1)?; // field of view
        let step_rad = self.number()?;
        self.numbers(3)?; // declared maximum (50 where readings of 81.83 follow: not to be relied on), accuracy, remission
        let ranges = self.readings()?;
        if ranges.is_empty() {
            return Err(self.fault("no readings; expected at least one"));
        }
        self.readings()?; // remissions
        let mut pose = None;
        if with_poses {
            self.pose()?; // of the laser
            pose = Some(self.pose()?);
            self.numbers(5)?; // velocities and safety distances
        }
        Ok(Scan {
            kind,
            ranges,
            fan: Some((first_rad, step_rad)),
            pose,
            odometry: None,
            stamp_s: self.stamp()?,
        })
    }
}

/// Step of a scanner that covers 180°: with 180 or 360 beams the last one is left out, with 181 or 361 it is there.
fn half_circle_step_rad(beams: usize) -> f64 {
    let steps = if beams.is_multiple_of(2) {
        beams
    } else {
        beams - 1
    };
    PI / steps.max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scan_has_its_readings_poses_and_directions() {
        let line = b"FLASER 3 1.5 inf 2.5 1 2 0.5 1.1 2.1 0.6 7.25 host 7.5";
        let Ok(Some(Message::Scan(scan))) = parse(line) else {
            panic!("a scan")
        };
        assert_eq!(scan.ranges, [1.5, f32::INFINITY, 2.5]);
        assert_eq!(scan.pose, Some(Pose::new(1.0, 2.0, 0.5)));
        assert_eq!(scan.odometry, Some(Pose::new(1.1, 2.1, 0.6)));
        assert_eq!(scan.stamp_s, 7.25);
        assert_eq!(scan.fan, Some((-FRAC_PI_2, FRAC_PI_2)));
        assert_eq!(half_circle_step_rad(360), PI / 360.0);
        assert_eq!(half_circle_step_rad(181), PI / 180.0);
    }

    #[test]
    fn a_laser_line_of_a_pose_graph_gives_the_robot_pose() {
        let line = b"ROBOTLASER1 0 -1.57 3.14 0.0175 50 0.1 0 2 1.5 81.83 1 0.3 9 9 9 4 5 0.1 0 0 0 0 0 12.5 x 3";
        let Ok(Some(Message::Scan(scan))) = parse(line) else {
            panic!("a scan")
        };
        assert_eq!(scan.pose, Some(Pose::new(4.0, 5.0, 0.1)));
        assert_eq!((scan.fan, scan.stamp_s), (Some((-1.57, 0.0175)), 12.5));
    }

    #[test]
    fn damaged_lines_say_what_is_wrong() {
        for (line, part) in [
            (&b"FLASER 3 1 2"[..], "ends too early"),
            (b"FLASER 3 1 2 x 0 0 0 0 0 0 1 h 1", "holds `x`"),
            (b"FLASER 2 1 2 3 0 0 0 0 0 0 1 h 1", "holds `h`"),
            (b"FLASER 2 1 2 nan 0 0 0 0 0 1 h 1", "finite"),
            (b"FLASER 99999999999 1", "more than the line holds"),
            (b"FLASER -1 1", "number of readings"),
            (b"ODOM 1 2 3 0 0 0 1 h 1 9", "goes on"),
            (b"ODOM 1 \xff\xfe 3 0 0 0 1 h 1", "expected a number"),
        ] {
            let fault = parse(line).unwrap_err();
            assert!(fault.contains(part), "{fault}");
        }
        assert!(parse(b"PARAM anything_at all \xff").unwrap().is_none());
    }
}
