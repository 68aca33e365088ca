//! People who walk past the robot or stand about, and fire doors that they leave open for a while.
//!
//! Duckett & Nehmzow (1998, 7) mapped an empty corridor and came back when "29 persons walked past the robot (inbetween
//! the robot and the wall it was following in 11 of the cases). A further nine persons stood in the corridor or in
//! doorways", and "on four occasions, fire-doors in the immediate vicinity of the robot were left open for several
//! seconds".

mod config;
mod person;
#[cfg(test)]
mod tests;

pub use config::PeopleConfig;

use super::{
    Surroundings, Wall,
    timed_path::{TimedPath, TimedPose},
};
use crate::{
    error::{Error, Result},
    seed::{Seed, Stream},
};
use nalgebra::Point2;
use person::{MARGIN_M, Person, Room, SIGHT_M};
use rand::RngExt;

/// What the robot does while people come.
#[derive(Debug, Clone, Copy)]
pub struct Outing<'a> {
    /// Where the robot is when; a pose every second or half metre will do.
    pub path: &'a [TimedPose],
    /// Nobody comes and fire doors stay shut until this time: the robot maps.
    pub map_until_s: f64,
    /// Building and, as what is passing, its fire doors.
    pub around: Surroundings<'a>,
    /// Radius of the robot, metres.
    pub radius_m: f64,
    /// On which side the wall is that it follows, if it follows one.
    pub wall_on_left: Option<bool>,
}

/// Everyone who comes in one run, and the fire doors.
///
/// They keep to the robot's own way through the building, to one side of it, so they walk through no walls.
///
/// ```
/// use ballmark::{geometry::Pose, seed::Seed, world::{people::{Outing, People, PeopleConfig}, FloorPlan, Material, Raycaster, Surroundings, TimedPose, Wall}};
/// use nalgebra::Point2;
/// let wall = |y_m| Wall::new(Point2::new(-5.0, y_m), Point2::new(25.0, y_m), Material::PLAIN);
/// let caster = Raycaster::new(FloorPlan::new(vec![wall(-0.5), wall(1.5)])?);
/// let path: Vec<TimedPose> = (0..160)
///     .map(|s| TimedPose { stamp_s: f64::from(s), pose: Pose::new(0.125 * f64::from(s), 0.0, 0.0) })
///     .collect();
/// let outing = Outing {
///     path: &path,
///     map_until_s: 60.0,
///     around: Surroundings::from(&caster),
///     radius_m: 0.23,
///     wall_on_left: Some(false),
/// };
/// let config = PeopleConfig { passing: 5, between: 2, ..Default::default() };
/// let people = People::new(&config, Seed(1), 0, &outing)?;
/// let mut walls = Vec::new();
/// people.passing_at(30.0, &mut walls);
/// assert!(walls.is_empty()); // the robot still maps
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct People {
    path: TimedPath,
    rooms: Vec<Room>,
    radius_m: f64,
    map_until_s: f64,
    persons: Vec<Person>,
    config: PeopleConfig,
    fire_doors: Vec<Wall>,
    /// Fire door, and from when until when it stands open, seconds.
    openings: Vec<(usize, f64, f64)>,
}

/// How near to a fire door the robot is when someone leaves it open, metres: in its "immediate vicinity".
const VICINITY_M: f64 = 3.0;

impl People {
    /// Draws who comes when in a run.
    ///
    /// Each meeting is drawn from its own share of the time left after mapping, the first from the first, so that they
    /// spread over the run; and only where the robot leaves room to pass.
    ///
    /// # Errors
    /// A usage error where a constant is out of bounds, or someone is to pass between a robot and the wall that it
    /// follows while it follows none. A work error where the path is none, or never leaves the room, or the nearness
    /// to a fire door, that is needed.
    pub fn new(config: &PeopleConfig, seed: Seed, run: u64, outing: &Outing) -> Result<Self> {
        config.check()?;
        let path = TimedPath::new(outing.path).ok_or_else(|| {
            Error::work("people: expected a path of finite poses, in their order")
        })?;
        let rooms = outing
            .path
            .iter()
            .map(|timed| Room::beside(&timed.pose, &outing.around))
            .collect();
        let mut people = Self {
            path,
            rooms,
            radius_m: outing.radius_m,
            map_until_s: outing.map_until_s,
            persons: Vec::new(),
            config: config.clone(),
            fire_doors: outing.around.passing().to_vec(),
            openings: Vec::new(),
        };
        people.invite_walkers(outing, &mut seed.numbered_stream("world/people/walk", run))?;
        people.invite_standers(outing, &mut seed.numbered_stream("world/people/stand", run))?;
        people.open_doors(&mut seed.numbered_stream("world/people/doors", run))?;
        Ok(people)
    }

    /// Adds the walls that are there at a time, in seconds of the run: those of everyone in sight, and the fire doors
    /// that are shut. Nobody is within the robot's radius.
    pub fn passing_at(&self, stamp_s: f64, walls: &mut Vec<Wall>) {
        let shut = (0..self.fire_doors.len()).filter(|&door| !self.is_open(door, stamp_s));
        walls.extend(shut.map(|door| self.fire_doors[door]));
        if stamp_s < self.map_until_s {
            return;
        }
        let (robot, way_m) = self.path.at_time(stamp_s);
        for person in &self.persons {
            let there_m = person.way_m(stamp_s);
            if (there_m - way_m).abs() <= SIGHT_M
                && let Some(body) = person.body(there_m, &robot, self)
            {
                walls.extend(body);
            }
        }
    }

    /// Does a fire door stand open at a time?
    pub fn is_open(&self, door: usize, stamp_s: f64) -> bool {
        self.openings.iter().any(|&(opened, from_s, until_s)| {
            opened == door && (from_s..until_s).contains(&stamp_s)
        })
    }

    /// When the robot meets someone who walks, and whether they are on its left; in no order.
    pub fn meetings(&self) -> impl Iterator<Item = (f64, bool)> + '_ {
        let walking = self.persons.iter().filter(|person| person.walks());
        walking.map(|person| (person.met_s, person.aside_m > 0.0))
    }

    fn invite_walkers(&mut self, outing: &Outing, random: &mut Stream) -> Result<()> {
        let PeopleConfig {
            passing, between, ..
        } = self.config;
        if between > 0 {
            let Some(left) = outing.wall_on_left else {
                return Err(Error::usage(format!(
                    "people: `between` is {between}, but the robot follows no wall; expected 0"
                )));
            };
            let times = self.meeting_times(between, "between", &[left], random)?;
            for (index, left) in times {
                self.persons.push(self.walker(index, left, random));
            }
        }
        // The others keep to the side that is free.
        let sides: &[bool] = match outing.wall_on_left {
            Some(left) => &[!left],
            None => &[true, false],
        };
        let at_a_rate = self.drawn_at_rate(random);
        for (count, key) in [(passing - between, "passing"), (at_a_rate, "per_minute")] {
            for (index, left) in self.meeting_times(count, key, sides, random)? {
                self.persons.push(self.walker(index, left, random));
            }
        }
        Ok(())
    }

    /// How many come in the time after mapping at the configured rate: a Poisson process, one gap after another.
    fn drawn_at_rate(&self, random: &mut Stream) -> usize {
        let poses = self.path.poses();
        let minutes =
            (poses[poses.len() - 1].stamp_s - self.map_until_s.max(poses[0].stamp_s)) / 60.0;
        let mut come = 0;
        let mut until = -(1.0 - random.random::<f64>()).ln();
        while until < minutes * self.config.per_minute {
            come += 1;
            until -= (1.0 - random.random::<f64>()).ln();
        }
        come
    }

    /// Someone who walks past where the robot is at a pose of its path, towards it or overtaking.
    fn walker(&self, index: usize, left: bool, random: &mut Stream) -> Person {
        let [slow, fast] = self.config.speed_m_per_s;
        let speed = slow + (fast - slow) * random.random::<f64>();
        let towards = random.random::<bool>();
        let (body_m, aside_m) = self.squeezed(index, left, random.random());
        Person {
            met_s: self.path.poses()[index].stamp_s,
            met_m: self.path.ways_m()[index],
            speed_m_per_s: if towards { -speed } else { speed },
            aside_m,
            body_m,
            colour: [(); 3].map(|()| 0.08 + 0.5 * random.random::<f64>()),
        }
    }

    fn invite_standers(&mut self, outing: &Outing, random: &mut Stream) -> Result<()> {
        let sides: &[bool] = match outing.wall_on_left {
            Some(left) => &[!left],
            None => &[true, false],
        };
        for (index, left) in self.meeting_times(self.config.standing, "standing", sides, random)? {
            let mut person = self.walker(index, left, random);
            person.speed_m_per_s = 0.0;
            // With their back to the wall, or to the open room that is too wide to have one near.
            let standing_m = (self.free_m(index, left) - person.body_m - MARGIN_M)
                .min(self.radius_m + 1.0 + person.body_m);
            person.aside_m = if left { standing_m } else { -standing_m };
            self.persons.push(person);
        }
        Ok(())
    }

    /// Radius of someone who passes at a pose, and how far to the left of the robot's way, metres: as they like between
    /// robot and wall, but within a metre of the robot.
    fn squeezed(&self, index: usize, left: bool, at: f64) -> (f64, f64) {
        let gap_m = self.free_m(index, left) - self.radius_m - 2.0 * MARGIN_M;
        let body_m = self.config.radius_m.min(gap_m / 2.0);
        let spare_m = (gap_m - 2.0 * body_m).min(1.0);
        let aside_m = self.radius_m + MARGIN_M + body_m + at * spare_m;
        (body_m, if left { aside_m } else { -aside_m })
    }

    fn free_m(&self, index: usize, left: bool) -> f64 {
        self.rooms[index].free_m(left)
    }

    /// Poses of the path, and sides, at which someone can meet the robot: as many as asked for.
    fn meeting_times(
        &self,
        count: usize,
        key: &str,
        sides: &[bool],
        random: &mut Stream,
    ) -> Result<Vec<(usize, bool)>> {
        let needed_m = self.radius_m + 2.0 * (self.config.slim_m + MARGIN_M);
        let after_mapping = self.after_mapping();
        let possible: Vec<(usize, bool)> = after_mapping
            .flat_map(|index| sides.iter().map(move |&left| (index, left)))
            .filter(|&(index, left)| self.free_m(index, left) >= needed_m)
            .collect();
        spread(count, &possible, random).ok_or_else(|| {
            Error::work(format!(
                "people: `{key}` asks for {count}, but after mapping there are never {needed_m:.2} m from the robot's \
                 centre to the wall beside it; expected room for someone"
            ))
        })
    }

    /// Poses of the path at which the robot no longer maps.
    fn after_mapping(&self) -> impl Iterator<Item = usize> + '_ {
        let poses = self.path.poses();
        (0..poses.len()).filter(|&index| poses[index].stamp_s >= self.map_until_s)
    }

    fn open_doors(&mut self, random: &mut Stream) -> Result<()> {
        let count = self.config.fire_doors_opened;
        let near: Vec<(usize, usize)> = self
            .after_mapping()
            .flat_map(|index| (0..self.fire_doors.len()).map(move |door| (index, door)))
            .filter(|&(index, door)| {
                let pose = self.path.poses()[index].pose;
                let place = Point2::new(pose.x_m, pose.y_m);
                self.fire_doors[door].distance_m(&place) <= VICINITY_M
            })
            .collect();
        let chosen = spread(count, &near, random).ok_or_else(|| {
            Error::work(format!(
                "people: `fire_doors_opened` is {count}, but after mapping the robot is never within {VICINITY_M} m of \
                 a fire door; expected one there"
            ))
        })?;
        let [least_s, most_s] = self.config.opened_s;
        for (index, door) in chosen {
            let from_s = self.path.poses()[index].stamp_s;
            let until_s = from_s + least_s + (most_s - least_s) * random.random::<f64>();
            self.openings.push((door, from_s, until_s));
        }
        Ok(())
    }
}

/// So many of the possible ones, each drawn from its own share of them in their order; `None` where there are none.
fn spread<T: Copy>(count: usize, possible: &[T], random: &mut Stream) -> Option<Vec<T>> {
    if count > 0 && possible.is_empty() {
        return None;
    }
    let drawn = (0..count).map(|number| {
        let share = (number as f64 + random.random::<f64>()) / count as f64;
        possible[((share * possible.len() as f64) as usize).min(possible.len() - 1)]
    });
    Some(drawn.collect())
}
