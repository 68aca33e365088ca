//! All walls in the way of a ray, one behind the other: what a camera sees above the nearer ones.

use super::{Hit, Raycaster, meet};
use nalgebra::{Point2, Vector2};
use std::ops::ControlFlow;

impl Raycaster {
    /// Visits every wall on the way from `origin` along the unit vector `direction`, up to `reach_m` metres, nearest
    /// first, until `visit` breaks off; of several at the same distance the first in the plan comes first.
    ///
    /// ```
    /// use ballmark::world::{FloorPlan, Material, Raycaster, Wall};
    /// use nalgebra::{Point2, Vector2};
    /// use std::ops::ControlFlow;
    /// let upright = |x_m| Wall::new(Point2::new(x_m, -1.0), Point2::new(x_m, 1.0), Material::PLAIN);
    /// let caster = Raycaster::new(FloorPlan::new([3.0, 1.0, 2.0].map(upright).to_vec())?);
    /// let mut seen = Vec::new();
    /// caster.cast_through(&Point2::origin(), &Vector2::x(), 10.0, |hit| {
    ///     seen.push((hit.wall, hit.distance_m));
    ///     if hit.wall == 2 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    /// });
    /// assert_eq!(seen, [(1, 1.0), (2, 2.0)]);
    /// # Ok::<(), ballmark::Error>(())
    /// ```
    pub fn cast_through(
        &self,
        origin: &Point2<f64>,
        direction: &Vector2<f64>,
        reach_m: f64,
        mut visit: impl FnMut(Hit) -> ControlFlow<()>,
    ) {
        // A wall may lie in several cells; it is visited in the one where the ray meets it.
        let mut passed_m = f64::NEG_INFINITY;
        let mut here: Vec<(f64, usize)> = Vec::new();
        self.walk(origin, direction, reach_m, |walls, exit_m| {
            here.clear();
            here.extend(walls.iter().filter_map(|&wall| {
                let distance_m = meet(&self.plan.walls()[wall as usize], origin, direction)?;
                let within = distance_m > passed_m && distance_m <= exit_m.min(reach_m);
                // Adding 0 makes −0 a 0, which sorts like it.
                within.then_some((distance_m + 0.0, wall as usize))
            }));
            here.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            passed_m = exit_m;
            here.iter().try_for_each(|&(distance_m, wall)| {
                let met = &self.plan.walls()[wall];
                visit(Hit::at(met, wall, direction, distance_m))
            })
        });
    }
}

#[cfg(test)]
mod tests {
    use super::{
        super::odd_rays::{REACH_M, odd_rays},
        *,
    };

    #[test]
    fn every_wall_in_the_way_is_visited_once_and_in_order() {
        odd_rays(|plan, caster, origin, direction| {
            let mut expected: Vec<(f64, usize)> = (plan.walls().iter().enumerate())
                .filter_map(|(index, wall)| Some((meet(wall, origin, direction)?, index)))
                .filter(|met| met.0 <= REACH_M)
                .collect();
            expected.sort_by(|a, b| a.partial_cmp(b).unwrap());
            let mut found = Vec::new();
            caster.cast_through(origin, direction, REACH_M, |hit| {
                found.push((hit.distance_m, hit.wall));
                ControlFlow::Continue(())
            });
            assert_eq!(found, expected);
        });
    }
}
