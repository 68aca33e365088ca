//! Robots that learn on in different ways, and one that doesn't.

use super::{
    LifelongConfig,
    judge::{Judged, judged},
    rivals::Scans,
};
use crate::{
    error::Result,
    experiment::adaptation::{AdaptConfig, LabelRecord, adapt, judged as judged_labels, labelled},
    localiser::{
        LiveLocaliser, SelfLabel,
        self_labels::{GateOver, LabelsFrom, of_model},
    },
    model::{Memory, Model, update},
    recording::Recording,
    seed::Seed,
};
use serde::{Deserialize, Serialize};

/// How a robot learns from a day.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum RobotKind {
    /// The model of the first day.
    Frozen,
    /// Its own labels that pass the gate; map and filters.
    Adapted,
    /// The same, the gate asking each label's own moment.
    AdaptedByMoment,
    /// As `adapted`, the map alone.
    MapOnly,
    /// All of its own labels, as the whole run tells them.
    Ungated,
    /// All labels, as its filter has them at the moment, from a start anywhere.
    UngatedFiltered,
    /// True labels: a bound that no robot reaches by itself.
    TrueLabels,
    /// True labels, the map alone.
    TrueLabelsMapOnly,
    /// Raw snapshots of the first day, held against by their distance: nothing is learned.
    RawFrozen,
    /// The same, its own labels that pass the gate extend them and what is old is forgotten.
    RawAdapted,
}

/// All of them, the one that the others are held against first.
pub const ROBOTS: [RobotKind; 10] = [
    RobotKind::Frozen,
    RobotKind::Adapted,
    RobotKind::AdaptedByMoment,
    RobotKind::MapOnly,
    RobotKind::Ungated,
    RobotKind::UngatedFiltered,
    RobotKind::TrueLabels,
    RobotKind::TrueLabelsMapOnly,
    RobotKind::RawFrozen,
    RobotKind::RawAdapted,
];

impl RobotKind {
    /// What tables call it.
    pub fn title(self) -> &'static str {
        match self {
            Self::Frozen => "first day's model",
            Self::Adapted => "adapted",
            Self::AdaptedByMoment => "adapted, gate by moment",
            Self::MapOnly => "adapted, map alone",
            Self::Ungated => "no gate",
            Self::UngatedFiltered => "no gate, filter's labels",
            Self::TrueLabels => "true labels",
            Self::TrueLabelsMapOnly => "true labels, map alone",
            Self::RawFrozen => "first day's raw snapshots",
            Self::RawAdapted => "raw snapshots, adapted",
        }
    }

    /// The configuration as this robot has it.
    fn own(self, config: &AdaptConfig) -> AdaptConfig {
        let mut own = config.clone();
        if matches!(self, Self::MapOnly | Self::TrueLabelsMapOnly) {
            own.update.steps = 0;
        }
        if matches!(self, Self::Ungated | Self::UngatedFiltered) {
            own.labels.gate = 1.0;
        }
        if self == Self::AdaptedByMoment {
            own.labels.gate_over = GateOver::Moment;
        }
        if self == Self::UngatedFiltered {
            own.labels.from = LabelsFrom::Filtered;
        }
        own
    }
}

/// A robot between two days.
pub(super) struct Robot {
    kind: RobotKind,
    model: Model,
    memory: Memory,
    /// What raw snapshots are held against by; of the rivals.
    scans: Option<Scans>,
}

impl Robot {
    pub(super) fn new(
        kind: RobotKind,
        model: &Model,
        memory: &Memory,
        config: &LifelongConfig,
    ) -> Result<Self> {
        let is_raw = matches!(kind, RobotKind::RawFrozen | RobotKind::RawAdapted);
        Ok(Self {
            kind,
            model: model.clone(),
            memory: memory.clone(),
            scans: is_raw
                .then(|| Scans::of(model, memory, config))
                .transpose()?,
        })
    }

    /// How it does on a day that it has not seen yet.
    pub(super) fn judged(
        &self,
        day: &Recording,
        config: &LifelongConfig,
        seed: Seed,
    ) -> Result<Judged> {
        let mut robot = match &self.scans {
            Some(scans) => scans.robot(&self.model, &self.memory)?,
            None => LiveLocaliser::new(&self.model)?,
        };
        judged(&mut robot, day, config, seed)
    }

    /// Learns from a day; how it labelled it.
    pub(super) fn learn(
        &mut self,
        day: &Recording,
        config: &AdaptConfig,
    ) -> Result<Option<LabelRecord>> {
        let own = self.kind.own(config);
        match self.kind {
            RobotKind::Frozen | RobotKind::RawFrozen => Ok(None),
            RobotKind::TrueLabels | RobotKind::TrueLabelsMapOnly => {
                let truth = (0..day.len()).map(|k| SelfLabel {
                    pose: day.poses()[k],
                    route_m: day.route_m().map(|route| route[k]),
                    score: 0.0,
                    kept: true,
                    beyond: false,
                });
                self.take_in(day, &truth.collect::<Vec<_>>(), &own)
            }
            RobotKind::RawAdapted => {
                let labels = match &self.scans {
                    Some(scans) => scans.labels(&self.model, &self.memory, day, &own.labels)?,
                    None => of_model(&self.model, day, &own.labels, None)?,
                };
                // What is kept of snapshots is kept by the same law; the networks ride along unused.
                let mut map_only = own;
                map_only.update.steps = 0;
                self.take_in(day, &labels, &map_only)
            }
            _ => {
                let memory = Some(&self.memory);
                let adapted = adapt(&self.model, memory, day, &own, None, &mut |_| {})?;
                self.model = adapted.model;
                self.memory = adapted.memory.unwrap_or_else(|| self.memory.clone());
                Ok(Some(adapted.labels))
            }
        }
    }

    fn take_in(
        &mut self,
        day: &Recording,
        labels: &[SelfLabel],
        config: &AdaptConfig,
    ) -> Result<Option<LabelRecord>> {
        let record = judged_labels(labels, day, &self.model.places());
        if let Some(labelled) = labelled(&*self.model.seen_in(day)?, labels)? {
            let memory = Some(&self.memory);
            let updated = update(&self.model, memory, &labelled, &config.update, &mut |_| {})?;
            self.model = updated.model;
            self.memory = updated.memory.unwrap_or_else(|| self.memory.clone());
        }
        Ok(Some(record))
    }
}
