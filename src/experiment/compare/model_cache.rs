//! The models of systems that need BaLL's filters: trained on the mapping part of a dataset, once for each distinct recipe.

use super::file_names;
use crate::{
    error::{Error, Result},
    experiment::protocol::Protocol,
    learning::{Recipe, trainer::Progress},
    model::{Note, Training},
    storage,
};
use std::{
    borrow::Cow,
    path::{Path, PathBuf},
};

/// The models of one dataset.
pub(super) struct ModelCache<'a> {
    folder: &'a Path,
    dataset: &'a str,
    /// What was trained, and where it lies or why it failed.
    trained: Vec<(Recipe, std::result::Result<PathBuf, String>)>,
    /// What the scores of the trainings do not show, each with the system that it is about.
    pub notes: Vec<String>,
}

impl<'a> ModelCache<'a> {
    /// For a dataset whose models go to this folder, their names beginning with the dataset's.
    pub fn new(folder: &'a Path, dataset: &'a str) -> Self {
        Self {
            folder,
            dataset,
            trained: Vec::new(),
            notes: Vec::new(),
        }
    }

    /// The file of the model of a recipe; `system` gives it its name.
    ///
    /// # Errors
    /// Where the mapping part is not enough to learn from, or the file can't be written.
    pub fn model(
        &mut self,
        system: &str,
        recipe: &Recipe,
        protocol: &Protocol,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<PathBuf> {
        let known = self.trained.iter().position(|(known, _)| known == recipe);
        let at = match known {
            Some(at) => at,
            None => {
                let number = self.trained.len();
                let all = [self.dataset, system].into_iter();
                let name = match &file_names(all)[..] {
                    [dataset, system] if number == 0 => format!("{dataset}-{system}"),
                    names => format!("{}-{}", names.join("-"), number + 1),
                };
                let file = self.folder.join(format!("{name}.safetensors"));
                let made = train(recipe, protocol, &file, progress);
                let made = made.map(|notes| {
                    let notes = notes.iter().map(|note| format!("{system}: {note}"));
                    self.notes.extend(notes);
                    file
                });
                let made = made.map_err(|e| e.to_string());
                self.trained.push((recipe.clone(), made));
                number
            }
        };
        self.trained[at].1.clone().map_err(Error::work)
    }
}

fn train(
    recipe: &Recipe,
    protocol: &Protocol,
    file: &Path,
    progress: &mut dyn FnMut(Progress),
) -> Result<Vec<Note>> {
    let split;
    // All systems of a comparison have the same inputs.
    let mut recipe = recipe.clone();
    recipe.input.history_m.get_or_insert_default();
    let recipe = &recipe;
    let (recipe, recording) = match &protocol.split {
        // The protocol deals the parts, just as `ballmark train` does: the model is the same.
        Some(dealt) => {
            split = Recipe {
                split: *dealt,
                ..recipe.clone()
            };
            (&split, Cow::Borrowed(&*protocol.recording))
        }
        None => {
            let mapping = protocol.recording.select(&protocol.mapping)?;
            (recipe, Cow::Owned(mapping))
        }
    };
    let training = Training::new(recipe, &recording).on_progress(|p| {
        if p.judged {
            progress(p);
        }
    });
    let learned = training.run()?;
    if let Some(folder) = file.parent() {
        storage::make_folder(folder)?;
    }
    learned.model.write(file)?;
    Ok(learned.report.notes)
}
