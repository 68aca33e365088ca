//! The sequences that trials run over, on unseen runs and on the validation part, and the evidence that is tuned on the latter.

use super::{
    evidence_tuning::Sequences,
    method::{AnswersBy, Method},
    methods::MethodContext,
    once::kept,
    trials::{self, Trial, TrialSampling},
};
use crate::{
    belief::{Neighbours, OdometryMotion, Places},
    error::Result,
    localiser::{PreparedSensorModel, sensor_model::EvidenceScale},
    recording::Recording,
};
use std::ops::Range;

/// The trials that everybody plays.
pub(super) fn drawn(context: &MethodContext) -> Result<Vec<Trial>> {
    let (parts, config) = (context.parts, context.config);
    let sampling = TrialSampling {
        count: config.trials,
        spacing_m: config.spacing_m,
        shortest_m: config.shortest_m,
        longest_m: config.longest_m,
    };
    let stretches = context.unseen_stretches()?;
    trials::draw(parts.run, stretches, &sampling, context.seed())
}

impl MethodContext<'_> {
    /// Stretches of the unseen part that lead through places that training saw.
    fn unseen_stretches(&self) -> Result<&[Range<usize>]> {
        kept(&self.once.unseen_stretches, || {
            let parts = self.parts;
            mapped_stretches(self, parts.run, &parts.places, &parts.unseen)
        })
    }

    /// The same of the validation part.
    fn validation_stretches(&self) -> Result<&[Range<usize>]> {
        kept(&self.once.validation_stretches, || {
            let source = self.source()?;
            let places = Places::of(&source.recording);
            mapped_stretches(self, &source.recording, &places, &source.validation)
        })
    }
}

/// Stretches of a part that lead through places that training saw.
fn mapped_stretches(
    context: &MethodContext,
    recording: &Recording,
    places: &Places,
    part: &[usize],
) -> Result<Vec<Range<usize>>> {
    let mapped = &context.mapped;
    let near = Neighbours::find(&mapped.places, &places.select(part), &mapped.map.nearness)?;
    let is_mapped = |k: usize| part.binary_search(&k).is_ok_and(|row| near.is_mapped(row));
    let longest_gap_m = context.config.longest_gap_m;
    Ok(trials::stretches(recording, part, is_mapped, longest_gap_m))
}

/// Sequences of the validation part, for tuning evidence: as many as settle it.
pub(super) const VALIDATION_SEQUENCES: usize = 8;

/// Their length, in metres.
const VALIDATION_LENGTH_M: f64 = 10.0;

/// So many sequences of the validation part, as long as trials or, where it has none so long, of a metre or more; none where what
/// the models learned from is not at hand or has no such stretch.
pub(super) fn validation_sequences(context: &MethodContext, count: usize) -> Result<Vec<Trial>> {
    let Some(source) = &context.parts.source else {
        return Ok(Vec::new());
    };
    let (recording, config) = (&*source.recording, context.config);
    let stretches = context.validation_stretches()?;
    for shortest_m in [config.shortest_m, 1.0] {
        let sampling = TrialSampling {
            count,
            spacing_m: config.spacing_m,
            shortest_m,
            longest_m: VALIDATION_LENGTH_M.max(shortest_m),
        };
        if let Ok(drawn) = trials::draw(recording, stretches, &sampling, context.seed()) {
            return Ok(drawn);
        }
    }
    Ok(Vec::new())
}

/// Has what the models learned from a sequence of the validation part?
pub(super) fn has_validation_sequences(context: &MethodContext) -> Result<bool> {
    Ok(!validation_sequences(context, VALIDATION_SEQUENCES)?.is_empty())
}

/// How much a method's evidence counts: as tuned on sequences of the validation part; where there are none, as usual for it.
pub(super) fn evidence_scale(
    method: &Method,
    context: &MethodContext,
) -> Result<Option<EvidenceScale>> {
    let own_model: Box<dyn PreparedSensorModel>;
    if let Some(tuned) = method.evidence_scale {
        return Ok(Some(EvidenceScale::of(tuned)));
    }
    let usual = match &method.answers {
        AnswersBy::Odometry | AnswersBy::Recorded(_) | AnswersBy::Nobody(_) => return Ok(None),
        AnswersBy::Localiser(localiser) => match localiser.evidence_scale() {
            None => return Ok(None),
            usual => usual.map(EvidenceScale::of),
        },
        AnswersBy::Sensor(_) | AnswersBy::PreparedSensor(_) => {
            Some(EvidenceScale::of(method.usual_scale))
        }
    };
    let sequences = validation_sequences(context, VALIDATION_SEQUENCES)?;
    let source = match &context.parts.source {
        Some(source) if !sequences.is_empty() => source,
        _ => return Ok(usual),
    };
    let places = Places::of(&source.recording);
    let sequences = Sequences {
        recording: &source.recording,
        places: &places,
        trials: &sequences,
        grid: &context.grid,
        motion: motion(method, context),
    };
    let sensor = match (&method.answers, &method.validation) {
        (AnswersBy::Localiser(localiser), _) => {
            let tuned = sequences.tuned_localiser(localiser.as_ref(), context.seed())?;
            return Ok(tuned.map(EvidenceScale::of).or(usual));
        }
        (AnswersBy::Sensor(model), _) => {
            own_model = model.prepare(&source.recording, &source.validation)?;
            own_model.as_ref()
        }
        (_, Some(prepared)) => prepared.as_ref(),
        _ => return Ok(usual),
    };
    let scale = sequences.tuned(sensor, context.seed())?;
    Ok(Some(EvidenceScale::of(scale)))
}

/// What the filter believes of odometry: the configuration's word first, then the method's, then what the mapping part shows.
pub(super) fn motion<'a>(method: &'a Method, context: &'a MethodContext) -> &'a OdometryMotion {
    let own = method.motion.as_ref();
    let usual = own.unwrap_or(&context.mapped.motion);
    context.config.motion.as_ref().unwrap_or(usual)
}
