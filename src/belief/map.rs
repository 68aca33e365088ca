//! The map: what the detectors answer where.

use super::{
    neighbours::{Nearness, Neighbours},
    places::Places,
};
use crate::error::{Error, Result};
use ndarray::{Array1, Array2, ArrayView1, ArrayView2, ArrayViewMut1, Axis};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::sync::OnceLock;

/// How a map fills the places between its snapshots.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MapConfig {
    /// Which training snapshots speak for a place.
    pub nearness: Nearness,
    /// Probability that a feature is answered by chance, for all that no map knows (people, moved doors): a probability m
    /// becomes (1 − u) m + u/2, so no answer is impossible anywhere.
    pub unmodelled_probability: f64,
    /// The same of scans that are rendered, which show what stood there when the map was drawn, once training is over.
    pub unmodelled_when_rendered: f64,
    /// What the places between are filled from.
    pub filled_from: FilledFrom,
    /// Snapshots of the training part that come into the map at most, evenly over the places
    /// ([`thinned`](super::thinning::thinned)); 0: all of them. All are learned from.
    pub most_places: usize,
}

/// Places of a map at most, where nothing else is said: as many as a building of a kilometre of corridor has at five a metre and
/// in both directions.
const MOST_PLACES: usize = 10_000;

/// What a map is filled from between the snapshots that were taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum FilledFrom {
    /// Rendered scans where all sensors measure ranges in the plane, in known directions; else visits.
    #[default]
    Auto,
    /// The nearest snapshots that were taken (Thrun 1998, 5.1.6).
    Visits,
    /// The scans that an occupancy map of the training part predicts, at every pose.
    Rendered,
}

impl MapConfig {
    /// Is there room in a map for the neighbours of a place?
    ///
    /// # Errors
    /// A usage error that names the key.
    pub fn check_most_places(&self) -> Result<()> {
        match self.most_places == 0 || self.most_places >= self.nearness.k {
            true => Ok(()),
            false => Err(Error::usage(format!(
                "map.most_places = {}: expected 0 (all), or at least map.nearness.k = {}",
                self.most_places, self.nearness.k
            ))),
        }
    }
}

impl Default for MapConfig {
    fn default() -> Self {
        Self {
            nearness: Nearness::default(),
            unmodelled_probability: 0.002,
            unmodelled_when_rendered: 0.05,
            filled_from: FilledFrom::default(),
            most_places: MOST_PLACES,
        }
    }
}

/// P(f_i = 1 | ξ), learned from examples: the activation of every training snapshot, and where it was taken.
///
/// P(f|ξ) is the product of these over the features, not the average of the snapshots' own products: the features are
/// taken to be independent at a place (Thrun 1998, 5.1.6 with eq. 33).
///
/// ```
/// use ballmark::belief::{FeatureMap, MapConfig, Nearness, Places};
/// // Two snapshots of one place, whose two features say (.9, .9) and (.1, .1).
/// let activation = ndarray::array![[0.9, 0.9], [0.1, 0.1]];
/// let nearness = Nearness { k: 2, ..Nearness::default() };
/// let config = MapConfig { nearness, unmodelled_probability: 0.0, ..MapConfig::default() };
/// let map = FeatureMap::new(Places::Route(vec![0.0, 0.1]), activation, config)?;
/// let here = map.at(&Places::Route(vec![0.05]))?;
/// let both = here.probability()[[0, 0]] * here.probability()[[0, 1]];
/// assert!((both - 0.25).abs() < 1e-15); // the average of products would be .41
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct FeatureMap {
    places: Places,
    /// `[snapshot, feature]`
    activation: Array2<f64>,
    config: MapConfig,
}

impl FeatureMap {
    /// A map from the places of K training snapshots and their activations g_i(s_k), `[snapshot, feature]`.
    ///
    /// # Errors
    /// Where there are fewer snapshots than k, not as many places as activations, no feature, an activation outside of [0, 1],
    /// or a key of `config` that makes no sense.
    pub fn new(places: Places, activation: Array2<f64>, config: MapConfig) -> Result<Self> {
        if activation.nrows() != places.len() {
            return Err(Error::work(format!(
                "map: {} activations for {} places",
                activation.nrows(),
                places.len()
            )));
        }
        check_probabilities("map: activation of snapshot", &activation)?;
        let unmodelled = config.unmodelled_probability;
        if !(0.0..1.0).contains(&unmodelled) {
            return Err(Error::usage(format!(
                "map: `unmodelled_probability` is {unmodelled}; expected 0 or more, below 1"
            )));
        }
        config.nearness.check(places.len())?;
        Ok(Self {
            places,
            activation,
            config,
        })
    }

    /// Where the training snapshots were taken.
    pub fn places(&self) -> &Places {
        &self.places
    }

    /// What the detectors said of them, `[snapshot, feature]`.
    pub fn activation(&self) -> ArrayView2<'_, f64> {
        self.activation.view()
    }

    /// How the places between are filled.
    pub fn config(&self) -> &MapConfig {
        &self.config
    }

    /// The map at some places, the cells of a grid as a rule.
    ///
    /// # Errors
    /// Where the places asked for lie along a route and those of the map in the plane, or the other way round.
    pub fn at(&self, queries: &Places) -> Result<GridMap> {
        let near = Neighbours::find(&self.places, queries, &self.config.nearness)?;
        self.from_neighbours(&near)
    }

    /// The same where the neighbours are known already.
    ///
    /// At a mapped place it is the mean activation of the k nearest snapshots (T98 5.1.6). At an unmapped one it is the
    /// mean of all snapshots: a heading that nobody ever saw says neither yes nor no.
    ///
    /// # Errors
    /// Where a neighbour is no snapshot of this map.
    pub fn from_neighbours(&self, near: &Neighbours) -> Result<GridMap> {
        let (k, n) = self.activation.dim();
        let cells = near.len();
        if (0..cells).any(|cell| near.of(cell).iter().any(|&index| index >= k)) {
            return Err(Error::work(format!(
                "map: a neighbour that is none of the {k} training snapshots"
            )));
        }
        let neutral = self
            .activation
            .mean_axis(Axis(0))
            .unwrap_or_else(|| Array1::from_elem(n, 0.5)); // no snapshot: k ≥ 1 forbids it
        let unmodelled = self.config.unmodelled_probability;
        let mut probability = vec![0.0; cells * n];
        let rows = probability.par_chunks_mut(n).enumerate();
        rows.for_each(|(cell, row)| {
            let mut row = ArrayViewMut1::from(row);
            if near.is_mapped(cell) {
                for &snapshot in near.of(cell) {
                    row += &self.activation.row(snapshot);
                }
                row /= near.k() as f64;
            } else {
                row.assign(&neutral);
            }
            row.mapv_inplace(|m| (1.0 - unmodelled) * m + unmodelled / 2.0);
        });
        let probability = Array2::from_shape_vec((cells, n), probability)
            .map_err(|e| Error::work(format!("map: {e}")))?;
        GridMap::new(probability)
    }
}

/// P(f_i = 1 | ξ) at every cell of a grid, ready for evidence.
#[derive(Debug, Clone)]
pub struct GridMap {
    /// `[cell, feature]`
    probability: Array2<f64>,
    log_odds: OnceLock<LogOdds>,
}

/// The map as mean-field evidence wants it.
#[derive(Debug, Clone)]
struct LogOdds {
    /// ln m/(1−m), `[cell, feature]`
    slope: Array2<f64>,
    /// Σ_i ln(1−m_i), `[cell]`
    offset: Vec<f64>,
}

impl GridMap {
    /// From probabilities, `[cell, feature]`.
    ///
    /// # Errors
    /// Where there is no feature, or a value isn't in [0, 1].
    pub fn new(probability: Array2<f64>) -> Result<Self> {
        check_probabilities("map: probability of cell", &probability)?;
        Ok(Self {
            probability: probability.as_standard_layout().into_owned(),
            log_odds: OnceLock::new(),
        })
    }

    /// P(f_i = 1 | ξ), `[cell, feature]`.
    pub fn probability(&self) -> ArrayView2<'_, f64> {
        self.probability.view()
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.probability.nrows()
    }

    /// Number of features n.
    pub fn features(&self) -> usize {
        self.probability.ncols()
    }

    /// Σ_i g_i ln m_i(ξ) + (1−g_i) ln(1−m_i(ξ)) at every cell. The logarithms are taken at the first call and kept.
    pub(super) fn cross_entropy(&self, g: &[f64]) -> Vec<f64> {
        let LogOdds { slope, offset } = self
            .log_odds
            .get_or_init(|| LogOdds::new(&self.probability));
        let cells = (0..self.cells()).into_par_iter();
        cells
            .map(|cell| {
                let slopes = slope.row(cell);
                let terms = slopes.iter().zip(g);
                offset[cell] + terms.map(|(s, g)| s * g).sum::<f64>()
            })
            .collect()
    }
}

impl LogOdds {
    fn new(probability: &Array2<f64>) -> Self {
        // A certain map would make 0 · ∞ of a feature that agrees with it.
        let certain = |m: f64| m.clamp(f64::EPSILON, 1.0 - f64::EPSILON);
        // On one thread: this runs while others wait for it, and a rayon thread that waits for its share of the work takes
        // up other work meanwhile, which may be a trial that asks for these very logarithms: nobody would ever finish.
        let sum = |row: ArrayView1<f64>| row.iter().map(|&m| (-certain(m)).ln_1p()).sum();
        Self {
            offset: probability.rows().into_iter().map(sum).collect(),
            slope: probability.mapv(|m| certain(m).ln() - (-certain(m)).ln_1p()),
        }
    }
}

fn check_probabilities(what: &str, values: &Array2<f64>) -> Result<()> {
    if values.ncols() == 0 {
        return Err(Error::work("map: no feature; expected at least one"));
    }
    match values
        .indexed_iter()
        .find(|(_, v)| !(0.0..=1.0).contains(*v))
    {
        Some(((row, feature), value)) => Err(Error::work(format!(
            "{what} {row}, feature {feature} is {value}; expected a probability"
        ))),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use ndarray::array;

    use std::f64::consts::PI;

    fn config(k: usize, unmodelled_probability: f64) -> MapConfig {
        MapConfig {
            nearness: Nearness {
                k,
                ..Nearness::default()
            },
            unmodelled_probability,
            ..MapConfig::default()
        }
    }

    #[test]
    fn averages_the_nearest_and_is_neutral_where_nothing_was_seen() {
        let poses = [(0.0, 3.1), (0.2, -3.1), (0.1, 0.0), (4.0, 0.0)];
        let places = Places::Plane(
            poses
                .map(|(x, heading)| Pose::new(x, 0.0, heading))
                .to_vec(),
        );
        let activation = array![[0.8], [0.6], [0.1], [0.3]];
        let map = FeatureMap::new(places, activation, config(2, 0.0)).unwrap();
        // West is where the first two looked, on both sides of the turn; nobody looked north; nobody was at (9, 9).
        let asked = vec![
            Pose::new(0.1, 0.0, PI),
            Pose::new(0.1, 0.0, PI / 2.0),
            Pose::new(9.0, 9.0, 0.0),
        ];
        let here = map.at(&Places::Plane(asked)).unwrap();
        let expected = [0.7, 0.45, 0.45];
        for (cell, e) in expected.iter().enumerate() {
            assert!((here.probability()[[cell, 0]] - e).abs() < 1e-15, "{cell}");
        }
    }

    #[test]
    fn nothing_is_impossible_where_something_is_unmodelled() {
        let places = Places::Route(vec![0.0, 1.0]);
        let map = FeatureMap::new(places.clone(), array![[0.0], [1.0]], config(1, 0.02)).unwrap();
        let here = map.at(&places).unwrap();
        assert!((here.probability()[[0, 0]] - 0.01).abs() < 1e-15);
        assert!((here.probability()[[1, 0]] - 0.99).abs() < 1e-15);
    }

    #[test]
    fn what_is_no_map_is_refused() {
        let places = || Places::Route(vec![0.0, 1.0]);
        let message = |activation: Array2<f64>, config| {
            FeatureMap::new(places(), activation, config)
                .unwrap_err()
                .to_string()
        };
        assert!(
            message(array![[0.5], [f64::NAN]], config(1, 0.0))
                .contains("snapshot 1, feature 0 is NaN")
        );
        assert!(message(array![[0.5]], config(1, 0.0)).contains("1 activations for 2 places"));
        assert!(
            message(array![[0.5], [0.5]], config(3, 0.0))
                .contains("2 training snapshots; expected at least k = 3")
        );
        assert!(message(array![[0.5], [0.5]], config(1, 1.0)).contains("unmodelled_probability"));
        assert!(GridMap::new(array![[1.1]]).is_err());
    }
}
