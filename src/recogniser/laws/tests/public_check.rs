//! The check that users call for recognisers of their own: it passes ours, and names what others break.

use super::*;

#[test]
fn the_public_check_passes_built_in_recognisers() {
    let room = test_world();
    for kind in [Kind::Nearest, Kind::Rce, Kind::GrowingCells] {
        check(&kind.default_config(), &room, &first_lap()).unwrap();
    }
}

/// Recognisers that break one law each.
#[derive(Debug, Clone, Serialize, Deserialize)]
enum Broken {
    /// Answers by what odometry says.
    LooksAtOdometry,
    /// A class that it says it doesn't have.
    ClassOutOfBounds,
    /// No finite fit on readings without return.
    FitNotFinite,
    /// Takes any sensors.
    TakesAnySensor,
    /// Answers many together otherwise than one by one.
    TogetherOtherwise,
}

impl Constants for Broken {
    fn kind(&self) -> &str {
        "broken"
    }
}

impl RecogniserConfig for Broken {
    fn learn(&self, _: &Recording, snapshots: &[usize], _: Seed) -> Result<Box<dyn Recogniser>> {
        if snapshots.is_empty() {
            return Err(crate::Error::work("nothing to learn from"));
        }
        Ok(Box::new(self.clone()))
    }
}

impl Recogniser for Broken {
    fn name(&self) -> &str {
        "broken"
    }

    fn responses(&self) -> usize {
        1000
    }

    fn matches(&self) -> usize {
        1
    }

    fn bytes_per_place(&self) -> usize {
        1
    }

    fn check_channels(&self, channels: &[Channel]) -> Result<()> {
        let known = channels.iter().any(|channel| channel.name == "sonar");
        match known || matches!(self, Broken::TakesAnySensor) {
            true => Ok(()),
            false => Err(crate::Error::work("no channel `sonar`")),
        }
    }

    fn respond(&self, channels: &[Channel], observation: &Observation) -> Option<Response> {
        self.check_channels(channels).ok()?;
        let value = *observation.values.first()?;
        let (class, fit) = match self {
            Broken::LooksAtOdometry => {
                ((observation.odometry.x_m.abs() * 10.0) as usize % 1000, 1.0)
            }
            Broken::ClassOutOfBounds => (1000, 1.0),
            Broken::FitNotFinite => (0, f64::from(value)),
            Broken::TakesAnySensor | Broken::TogetherOtherwise => (0, 1.0),
        };
        Some(Response { class, fit })
    }

    fn respond_all(&self, recording: &Recording, snapshots: &[usize]) -> Vec<Option<Response>> {
        let alone = |&k: &usize| self.respond(recording.channels(), &recording.observation(k));
        match self {
            Broken::TogetherOtherwise => vec![None; snapshots.len()],
            _ => snapshots.iter().map(alone).collect(),
        }
    }
}

#[test]
fn the_public_check_names_the_law_that_is_broken() {
    let room = test_world();
    for (broken, law) in [
        (Broken::LooksAtOdometry, "truth or odometry"),
        (Broken::ClassOutOfBounds, "expected a class below 1000"),
        (Broken::FitNotFinite, "finite fit"),
        (Broken::TakesAnySensor, "passes other sensors"),
        (Broken::TogetherOtherwise, "among others"),
    ] {
        let error = check(&broken, &room, &first_lap()).unwrap_err().to_string();
        assert!(error.starts_with("broken breaks a law"), "{error}");
        assert!(error.contains(law), "{law}: {error}");
    }
}
