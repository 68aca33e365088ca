//! The grid Bayes filter with sensor models as a configuration names it: `kind = "bayes"`.

use super::{
    method::Method, methods::MethodContext, product::product, sensor_models::SensorModelConfig,
};
use crate::{
    error::{Error, Result},
    registry::Constants,
};
use serde::Serialize;
use std::path::PathBuf;

/// A filter with one or several sensor models, and what the trained one among them is.
#[derive(Debug, Clone)]
pub struct FilterConfig {
    /// What it tells places apart by; several at once multiply, without any it goes by odometry alone.
    pub landmarks: Vec<Box<dyn SensorModelConfig>>,
    /// File of the model of those landmarks that need one and name none.
    pub model: PathBuf,
}

impl FilterConfig {
    /// Whatever the sensor model of one's own is: a filter with it.
    pub fn of(landmarks: impl SensorModelConfig + 'static) -> Self {
        Self {
            landmarks: vec![Box::new(landmarks)],
            model: PathBuf::new(),
        }
    }

    /// Does any of the landmarks need the system's model?
    fn needs_model(&self) -> bool {
        let mut landmarks = self.landmarks.clone();
        let mut models = landmarks.iter_mut().filter_map(|l| l.model());
        models.any(|model| model.as_os_str().is_empty())
    }

    /// The filter as a method of these trials, to be called so.
    ///
    /// # Errors
    /// Where a sensor model can't be made.
    pub fn method<'a>(&self, context: &MethodContext<'a>, name: &str) -> Result<Method<'a>> {
        let mut factors = Vec::new();
        for landmarks in &self.landmarks {
            let mut landmarks = landmarks.clone();
            if let Some(model) = landmarks.model()
                && model.as_os_str().is_empty()
            {
                model.clone_from(&self.model);
            }
            factors.push(landmarks.method(context)?);
        }
        let one = match factors.len() {
            0 => Some(context.odometry(name, name)),
            1 => factors.pop(),
            _ => product(context, name, name, &factors.iter().collect::<Vec<_>>())?,
        };
        let one = one.ok_or_else(|| Error::work("landmarks without a sensor model"))?;
        Ok(Method {
            name: name.into(),
            title: name.into(),
            ..one
        })
    }
}

impl Serialize for FilterConfig {
    fn serialize<S: serde::Serializer>(
        &self,
        serializer: S,
    ) -> std::result::Result<S::Ok, S::Error> {
        use serde::ser::{Error as _, SerializeStruct};
        let landmarks = self.landmarks.iter().map(|l| l.to_json());
        let landmarks = landmarks
            .collect::<Result<Vec<_>>>()
            .map_err(S::Error::custom)?;
        let mut fields = serializer.serialize_struct("FilterConfig", 2)?;
        fields.serialize_field("landmarks", &landmarks)?;
        if !self.model.as_os_str().is_empty() {
            fields.serialize_field("model", &self.model)?;
        }
        fields.end()
    }
}

impl Constants for FilterConfig {
    fn kind(&self) -> &str {
        "bayes"
    }

    fn description(&self) -> &str {
        "The grid Bayes filter, driven by one or several sensor models."
    }

    fn check(&self) -> Result<()> {
        self.landmarks.iter().try_for_each(|l| l.check())
    }

    fn model(&mut self) -> Option<&mut PathBuf> {
        self.needs_model().then_some(&mut self.model)
    }

    fn files(&mut self) -> Vec<&mut PathBuf> {
        let own = self.landmarks.iter_mut().flat_map(|l| l.files());
        own.chain([&mut self.model]).collect()
    }
}
