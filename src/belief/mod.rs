//! Where the robot may be.

pub mod places;
pub mod prior;

pub use places::Places;
pub use prior::Uncertainty;
