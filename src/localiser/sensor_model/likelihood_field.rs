//! The likelihood field of an occupancy map as a sensor model: what a user of a laser scanner has without learning.

use super::{SensorModel, ln_mean_exp};
use crate::{
    belief::{Belief, Grid},
    error::{Error, Result},
    geometry::Pose,
    localiser::likelihood_field::FieldOverGrid,
    mapping::LikelihoodField,
    recording::Observation,
    seed::Stream,
};
use rayon::prelude::*;
use std::sync::Arc;

/// ln p(z | ξ) of a scan by a [`LikelihoodField`] (Thrun, Burgard & Fox, *Probabilistic Robotics*, 2005, table 6.3) at the
/// cells of a grid, or at places of which poses are known.
///
/// Beams of one scan are taken as independent of each other, which neighbouring ones are not: what comes out is too sharp by
/// far, and has to be scaled ([`EvidenceScale`](super::EvidenceScale)) before a filter may believe it.
///
/// ```
/// use ballmark::{belief::{Belief, Places}, geometry::Pose, localiser::sensor_model::{LikelihoodFieldModel, SensorModel}, seed::Seed};
/// use ballmark::mapping::{LikelihoodField, LikelihoodFieldConfig, OccupancyMap, OccupancyMapConfig};
/// # use ballmark::recording::{Channel, Columns, Recording};
/// # let laser = Channel { name: "laser".into(), width: 1, unit: "m".into(), bearing_rad: Some(vec![0.0]), maximum: None, offset_m: None };
/// # let recording = Recording::new(Columns { channels: vec![laser], values: ndarray::array![[2.0], [2.0]], stamp_s: vec![0.0, 1.0],
/// #     pose: vec![Pose::new(0.1, 0.1, 0.0); 2], odometry: vec![Pose::default(); 2], run: vec![0, 0], ..Columns::default() })?;
/// let map = OccupancyMap::from_scans(&recording, &[0, 1], &OccupancyMapConfig::default())?;
/// let field = std::sync::Arc::new(LikelihoodField::new(&map, &LikelihoodFieldConfig::default())?);
/// let poses = vec![Pose::new(0.1, 0.1, 0.0), Pose::new(1.1, 0.1, 0.0)];
/// let model = LikelihoodFieldModel::at_poses(&field, poses.iter().map(|pose| vec![*pose]).collect())?;
/// let belief = Belief::uniform(&std::sync::Arc::new(Places::Plane(poses)))?;
/// let said = model.log_likelihood(&recording.observation(0), &belief, &mut Seed(1).stream("not drawn from"))?;
/// assert!(said[0] > said[1]);
/// # Ok::<(), ballmark::Error>(())
/// ```
pub struct LikelihoodFieldModel {
    field: Arc<LikelihoodField>,
    at: At,
}

/// Where the field is asked.
enum At {
    Grid(FieldOverGrid, usize),
    /// Poses that stand for each place: the place is as likely as they are on average.
    Poses(Vec<Vec<Pose>>),
}

impl LikelihoodFieldModel {
    /// At all cells of a grid in the plane.
    ///
    /// # Errors
    /// Where the grid lies along a route.
    pub fn over_grid(field: &Arc<LikelihoodField>, grid: &Arc<Grid>) -> Result<Self> {
        let at = At::Grid(FieldOverGrid::new(field, grid)?, grid.len());
        Ok(Self {
            field: Arc::clone(field),
            at,
        })
    }

    /// At places for each of which some poses stand, `[place]`: along a route those of the snapshots taken there. A place
    /// without any is as likely as all places are on average.
    ///
    /// # Errors
    /// Where no place has a pose.
    pub fn at_poses(field: &Arc<LikelihoodField>, poses: Vec<Vec<Pose>>) -> Result<Self> {
        if poses.iter().all(Vec::is_empty) {
            return Err(Error::work(
                "likelihood field: no place with a known pose; expected at least one",
            ));
        }
        Ok(Self {
            field: Arc::clone(field),
            at: At::Poses(poses),
        })
    }
}

impl SensorModel for LikelihoodFieldModel {
    fn name(&self) -> &str {
        "likelihood_field"
    }

    fn log_likelihood(
        &self,
        observation: &Observation,
        belief: &Belief,
        _: &mut Stream,
    ) -> Result<Vec<f64>> {
        let beams = self.field.beams(observation.channels, observation)?;
        let places = match &self.at {
            At::Grid(_, cells) => *cells,
            At::Poses(poses) => poses.len(),
        };
        if belief.mass().len() != places {
            return Err(Error::work(format!(
                "likelihood field: a belief over {} places; expected the {places} that it was made for",
                belief.mass().len()
            )));
        }
        Ok(match &self.at {
            At::Grid(field, _) => {
                let sums = field.log_likelihood(&beams);
                sums.into_iter().map(f64::from).collect()
            }
            At::Poses(poses) => {
                let of_place = |poses: &Vec<Pose>| {
                    let each = poses.iter().map(|p| self.field.log_likelihood(p, &beams));
                    ln_mean_exp(&each.collect::<Vec<f64>>())
                };
                let known: Vec<f64> = poses.par_iter().map(of_place).collect();
                let finite = known.iter().copied().filter(|l| l.is_finite());
                let neutral = ln_mean_exp(&finite.collect::<Vec<f64>>());
                let or_neutral = |l: f64| if l.is_finite() { l } else { neutral };
                known.into_iter().map(or_neutral).collect()
            }
        })
    }

    fn depends_on_belief(&self) -> bool {
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        belief::{GridConfig, Places},
        mapping::{LikelihoodFieldConfig, OccupancyMap, OccupancyMapConfig},
        recogniser::test_world::test_world,
        seed::Seed,
    };

    #[test]
    fn a_grid_and_poses_agree_and_find_the_truth() {
        let recording = test_world();
        let snapshots: Vec<usize> = (0..recording.len()).collect();
        let map = OccupancyMap::from_scans(&recording, &snapshots, &OccupancyMapConfig::default())
            .unwrap();
        let field =
            Arc::new(LikelihoodField::new(&map, &LikelihoodFieldConfig::default()).unwrap());
        let config = GridConfig {
            headings: 12,
            ..GridConfig::default()
        };
        let grid = Arc::new(Grid::over(&Places::of(&recording), &config).unwrap());
        let over_grid = LikelihoodFieldModel::over_grid(&field, &grid).unwrap();
        let Places::Plane(cells) = &**grid.places() else {
            unreachable!("a grid in the plane")
        };
        let each = cells.iter().map(|pose| vec![*pose]).collect();
        let at_poses = LikelihoodFieldModel::at_poses(&field, each).unwrap();
        let belief = Belief::uniform(grid.places()).unwrap();
        let mut stream = Seed(1).stream("not drawn from");
        let observation = recording.observation(17);
        let a = over_grid
            .log_likelihood(&observation, &belief, &mut stream)
            .unwrap();
        let b = at_poses
            .log_likelihood(&observation, &belief, &mut stream)
            .unwrap();
        let best = |l: &[f64]| (0..l.len()).max_by(|&x, &y| l[x].total_cmp(&l[y])).unwrap();
        for l in [&a, &b] {
            assert!(cells[best(l)].distance_m(&recording.poses()[17]) < 0.6);
        }
        // A grid reads the field at the middle of sub-cells, poses exactly where beams end.
        let off = |(a, b): (&f64, &f64)| (a - b).abs();
        let mean = a.iter().zip(&b).map(off).sum::<f64>() / a.len() as f64;
        assert!(mean < 1.0, "{mean}");

        let small = Belief::uniform(&Arc::new(Places::Route(vec![0.0]))).unwrap();
        let error = over_grid.log_likelihood(&observation, &small, &mut stream);
        assert!(
            error
                .unwrap_err()
                .to_string()
                .contains("a belief over 1 places")
        );
    }

    #[test]
    fn a_place_is_as_likely_as_its_poses_on_average_and_one_without_as_all() {
        let recording = test_world();
        let snapshots: Vec<usize> = (0..recording.len()).collect();
        let map = OccupancyMap::from_scans(&recording, &snapshots, &OccupancyMapConfig::default())
            .unwrap();
        let field =
            Arc::new(LikelihoodField::new(&map, &LikelihoodFieldConfig::default()).unwrap());
        let (here, there) = (recording.poses()[17], recording.poses()[40]);
        let groups = vec![vec![here], vec![there], vec![here, there], vec![]];
        let model = LikelihoodFieldModel::at_poses(&field, groups).unwrap();
        let places = Arc::new(Places::Route(vec![0.0, 1.0, 2.0, 3.0]));
        let belief = Belief::uniform(&places).unwrap();
        let mut stream = Seed(1).stream("not drawn from");
        let l = model
            .log_likelihood(&recording.observation(17), &belief, &mut stream)
            .unwrap();
        let p: Vec<f64> = l.iter().map(|x| (x - l[0]).exp()).collect();
        assert!((p[2] - 0.5 * (p[0] + p[1])).abs() < 1e-9, "{p:?}");
        assert!((p[3] - (p[0] + p[1] + p[2]) / 3.0).abs() < 1e-9, "{p:?}");
        assert!(LikelihoodFieldModel::at_poses(&field, vec![vec![]]).is_err());
    }
}
