//! The format of the KITTI odometry benchmark (Geiger, Lenz & Urtasun, *Are we ready for autonomous driving?*, 2012).

use super::{Rows, lines, tum};
use crate::{
    error::Result,
    score::trajectory::{Pose3, rotation},
};
use nalgebra::Matrix3;
use std::path::Path;

const ENTRIES: [&str; 12] = [
    "r11", "r12", "r13", "tx", "r21", "r22", "r23", "ty", "r31", "r32", "r33", "tz",
];

pub(super) fn read(path: &Path, text: &str) -> Result<Rows> {
    let (line, pose) = lines::rows(path, text, |line| {
        let m = lines::numbers(line, ENTRIES, "KITTI: three rows of four")?;
        let rotation = Matrix3::new(m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]);
        if !rotation::is_rotation(&rotation) {
            return Err(
                "no rotation in columns 1-3, 5-7, 9-11; expected rows of length 1 at right angles, right-handed"
                    .to_string(),
            );
        }
        Ok(Pose3 {
            position_m: tum::position([m[3], m[7], m[11]])?,
            rotation,
        })
    })?;
    Ok(Rows {
        line,
        stamp_s: None,
        pose,
    })
}
