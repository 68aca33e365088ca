//! BaLL's Bayes filter as a member of the registry: lost at first, it weighs every cell of a grid by what its learned
//! features, its odometry and, where there is one, its compass say.
//!
//! Thrun (1998, below T98), Table 1, as [`crate::belief`] has it: Bel(ξ) ← P(f|ξ) Bel(ξ) for what is sensed (eq. 17), Bel(ξ)
//! ← ∫ P(ξ|ξ̃, a) Bel(ξ̃) dξ̃ for what is driven (eq. 19). Learning reads a trained model: its filters and its map.
//!
//! The estimate is the place of the belief's mode, the posterior what the cells of a place hold together. A belief along
//! a route knows one number of a place; the mapped places nearest along the route, before and behind, say where in the
//! plane that is. A route driven in laps or both ways is none for such a belief; there the places are poses in the plane.

mod frame;
mod saved;
mod trial_runner;

use super::{
    Learn, Localiser, TrialRunner,
    sensor_model::{Compass, Independent},
    sites::Sites,
};
use crate::{
    belief::{
        Evidence, FeatureMap, Grid, GridConfig, MapConfig, OdometryMotion, Places,
        evidence::MAX_ENUMERATED_FEATURES,
    },
    detector::{Detector, filters::Filters},
    error::{Error, Result},
    geometry::Pose,
    model::Model,
    recording::{Channel, Recording},
    seed::Seed,
};
use ndarray::Array2;
use saved::Saved;
use serde::{Deserialize, Serialize};
use std::{path::PathBuf, sync::Arc};

/// Which model, and how it is put to use.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BayesConfig {
    /// File of the trained model. It must not have seen what is answered later; of the mapping part it may have.
    pub model: PathBuf,
    /// How answers become likelihoods.
    pub evidence: Evidence,
    /// Cells of the belief.
    pub grid: GridConfig,
    /// What the filter believes of odometry; nothing said: what the model learned of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion: Option<OdometryMotion>,
    /// Standard deviation that the filter expects of a compass heading, radians; with a large one (100) the compass says
    /// nothing. Assumed: steel and cables turn compasses by some ten degrees indoors.
    pub compass_sd_rad: f64,
}

impl Default for BayesConfig {
    fn default() -> Self {
        Self {
            model: PathBuf::new(),
            evidence: Evidence::MeanField,
            grid: GridConfig::default(),
            motion: None,
            compass_sd_rad: 0.2,
        }
    }
}

impl BayesConfig {
    /// # Errors
    /// Where no model is named, or a constant makes no sense.
    pub fn check(&self) -> Result<()> {
        if self.model.as_os_str().is_empty() {
            return Err(Error::usage(
                "bayes.model: none; expected the file of a trained model",
            ));
        }
        self.check_constants()
    }

    fn check_constants(&self) -> Result<()> {
        self.grid.check()?;
        if let Some(motion) = &self.motion {
            motion.clone().checked()?;
        }
        let compass = Compass::new(0.0, self.compass_sd_rad);
        compass.map(|_| ()).map_err(|e| e.context("bayes"))
    }
}

/// What a trained model knows: its filters, and their map.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Known {
    /// Snapshot → P(f_i = 1 | s).
    pub filters: Filters,
    /// The places of the map in the plane.
    pub pose: Vec<Pose>,
    /// The same along the route, in metres, where there is one.
    pub route_m: Option<Vec<f64>>,
    /// What the filters answered there, `[place][feature]`.
    pub activation: Vec<Vec<f32>>,
    /// How the places between are filled.
    pub map: MapConfig,
    /// How far odometry can be trusted.
    pub motion: OdometryMotion,
}

impl From<Model> for Known {
    fn from(model: Model) -> Self {
        let rows = model.activation.rows().into_iter();
        Self {
            activation: rows.map(|row| row.to_vec()).collect(),
            filters: Filters::new(model.header.input, model.weights),
            pose: model.pose,
            route_m: model.route_m,
            map: model.header.recipe.map,
            motion: model.header.motion,
        }
    }
}

impl Known {
    /// P(f|ξ), along the route where there is one, else in the plane.
    fn feature_map(&self) -> Result<FeatureMap> {
        let places = match &self.route_m {
            Some(route) if route.len() != self.pose.len() => {
                return Err(Error::work(format!(
                    "bayes: {} places along the route; expected {}, as many as in the plane",
                    route.len(),
                    self.pose.len()
                )));
            }
            Some(route) => Places::Route(route.clone()),
            None => Places::Plane(self.pose.clone()),
        };
        let n = self.filters.features();
        if let Some(row) = self.activation.iter().find(|row| row.len() != n) {
            return Err(Error::work(format!(
                "bayes: {} activations of a place; expected {n}, one a filter",
                row.len()
            )));
        }
        let flat = self.activation.iter().flatten();
        let flat = flat.map(|&g| f64::from(g)).collect();
        let activation = Array2::from_shape_vec((self.activation.len(), n), flat)
            .map_err(|e| Error::work(format!("bayes: activations: {e}")))?;
        FeatureMap::new(places, activation, self.map.clone())
    }
}

/// The filter with its model, and the cells that it spreads its belief over.
///
/// ```no_run
/// use ballmark::{localiser::{Learn, Localiser, bayes::{Bayes, BayesConfig}}, recording::npz, seed::Seed};
/// let recording = npz::read("laps.npz".as_ref())?;
/// let (first_lap, rest): (Vec<usize>, Vec<usize>) = (0..recording.len()).partition(|&k| k < 300);
/// let config = BayesConfig { model: "first-lap.safetensors".into(), ..BayesConfig::default() };
/// let bayes = Bayes::learn(&config, &recording, &first_lap, Seed(1))?;
/// let player = bayes.prepare(&recording, &rest)?;
/// let steps = player.play(&rest[..40], None, &mut Seed(1).stream("a trial"))?;
/// println!("{:?}", steps[39].estimate);
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(try_from = "Saved", into = "Saved")]
pub struct Bayes {
    known: Known,
    evidence: Evidence,
    grid_config: GridConfig,
    motion: OdometryMotion,
    compass_sd_rad: f64,
    /// What is added to a compass heading to make it one of the map; none where the mapping part has no compass.
    compass_zero_rad: Option<f64>,
    sensor: Arc<Independent>,
    grid: Arc<Grid>,
    sites: Sites,
}

impl Bayes {
    /// A filter with what a model knows; [`Learn::learn`] takes it from a file. The mapping part shows that the map is one
    /// of this recording, and where the compass's zero is in it.
    ///
    /// # Errors
    /// Where the recording lacks a channel that the filters work from, the map is in another frame or knows snapshots
    /// outside of the mapping part, or a constant makes no sense.
    pub fn new(
        config: &BayesConfig,
        known: Known,
        recording: &Recording,
        snapshots: &[usize],
    ) -> Result<Self> {
        config.check_constants()?;
        known.filters.check_channels(recording.channels())?;
        let known = frame::fitted(known, recording, snapshots)?;
        Self::try_from(Saved {
            evidence: config.evidence,
            grid: config.grid.clone(),
            motion: config.motion.clone().unwrap_or(known.motion.clone()),
            compass_sd_rad: config.compass_sd_rad,
            compass_zero_rad: Compass::zero_rad(recording, snapshots),
            known,
        })
    }

    fn features(&self) -> usize {
        self.known.filters.features()
    }
}

fn check_evidence(evidence: Evidence, features: usize) -> Result<()> {
    if evidence == Evidence::Jeffrey && features > MAX_ENUMERATED_FEATURES {
        return Err(Error::usage(format!(
            "bayes.evidence = jeffrey: the model has {features} features; expected at most \
             {MAX_ENUMERATED_FEATURES}, or another evidence"
        )));
    }
    Ok(())
}

impl Localiser for Bayes {
    fn name(&self) -> &'static str {
        "bayes"
    }

    fn places(&self) -> usize {
        self.known.pose.len()
    }

    fn bytes_per_place(&self) -> usize {
        let route = usize::from(self.known.route_m.is_some()) * size_of::<f64>();
        size_of::<Pose>() + route + self.features() * size_of::<f32>()
    }

    fn check_channels(&self, channels: &[Channel]) -> Result<()> {
        self.known.filters.check_channels(channels)
    }

    fn prepare<'a>(
        &'a self,
        recording: &'a Recording,
        snapshots: &[usize],
    ) -> Result<Box<dyn TrialRunner + 'a>> {
        Ok(Box::new(trial_runner::Filter::new(
            self, recording, snapshots,
        )?))
    }
}

impl Learn for Bayes {
    type Config = BayesConfig;

    fn learn(
        config: &BayesConfig,
        recording: &Recording,
        snapshots: &[usize],
        _: Seed,
    ) -> Result<Self> {
        config.check()?;
        let model = Model::read(&config.model)?;
        Self::new(config, model.into(), recording, snapshots).map_err(|e| e.in_file(&config.model))
    }

    /// Nothing is left to check: a file's content is checked before the filter is built of it.
    fn check(&self) -> Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests;
