//! Simulated buildings and robots that yield Recordings, which nothing downstream can tell from logged ones.
//!
//! Read in this order: a [`FloorPlan`] is made of walls, each of a material; [`wall_line`] puts doors, windows and
//! side hallways into a wall; [`enclosure`] makes sure that the robot can't get out; a [`Raycaster`] says what a ray
//! hits first; a [`Sonar`] ring hears echoes along such rays; a [`robot`] drives a [`Route`] and
//! dead-reckons; [`simulation`] lets it do so run after run and records; [`corridor`] is Thrun's 89 metres.

pub mod camera;
pub mod corridor;
mod echo;
pub mod enclosure;
pub mod floor_plan;
mod look;
pub mod odometry;
pub mod raycast;
pub mod robot;
pub mod route;
mod scene;
pub mod simulation;
pub mod sonar;
mod surroundings;
pub mod wall_line;

pub use camera::{Camera, CameraConfig};
pub use floor_plan::{FloorPlan, Material, Wall};
pub use look::Look;
pub use odometry::OdometryConfig;
pub use raycast::{Hit, Raycaster};
pub use robot::{RobotConfig, Stop};
pub use route::Route;
pub use scene::{Light, RunScene};
pub use simulation::simulate;
pub use sonar::{Sonar, SonarConfig};
pub use surroundings::Surroundings;
pub use wall_line::{Opening, OpeningKind, Room, WallLine};
