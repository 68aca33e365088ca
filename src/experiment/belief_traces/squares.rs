//! Squares that a belief over a grid is reduced to.

use crate::{
    belief::{Belief, Grid, Places},
    localiser::Probable,
};
use std::collections::BTreeMap;

/// Squares over the cells of a grid, or pieces of a route.
pub(super) struct Squares {
    /// Edge, in metres.
    pub cell_m: f64,
    /// Centres, metres.
    pub centres: Vec<Vec<f64>>,
    /// Centre of the grid's first site, and the edge of its cells, in metres.
    first_m: [f64; 2],
    fine_m: f64,
    /// Cells of the grid along the edge of a square.
    by: i64,
    /// By their number along each axis.
    number: BTreeMap<[i64; 2], usize>,
    /// Of each site of the grid.
    of_site: Vec<usize>,
}

impl Squares {
    /// The smallest that are at most so many.
    pub fn over(grid: &Grid, most: usize) -> Self {
        let sites = grid.len() / grid.headings();
        let mut by = 1;
        loop {
            let squares = Self::of_size(grid, sites, by);
            if squares.centres.len() <= most {
                return squares;
            }
            by += 1;
        }
    }

    fn of_size(grid: &Grid, sites: usize, by: i64) -> Self {
        let (first_m, fine_m) = (place(grid.places(), 0), grid.cell_m());
        let at: Vec<[i64; 2]> = (0..sites)
            .map(|site| square(place(grid.places(), site), first_m, fine_m, by))
            .collect();
        let mut number: BTreeMap<[i64; 2], usize> = at.iter().map(|square| (*square, 0)).collect();
        for (index, of_square) in number.values_mut().enumerate() {
            *of_square = index;
        }
        let is_route = matches!(**grid.places(), Places::Route(_));
        let centre = |square: &[i64; 2]| {
            let middle = |n: i64| (n * by) as f64 + 0.5 * (by - 1) as f64;
            let centre = [0, 1].map(|axis| first_m[axis] + middle(square[axis]) * fine_m);
            centre[..if is_route { 1 } else { 2 }].to_vec()
        };
        Self {
            cell_m: by as f64 * fine_m,
            first_m,
            fine_m,
            by,
            centres: number.keys().map(centre).collect(),
            of_site: at.iter().map(|square| number[square]).collect(),
            number,
        }
    }

    /// What each square holds of a belief over the grid.
    pub fn of_belief(&self, belief: &Belief) -> Vec<u8> {
        let mut mass = vec![0.0; self.centres.len()];
        for (cell, held) in belief.mass().iter().enumerate() {
            mass[self.of_site[cell % self.of_site.len()]] += held;
        }
        levels(&mass)
    }

    /// What each square holds of a posterior over places in the plane; what lies in none is left out.
    pub fn of_places(&self, posterior: &[Probable]) -> Vec<u8> {
        let mut mass = vec![0.0; self.centres.len()];
        for (place, held) in posterior {
            let at = square(*place, self.first_m, self.fine_m, self.by);
            if let Some(&number) = self.number.get(&at) {
                mass[number] += held;
            }
        }
        levels(&mass)
    }
}

/// A place on the plane; along a route its coordinate and 0.
fn place(places: &Places, index: usize) -> [f64; 2] {
    match places {
        Places::Route(route) => [route[index], 0.0],
        Places::Plane(poses) => [poses[index].x_m, poses[index].y_m],
    }
}

/// The square that holds a place: squares are counted from the first site on, `by` cells each.
fn square(place: [f64; 2], first_m: [f64; 2], fine_m: f64, by: i64) -> [i64; 2] {
    [0, 1].map(|axis| {
        let cells = ((place[axis] - first_m[axis]) / fine_m + 0.5).floor();
        (cells as i64).div_euclid(by)
    })
}

/// 255 · √mass.
fn levels(mass: &[f64]) -> Vec<u8> {
    let level = |mass: &f64| (255.0 * mass.clamp(0.0, 1.0).sqrt()).round() as u8;
    mass.iter().map(level).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{belief::GridConfig, geometry::Pose};

    #[test]
    fn headings_count_together_and_squares_grow_until_they_are_few_enough() {
        let config = GridConfig {
            headings: 4,
            margin_m: 2.0,
            ..GridConfig::default()
        };
        let mapped = Places::Plane(vec![Pose::new(0.1, 0.1, 0.0)]);
        let grid = Grid::over(&mapped, &config).unwrap();
        let sites = grid.len() / 4;
        let fine = Squares::over(&grid, sites);
        assert_eq!((fine.centres.len(), fine.cell_m), (sites, 0.25));
        let coarse = Squares::over(&grid, 20);
        assert!(coarse.centres.len() <= 20 && coarse.cell_m > 0.25);
        let mut mass = vec![0.0; grid.len()];
        (0..4).for_each(|heading| mass[heading * sites + 7] = 0.25);
        let belief = Belief::from_mass(grid.places(), mass).unwrap();
        let levels = fine.of_belief(&belief);
        assert_eq!(levels.iter().filter(|level| **level > 0).count(), 1);
        assert!(levels.contains(&255));
        // Each at the centre of its site, wherever the grid begins.
        let route = Grid::along_route(
            0.3,
            9.0,
            &GridConfig {
                cell_m: 0.1,
                ..config
            },
        )
        .unwrap();
        let pieces = Squares::over(&route, route.len());
        assert_eq!(pieces.centres.len(), route.len());
        let Places::Route(centres) = &**route.places() else {
            panic!("no route")
        };
        let same = |(a, b): (&Vec<f64>, &f64)| (a[0] - b).abs() < 1e-9;
        assert!(pieces.centres.iter().zip(centres).all(same));
        let centre = [fine.centres[3][0], fine.centres[3][1]];
        let particles = fine.of_places(&[(centre, 0.25), ([99.0, 0.0], 0.75)]);
        assert_eq!(
            (particles[3], particles.iter().map(|l| u32::from(*l)).sum()),
            (128, 128)
        );
    }
}
