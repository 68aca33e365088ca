//! Simulated buildings and robots that yield Recordings, which nothing downstream can tell from logged ones.
//!
//! Read in this order: a [`FloorPlan`] is made of walls, each of a material; [`wall_line`] opens doors in a wall; [`enclosure`] makes sure that the robot can't get out; a [`Raycaster`] says what a ray
//! hits first; along such rays a [`Sonar`] ring hears echoes, an [`Infrared`] ring sees how much light comes back and a
//! [`Laser`] measures; [`people`] get in their way; a [`Compass`] tells the heading, with its [`unsteadiness`], and [`turret_headings`] how a turret
//! follows it; a [`Camera`] looks. A [`robot`] [drives](driving) a [`Route`], follows a wall or visits poses, and dead-reckons;
//! [`building`] reads all of this from a file, walls also from a [`map_server`] map; [`simulation`] lets the robot drive
//! run after run and records; [`corridor`] is Thrun's 89 metres. [`ExpectedRanges`] turn it round: what a robot with
//! the plan expects to measure. [`generated`] draws whole buildings, and runs through them, at random.

mod bounds;
pub mod building;
pub mod camera;
pub mod compass;
pub mod corridor;
pub mod driving;
pub mod enclosure;
mod expected_ranges;
pub mod floor_plan;
pub mod generated;
pub mod infrared;
pub mod laser;
mod look;
pub mod map_server;
pub mod odometry;
pub mod people;
pub mod raycast;
pub mod robot;
pub mod route;
mod scene;
pub mod simulation;
pub mod sonar;
mod surroundings;
mod timed_path;
mod turret;
pub mod unsteadiness;
mod visit;
mod wall_following;
pub mod wall_line;
mod way;

pub use building::{Building, WorldConfig};
pub use camera::{Camera, CameraConfig};
pub use compass::{Compass, CompassConfig};
pub use expected_ranges::ExpectedRanges;
pub use floor_plan::{FloorPlan, Material, Wall};
pub use infrared::{Infrared, InfraredConfig};
pub use laser::{Laser, LaserConfig};
pub use look::Look;
pub use odometry::OdometryConfig;
pub use people::{Outing, People, PeopleConfig};
pub use raycast::{Hit, Raycaster};
pub use robot::{RobotConfig, Stop};
pub use route::Route;
pub use scene::{Light, RunScene};
pub use simulation::simulate;
pub use sonar::{Sonar, SonarConfig};
pub use surroundings::Surroundings;
pub use timed_path::TimedPose;
pub use turret::{Turret, turret_headings};
pub use wall_line::{OpenDoor, Room, WallLine};
