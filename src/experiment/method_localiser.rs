//! A method of localisation trials as a whole localiser, for experiments that play runs to localisers.

use super::{
    method::{AnswersBy, Method},
    methods::MethodContext,
    sequences::{evidence_scale, motion},
};
use crate::{
    belief::{Belief, Places},
    error::{Error, Result},
    geometry::Pose,
    localiser::{
        BayesLocaliser, Localiser, PreparedSensorModel, Sites, Step, TrialRunner,
        sensor_model::{EvidenceScale, Scaled},
    },
    recording::{Channel, Recording},
    seed::{Seed, Stream},
};
use rand::RngExt;
use std::sync::Arc;

/// The grid Bayes filter with a method's sensor model, its evidence tuned; it starts anywhere.
pub(super) struct FilterLocaliser<'a> {
    context: MethodContext<'a>,
    method: Method<'a>,
    scale: EvidenceScale,
    sites: Sites,
}

impl<'a> FilterLocaliser<'a> {
    /// # Errors
    /// Where the method is no sensor model, or fails on the validation part.
    pub fn new(context: &MethodContext<'a>, method: Method<'a>) -> Result<Self> {
        let scale = evidence_scale(&method, context)?
            .ok_or_else(|| Error::work(format!("{}: no sensor model", method.name)))?;
        let source = context.source()?;
        let poses = source.recording.poses();
        let pose: Vec<Pose> = source.training.iter().map(|&k| poses[k]).collect();
        let route_m = match &context.mapped.places {
            Places::Route(route_m) => Some(&route_m[..]),
            Places::Plane(_) => None,
        };
        Ok(Self {
            sites: Sites::of(&context.grid, &pose, route_m),
            context: context.clone(),
            method,
            scale,
        })
    }
}

impl Localiser for FilterLocaliser<'_> {
    fn name(&self) -> &str {
        &self.method.name
    }

    fn places(&self) -> usize {
        self.context.mapped.places.len()
    }

    fn bytes_per_place(&self) -> usize {
        size_of::<Pose>() + self.method.bytes_per_place.unwrap_or(0)
    }

    /// The recording's own sensors: the method was made for the run that it is played.
    fn check_channels(&self, _: &[Channel]) -> Result<()> {
        Ok(())
    }

    /// Only the run of the context can be prepared.
    fn prepare<'a>(
        &'a self,
        recording: &'a Recording,
        snapshots: &[usize],
    ) -> Result<Box<dyn TrialRunner + 'a>> {
        if !std::ptr::eq(recording, self.context.parts.run) {
            return Err(Error::work(format!(
                "{}: made for another recording",
                self.method.name
            )));
        }
        let sensor: Arc<dyn PreparedSensorModel + 'a> = match &self.method.answers {
            AnswersBy::PreparedSensor(sensor) => sensor.clone(),
            AnswersBy::Sensor(model) => model.prepare(recording, snapshots)?.into(),
            _ => {
                return Err(Error::work(format!(
                    "{}: no sensor model",
                    self.method.name
                )));
            }
        };
        Ok(Box::new(Runner {
            localiser: self,
            recording,
            sensor,
        }))
    }
}

/// The filter with the run before it.
struct Runner<'a, 'b> {
    localiser: &'a FilterLocaliser<'b>,
    recording: &'a Recording,
    sensor: Arc<dyn PreparedSensorModel + 'a>,
}

impl TrialRunner for Runner<'_, '_> {
    fn play(&self, trial: &[usize], _: Option<Pose>, stream: &mut Stream) -> Result<Vec<Step>> {
        let features = Seed(stream.random()).stream("sampled features");
        let FilterLocaliser {
            context,
            method,
            scale,
            sites,
        } = self.localiser;
        let scaled = Scaled::new(self.sensor.as_ref(), *scale);
        let no_idea = Belief::uniform(context.grid.places())?;
        let motion = motion(method, context);
        let mut robot =
            BayesLocaliser::new(&context.grid, motion, no_idea, Some(&scaled), features)?;
        robot.play(self.recording, trial, sites)
    }
}
