//! The format of the TUM RGB-D benchmark (Sturm et al., *A benchmark for the evaluation of RGB-D SLAM systems*, 2012).

use super::{Rows, lines};
use crate::{
    error::Result,
    score::trajectory::{Pose3, poses::FARTHEST_M},
};
use nalgebra::Vector3;
use std::path::Path;

/// How far a quaternion's length may be from 1: rounding, not something else than a quaternion.
const UNIT: f64 = 0.1;

pub(super) fn read(path: &Path, text: &str) -> Result<Rows> {
    let names = ["stamp", "x", "y", "z", "qx", "qy", "qz", "qw"];
    let parse = |line: &str| {
        let [stamp_s, x, y, z, qx, qy, qz, qw] =
            lines::numbers(line, names, "TUM: stamp x y z qx qy qz qw")?;
        Ok((stamp_s, pose([x, y, z], [qx, qy, qz, qw])?))
    };
    let (line, rows) = lines::rows(path, text, parse)?;
    let (stamp_s, pose) = rows.into_iter().unzip();
    Ok(Rows {
        line,
        stamp_s: Some(stamp_s),
        pose,
    })
}

/// A pose of finite numbers, checked.
pub(super) fn pose(xyz: [f64; 3], xyzw: [f64; 4]) -> std::result::Result<Pose3, String> {
    let length = xyzw.iter().map(|q| q * q).sum::<f64>().sqrt();
    if length < 1e-6 {
        return Err("a quaternion of length zero; expected length 1".into());
    }
    if (length - 1.0).abs() > UNIT {
        return Err(format!(
            "a quaternion of length {length:.3}; expected length 1, in the order x, y, z, w"
        ));
    }
    let pose = Pose3::from_quaternion(position(xyz)?, xyzw);
    pose.ok_or_else(|| "a quaternion of length zero; expected length 1".into())
}

/// A place that robots go to.
pub(super) fn position(xyz: [f64; 3]) -> std::result::Result<Vector3<f64>, String> {
    match xyz.iter().find(|x| x.abs() > FARTHEST_M) {
        Some(far) => Err(format!("a place {far:e} m away; expected within 1e9 m")),
        None => Ok(Vector3::from(xyz)),
    }
}
