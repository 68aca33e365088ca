//! What a trained model's answers say at the cells of a grid.

use super::{EveryPose, EvidenceScale, LearnedFeatures, SensorModel};
use crate::{
    belief::{Evidence, Grid},
    detector::{MOST_VIEWS, Viewed},
    error::{Error, Result},
    model::Model,
    seed::Seed,
};
use std::sync::Arc;

/// The sensor model of a trained model: of its map at every pose, where it has one and evidence is mean-field, else of its visits.
/// `query_views` as [`LiveConfig`](crate::localiser::LiveConfig) has it.
///
/// # Errors
/// Where there are too many views (the call is wrong), or the model has fewer places than neighbours that its map asks for.
pub(in crate::localiser) fn sensor_of(
    model: &Model,
    grid: &Grid,
    evidence: Evidence,
    query_views: usize,
    seed: Seed,
) -> Result<Box<dyn SensorModel>> {
    if query_views > MOST_VIEWS {
        return Err(Error::usage(format!(
            "query_views = {query_views}: expected at most {MOST_VIEWS}"
        )));
    }
    let detector = Viewed::new(model.detector(), query_views, seed);
    let detector = Arc::new(detector);
    let at_every_pose = match evidence {
        Evidence::MeanField => model.code_map(grid, false)?,
        _ => None,
    };
    Ok(match at_every_pose {
        Some(map) => Box::new(EveryPose::new(detector, Arc::new(map))?),
        None => {
            let map = Arc::new(model.map()?.at(grid.places())?);
            Box::new(LearnedFeatures::new(detector, map, evidence)?)
        }
    })
}

/// How much a model's evidence counts, where nobody says `given`; none: as much as it says.
///
/// # Errors
/// Where it is not above 0 (the call is wrong).
pub(in crate::localiser) fn scale_of(
    model: &Model,
    given: Option<f64>,
) -> Result<Option<EvidenceScale>> {
    match given.or(model.header.evidence_scale) {
        Some(scale) if !(scale.is_finite() && scale > 0.0) => Err(Error::usage(format!(
            "evidence_scale = {scale}: expected a number above 0"
        ))),
        scale => Ok(scale.map(EvidenceScale::of)),
    }
}
