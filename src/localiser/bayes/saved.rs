//! The Bayes filter as a file holds it, checked before its grid and its map are built again.

use super::{Bayes, Known, check_evidence};
use crate::{
    belief::{Evidence, Grid, GridConfig, OdometryMotion},
    detector::Detector,
    error::{Error, Result},
    localiser::{
        sensor_model::{Compass, Independent, LearnedFeatures, SensorModel},
        sites::Sites,
    },
};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// What a file holds of it.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Saved {
    pub(super) known: Known,
    pub(super) evidence: Evidence,
    pub(super) grid: GridConfig,
    pub(super) motion: OdometryMotion,
    pub(super) compass_sd_rad: f64,
    pub(super) compass_zero_rad: Option<f64>,
}

impl From<Bayes> for Saved {
    fn from(bayes: Bayes) -> Self {
        Self {
            known: bayes.known,
            evidence: bayes.evidence,
            grid: bayes.grid_config,
            motion: bayes.motion,
            compass_sd_rad: bayes.compass_sd_rad,
            compass_zero_rad: bayes.compass_zero_rad,
        }
    }
}

impl TryFrom<Saved> for Bayes {
    type Error = Error;

    fn try_from(saved: Saved) -> Result<Self> {
        let known = saved.known;
        if let Some(bad) = known.pose.iter().position(|pose| !pose.is_finite()) {
            return Err(Error::work(format!(
                "bayes: the pose of place {bad} is not finite; expected metres and radians"
            )));
        }
        let compass = Compass::new(saved.compass_zero_rad.unwrap_or(0.0), saved.compass_sd_rad)
            .map_err(|e| e.context("bayes"))?;
        let map = known.feature_map()?;
        check_evidence(saved.evidence, known.filters.features())?;
        let grid = Grid::over(map.places(), &saved.grid)?;
        let features = LearnedFeatures::new(
            Arc::new(known.filters.clone()),
            Arc::new(map.at(grid.places())?),
            saved.evidence,
        )?;
        let mut sensors: Vec<Box<dyn SensorModel>> = vec![Box::new(features)];
        if saved.compass_zero_rad.is_some() {
            sensors.push(Box::new(compass));
        }
        Ok(Self {
            sites: Sites::of(&grid, &known.pose, known.route_m.as_deref()),
            evidence: saved.evidence,
            grid_config: saved.grid,
            motion: saved.motion.checked()?,
            compass_sd_rad: saved.compass_sd_rad,
            compass_zero_rad: saved.compass_zero_rad,
            sensor: Arc::new(Independent::new(sensors)),
            grid: Arc::new(grid),
            known,
        })
    }
}
