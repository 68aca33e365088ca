//! What a robot must know of a model besides its networks: how much its answers count, and when they say that it is lost.

use super::{
    learned_row::{Rounded, learned_features},
    localise_config::LocaliseConfig,
    lost_tuning::tuned_lost,
    methods::MethodContext,
    parts::Parts,
    sequences::{evidence_scale, has_validation_sequences},
};
use crate::{error::Result, localiser::LostConfig, model::Model, recording::Recording};

/// Both, as tuned on whole sequences of the validation part, to be stored with the model
/// ([`Header`](crate::model::Header)).
#[derive(Debug, Clone, PartialEq)]
pub struct RobotConstants {
    /// Power of a snapshot's evidence in the Bayes filter.
    pub evidence_scale: f64,
    /// When a robot with these features counts as lost.
    pub lost: LostConfig,
}

/// Gives a model the constants that [`tuned`] finds; none where it finds none.
///
/// # Errors
/// As [`tuned`]; the model is as it was then.
pub fn tune(model: &mut Model, recording: &Recording) -> Result<()> {
    let tuned = tuned(model, recording)?;
    model.header.evidence_scale = tuned.as_ref().map(|tuned| tuned.evidence_scale);
    model.header.lost = tuned.map(|tuned| tuned.lost);
    Ok(())
}

/// The constants of a model's features, as trials would tune them; none where the recording that it learned from has no sequence of
/// the validation part.
///
/// # Errors
/// Where the recording is another one, or the model's places are too many or too far apart for a grid.
pub fn tuned(model: &Model, recording: &Recording) -> Result<Option<RobotConstants>> {
    if model.header.scores.validation.is_none() {
        return Ok(None);
    }
    let recording = model.seen_in(recording)?;
    let parts = Parts::new(model, &recording, None)?;
    let (models, config) = ([model], LocaliseConfig::default());
    let mut context = MethodContext::new(&models, &parts, &config)?;
    // What single snapshots say is not asked for here, and would take the longest by far.
    context.priors.clear();
    if !has_validation_sequences(&context)? {
        return Ok(None);
    }
    let method = learned_features(&context, model, Rounded::No, "learned", "learned")?;
    let Some(scale) = evidence_scale(&method, &context)? else {
        return Ok(None);
    };
    Ok(Some(RobotConstants {
        evidence_scale: scale.scale,
        lost: tuned_lost(&method, &context, Some(scale))?.unwrap_or_default(),
    }))
}
