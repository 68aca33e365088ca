//! Places beyond the map, where a robot may have gone that nothing is known of.
//!
//! A belief over mapped places alone leaves a robot that goes on into a new room no choice but a mapped one, and among rooms that look alike one
//! of them explains what is sensed. So in the plane the belief reaches further than the map. Beyond it an observation is as likely as of a robot
//! that may be anywhere on the map: what is sensed tells nothing there, and odometry alone leads out and back.

use super::PreparedSensorModel;
use crate::{
    belief::{Belief, Grid, GridConfig, Places},
    error::Result,
    seed::Stream,
};
use std::sync::Arc;

/// The cells of a map, and a grid that reaches beyond them.
pub(super) struct Beyond {
    /// The map's own.
    pub(super) mapped: Arc<Grid>,
    /// Those of the belief.
    pub(super) grid: Arc<Grid>,
    /// Of each cell of the belief the map's cell there; none beyond the map.
    pub(super) of_map: Vec<Option<usize>>,
}

impl Beyond {
    /// The grid over mapped places, and one that reaches `beyond_m` further; along a route both are the same, which has no beyond.
    pub(super) fn new(places: &Places, config: &GridConfig, beyond_m: f64) -> Result<Self> {
        let mapped = Arc::new(Grid::over(places, config)?);
        let grid = match places {
            Places::Plane(_) if beyond_m > 0.0 => {
                let further = GridConfig {
                    margin_m: config.margin_m + beyond_m,
                    ..config.clone()
                };
                Arc::new(Grid::over(places, &further)?)
            }
            _ => Arc::clone(&mapped),
        };
        let cells = 0..grid.len();
        Ok(Self {
            of_map: cells
                .map(|cell| mapped.cell_at(grid.places(), cell))
                .collect(),
            mapped,
            grid,
        })
    }

    /// Is a cell of the belief one of the map?
    pub(super) fn is_mapped(&self) -> Vec<bool> {
        self.of_map.iter().map(Option::is_some).collect()
    }
}

/// A sensor model of the map's cells, at those of the belief.
pub(super) struct BeyondTheMap<'a> {
    pub(super) cells: &'a Beyond,
    pub(super) within: &'a dyn PreparedSensorModel,
    /// Over the map's cells.
    pub(super) anywhere: Belief,
}

impl PreparedSensorModel for BeyondTheMap<'_> {
    fn log_likelihood(
        &self,
        snapshot: usize,
        _belief: &Belief,
        stream: &mut Stream,
    ) -> Result<Vec<f64>> {
        let on_map = (self.within).log_likelihood(snapshot, &self.anywhere, stream)?;
        let beyond = self.anywhere.log_predictive(&on_map);
        let at = |cell: &Option<usize>| cell.map_or(beyond, |cell| on_map[cell]);
        Ok(self.cells.of_map.iter().map(at).collect())
    }
}
