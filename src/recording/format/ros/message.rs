//! The messages that a recording is made of, decoded: laser scans, single ranges, odometry, poses, transforms, pictures.

use super::cursor::{Cursor, Serialisation};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};

/// A message type that is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Scan,
    Range,
    Picture,
    Odometry,
    Pose,
    PoseWithCovariance,
    Transforms,
}

impl Kind {
    /// The kind of a type by its name in ROS 1's spelling; `None` for a type that nothing here needs.
    pub(super) fn named(type_name: &str) -> Option<Self> {
        Some(match type_name {
            "sensor_msgs/LaserScan" => Kind::Scan,
            "sensor_msgs/Range" => Kind::Range,
            "sensor_msgs/CompressedImage" => Kind::Picture,
            "nav_msgs/Odometry" => Kind::Odometry,
            "geometry_msgs/PoseStamped" => Kind::Pose,
            "geometry_msgs/PoseWithCovarianceStamped" => Kind::PoseWithCovariance,
            "tf2_msgs/TFMessage" | "tf/tfMessage" => Kind::Transforms,
            _ => return None,
        })
    }

    /// Does it fill a channel?
    pub(super) fn is_sensor(self) -> bool {
        matches!(self, Kind::Scan | Kind::Range | Kind::Picture)
    }
}

/// `sensor_msgs/msg/LaserScan` as `sensor_msgs/LaserScan`: one spelling for both generations.
pub(super) fn ros1_spelling(type_name: &str) -> String {
    match type_name.split_once("/msg/") {
        Some((package, name)) => format!("{package}/{name}"),
        None => type_name.to_string(),
    }
}

/// A `sensor_msgs/LaserScan`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Scan {
    pub first_rad: f32,
    pub step_rad: f32,
    pub nearest_m: f32,
    pub farthest_m: f32,
    pub ranges: Vec<f32>,
}

/// A `sensor_msgs/Range`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Range {
    pub infrared: bool,
    pub nearest_m: f32,
    pub farthest_m: f32,
    pub range: f32,
}

/// One transform of a `tf2_msgs/TFMessage`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Transform {
    pub stamp_s: f64,
    pub parent: String,
    pub child: String,
    pub parent_from_child: Isometry3<f64>,
}

/// What a message says.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Content<'a> {
    Scan(Scan),
    Range(Range),
    Picture {
        format: String,
        file: &'a [u8],
    },
    /// A pose; `child` is the frame that it is the pose of, where the message says so.
    Pose {
        pose: Isometry3<f64>,
        child: Option<String>,
    },
    Transforms(Vec<Transform>),
}

/// A decoded message; time and frame are those of its header (without one: 0 and empty).
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Message<'a> {
    pub stamp_s: f64,
    pub frame: String,
    pub content: Content<'a>,
}

/// The fewest bytes of one transform: its header, an empty name, seven numbers.
const TRANSFORM_BYTES: usize = 8 + 4 + 4 + 7 * 8;

/// Reads a message of some kind; `Err` says in words what is wrong with it.
pub(super) fn decode(
    kind: Kind,
    bytes: &[u8],
    serialisation: Serialisation,
) -> Result<Message<'_>, String> {
    let mut fields = Cursor::new(bytes, serialisation)?;
    if kind == Kind::Transforms {
        let n = fields.count(TRANSFORM_BYTES)?;
        let transforms: Result<Vec<Transform>, String> =
            (0..n).map(|_| transform(&mut fields)).collect();
        let content = Content::Transforms(transforms?);
        fields.end(0)?;
        return Ok(Message {
            stamp_s: 0.0,
            frame: String::new(),
            content,
        });
    }
    let (stamp_s, frame) = fields.header()?;
    let mut spare = 0;
    let content = match kind {
        Kind::Scan => {
            let (first_rad, end_rad, step_rad) = (fields.f32()?, fields.f32()?, fields.f32()?);
            if !(first_rad.is_finite() && end_rad.is_finite() && step_rad.is_finite()) {
                return Err("its angles are not finite; expected radians".into());
            }
            fields.f32()?; // time between beams
            fields.f32()?; // time between scans
            let (nearest_m, farthest_m) = (fields.f32()?, fields.f32()?);
            let ranges = fields.f32s()?;
            fields.f32s()?; // intensities
            Content::Scan(Scan {
                first_rad,
                step_rad,
                nearest_m,
                farthest_m,
                ranges,
            })
        }
        Kind::Range => {
            let radiation = fields.u8()?;
            fields.f32()?; // field of view
            let (nearest_m, farthest_m) = (fields.f32()?, fields.f32()?);
            spare = 4; // the variance, which newer versions of ROS 2 add
            Content::Range(Range {
                infrared: radiation == 1,
                nearest_m,
                farthest_m,
                range: fields.f32()?,
            })
        }
        Kind::Picture => Content::Picture {
            format: fields.string()?,
            file: fields.bytes()?,
        },
        Kind::Odometry => {
            let child = fields.string()?;
            let pose = pose(&mut fields)?;
            fields.skip_f64s(36 + 6 + 36)?; // covariance, velocities and theirs
            let child = child.strip_prefix('/').unwrap_or(&child);
            Content::Pose {
                pose,
                child: (!child.is_empty()).then(|| child.to_string()),
            }
        }
        Kind::Pose | Kind::PoseWithCovariance => {
            let pose = pose(&mut fields)?;
            if kind == Kind::PoseWithCovariance {
                fields.skip_f64s(36)?;
            }
            Content::Pose { pose, child: None }
        }
        Kind::Transforms => unreachable!("decoded above: it has no header of its own"),
    };
    fields.end(spare)?;
    Ok(Message {
        stamp_s,
        frame,
        content,
    })
}

fn transform(fields: &mut Cursor) -> Result<Transform, String> {
    let (stamp_s, parent) = fields.header()?;
    let child = fields.string()?;
    Ok(Transform {
        stamp_s,
        parent,
        child: child.strip_prefix('/').unwrap_or(&child).to_string(),
        parent_from_child: pose(fields)?,
    })
}

/// Position and rotation: x, y, z in metres, then a quaternion x, y, z, w.
fn pose(fields: &mut Cursor) -> Result<Isometry3<f64>, String> {
    let mut numbers = [0.0; 7];
    for number in &mut numbers {
        *number = fields.f64()?;
    }
    let [x, y, z, i, j, k, w] = numbers;
    if let Some(number) = numbers.iter().find(|n| !n.is_finite()) {
        return Err(format!("a pose with `{number}`; expected finite numbers"));
    }
    let quaternion = Quaternion::new(w, i, j, k);
    if !(0.9..=1.1).contains(&quaternion.norm()) {
        return Err(format!(
            "a rotation of length {:.3}; expected a quaternion of length 1",
            quaternion.norm()
        ));
    }
    let rotation = UnitQuaternion::from_quaternion(quaternion);
    Ok(Isometry3::from_parts(Translation3::new(x, y, z), rotation))
}

#[cfg(test)]
mod tests;
