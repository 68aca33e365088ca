//! Pose graphs of g2o (Kümmerle et al., *g2o: a general framework for graph optimization*, 2011) and TORO: their vertices are the poses.

use super::{Rows, lines, tum};
use crate::{
    error::{Error, Result},
    geometry::Pose,
    score::trajectory::Pose3,
};
use std::path::Path;

/// Vertices of the plane and of space.
const PLANE: [&str; 2] = ["VERTEX_SE2", "VERTEX2"];
const SPACE: [&str; 2] = ["VERTEX_SE3:QUAT", "VERTEX3:QUAT"];

/// Does a line read like one of a graph?
pub(super) fn is_of_graph(line: &str) -> bool {
    let kind = line.split_ascii_whitespace().next().unwrap_or_default();
    ["VERTEX", "EDGE", "FIX", "PARAMS_SE"]
        .iter()
        .any(|start| kind.starts_with(start))
}

/// Vertices in the order of their numbers, whatever that of their lines. Edges and sensors' lines are passed over.
pub(super) fn read(path: &Path, text: &str) -> Result<Rows> {
    let mut vertices: Vec<(u64, u64, Pose3)> = Vec::new();
    for (line, content) in lines::content(text) {
        let (kind, rest) = content
            .split_once(|c: char| c.is_ascii_whitespace())
            .unwrap_or((content, ""));
        let wrong = |fault: String| Error::input(path, format!("line {line}"), fault);
        let (id, pose) = if PLANE.contains(&kind) {
            let names = ["id", "x", "y", "theta"];
            let [id, x, y, theta] =
                lines::numbers(rest, names, "a vertex: id x y theta").map_err(wrong)?;
            let flat = Pose3::from_plane(&Pose::new(x, y, theta));
            let position_m = tum::position([x, y, 0.0]).map_err(wrong)?;
            (id, Pose3 { position_m, ..flat })
        } else if SPACE.contains(&kind) {
            let names = ["id", "x", "y", "z", "qx", "qy", "qz", "qw"];
            let [id, x, y, z, qx, qy, qz, qw] =
                lines::numbers(rest, names, "a vertex: id x y z qx qy qz qw").map_err(wrong)?;
            let pose = tum::pose([x, y, z], [qx, qy, qz, qw]).map_err(wrong)?;
            (id, pose)
        } else {
            continue;
        };
        if !(id >= 0.0 && id.fract() == 0.0 && id < 2f64.powi(53)) {
            return Err(wrong(format!(
                "vertex {id}; expected a whole number from 0"
            )));
        }
        vertices.push((id as u64, line, pose));
    }
    vertices.sort_by_key(|(id, line, _)| (*id, *line));
    if let Some(pair) = vertices.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        let fault = format!("vertex {} twice, first in line {}", pair[1].0, pair[0].1);
        return Err(Error::input(path, format!("line {}", pair[1].1), fault));
    }
    Ok(Rows {
        line: vertices.iter().map(|(_, line, _)| *line).collect(),
        stamp_s: None,
        pose: vertices.into_iter().map(|(_, _, pose)| pose).collect(),
    })
}
