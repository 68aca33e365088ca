//! A bag of ROS 2 as its recorder leaves it: a folder of files, in order one log, and `metadata.yaml`.

use super::{assembled, collector::Collector, mcap, rosbag2, sqlite};
use crate::{
    error::{Error, Result},
    recording::{imported_log::ImportedLog, log_options::LogOptions, source::Source},
    storage,
};
use serde::Deserialize;
use sha2::Sha256;
use std::path::{Path, PathBuf};

const METADATA: &str = "metadata.yaml";
/// Longest metadata file.
const METADATA_BYTES: usize = 16 << 20;

#[derive(Deserialize)]
struct Metadata {
    rosbag2_bagfile_information: Information,
}

#[derive(Deserialize)]
struct Information {
    relative_file_paths: Vec<String>,
    #[serde(default)]
    message_count: Option<u64>,
}

/// Reads all files of a bag as one log; the digest goes on with each file's bytes in order.
///
/// # Errors
/// Where the folder is no bag, a file of it is missing or no part of a bag, or as
/// [`read_rosbag2`](super::read_rosbag2).
pub(in crate::recording) fn read(
    folder: &Path,
    options: &LogOptions,
    mut hash: Sha256,
) -> Result<(ImportedLog, Sha256)> {
    let mut collector = Collector::new(options.topics.as_deref());
    let metadata = folder.join(METADATA);
    let (files, stated) = match metadata.exists() {
        true => {
            let information = information(&metadata)?;
            let names = information.relative_file_paths.iter();
            let files: Result<Vec<PathBuf>> = names.map(|name| in_folder(folder, name)).collect();
            (files?, information.message_count)
        }
        false => {
            let what = "bag without metadata.yaml, as a recorder that crashed leaves it";
            collector.account.warning(what);
            (files_of_bag(folder)?, None)
        }
    };
    if files.is_empty() {
        return Err(Error::file(
            folder,
            "is a folder without files of a rosbag2; expected a file, or a folder with metadata.yaml and .db3 or .mcap files",
        ));
    }
    for path in &files {
        let mut source = Source::open(path, hash)?;
        let name = path.file_name().unwrap_or(path.as_os_str());
        collector.file = Some(name.to_string_lossy().into_owned());
        let read = read_file(path, &mut source, &mut collector);
        // A file that can't be read on, or that changed meanwhile, is why a reader stumbled.
        let (hashed, damage) = source.end()?;
        read?;
        if let Some(damage) = damage {
            collector.lost(&"packing", &damage);
        }
        hash = hashed;
    }
    collector.file = None;
    let found = collector.messages;
    if let Some(stated) = stated.filter(|n| *n != found && collector.account.lost_count() == 0) {
        let fault = format!("{found} messages in all files; expected {stated}");
        collector.lost(&METADATA, &fault);
    }
    Ok((assembled(folder, collector, options)?, hash))
}

/// Reads one of a bag's files.
fn read_file(path: &Path, source: &mut Source, collector: &mut Collector) -> Result<()> {
    if source.is_empty {
        collector.lost(&"the whole", "the file is empty");
        return Ok(());
    }
    let content = source.content()?;
    let read = if content.starts_with(sqlite::MAGIC) {
        rosbag2::read(&content, collector)
    } else if content.starts_with(mcap::MAGIC) {
        mcap::read(&content, collector);
        Ok(())
    } else {
        Err("no part of a rosbag2; expected SQLite or MCAP, plain or zstd".into())
    };
    content.check(path)?;
    read.map_err(|fault| Error::file(path, fault))
}

fn information(path: &Path) -> Result<Information> {
    let bytes = storage::read_file(path)?;
    if bytes.len() > METADATA_BYTES {
        let fault = format!(
            "{} bytes; expected the few of a rosbag2's metadata",
            bytes.len()
        );
        return Err(Error::file(path, fault));
    }
    let metadata: Metadata = serde_saphyr::from_slice(&bytes).map_err(|fault| {
        let fault = fault.to_string().replace('\n', " ");
        Error::file(path, format!("{fault}; expected the metadata of a rosbag2"))
    })?;
    Ok(metadata.rosbag2_bagfile_information)
}

/// A file that the metadata name. Old recorders put the folder's name ahead, and some leave `.zstd` away.
fn in_folder(folder: &Path, name: &str) -> Result<PathBuf> {
    let base = Path::new(name).file_name().unwrap_or_default();
    let path = folder.join(base);
    let mut packed = path.clone().into_os_string();
    packed.push(".zstd");
    let packed = PathBuf::from(packed);
    match (path.is_file(), packed.is_file()) {
        (true, _) => Ok(path),
        (false, true) => Ok(packed),
        (false, false) => Err(Error::file(
            folder.join(METADATA),
            format!(
                "names the file `{}`, which isn't in the folder; expected all files of the bag",
                name.escape_debug()
            ),
        )),
    }
}

/// The files of a bag by their names, those of a number in its order.
fn files_of_bag(folder: &Path) -> Result<Vec<PathBuf>> {
    let refused = |e| Error::io("cannot read the folder", folder, e);
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(refused)? {
        let path = entry.map_err(refused)?.path();
        let name = path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        let plain = name.strip_suffix(".zstd").unwrap_or(&name);
        if path.is_file() && (plain.ends_with(".db3") || plain.ends_with(".mcap")) {
            files.push((name.len(), name, path));
        }
    }
    files.sort();
    Ok(files.into_iter().map(|(_, _, path)| path).collect())
}
