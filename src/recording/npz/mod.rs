//! Datasets: a recording as a `.npz` file that numpy opens with `allow_pickle=False`.
//!
//! | array | type, shape | meaning |
//! |---|---|---|
//! | `stamp` | f64 `[K]` | seconds |
//! | `pose` | f64 `[K, 3]` | the label: x, y in metres, heading in radians |
//! | `odometry` | f64 `[K, 3]` | optional: raw dead-reckoned pose, cumulative; without it the poses are repeated |
//! | `run` | i64 `[K]` | run number |
//! | `compass`, `route` | f64 `[K]` | optional: heading in radians, metres along a route |
//! | each channel | f32 `[K, D]` | NaN = no return |
//! | `meta` | u8 | UTF-8 JSON: `{"channels": {NAME: {"unit", "bearing_rad", "maximum"}}, "source", "sha256"}` |
//!
//! Written compressed, with the same bytes for the same recording. Read plain or compressed, numbers of other types where they are
//! taken in without loss of a reading (`f64` channels, `i32` runs); arrays that `meta` doesn't name are
//! passed over.

mod meta;

use super::{Channel, Columns, Recording};
use crate::{
    archive::{
        self, Archive, Writer,
        npy::{Shape, Widened},
    },
    error::{Error, Result},
    geometry::Pose,
    storage,
};
use meta::{Channels, Meta};
use ndarray::{Array1, Array2, Axis};
use std::{io, path::Path};

/// What a dataset's file is expected to be, for messages.
const EXPECTED: &str = "a dataset such as `ballmark import` writes";

/// Names that mean something else than a channel.
const RESERVED: [&str; 7] = [
    "stamp", "pose", "odometry", "run", "compass", "route", "meta",
];

/// Reads a dataset; its checksum comes with it.
///
/// # Errors
/// Where the file can't be read, is no whole `.npz`, lacks an array, or an array has another type or shape than the table
/// above says. Memory is bounded by the size of the file, whatever it claims to hold.
///
/// ```
/// # let folder = tempfile::tempdir().unwrap();
/// # let path = folder.path().join("walk.npz");
/// # let log = b"FLASER 2 1.5 2.5 0 0 0 0 0 0 0.1 host 0.1\n";
/// # let recording = ballmark::recording::format::carmen::read("walk.log".as_ref(), log, &Default::default())?.recording;
/// use ballmark::recording::npz;
/// npz::write(&path, &recording)?;
/// let again = npz::read(&path)?;
/// assert_eq!(again.values(), recording.values());
/// # Ok::<(), ballmark::Error>(())
/// ```
pub fn read(path: &Path) -> Result<Recording> {
    from_bytes(path, &storage::read_file(path)?)
}

/// Reads a dataset from the bytes of its file; `path` is for messages only.
///
/// # Errors
/// As [`read`].
pub fn from_bytes(path: &Path, file: &[u8]) -> Result<Recording> {
    if file.is_empty() {
        return Err(Error::file(
            path,
            "the file is empty; expected a .npz dataset",
        ));
    }
    let mut dataset = Dataset(Archive::open(path, file, EXPECTED)?);
    let wrong = |array: &str, fault: String| Error::input(path, format!("array `{array}`"), fault);

    let meta = dataset.0.read::<u8>("meta")?;
    let meta: Meta = serde_json::from_slice(&meta.data)
        .map_err(|e| wrong("meta", format!("{e}; expected JSON with `channels`")))?;
    let stamp_s = dataset.column::<f64>("stamp", None)?;
    let k = stamp_s.len();
    let pose = dataset.poses("pose", k)?;
    let odometry = match dataset.0.has("odometry") {
        true => dataset.poses("odometry", k)?,
        false => pose.clone(),
    };
    let run = dataset.column::<i64>("run", Some(k))?;
    let mut optional = |name: &str| match dataset.0.has(name) {
        true => dataset.column::<f64>(name, Some(k)).map(Some),
        false => Ok(None),
    };
    let (compass_rad, route_m) = (optional("compass")?, optional("route")?);

    let mut channels = Vec::new();
    for (name, described) in meta.channels.0 {
        if RESERVED.contains(&name.as_str()) {
            return Err(wrong(
                "meta",
                format!("a channel named `{name}`; expected a name that no other array has"),
            ));
        }
        let shape = dataset.0.shape(&name)?;
        let &[rows, width] = shape.as_slice() else {
            return Err(wrong(
                &name,
                format!(
                    "shape {}; expected ({k}, values), one row a snapshot",
                    Shape(&shape)
                ),
            ));
        };
        if rows != k {
            return Err(wrong(
                &name,
                format!("shape {}; expected {k} rows, one a snapshot", Shape(&shape)),
            ));
        }
        if let Some(maximum) = described.maximum.filter(|m| !(m.is_finite() && *m > 0.0)) {
            return Err(wrong(
                "meta",
                format!(
                    "`maximum` of channel `{}` is {maximum}; expected more than 0, or null for none",
                    name.escape_debug()
                ),
            ));
        }
        channels.push(Channel {
            name,
            width,
            unit: described.unit,
            bearing_rad: described.bearing_rad,
            maximum: described.maximum,
            offset_m: described.offset_m,
        });
    }
    if k == 0 {
        // Widths of no rows are bounded by nothing.
        return Err(wrong("pose", "no snapshot; expected at least one".into()));
    }
    let values = dataset.values(&channels, k)?;
    let recording = Recording::new(Columns {
        channels,
        values,
        stamp_s,
        pose,
        odometry,
        run,
        compass_rad,
        route_m,
        source: meta.source,
        source_sha256: meta.sha256,
        dataset_sha256: Some(storage::sha256(file)),
        degraded: None,
        noise: None,
    });
    recording.map_err(|e| e.in_file(path))
}

/// Writes a dataset, whole or not at all.
///
/// # Errors
/// Where the file can't be written, or a channel bears the name of another array.
pub fn write(path: &Path, recording: &Recording) -> Result<()> {
    let taken = |c: &&Channel| RESERVED.contains(&c.name.as_str()) || c.name.is_empty();
    if let Some(channel) = recording.channels().iter().find(taken) {
        return Err(Error::work(format!(
            "a channel can't be named `{}`; expected another name than {}",
            channel.name,
            RESERVED.join(", ")
        )));
    }
    archive::write(path, |archive| add_arrays(archive, recording))
}

fn add_arrays(archive: &mut Writer<'_>, recording: &Recording) -> io::Result<()> {
    let c = recording.columns();
    archive.add("stamp", Array1::from(c.stamp_s.clone()).view())?;
    archive.add("pose", pose_array(&c.pose).view())?;
    archive.add("odometry", pose_array(&c.odometry).view())?;
    archive.add("run", Array1::from(c.run.clone()).view())?;
    for (name, column) in [("compass", &c.compass_rad), ("route", &c.route_m)] {
        if let Some(column) = column {
            archive.add(name, Array1::from(column.clone()).view())?;
        }
    }
    let mut first = 0;
    for channel in &c.channels {
        let block = c
            .values
            .slice_axis(Axis(1), (first..first + channel.width).into());
        archive.add(&channel.name, block.as_standard_layout().view())?;
        first += channel.width;
    }
    let meta = serde_json::to_vec(&Meta {
        channels: Channels::of(&c.channels),
        source: c.source.clone(),
        sha256: c.source_sha256.clone(),
    })?;
    archive.add("meta", Array1::from(meta).view())
}

fn pose_array(poses: &[Pose]) -> Array2<f64> {
    Array2::from_shape_fn((poses.len(), 3), |(k, i)| match i {
        0 => poses[k].x_m,
        1 => poses[k].y_m,
        _ => poses[k].heading_rad,
    })
}

/// An archive whose arrays have one row a snapshot.
struct Dataset<'a>(Archive<'a>);

impl Dataset<'_> {
    /// The values of all channels side by side. Of several, one at a time is held twice; of one alone nothing is.
    fn values(&mut self, channels: &[Channel], k: usize) -> Result<Array2<f32>> {
        // Some programs write infinity where nothing came back.
        let finite = |v: f32| if v.is_finite() { v } else { f32::NAN };
        if let [only] = channels {
            let mut block = self.0.read_widened::<f32>(&only.name)?.data;
            block.iter_mut().for_each(|v| *v = finite(*v));
            let values = Array2::from_shape_vec((k, only.width), block);
            return values.map_err(|e| self.0.wrong(&only.name, e));
        }
        let width: usize = channels.iter().map(|c| c.width).sum();
        let mut values = Array2::from_elem((k, width), f32::NAN);
        let mut first = 0;
        for channel in channels {
            let block = self.0.read_widened::<f32>(&channel.name)?.data;
            let mut to = values.slice_axis_mut(Axis(1), (first..first + channel.width).into());
            to.iter_mut().zip(block).for_each(|(to, v)| *to = finite(v));
            first += channel.width;
        }
        Ok(values)
    }

    fn column<T: Widened>(&mut self, name: &str, k: Option<usize>) -> Result<Vec<T>> {
        let array = self.0.read_widened::<T>(name)?;
        match (array.shape.as_slice(), k) {
            (&[_], None) => Ok(array.data),
            (&[n], Some(k)) if n == k => Ok(array.data),
            (shape, k) => {
                let expected = k.map_or("(snapshots)".to_string(), |k| {
                    format!("({k}), one a snapshot")
                });
                Err(self
                    .0
                    .wrong(name, format!("shape {}; expected {expected}", Shape(shape))))
            }
        }
    }

    fn poses(&mut self, name: &str, k: usize) -> Result<Vec<Pose>> {
        let array = self.0.read_widened::<f64>(name)?;
        if array.shape != [k, 3] {
            return Err(self.0.wrong(
                name,
                format!(
                    "shape {}; expected ({k}, 3): x, y, heading a snapshot",
                    Shape(&array.shape)
                ),
            ));
        }
        let triples = array.data.chunks_exact(3);
        Ok(triples.map(|p| Pose::new(p[0], p[1], p[2])).collect())
    }
}
