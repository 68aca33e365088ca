//! Which training a checkpoint or a model is of: version, data and recipe.

use crate::{
    error::{Error, Result},
    geometry::Pose,
    learning::{recipe::Recipe, start::Start},
    mapping::{Occupancy, OccupancyMap},
    recording::Recording,
    storage,
};
use sha2::{Digest, Sha256};

/// Names a training: two of the same identity, unbroken and on one machine, end in the same bits.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TrainingIdentity {
    /// SHA-256 (hexadecimal) of the crate's version, the recording's content and the whole recipe.
    pub whole: String,
    /// The same without the recipe's number of steps: a training may go on from the checkpoint of one with another number of steps.
    pub but_for_steps: String,
}

impl TrainingIdentity {
    /// The identity of training a recipe on a recording, in a map that was made elsewhere and from networks that have
    /// learned already, where these are given.
    ///
    /// The recording counts by its columns, not by the checksum of the file that it came from: a part of a dataset has the
    /// same checksum and is other data.
    ///
    /// # Errors
    /// Where the recipe can't be written down (a number that is none).
    pub fn new(
        recipe: &Recipe,
        recording: &Recording,
        given: Option<&OccupancyMap>,
        start: Option<&Start>,
    ) -> Result<Self> {
        let mut data = digest(recording)?;
        if let Some(map) = given {
            data += &map_digest(map);
        }
        if let Some(start) = start {
            data += &start_digest(start);
        }
        let named = |recipe: &Recipe| -> Result<String> {
            let recipe =
                serde_json::to_string(recipe).map_err(|e| Error::work(format!("recipe: {e}")))?;
            let words = format!("{} {data} {recipe}", env!("CARGO_PKG_VERSION"));
            Ok(storage::sha256(words.as_bytes()))
        };
        let mut of_any_length = recipe.clone();
        of_any_length.descent.steps = 0;
        Ok(Self {
            whole: named(recipe)?,
            but_for_steps: named(&of_any_length)?,
        })
    }
}

/// SHA-256 of the networks that a training begins with.
fn start_digest(start: &Start) -> String {
    let mut bytes = Vec::new();
    for layer in &start.weights.layers {
        bytes.extend(layer.weight.iter().flat_map(|v| v.to_le_bytes()));
        bytes.extend(layer.bias.iter().flat_map(|v| v.to_le_bytes()));
    }
    let constants = start.input.mean.iter().chain(&start.input.deviation);
    bytes.extend(constants.flat_map(|v| v.to_le_bytes()));
    format!(" from {}", storage::sha256(&bytes))
}

/// SHA-256 of a map that was made elsewhere.
fn map_digest(map: &OccupancyMap) -> String {
    let [x_m, y_m] = map.origin_m();
    let numbers = [map.cell_m(), x_m, y_m, map.size()[0] as f64];
    let mut bytes: Vec<u8> = numbers.iter().flat_map(|v| v.to_le_bytes()).collect();
    bytes.extend(map.cells().iter().map(|cell| match cell {
        Occupancy::Unknown => 0,
        Occupancy::Free => 1,
        Occupancy::Occupied => 2,
    }));
    format!(" map {}", storage::sha256(&bytes))
}

/// SHA-256 of all that a training can see of a recording.
fn digest(recording: &Recording) -> Result<String> {
    let columns = recording.columns();
    let mut sha = Sha256::new();
    let channels =
        serde_json::to_vec(&columns.channels).map_err(|e| Error::work(format!("channels: {e}")))?;
    // Every part is preceded by its length, so that no two recordings give the same bytes.
    sha.update((channels.len() as u64).to_le_bytes());
    sha.update(&channels);
    sha.update((columns.run.len() as u64).to_le_bytes());
    let mut row_bytes = Vec::new();
    for row in columns.values.rows() {
        row_bytes.clear();
        row_bytes.extend(row.iter().flat_map(|v| v.to_le_bytes()));
        sha.update(&row_bytes);
    }
    let mut numbers = |values: &mut dyn Iterator<Item = f64>| {
        values.for_each(|v| sha.update(v.to_le_bytes()));
    };
    let of_pose = |p: &Pose| [p.x_m, p.y_m, p.heading_rad];
    numbers(&mut columns.stamp_s.iter().copied());
    numbers(&mut columns.pose.iter().flat_map(of_pose));
    numbers(&mut columns.odometry.iter().flat_map(of_pose));
    for run in &columns.run {
        sha.update(run.to_le_bytes());
    }
    for optional in [&columns.compass_rad, &columns.route_m] {
        sha.update([u8::from(optional.is_some())]);
        for v in optional.iter().flatten() {
            sha.update(v.to_le_bytes());
        }
    }
    Ok(storage::hexadecimal(sha))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{recording::Columns, seed::Seed, world::corridor};

    #[test]
    fn other_data_another_recipe_and_other_steps_are_told_apart() {
        let config = corridor::CorridorConfig {
            runs: 2,
            spacing_m: 5.0,
        };
        let recording = corridor::thrun1998(Seed(1), &config).unwrap();
        let recipe = Recipe::default();
        let identity = TrainingIdentity::new(&recipe, &recording, None, None).unwrap();
        assert_eq!(
            identity,
            TrainingIdentity::new(&recipe, &recording, None, None).unwrap()
        );

        let changes: [fn(&mut Columns); 6] = [
            |c| c.values[[3, 2]] += 0.5,
            |c| c.pose[1].x_m += 0.5,
            |c| c.odometry[1].y_m += 0.5,
            |c| c.run[1..].iter_mut().for_each(|run| *run += 1),
            |c| c.route_m = None,
            |c| c.channels[0].maximum = Some(1000.0),
        ];
        for (number, change) in changes.into_iter().enumerate() {
            let mut columns = recording.clone().into_columns();
            // A part of a dataset keeps the checksum of the whole.
            columns.dataset_sha256 = Some("the same".into());
            change(&mut columns);
            let other = Recording::new(columns).unwrap();
            let other = TrainingIdentity::new(&recipe, &other, None, None).unwrap();
            assert_ne!(other.whole, identity.whole, "change {number}");
            assert_ne!(
                other.but_for_steps, identity.but_for_steps,
                "change {number}"
            );
        }

        let mut longer = recipe.clone();
        longer.descent.steps += 1;
        let longer = TrainingIdentity::new(&longer, &recording, None, None).unwrap();
        assert_ne!(longer.whole, identity.whole);
        assert_eq!(longer.but_for_steps, identity.but_for_steps);
        let mut other = recipe.clone();
        other.seed += 1;
        let other = TrainingIdentity::new(&other, &recording, None, None).unwrap();
        assert_ne!(other.but_for_steps, identity.but_for_steps);
    }
}
