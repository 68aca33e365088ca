//! What surrounds a robot at one moment: the walls of its floor plan, and the people and doors that move.

use super::{Hit, Raycaster, Wall};
use nalgebra::{Point2, Vector2};
use std::ops::ControlFlow;

/// A floor plan together with walls that are there for this moment only: people, the leaf of a door that swings.
///
/// ```
/// use ballmark::world::{FloorPlan, Material, Raycaster, Surroundings, Wall};
/// use nalgebra::{Point2, Vector2};
/// let upright = |x_m| Wall::new(Point2::new(x_m, -1.0), Point2::new(x_m, 1.0), Material::PLAIN);
/// let caster = Raycaster::new(FloorPlan::new(vec![upright(5.0)])?);
/// let passing = [upright(2.0).between(0.0, 1.8)];
/// let around = Surroundings::new(&caster, &passing);
/// let seen_m = |height_m| around.cast(&Point2::origin(), &Vector2::x(), 10.0, height_m).unwrap().distance_m;
/// assert_eq!((seen_m(0.5), seen_m(2.0)), (2.0, 5.0)); // over their heads the wall is seen
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Surroundings<'a> {
    caster: &'a Raycaster,
    passing: &'a [Wall],
}

impl<'a> Surroundings<'a> {
    /// A plan, and what is passing.
    pub fn new(caster: &'a Raycaster, passing: &'a [Wall]) -> Self {
        Self { caster, passing }
    }

    /// The nearest wall that stands at a height above the floor, on the way from `origin` along the unit vector
    /// `direction`, up to `reach_m` metres.
    pub fn cast(
        &self,
        origin: &Point2<f64>,
        direction: &Vector2<f64>,
        reach_m: f64,
        height_m: f64,
    ) -> Option<Hit> {
        let standing = |wall: &Wall| wall.stands_at(height_m);
        let fixed = self.caster.cast_at(origin, direction, reach_m, standing);
        let first = self.caster.plan().walls().len();
        self.passing
            .iter()
            .enumerate()
            .filter(|(_, wall)| standing(wall))
            .filter_map(|(index, wall)| Hit::of(wall, first + index, origin, direction))
            .filter(|hit| hit.distance_m <= reach_m)
            .chain(fixed)
            .min_by(|a, b| a.distance_m.total_cmp(&b.distance_m))
    }

    /// Visits every wall on the way from `origin` along the unit vector `direction`, up to `reach_m` metres and at any
    /// height, nearest first, until `visit` breaks off.
    pub fn cast_through(
        &self,
        origin: &Point2<f64>,
        direction: &Vector2<f64>,
        reach_m: f64,
        mut visit: impl FnMut(Hit) -> ControlFlow<()>,
    ) {
        let first = self.caster.plan().walls().len();
        let mut passing: Vec<Hit> = self
            .passing
            .iter()
            .enumerate()
            .filter_map(|(index, wall)| Hit::of(wall, first + index, origin, direction))
            .filter(|hit| hit.distance_m <= reach_m)
            .collect();
        // The nearest last, to be taken off there.
        passing.sort_by(|a, b| b.distance_m.total_cmp(&a.distance_m));
        let mut done = false;
        self.caster
            .cast_through(origin, direction, reach_m, |fixed| {
                let nearer = |hit: &mut Hit| hit.distance_m < fixed.distance_m;
                let mut stopped = ControlFlow::Continue(());
                while let Some(hit) = passing.pop_if(nearer)
                    && stopped.is_continue()
                {
                    stopped = visit(hit);
                }
                if stopped.is_continue() {
                    stopped = visit(fixed);
                }
                done = stopped.is_break();
                stopped
            });
        while let Some(hit) = passing.pop()
            && !done
        {
            done = visit(hit).is_break();
        }
    }

    /// The wall of a [`Hit`].
    pub fn wall(&self, hit: &Hit) -> &'a Wall {
        let walls = self.caster.plan().walls();
        match hit.wall.checked_sub(walls.len()) {
            None => &walls[hit.wall],
            Some(passing) => &self.passing[passing],
        }
    }

    /// The plan made ready for rays.
    pub fn caster(&self) -> &'a Raycaster {
        self.caster
    }

    /// What is passing.
    pub fn passing(&self) -> &'a [Wall] {
        self.passing
    }
}

impl<'a> From<&'a Raycaster> for Surroundings<'a> {
    fn from(caster: &'a Raycaster) -> Self {
        Self::new(caster, &[])
    }
}
