//! Pre-trained networks as a model: one of a simulated building that they were judged in.

use super::{
    header::{Header, OccupancyHeader, Scores},
    trained_model::Model,
};
use crate::{
    belief::OdometryMotion,
    detector::{device, net::NetDetector},
    error::{Error, Result},
    learning::{Recipe, pretraining::Pretrained, start::Start, training_set::TrainingSet},
    recording::split::Split,
};

impl Model {
    /// Pre-trained networks with the map of a simulated building, in which they can be tried; what they are for is to
    /// [begin](crate::model::Training::from_pretrained) other trainings.
    ///
    /// # Errors
    /// Where the building gives no map.
    pub fn of_pretrained(recipe: &Recipe, pretrained: Pretrained) -> Result<Self> {
        let recording = &pretrained.building.first;
        let everything: Vec<usize> = (0..recording.len()).collect();
        let split = Split {
            train: everything.clone(),
            ..Split::default()
        };
        let start = Start {
            input: pretrained.input,
            weights: pretrained.weights,
            channels: recording.channels().to_vec(),
            same_sensors: false,
        };
        let set = TrainingSet::in_map(recipe, recording, &split, None, Some(&start))?;
        let Some(every_pose) = &set.every_pose else {
            return Err(Error::work(
                "pre-training: the building's scans draw no map",
            ));
        };
        let detector = NetDetector::new(start.input.clone(), &start.weights, &device::cpu());
        let g = detector.respond(set.inputs.view())?;
        let candidates = detector.respond(every_pose.at_training.view())?;
        Ok(Self {
            header: Header {
                crate_version: env!("CARGO_PKG_VERSION").to_string(),
                recipe: recipe.clone(),
                prior: recipe.uncertainty,
                channels: recording.channels().to_vec(),
                dataset_sha256: None,
                input: start.input,
                activation: start.weights.activation,
                motion: OdometryMotion::fitted(recording, &everything),
                evidence_scale: None,
                lost: None,
                occupancy: Some(OccupancyHeader {
                    cell_m: every_pose.sensed.map.cell_m(),
                    origin_m: every_pose.sensed.map.origin_m(),
                    sensors: every_pose.sensed.sensors.clone(),
                }),
                scores: Scores {
                    train: set.judge(g.view(), candidates.view())?,
                    validation: None,
                },
                training: None,
                updates: Vec::new(),
            },
            weights: start.weights,
            pose: recording.poses().to_vec(),
            route_m: None,
            activation: g,
            occupancy: Some(every_pose.sensed.map.clone()),
        })
    }

    /// What a training begins with that goes on from this model.
    pub fn as_start(&self) -> Start {
        Start {
            input: self.header.input.clone(),
            weights: self.weights.clone(),
            channels: self.header.channels.clone(),
            same_sensors: false,
        }
    }
}
