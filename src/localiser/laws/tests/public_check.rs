//! The check that users call for localisers of their own: it passes ours, and names what others break.

use super::*;

#[test]
fn the_public_check_passes_built_in_localisers() {
    let room = test_world();
    let trial: Vec<usize> = (104..144).collect();
    for kind in [Kind::DeadReckoning, Kind::EvidenceBased, Kind::Memoryless] {
        check(&kind.default_config(), &room, &first_lap(), &trial).unwrap();
    }
}

/// Localisers that break one law each.
#[derive(Debug, Clone, Serialize, Deserialize)]
enum Broken {
    /// Answers with the truth.
    LooksAtTheTruth,
    /// Answers with where the trial ends.
    LooksAhead,
    /// One answer too few.
    Lazy,
    /// Probabilities that sum to 2.
    TooProbable,
    TurnedByNaN,
}

impl Constants for Broken {
    fn kind(&self) -> &str {
        "broken"
    }
}

impl LocaliserConfig for Broken {
    fn learn(&self, _: &Recording, _: &[usize], _: Seed) -> Result<Box<dyn Localiser>> {
        Ok(Box::new(self.clone()))
    }
}

impl Localiser for Broken {
    fn name(&self) -> &str {
        "broken"
    }

    fn places(&self) -> usize {
        0
    }

    fn bytes_per_place(&self) -> usize {
        0
    }

    fn check_channels(&self, _: &[Channel]) -> Result<()> {
        Ok(())
    }

    fn prepare<'a>(
        &'a self,
        recording: &'a Recording,
        _: &[usize],
    ) -> Result<Box<dyn TrialRunner + 'a>> {
        Ok(Box::new((self, recording)))
    }
}

impl TrialRunner for (&Broken, &Recording) {
    fn play(&self, trial: &[usize], _: Option<Pose>, _: &mut Stream) -> Result<Vec<Step>> {
        let (broken, recording) = self;
        let odometry = |k: usize| recording.observation(k).odometry;
        let last = trial.last().copied().unwrap_or_default();
        let mut steps: Vec<Step> = trial
            .iter()
            .map(|&k| {
                let pose = match broken {
                    Broken::LooksAtTheTruth => recording.poses()[k],
                    Broken::LooksAhead => odometry(last),
                    _ => odometry(k),
                };
                let place = [pose.x_m, pose.y_m];
                let posterior = match broken {
                    Broken::TooProbable => vec![(place, 1.0), (place, 1.0)],
                    _ => Vec::new(),
                };
                Step {
                    estimate: Some(Estimate::Place(place)),
                    posterior,
                    heading_rad: matches!(broken, Broken::TurnedByNaN).then_some(f64::NAN),
                }
            })
            .collect();
        if matches!(broken, Broken::Lazy) {
            steps.pop();
        }
        Ok(steps)
    }
}

#[test]
fn the_public_check_names_the_law_that_is_broken() {
    let room = test_world();
    let trial: Vec<usize> = (104..144).collect();
    for (broken, law) in [
        (Broken::LooksAtTheTruth, "true poses"),
        (Broken::LooksAhead, "later snapshots"),
        (Broken::Lazy, "39 answers to a trial of 40"),
        (Broken::TooProbable, "with sum 2"),
        (Broken::TurnedByNaN, "a heading that is not finite"),
    ] {
        let error = check(&broken, &room, &first_lap(), &trial)
            .unwrap_err()
            .to_string();
        assert!(
            error.starts_with("broken breaks a law") && error.contains(law),
            "{law}: {error}"
        );
    }
}
