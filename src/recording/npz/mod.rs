//! Datasets: a recording as a `.npz` file that numpy opens with `allow_pickle=False`.
//!
//! | array | type, shape | meaning |
//! |---|---|---|
//! | `stamp` | f64 `[K]` | seconds |
//! | `pose` | f64 `[K, 3]` | the label: x, y in metres, heading in radians |
//! | `odometry` | f64 `[K, 3]` | raw dead-reckoned pose, cumulative |
//! | `run` | i64 `[K]` | run number |
//! | `compass`, `route` | f64 `[K]` | optional: heading in radians, metres along a route |
//! | each channel | f32 `[K, D]` | NaN = no return |
//! | `meta` | u8 | UTF-8 JSON: `{"channels": {NAME: {"unit", "bearing_rad", "maximum"}}, "source", "sha256"}` |
//!
//! Written compressed, with the same bytes for the same recording. Read plain or compressed; arrays that `meta` doesn't name are
//! passed over.

mod meta;
mod npy;

use super::{Channel, Columns, Recording, compressed};
use crate::{
    error::{Error, Result},
    geometry::Pose,
    storage,
};
use meta::{Channels, Meta};
use ndarray::{Array1, Array2, ArrayView, Axis, Dimension};
use ndarray_npy::{WritableElement, WriteNpyExt};
use npy::{Element, Shape};
use std::{
    io::{self, Cursor, Read, Seek, Write},
    path::Path,
};
use zip::{
    CompressionMethod, DateTime, ZipArchive, ZipWriter, result::ZipError, write::SimpleFileOptions,
};

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
/// # let recording = ballmark::recording::carmen::read("walk.log".as_ref(), log, None)?.recording;
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
    let archive = ZipArchive::new(Cursor::new(file)).map_err(|e| {
        Error::file(
            path,
            format!(
                "not a whole .npz file ({e}); expected a dataset such as `ballmark import` writes"
            ),
        )
    })?;
    let mut arrays = Arrays {
        path,
        archive,
        left: compressed::largest_content(file.len()),
    };
    let wrong = |array: &str, fault: String| Error::input(path, format!("array `{array}`"), fault);

    let meta: npy::Array<u8> = arrays.read("meta")?;
    let meta: Meta = serde_json::from_slice(&meta.data)
        .map_err(|e| wrong("meta", format!("{e}; expected JSON with `channels`")))?;
    let stamp_s = arrays.column::<f64>("stamp", None)?;
    let k = stamp_s.len();
    let pose = arrays.poses("pose", k)?;
    let odometry = arrays.poses("odometry", k)?;
    let run = arrays.column::<i64>("run", Some(k))?;
    let mut optional = |name: &str| match arrays.has(name) {
        true => arrays.column::<f64>(name, Some(k)).map(Some),
        false => Ok(None),
    };
    let (compass_rad, route_m) = (optional("compass")?, optional("route")?);

    let mut channels = Vec::new();
    let mut blocks = Vec::new();
    for (name, described) in meta.channels.0 {
        if RESERVED.contains(&name.as_str()) {
            return Err(wrong(
                "meta",
                format!("a channel named `{name}`; expected a name that no other array has"),
            ));
        }
        let block = arrays.read::<f32>(&name)?;
        let &[rows, width] = block.shape.as_slice() else {
            return Err(wrong(
                &name,
                format!(
                    "shape {}; expected ({k}, values), one row a snapshot",
                    Shape(&block.shape)
                ),
            ));
        };
        if rows != k {
            return Err(wrong(
                &name,
                format!(
                    "shape {}; expected {k} rows, one a snapshot",
                    Shape(&block.shape)
                ),
            ));
        }
        channels.push(Channel {
            name,
            width,
            unit: described.unit,
            bearing_rad: described.bearing_rad,
            maximum: described.maximum,
        });
        blocks.push(block.data);
    }
    let mut values = Array2::from_elem((k, channels.iter().map(|c| c.width).sum()), f32::NAN);
    let mut first = 0;
    for (channel, data) in channels.iter().zip(blocks) {
        let mut block = values.slice_axis_mut(Axis(1), (first..first + channel.width).into());
        // Some programs write infinity where nothing came back.
        block
            .iter_mut()
            .zip(data)
            .filter(|(_, v)| v.is_finite())
            .for_each(|(to, v)| *to = v);
        first += channel.width;
    }
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
    storage::write_file(path, |out| write_arrays(out, recording))
}

fn write_arrays(out: &mut dyn storage::WriteSeek, recording: &Recording) -> io::Result<()> {
    let c = recording.columns();
    let mut zip = ZipWriter::new(out);
    add(&mut zip, "stamp", Array1::from(c.stamp_s.clone()).view())?;
    add(&mut zip, "pose", pose_array(&c.pose).view())?;
    add(&mut zip, "odometry", pose_array(&c.odometry).view())?;
    add(&mut zip, "run", Array1::from(c.run.clone()).view())?;
    for (name, column) in [("compass", &c.compass_rad), ("route", &c.route_m)] {
        if let Some(column) = column {
            add(&mut zip, name, Array1::from(column.clone()).view())?;
        }
    }
    let mut first = 0;
    for channel in &c.channels {
        let block = c
            .values
            .slice_axis(Axis(1), (first..first + channel.width).into());
        add(&mut zip, &channel.name, block.as_standard_layout().view())?;
        first += channel.width;
    }
    let meta = serde_json::to_vec(&Meta {
        channels: Channels::of(&c.channels),
        source: c.source.clone(),
        sha256: c.source_sha256.clone(),
    })?;
    add(&mut zip, "meta", Array1::from(meta).view())?;
    zip.finish()?;
    Ok(())
}

fn add<W: Write + Seek, T: WritableElement, D: Dimension>(
    zip: &mut ZipWriter<W>,
    name: &str,
    array: ArrayView<T, D>,
) -> io::Result<()> {
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default()) // 1980: the bytes depend on the content only
        .large_file(array.len() as u64 * 8 > u64::from(u32::MAX) / 2);
    zip.start_file(format!("{name}.npy"), options)?;
    array.write_npy(zip).map_err(io::Error::other)
}

fn pose_array(poses: &[Pose]) -> Array2<f64> {
    Array2::from_shape_fn((poses.len(), 3), |(k, i)| match i {
        0 => poses[k].x_m,
        1 => poses[k].y_m,
        _ => poses[k].heading_rad,
    })
}

struct Arrays<'a> {
    path: &'a Path,
    archive: ZipArchive<Cursor<&'a [u8]>>,
    /// Bytes that may still be unpacked.
    left: u64,
}

impl Arrays<'_> {
    fn wrong(&self, array: &str, fault: impl std::fmt::Display) -> Error {
        Error::input(self.path, format!("array `{array}`"), fault)
    }

    fn has(&self, name: &str) -> bool {
        self.archive
            .index_for_name(&format!("{name}.npy"))
            .is_some()
    }

    fn read<T: Element>(&mut self, name: &str) -> Result<npy::Array<T>> {
        let bytes = self.unpack(name)?;
        npy::read(&bytes).map_err(|fault| self.wrong(name, fault))
    }

    fn unpack(&mut self, name: &str) -> Result<Vec<u8>> {
        let path = self.path;
        let wrong = |fault: String| Error::input(path, format!("array `{name}`"), fault);
        let entry = match self.archive.by_name(&format!("{name}.npy")) {
            Ok(entry) => entry,
            Err(ZipError::FileNotFound) => {
                return Err(wrong(
                    "missing; expected it in every dataset that needs or names it".into(),
                ));
            }
            Err(e) => return Err(wrong(format!("can't be opened: {e}"))),
        };
        let declared = entry.size();
        if declared > self.left {
            return Err(wrong(format!(
                "claims to unpack to {declared} bytes; expected a size that fits a file this small"
            )));
        }
        let mut bytes = Vec::new();
        let read = entry.take(self.left + 1).read_to_end(&mut bytes);
        read.map_err(|e| wrong(format!("damaged: {e}")))?;
        self.left = self.left.checked_sub(bytes.len() as u64).ok_or_else(|| {
            wrong(
                "unpacks to more bytes than it claims; expected a size that fits a file this small"
                    .into(),
            )
        })?;
        Ok(bytes)
    }

    fn column<T: Element>(&mut self, name: &str, k: Option<usize>) -> Result<Vec<T>> {
        let array = self.read::<T>(name)?;
        match (array.shape.as_slice(), k) {
            (&[_], None) => Ok(array.data),
            (&[n], Some(k)) if n == k => Ok(array.data),
            (shape, k) => {
                let expected = k.map_or("(snapshots)".to_string(), |k| {
                    format!("({k}), one a snapshot")
                });
                Err(self.wrong(name, format!("shape {}; expected {expected}", Shape(shape))))
            }
        }
    }

    fn poses(&mut self, name: &str, k: usize) -> Result<Vec<Pose>> {
        let array = self.read::<f64>(name)?;
        if array.shape != [k, 3] {
            return Err(self.wrong(
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
