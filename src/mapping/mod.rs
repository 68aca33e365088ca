//! The plan that range sensors draw: what an ordinary user of a laser scanner has before any learning.
//!
//! An [`OccupancyMap`] is made from the scans of a recording at their poses; a [`LikelihoodField`] (Thrun, Burgard & Fox,
//! *Probabilistic Robotics*, 2005, table 6.3) says how well a beam's end fits to it. Together they are the rival that
//! learned landmarks have to beat wherever a plan predicts the sensor.

mod candidates;
mod distance;
mod fit;
mod likelihood_field;
mod occupancy_map;
mod range_sensors;
mod raycast;
mod render;
mod ros_map;

pub use candidates::{drawn_maps, rendered_as};
pub use fit::{check_fits, read_fitting};
pub use likelihood_field::{Beam, LikelihoodField, LikelihoodFieldConfig};
pub use occupancy_map::{Occupancy, OccupancyMap, OccupancyMapConfig};
pub use range_sensors::{RangeBeam, RangeSensors};
pub use render::{RenderConfig, Rendered, Renderer};
pub use ros_map::RosMap;
