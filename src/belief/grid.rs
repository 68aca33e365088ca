//! The cells that a belief is spread over.

use super::{lattice::Lattice, places::Places};
use crate::{
    error::{Error, Result},
    geometry::{Pose, wrapped},
};
use serde::{Deserialize, Serialize};
use std::{f64::consts::TAU, sync::Arc};

/// How finely, and how far around the mapped places, a grid is laid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GridConfig {
    /// Edge of a cell, in metres.
    pub cell_m: f64,
    /// Headings told apart in the plane.
    pub headings: usize,
    /// In the plane, cells whose centre is within this distance of a mapped place belong to the grid, in metres.
    pub margin_m: f64,
    /// Largest number of cells, all headings counted: a mistyped `cell_m` should end in a message, not in a full memory.
    pub most_cells: usize,
}

impl Default for GridConfig {
    fn default() -> Self {
        Self {
            cell_m: 0.25,
            headings: 24,
            margin_m: 1.0,
            most_cells: 8_000_000,
        }
    }
}

impl GridConfig {
    /// # Errors
    /// A usage error where a value makes no sense; the message names its key.
    pub fn check(&self) -> Result<()> {
        let wrong = |key: &str, value: String, expected: &str| {
            Err(Error::usage(format!(
                "grid: `{key}` is {value}; expected {expected}"
            )))
        };
        if !(self.cell_m.is_finite() && self.cell_m > 0.0) {
            return wrong("cell_m", self.cell_m.to_string(), "metres above 0");
        }
        if !(self.margin_m.is_finite() && self.margin_m >= 0.0) {
            return wrong("margin_m", self.margin_m.to_string(), "metres, 0 or more");
        }
        if self.headings == 0 {
            return wrong("headings", "0".into(), "1 or more");
        }
        Ok(())
    }
}

/// The places where the robot can be, cut into cells: along a route every cell from its one end to the other, in the
/// plane the (x, y, θ) cells near some mapped place, with all headings of each.
///
/// Cells of one heading lie side by side: cell = heading · sites + site. Heading 0 points along x.
///
/// ```
/// use ballmark::{belief::{Grid, GridConfig, Places}, geometry::Pose};
/// let config = GridConfig { margin_m: 0.5, ..GridConfig::default() };
/// let grid = Grid::over(&Places::Plane(vec![Pose::new(3.1, 4.1, 0.0)]), &config)?;
/// let here = Places::Plane(vec![Pose::new(3.1, 4.1, 0.2)]);
/// let cell = grid.cell_at(&here, 0).unwrap();
/// assert!(grid.places().distance_m(cell, &here, 0) < 0.2);
/// assert!(grid.places().turn_rad(cell, &here, 0) <= std::f64::consts::TAU / 24.0 / 2.0);
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    lattice: Lattice,
    headings: usize,
    places: Arc<Places>,
}

impl Grid {
    /// The grid over the mapped places: from the first to the last along a route; around them all in the plane.
    ///
    /// # Errors
    /// Where a key of `config` makes no sense, the cells would be more than `most_cells` (both say the call is wrong), or
    /// there is no place.
    pub fn over(mapped: &Places, config: &GridConfig) -> Result<Self> {
        config.check()?;
        if mapped.is_empty() {
            return Err(Error::work("grid: no mapped place; expected at least one"));
        }
        match mapped {
            Places::Route(route) => {
                if let Some(bad) = route.iter().position(|x| !x.is_finite()) {
                    return Err(Error::work(format!(
                        "grid: snapshot {bad} lies at {} m along the route; expected a finite number",
                        route[bad]
                    )));
                }
                let (low, high) = route
                    .iter()
                    .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &x| {
                        (low.min(x), high.max(x))
                    });
                Self::along_route(low, high, config)
            }
            Places::Plane(poses) => Self::in_plane(poses, config),
        }
    }

    /// A grid from one coordinate along a route to another, in metres; the last cell may reach beyond the end.
    ///
    /// # Errors
    /// As [`Grid::over`].
    pub fn along_route(from_m: f64, to_m: f64, config: &GridConfig) -> Result<Self> {
        config.check()?;
        let lattice = Lattice::line(from_m, to_m, config.cell_m, config.most_cells)?;
        let route = (0..lattice.len()).map(|site| lattice.centre_m(site).0);
        Ok(Self {
            headings: 1,
            places: Arc::new(Places::Route(route.collect())),
            lattice,
        })
    }

    fn in_plane(poses: &[Pose], config: &GridConfig) -> Result<Self> {
        let headings = config.headings;
        let most_sites = config.most_cells / headings;
        let lattice = Lattice::around(poses, config.cell_m, config.margin_m, most_sites)?;
        let cells = (0..headings).flat_map(|heading| {
            let heading_rad = wrapped(heading as f64 * TAU / headings as f64);
            let lattice = &lattice;
            (0..lattice.len()).map(move |site| {
                let (x_m, y_m) = lattice.centre_m(site);
                Pose::new(x_m, y_m, heading_rad)
            })
        });
        Ok(Self {
            headings,
            places: Arc::new(Places::Plane(cells.collect())),
            lattice,
        })
    }

    /// Number of cells, all headings counted; never 0.
    #[allow(clippy::len_without_is_empty)]
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Centres of all cells, in order.
    pub fn places(&self) -> &Arc<Places> {
        &self.places
    }

    /// Headings told apart: 1 along a route.
    pub fn headings(&self) -> usize {
        self.headings
    }

    /// Edge of a cell, in metres.
    pub fn cell_m(&self) -> f64 {
        self.lattice.cell_m()
    }

    /// The cell that holds place `index` of `places`; `None` where it is off the grid.
    pub fn cell_at(&self, places: &Places, index: usize) -> Option<usize> {
        match (&*self.places, places) {
            (Places::Route(_), Places::Route(route)) => self
                .lattice
                .site_at(route[index], self.lattice.centre_m(0).1),
            (Places::Plane(_), Places::Plane(poses)) => self.cell_of(&poses[index]),
            _ => None,
        }
    }

    /// The cell that holds a pose; `None` where it is off the grid, or the grid lies along a route.
    pub fn cell_of(&self, pose: &Pose) -> Option<usize> {
        if matches!(*self.places, Places::Route(_)) {
            return None;
        }
        let turns = (pose.heading_rad / TAU * self.headings as f64).round() as i64;
        let heading = turns.rem_euclid(self.headings as i64) as usize;
        let site = self.lattice.site_at(pose.x_m, pose.y_m)?;
        Some(heading * self.lattice.len() + site)
    }

    pub(super) fn lattice(&self) -> &Lattice {
        &self.lattice
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn poses() -> Places {
        Places::Plane(vec![Pose::new(0.0, 0.0, 1.0), Pose::new(5.0, -3.0, 0.0)])
    }

    #[test]
    fn every_cell_is_found_at_its_centre_and_lies_near_a_mapped_place() {
        let config = GridConfig {
            headings: 7,
            ..GridConfig::default()
        };
        for mapped in [poses(), Places::Route(vec![3.0, -2.0, 11.1])] {
            let grid = Grid::over(&mapped, &config).unwrap();
            for cell in 0..grid.len() {
                assert_eq!(grid.cell_at(grid.places(), cell), Some(cell));
                let near = |k| grid.places().distance_m(cell, &mapped, k) <= 1.0;
                assert!(matches!(mapped, Places::Route(_)) || (0..mapped.len()).any(near));
            }
            for k in 0..mapped.len() {
                assert!(grid.cell_at(&mapped, k).is_some(), "{k}");
            }
        }
    }

    #[test]
    fn a_plane_grid_has_the_area_of_its_discs() {
        let config = GridConfig {
            cell_m: 0.05,
            ..GridConfig::default()
        };
        let grid = Grid::over(&poses(), &config).unwrap();
        let area = grid.len() as f64 / 24.0 * 0.05 * 0.05;
        assert!((area - 2.0 * std::f64::consts::PI).abs() < 0.06, "{area}");
    }

    #[test]
    fn absurd_configurations_are_refused_in_words() {
        let with = |change: fn(&mut GridConfig)| {
            let mut config = GridConfig::default();
            change(&mut config);
            let refused = Grid::over(&poses(), &config).unwrap_err();
            assert!(refused.is_usage(), "{refused}");
            refused.to_string()
        };
        assert!(with(|c| c.cell_m = 1e-6).contains("expected at most"));
        assert!(with(|c| c.margin_m = 1e9).contains("expected at most"));
        assert!(with(|c| c.most_cells = 1000).contains("expected at most 41"));
        assert!(with(|c| c.headings = 0).contains("`headings` is 0"));
        assert!(with(|c| c.cell_m = f64::NAN).contains("`cell_m`"));
        let far = Places::Route(vec![0.0, 1e15]);
        assert!(
            Grid::over(&far, &GridConfig::default())
                .unwrap_err()
                .is_usage()
        );
        let nowhere = Places::Route(vec![0.0, f64::NAN]);
        let error = Grid::over(&nowhere, &GridConfig::default()).unwrap_err();
        assert!(error.to_string().contains("snapshot 1"), "{error}");
        let far = Places::Plane(vec![Pose::new(1e300, 0.0, 0.0)]);
        let error = Grid::over(&far, &GridConfig::default()).unwrap_err();
        assert!(error.to_string().contains("snapshot 0"), "{error}");
    }
}
