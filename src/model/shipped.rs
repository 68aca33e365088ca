//! Pre-trained networks that come with the program.

use super::trained_model::Model;
use crate::{
    detector::{input::Input, net::Weights},
    error::Result,
    learning::Recipe,
    recording::Recording,
    seed::Seed,
};
use std::path::Path;

/// Their names and files; `models/README.md` says how they were made.
const SHIPPED: [(&str, &[u8]); 1] = [(
    "lidar-180",
    include_bytes!("../../models/lidar-180.safetensors"),
)];

impl Model {
    /// The networks, by name, that come with the program and fit to the sensors of a recording and to a recipe; none where none do.
    ///
    /// # Errors
    /// Where the recipe names a channel that the recording lacks.
    pub fn shipped_for(recipe: &Recipe, recording: &Recording) -> Result<Option<(String, Model)>> {
        // What the inputs are, not their constants: a few snapshots do.
        let few: Vec<usize> = (0..recording.len().min(2)).collect();
        let input = Input::fit(&recipe.input, recording, &few)?;
        for (name, bytes) in SHIPPED {
            let model = Self::from_bytes(Path::new(name), bytes)?;
            let start = model.as_start();
            let Ok(input) = start.input_for(input.clone(), recording.channels()) else {
                continue;
            };
            let mut random = Seed(0).stream("shape alone");
            let weights =
                Weights::random(&recipe.network, input.shape(), recipe.features, &mut random);
            if start.weights_for(recipe, weights).is_ok() {
                return Ok(Some((name.to_string(), model)));
            }
        }
        Ok(None)
    }
}
