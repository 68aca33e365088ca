//! Which snapshots a model learned from, and which it never saw.

use super::{protocol::Protocol, same_sensor::refuse_other_sensor};
use crate::{
    belief::{MapConfig, Places, thinning::thinned_snapshots},
    error::{Error, Result},
    learning::training_set::covered,
    model::{Model, seen},
    recording::{Recording, degraded::Degraded},
    seed::Seed,
};
use std::borrow::Cow;

/// Which snapshots a model learned from, and which it never saw.
#[derive(Clone)]
pub struct Parts<'a> {
    /// The recording to localise in.
    pub run: &'a Recording,
    /// Its places.
    pub places: Places,
    /// Its snapshots that the model never saw.
    pub unseen: Vec<usize>,
    /// Are these the validation part, which stopped the training?
    pub unseen_is_validation: bool,
    /// What the model learned from, where it is at hand: without it there are no baselines.
    pub source: Option<TrainingSource<'a>>,
}

/// The recording that a model learned from.
#[derive(Clone)]
pub struct TrainingSource<'a> {
    /// The whole recording.
    pub recording: Cow<'a, Recording>,
    /// Snapshots that maps are made of: those that the weights descended on, or of a long log so many of them as a map may have
    /// ([`thinned`](crate::belief::thinning::thinned)).
    pub training: Vec<usize>,
    /// Snapshots that stopped them.
    pub validation: Vec<usize>,
}

impl<'a> Parts<'a> {
    /// Finds out which part of `run` the model has not seen. `trained_on` is the dataset it learned from, where that is
    /// another one.
    ///
    /// # Errors
    /// Where `trained_on` is not the dataset that the model names, or it is seen by another sensor than the model learned with,
    /// or one lies along a route and the other doesn't.
    pub fn new(model: &Model, run: &'a Recording, trained_on: Option<Recording>) -> Result<Self> {
        let run_is_source = seen::is_source(model, run)?;
        let source = match trained_on {
            Some(recording) if seen::is_source(model, &recording)? => Some(Cow::Owned(recording)),
            Some(_) => {
                return Err(Error::work(format!(
                    "--trained-on names another dataset than the model learned from (sha256 {})",
                    model.header.dataset_sha256.as_deref().unwrap_or("unknown")
                )));
            }
            None if run_is_source => Some(Cow::Borrowed(run)),
            None => None,
        };
        if let Some(own) = &source {
            refuse_other_sensor(model, own)?;
        }
        refuse_two_way_route(run)?;
        let source = source
            .map(|recording| {
                let split = model.header.recipe.split.split(&recording)?;
                let test = split.test.clone();
                let training = model.mapped_of(&recording, &split.train);
                Ok::<_, Error>((
                    TrainingSource {
                        recording,
                        training,
                        validation: split.validation,
                    },
                    test,
                ))
            })
            .transpose()?;
        let places = Places::of(run);
        if std::mem::discriminant(&places) != std::mem::discriminant(&model.places()) {
            return Err(Error::work(
                "the model's places and the dataset's differ: one lies along a route (array `route`), the other in the plane",
            ));
        }
        if !run_is_source {
            refuse_training_data(model, run)?;
            refuse_what_it_adapted_to(model, run)?;
        }
        let (unseen, unseen_is_validation) = match &source {
            Some((source, test)) if run_is_source && test.is_empty() => {
                (source.validation.clone(), true)
            }
            Some((_, test)) if run_is_source => (test.clone(), false),
            _ => ((0..run.len()).collect(), false),
        };
        if unseen.is_empty() {
            return Err(Error::work(
                "the model saw every snapshot of this dataset; expected another recording, or a model trained with --test-fold",
            ));
        }
        Ok(Self {
            run,
            places,
            unseen,
            unseen_is_validation,
            source: source.map(|(source, _)| source),
        })
    }

    /// Those of a protocol: what is tested on is unseen, what maps is learned from.
    pub fn of_protocol(protocol: &'a Protocol<'a>) -> Self {
        let is_training = |k: &usize| protocol.validation.binary_search(k).is_err();
        let mapping = protocol.mapping.iter().copied();
        let training: Vec<usize> = mapping.filter(is_training).collect();
        let places = Places::of(&protocol.recording);
        let most = MapConfig::default().most_places;
        let training = thinned_snapshots(&places, &training, most);
        Self {
            run: &protocol.recording,
            places,
            unseen: protocol.testing.clone(),
            unseen_is_validation: false,
            source: Some(TrainingSource {
                recording: Cow::Borrowed(&*protocol.recording),
                training,
                validation: protocol.validation.clone(),
            }),
        }
    }

    /// The recording to localise in with what its unseen snapshots are disturbed by: people before this share of their range beams,
    /// and the noise that a configuration states; none where there is neither.
    ///
    /// # Errors
    /// As [`Recording::with_people`] and [`Degraded::noisy`].
    pub fn disturbed(
        &self,
        people: f64,
        degraded: &Degraded,
        seed: Seed,
    ) -> Result<Option<Recording>> {
        let crowded = match people > 0.0 {
            true => Some(self.run.with_people(&self.unseen, people, seed)?),
            false => None,
        };
        let run = crowded.as_ref().unwrap_or(self.run);
        Ok(degraded.noisy(run, &self.unseen, seed)?.or(crowded))
    }

    /// The same with another recording to localise in: what the unseen snapshots would have been, labels and order as they were.
    pub fn with_run<'b>(&'b self, run: &'b Recording) -> Parts<'b> {
        Parts {
            run,
            ..self.clone()
        }
    }

    /// Unseen snapshots at places that training saw: `mapped`.
    pub fn covered(&self, mapped: &Places) -> Vec<usize> {
        covered(&self.places, &self.unseen, mapped)
    }
}

/// A recording as these models know it, which learned from the same snapshots: without a route where they learned in the plane, and
/// with the readings of the way behind where one of them uses these; the others leave them.
///
/// # Errors
/// As [`Recording::with_history`].
pub fn as_learned(models: &[&Model], recording: Recording) -> Result<Recording> {
    let in_plane = |model: &&Model| matches!(model.places(), Places::Plane(_));
    let recording = match models.first().is_some_and(in_plane) {
        true => recording.in_the_plane(),
        false => recording,
    };
    let history_m = Model::history_of_all(models);
    match history_m.is_empty() {
        true => Ok(recording),
        false => recording.with_history(&history_m),
    }
}

/// A recording that is not the model's own may still hold what the model learned from: the same poses to the last bit.
fn refuse_training_data(model: &Model, run: &Recording) -> Result<()> {
    let known = seen::learned_poses(&model.pose, run, &[]);
    if seen::is_chance(known) {
        return Ok(());
    }
    Err(Error::work(format!(
        "at {known} places of its {} snapshots, to the last bit, the model has learned, but it is not the whole dataset that \
         the model learned from, with the same split: it may hold what the model has seen; expected an unseen recording, or \
         the very dataset that the model was trained on",
        run.len()
    )))
}

/// Nor is a dataset unseen whose snapshots a model has taken in, under labels of its own.
fn refuse_what_it_adapted_to(model: &Model, run: &Recording) -> Result<()> {
    let own = run.columns().dataset_sha256.as_ref();
    let mut updates = model.header.updates.iter();
    match updates.any(|update| own.is_some() && update.dataset_sha256.as_ref() == own) {
        false => Ok(()),
        true => Err(Error::work(
            "the model was adapted to this dataset (`ballmark adapt`); expected a recording that it has not taken in",
        )),
    }
}

/// A belief along a route knows no heading, so odometry can only carry it forwards.
fn refuse_two_way_route(run: &Recording) -> Result<()> {
    if !run.goes_one_way() {
        return Err(Error::work(
            "array `route`: it is driven backwards, too; a belief along a route knows one direction only: leave `route` \
             out (training and localising then go by the poses in the plane), or localise in runs of one direction",
        ));
    }
    Ok(())
}

/// Does odometry say just what the true poses say? Then whatever it carries is flattered.
pub fn odometry_is_the_truth(recording: &Recording) -> bool {
    let poses = recording.poses();
    recording.runs().into_iter().all(|run| {
        (run.start + 1..run.end).all(|k| {
            let (a, b) = (
                recording.observation(k - 1).odometry,
                recording.observation(k).odometry,
            );
            let (said, was) = (
                a.displacement_to(&b),
                poses[k - 1].displacement_to(&poses[k]),
            );
            (said.forward_m - was.forward_m).abs() < 1e-9
                && (said.left_m - was.left_m).abs() < 1e-9
                && (said.turn_rad - was.turn_rad).abs() < 1e-9
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        learning::Recipe,
        model::{Learned, Memory, Note, Training},
        world::corridor::{CorridorConfig, thrun1998},
    };

    /// A map of fewer places than snapshots were learned from: everybody finds the same ones again, from the file as from memory.
    #[test]
    fn a_map_of_some_training_places_is_known_as_such() {
        const MOST: usize = 60;
        let config = CorridorConfig {
            runs: 6,
            spacing_m: 1.0,
        };
        let recording = thrun1998(Seed(1), &config).unwrap();
        let mut recipe = Recipe {
            features: 1,
            ..Recipe::default()
        };
        recipe.split.test_fold = Some(0);
        recipe.descent.steps = 20;
        let all = recipe.split.split(&recording).unwrap().train;
        let Learned {
            model: of_all,
            report,
        } = Training::new(&recipe, &recording).run().unwrap();
        let is_thinned = |note: &Note| matches!(note, Note::MapThinned(..));
        assert!(!report.notes.iter().any(is_thinned));
        assert_eq!(of_all.pose.len(), all.len());
        recipe.map.most_places = MOST;
        let Learned { model, report } = Training::new(&recipe, &recording).run().unwrap();
        assert!((MOST / 2..=MOST).contains(&model.pose.len()));
        // All of them are learned from, and whoever trained it is told.
        assert_eq!(model.weights, of_all.weights);
        let told = Note::MapThinned(model.pose.len(), all.len());
        assert!(report.notes.contains(&told));
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("m.safetensors");
        model.write(&file).unwrap();
        assert_eq!(Model::read(&file).unwrap(), model);

        let parts = Parts::new(&model, &recording, None).unwrap();
        let source = parts.source.as_ref().unwrap();
        let poses = |snapshots: &[usize]| -> Vec<_> {
            snapshots.iter().map(|&k| recording.poses()[k]).collect()
        };
        assert_eq!(poses(&source.training), model.pose);
        assert!(source.training.iter().all(|k| all.contains(k)));
        let memory = Memory::of(&model, &recording).unwrap();
        assert_eq!(memory.recording().poses(), model.pose);
        // The activations are those of these snapshots.
        let detector = crate::detector::Detector::probabilities(
            &model.detector(),
            &recording.select(&source.training).unwrap(),
        );
        let apart = &detector.unwrap() - &model.activation;
        assert!(apart.iter().all(|d| d.abs() < 1e-5));
        // A file of before, whose header has no such key and whose map has all places, is known as well.
        assert!(seen::is_source(&of_all, &recording).unwrap());
    }
}
