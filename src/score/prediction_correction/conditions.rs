//! What a reader must know of an experiment to repeat it: the two reports that Ruiz-Mayor et al. (2006, R06) ask for beside the metric.
//! Poses don't tell it, so whoever made the experiment states it; what nobody stated is missing, and said to be.

use serde::{Deserialize, Serialize};

/// An aspect of a report in words, and what is stated of it.
pub type Aspect<'a> = (&'static str, Option<&'a str>);

/// Blank words state nothing.
fn stated<'a, const N: usize>(all: [(&'static str, &'a Option<String>); N]) -> Vec<Aspect<'a>> {
    let said = |text: &&str| !text.trim().is_empty();
    all.map(|(words, text)| (words, text.as_deref().filter(said)))
        .to_vec()
}

/// The experiments framework report (R06 3.1): what holds for all runs.
///
/// ```
/// use ballmark::score::prediction_correction::FrameworkReport;
/// let report = FrameworkReport { robot: Some("Sancho-2, tricycle".into()), ..FrameworkReport::default() };
/// let missing = report.aspects().iter().filter(|(_, stated)| stated.is_none()).count();
/// assert_eq!(missing, report.aspects().len() - 1);
/// ```
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FrameworkReport {
    /// What the localiser is developed for.
    pub objective: Option<String>,
    /// Type of robot, its sensors and odometry.
    pub robot: Option<String>,
    /// Type of environment that it shall navigate in: indoor, outdoor, office, home, factory.
    pub environment: Option<String>,
    /// How these condition the choice of runs.
    pub run_selection: Option<String>,
    /// A_P: how the estimate before correction is made.
    pub prediction: Option<String>,
    /// E: how it is corrected.
    pub correction: Option<String>,
    /// H: what the localiser expects to perceive at a pose.
    pub expected_perception: Option<String>,
    /// The uncertainty models of both.
    pub uncertainty: Option<String>,
    /// How often is corrected: a prediction, a second, a metre. What poses tell of it stands with each run.
    pub correction_frequency: Option<String>,
    /// How, how often and how precisely the real poses were measured.
    pub real_poses: Option<String>,
    /// Of simulated runs the models of the simulator.
    pub simulator: Option<String>,
}

impl FrameworkReport {
    /// Every aspect in words, and what is stated of it.
    pub fn aspects(&self) -> Vec<Aspect<'_>> {
        stated([
            ("objective", &self.objective),
            ("robot", &self.robot),
            ("environment", &self.environment),
            ("choice of runs", &self.run_selection),
            ("prediction (A_P)", &self.prediction),
            ("correction (E)", &self.correction),
            ("expected perception (H)", &self.expected_perception),
            ("uncertainty models", &self.uncertainty),
            ("frequency of corrections", &self.correction_frequency),
            ("measurement of real poses", &self.real_poses),
            ("models of the simulator", &self.simulator),
        ])
    }
}

/// The run conditions report (R06 3.2): what may change from run to run.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RunConditions {
    /// The place: topology of walls and obstacles.
    pub place: Option<String>,
    /// Properties of their materials.
    pub materials: Option<String>,
    /// Ambient conditions, such as temperature or light.
    pub ambient: Option<String>,
    /// Whatever else affects what the sensors capture.
    pub other_factors: Option<String>,
    /// By which criteria the trajectory was made.
    pub trajectory: Option<String>,
    /// Why the run stands for real ones, and why its statistics are valid.
    pub representative: Option<String>,
    /// What changed during the run, in numbers: people seen, doors moved.
    pub changes: Option<String>,
}

impl RunConditions {
    /// Every aspect in words, and what is stated of it.
    pub fn aspects(&self) -> Vec<Aspect<'_>> {
        stated([
            ("place, walls, obstacles", &self.place),
            ("materials", &self.materials),
            ("ambient conditions", &self.ambient),
            ("other factors", &self.other_factors),
            ("criteria of the trajectory", &self.trajectory),
            ("why it is representative", &self.representative),
            ("changes during the run", &self.changes),
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blank_words_state_nothing() {
        let conditions = RunConditions {
            place: Some("a corridor".into()),
            materials: Some("  ".into()),
            ..RunConditions::default()
        };
        let stated: Vec<&str> = (conditions.aspects().into_iter())
            .filter_map(|(_, text)| text)
            .collect();
        assert_eq!(stated, ["a corridor"]);
        assert_eq!(conditions.aspects().len(), 7);
        assert_eq!(FrameworkReport::default().aspects().len(), 11);
    }
}
