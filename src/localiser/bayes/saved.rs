//! The Bayes filter as a file holds it, checked before its grid and its map are built again.

use super::{Bayes, Known, check_compass_sd, check_evidence, frame};
use crate::{
    belief::{Evidence, Grid, GridConfig, OdometryMotion},
    detector::Detector,
    error::{Error, Result},
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
        if let Some(zero_rad) = saved.compass_zero_rad.filter(|zero| !zero.is_finite()) {
            return Err(Error::work(format!(
                "bayes: the compass's zero is at {zero_rad}; expected radians"
            )));
        }
        check_compass_sd(saved.compass_sd_rad)?;
        let map = known.feature_map()?;
        check_evidence(saved.evidence, known.filters.features())?;
        let grid = Grid::over(map.places(), &saved.grid)?;
        Ok(Self {
            sites: frame::sites(&grid, &known),
            evidence: saved.evidence,
            grid_config: saved.grid,
            motion: saved.motion.checked()?,
            compass_sd_rad: saved.compass_sd_rad,
            compass_zero_rad: saved.compass_zero_rad,
            map,
            grid: Arc::new(grid),
            known,
        })
    }
}
