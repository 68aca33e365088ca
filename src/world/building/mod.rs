//! Buildings and robots from files: one TOML a world.
//!
//! [`WorldConfig`] holds the file's keys; [`Building`] is the world they describe, checked: every name is known and every
//! number within its bounds. Lengths are metres, angles degrees where the key
//! ends in `_deg` (radians where it ends in `_rad`). An unknown key is an error.

mod config;
mod days;
mod fixture;
mod furnishing;
mod journey;
mod landmarks;
mod material;
mod polyline;
mod sensors;
mod sets;
#[cfg(test)]
mod tests;
mod wall;

use crate::{
    error::{Error, Result},
    seed::Seed,
    toml_file::TomlFile,
    world::{FloorPlan, Light, Material, PeopleConfig, RobotConfig, RunScene, Wall, map_server},
};
pub use config::{BuildingConfig, WorldConfig};
pub use days::DaysConfig;
use furnishing::Thing;
pub use furnishing::{FireDoorConfig, LightConfig, ThingConfig};
pub use journey::{Follow, PathConfig, RecordConfig, SetConfig};
pub(crate) use journey::{Journey, MAX_SNAPSHOTS, Spacing};
pub use material::MaterialConfig;
use material::Materials;
use polyline::Polyline;
use rand::RngExt;
use rand_distr::StandardNormal;
use sensors::Robot;
pub use sensors::SensorTables;
pub(crate) use sensors::Sensors;
pub(crate) use sets::RunSet;
use std::{ops::RangeInclusive, path::Path};
pub use wall::{
    DoorConfig, HallwayConfig, NicheConfig, PaintConfig, Side, WallConfig, WindowConfig,
};

/// A building, a robot and what it is to do, checked.
///
/// ```
/// use ballmark::{seed::Seed, world::building::Building};
/// let hall = Building::from_text(r#"
///     name = "hall"
///     [[wall]]
///     points = [[0, 0], [9, 0], [9, 4], [0, 4]]
///     closed = true
///     [sonar]
///     beams = 8
///     [path]
///     corners = [[1, 2], [8, 2]]
///     [record]
///     every_m = 0.5
/// "#)?;
/// assert_eq!(hall.plan_of_run(Seed(1), 0)?.plan.walls().len(), 4);
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Building {
    name: String,
    source: String,
    walls: Vec<Polyline>,
    map_walls: Vec<Wall>,
    things: Vec<Thing>,
    lights: Vec<Light>,
    fire_doors: Vec<Wall>,
    ceiling_m: f64,
    floor: Material,
    ceiling: Material,
    illumination_sd: f64,
    daylight: [f64; 2],
    robot: Robot,
    journey: Journey,
    sets: Vec<RunSet>,
    people: Option<PeopleConfig>,
    days: Option<DaysConfig>,
    wall_on_left: Option<bool>,
}

impl Building {
    /// Reads a world's file.
    ///
    /// # Errors
    /// Where it can't be read, or as [`Building::new`]; the message begins with the file's name.
    pub fn read(file: &Path) -> Result<Self> {
        Self::from_file(&TomlFile::read(file)?, file.parent())
    }

    /// The same from a text, which may name no map.
    ///
    /// # Errors
    /// As [`Building::new`].
    pub fn from_text(text: &str) -> Result<Self> {
        Self::from_file(&TomlFile::from_text(text), None)
    }

    fn from_file(text: &TomlFile, folder: Option<&Path>) -> Result<Self> {
        Self::new(&text.parse()?, folder).map_err(|fault| text.locate(fault))
    }

    /// Checks a world; a map's file is looked for in `folder`.
    ///
    /// # Errors
    /// A usage error that names the table, the key, the fault and what was expected; for a map's file as its reader
    /// says it.
    pub fn new(config: &WorldConfig, folder: Option<&Path>) -> Result<Self> {
        if config.name.is_empty() {
            return Err(Error::usage("`name` is empty; expected the world's name"));
        }
        let materials = Materials::new(&config.materials)?;
        let building = &config.building;
        let place = "[building]";
        within(building.ceiling_m, "ceiling_m", 0.1..=1000.0, place)?;
        within(
            building.illumination_sd,
            "illumination_sd",
            0.0..=1.0,
            place,
        )?;
        let [dim, bright] = building.daylight;
        if !(0.0 <= dim && dim <= bright && bright <= 1.0) {
            return Err(Error::usage(format!(
                "{place}: `daylight` is [{dim}, {bright}]; expected a range within 0 to 1"
            )));
        }
        let wall = materials.named(&building.wall, place)?;
        let numbered = |index: usize| index + 1;
        let walls = config.wall.iter().enumerate();
        let walls = walls.map(|(i, entry)| Polyline::new(entry, numbered(i), &materials, wall));
        let things = config.thing.iter().enumerate();
        let things = things.map(|(i, entry)| Thing::new(entry, numbered(i), &materials));
        let lights = config.light.iter().enumerate();
        let lights = lights.map(|(i, entry)| entry.light(numbered(i)));
        let doors = config.fire_door.iter().enumerate();
        let doors = doors.map(|(i, entry)| entry.wall(numbered(i), &materials));
        let map_walls = match &building.map {
            None => Vec::new(),
            Some(map) => {
                let Some(folder) = folder else {
                    return Err(Error::usage(format!(
                        "{place}: `map` is {map}; expected a world's file that it lies beside"
                    )));
                };
                map_server::walls(&folder.join(map), wall)?
            }
        };
        if config.wall.is_empty() && map_walls.is_empty() {
            return Err(Error::usage(
                "no wall; expected at least one [[wall]], or a `map` in [building]",
            ));
        }
        let robot = Robot::new(&config.robot)?;
        let journey = config.path.journey()?;
        let sets = sets::of_file(config, &robot)?;
        for camera in sets.iter().filter_map(|set| set.sensors.camera.as_ref()) {
            let height_m = camera.config().height_m;
            if height_m >= building.ceiling_m {
                return Err(Error::usage(format!(
                    "[camera]: `height_m` is {height_m}; expected less than the ceiling's {}",
                    building.ceiling_m
                )));
            }
        }
        if let Some(people) = &config.people {
            people.check()?;
        }
        if let Some(days) = &config.days {
            days.check()?;
        }
        Ok(Self {
            name: config.name.clone(),
            source: config.source.clone(),
            walls: walls.collect::<Result<_>>()?,
            map_walls,
            things: things.collect::<Result<_>>()?,
            lights: lights.collect::<Result<_>>()?,
            fire_doors: doors.collect::<Result<_>>()?,
            ceiling_m: building.ceiling_m,
            floor: materials.named(&building.floor, place)?,
            ceiling: materials.named(&building.ceiling, place)?,
            illumination_sd: building.illumination_sd,
            daylight: building.daylight,
            journey,
            sets,
            robot,
            people: config.people.clone(),
            days: config.days.clone(),
            wall_on_left: match (config.path.side, config.path.follow) {
                (None, Follow::Wall) => Some(true),
                (side, _) => side.map(|side| side == Side::Left),
            },
        })
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The real building or paper it is modelled on, in words.
    pub fn source(&self) -> &str {
        &self.source
    }

    /// How its robot drives.
    pub fn robot(&self) -> &RobotConfig {
        &self.robot.config
    }

    /// Names of its sets; none where the file has no `[[set]]`.
    pub fn set_names(&self) -> Vec<&str> {
        let names = self.sets.iter().map(|set| set.name.as_str());
        names.filter(|name| !name.is_empty()).collect()
    }

    pub(crate) fn sets(&self) -> &[RunSet] {
        &self.sets
    }

    pub(crate) fn journey(&self) -> &Journey {
        &self.journey
    }

    /// Is the wall that runs of a set keep beside them on the left, if they do, on the way there?
    pub(crate) fn wall_on_left(&self) -> Option<bool> {
        self.wall_on_left
    }

    pub(crate) fn people(&self) -> Option<&PeopleConfig> {
        self.people.as_ref()
    }

    pub(crate) fn turret_north(&self) -> bool {
        self.robot.turret_north
    }

    /// The building as run number `run` finds it: doors open or shut, things where they were left, lamps and daylight.
    ///
    /// # Errors
    /// Where a wall is out of the plan's bounds.
    pub fn plan_of_run(&self, seed: Seed, run: u64) -> Result<RunScene> {
        self.scene(seed, run, false)
    }

    /// The same with those doors shut that stay shut while the building is mapped.
    ///
    /// # Errors
    /// Where a wall is out of the plan's bounds.
    pub fn plan_while_mapping(&self, seed: Seed, run: u64) -> Result<RunScene> {
        self.scene(seed, run, true)
    }

    fn scene(&self, seed: Seed, run: u64, mapping: bool) -> Result<RunScene> {
        let Some(days) = &self.days else {
            let mut doors = seed.numbered_stream("world/building/doors", run);
            let mut things = seed.numbered_stream("world/building/things", run);
            let walls = self.walls(
                mapping,
                &mut || [doors.random(), doors.random()],
                &mut |thing, _| thing.walls(&mut things),
            );
            return self.lit(walls, self.lights.clone(), seed, run);
        };
        let day = days.day(run);
        let mut door = 0;
        let walls = self.walls(
            mapping,
            &mut || {
                let mut state = days.state(seed, "door", door, day);
                door += 1;
                [state.random(), state.random()]
            },
            &mut |thing, number| thing.walls(&mut days.state(seed, "thing", number, day)),
        );
        let lights = self.lights.iter().enumerate().map(|(number, light)| {
            let burns: f64 = days.state(seed, "lamp", number, day).random();
            Light {
                lit: light.lit && burns < days.lit,
                ..*light
            }
        });
        self.lit(walls, lights.collect(), seed, day)
    }

    /// All walls: `door` draws how each door stands, `thing` where the things are, by their number.
    fn walls(
        &self,
        mapping: bool,
        door: &mut dyn FnMut() -> [f64; 2],
        thing: &mut dyn FnMut(&Thing, usize) -> Vec<Wall>,
    ) -> Vec<Wall> {
        let mut walls: Vec<Wall> = Vec::new();
        for line in &self.walls {
            walls.extend(line.walls(door, mapping));
        }
        walls.extend(&self.map_walls);
        for (number, each) in self.things.iter().enumerate() {
            walls.extend(thing(each, number));
        }
        walls
    }

    /// The scene that walls make in the light of a run, or of a day.
    fn lit(
        &self,
        walls: Vec<Wall>,
        lights: Vec<Light>,
        seed: Seed,
        number: u64,
    ) -> Result<RunScene> {
        let mut random = seed.numbered_stream("world/building/lights", number);
        let normal: f64 = random.sample(StandardNormal);
        let [dim, bright] = self.daylight;
        Ok(RunScene {
            plan: FloorPlan::new(walls)?,
            lights,
            illumination: (1.0 + self.illumination_sd * normal).max(0.1),
            daylight: dim + random.random::<f64>() * (bright - dim),
            ceiling_m: self.ceiling_m,
            floor: self.floor,
            ceiling: self.ceiling,
            fire_doors: self.fire_doors.clone(),
        })
    }
}

/// Makes sure that a number lies in a range; the fault names its key and its place in the file.
fn within(value: f64, key: &str, expected: RangeInclusive<f64>, place: &str) -> Result<()> {
    if expected.contains(&value) {
        return Ok(());
    }
    Err(Error::usage(format!(
        "{place}: `{key}` is {value}; expected {} to {}",
        expected.start(),
        expected.end()
    )))
}
