//! What is played back: datasets from files, and worlds simulated at once.

use super::{CompareConfig, dataset_config::DatasetConfig};
use crate::{
    error::{Error, Result},
    experiment::protocol::Protocol,
    recording::{Recording, degraded::Degraded, npz},
    seed::Seed,
    world::{
        Building,
        simulation::{Choice, simulate},
    },
};
use std::path::{Path, PathBuf};

/// Where a dataset was simulated.
pub(super) struct World {
    /// The file that describes it.
    pub file: PathBuf,
    pub building: Building,
    /// The set of runs that was asked for.
    pub set: Option<String>,
}

/// A dataset, ready to be played back.
pub(super) struct LoadedDataset {
    pub recording: Recording,
    /// What it was simulated in; none where it was read from a file.
    pub world: Option<World>,
    /// What a caption must say of it.
    pub notes: Vec<String>,
}

impl LoadedDataset {
    /// Reads or simulates a dataset as a worse sensor would have made it; its files lie in `folder`.
    ///
    /// # Errors
    /// Where a file can't be read or is none of its kind, the world's robot can't drive, or the dataset has no such sensor; the
    /// message names the file.
    pub fn open(
        config: &DatasetConfig,
        folder: &Path,
        seed: u64,
        degraded: &Degraded,
    ) -> Result<Self> {
        let (recording, world) = match (&config.file, &config.world) {
            (Some(file), _) => (npz::read(&folder.join(file))?, None),
            (None, Some(world)) => {
                let file = folder.join(world);
                let building = Building::read(&file)?;
                let choice = Choice {
                    set: config.set.clone(),
                    runs: config.runs,
                };
                let seed = Seed(config.seed.unwrap_or(seed));
                let simulated = simulate(&building, seed, &choice);
                let recording = as_read(simulated.map_err(|e| e.in_file(&file))?)?;
                (
                    recording,
                    Some(World {
                        file,
                        building,
                        set: choice.set,
                    }),
                )
            }
            (None, None) => {
                let fault = "a dataset without `file` and `world`; expected one of them";
                return Err(Error::usage(fault));
            }
        };
        let recording = degraded
            .sensor(recording)
            .map_err(|e| e.context(&config.name))?;
        let one_way = recording.goes_one_way();
        let mut notes = Vec::new();
        if let Some(degraded) = &recording.columns().degraded {
            notes.push(format!("sensor degraded: {degraded}"));
        }
        if !one_way {
            notes.push("route left out, as it is not driven one way".to_string());
        }
        Ok(Self {
            recording: match one_way {
                true => recording,
                false => recording.in_the_plane(),
            },
            world,
            notes,
        })
    }
}

impl LoadedDataset {
    /// The comparison's protocol applied to it, with people and noise before what is tested on.
    ///
    /// # Errors
    /// As [`Protocol::new`].
    pub fn protocol(&self, config: &CompareConfig) -> Result<Protocol<'_>> {
        let protocol = Protocol::new(&self.recording, &config.protocol_for(&self.recording))?;
        let seed = config.trials().seed();
        let protocol = match config.degraded.people {
            Some(share) if share > 0.0 => protocol.with_people(share, seed)?,
            _ => protocol,
        };
        protocol.with_noise(&config.degraded, seed)
    }
}

/// Just what somebody gets who simulates first and reads the file then, checksum and all.
fn as_read(recording: Recording) -> Result<Recording> {
    let folder = tempfile::tempdir()
        .map_err(|e| Error::io("cannot make a temporary folder", std::env::temp_dir(), e))?;
    let file = folder.path().join("simulated.npz");
    npz::write(&file, &recording)?;
    npz::read(&file)
}
