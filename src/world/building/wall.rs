//! `[[wall]]`: a polyline, painted in stretches, with doors, windows, niches and hallways in it, as the file tells it.

use super::within;
use crate::error::{Error, Result};
use serde::Deserialize;

/// A side, seen along the way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// Left of it.
    Left,
    /// Right of it.
    #[default]
    Right,
}

/// A polyline of wall; positions of what is in it count in metres along it from its first point.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct WallConfig {
    /// At least two, metres.
    pub points: Vec<[f64; 2]>,
    /// Does it return to its first point?
    pub closed: bool,
    /// What it is made of.
    pub material: Option<String>,
    /// Where rooms and niches lie, seen along the points.
    pub behind: Side,
    /// Where it begins above the floor, metres.
    pub low_m: f64,
    /// Where it ends, metres; without it at the ceiling.
    pub high_m: Option<f64>,
    /// Stretches of another material.
    pub paint: Vec<PaintConfig>,
    /// Doors.
    pub door: Vec<DoorConfig>,
    /// Windows.
    pub window: Vec<WindowConfig>,
    /// Niches, and what stands out of the wall.
    pub niche: Vec<NicheConfig>,
    /// Hallways that branch off.
    pub hallway: Vec<HallwayConfig>,
}

/// A stretch of another material; where two overlap, the later one is seen.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PaintConfig {
    /// Where it begins, metres along the polyline.
    pub from_m: f64,
    /// Where it ends.
    pub to_m: f64,
    /// Its material.
    pub material: String,
}

/// A door with a room behind it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DoorConfig {
    /// Where it begins, metres along the polyline.
    pub at_m: f64,
    /// Width, metres.
    pub width_m: f64,
    /// Probability that it stands open in a run.
    #[serde(default)]
    pub open: f64,
    /// How far it stands open then, degrees: drawn evenly from this range.
    #[serde(default = "opened_deg")]
    pub opened_deg: [f64; 2],
    /// How deep it lies in the wall, metres.
    #[serde(default = "setback_m")]
    pub setback_m: f64,
    /// Depth of the room behind it, metres.
    #[serde(default = "room_depth_m")]
    pub room_depth_m: f64,
    /// How far the room reaches before the door along the wall, metres; without it 1.8, or halfway to what is there.
    pub room_before_m: Option<f64>,
    /// How far it reaches past the door.
    pub room_after_m: Option<f64>,
    /// Material of the leaf; without it wood.
    pub leaf: Option<String>,
    /// Material of the frame; without it steel.
    pub frame: Option<String>,
    /// Does it stay shut while the building is mapped?
    #[serde(default)]
    pub shut_while_mapping: bool,
}

/// A window: a pane set back in the wall, between sill and head.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WindowConfig {
    /// Where it begins, metres along the polyline.
    pub at_m: f64,
    /// Width, metres.
    pub width_m: f64,
    /// Height of its lower edge, metres.
    #[serde(default = "sill_m")]
    pub sill_m: f64,
    /// Height of its upper edge, metres.
    #[serde(default = "head_m")]
    pub head_m: f64,
    /// How deep the pane lies in the wall, metres.
    #[serde(default = "pane_depth_m")]
    pub depth_m: f64,
    /// Material of the pane; without it glass.
    pub pane: Option<String>,
}

/// A niche with a back of its own material (an elevator, a cupboard); with a negative depth it stands out of the wall
/// (a pilaster, a blackboard, a fountain).
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NicheConfig {
    /// Where it begins, metres along the polyline.
    pub at_m: f64,
    /// Width, metres.
    pub width_m: f64,
    /// Depth behind the face of the wall, metres.
    pub depth_m: f64,
    /// Material of its back, where it stands out of all its faces; without it that of the wall.
    pub back: Option<String>,
    /// Height of its lower edge, metres.
    #[serde(default)]
    pub low_m: f64,
    /// Height of its upper edge, metres; without it the ceiling.
    pub high_m: Option<f64>,
}

/// A hallway that branches off, with a wall at its end.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HallwayConfig {
    /// Where it begins, metres along the polyline.
    pub at_m: f64,
    /// Width, metres.
    pub width_m: f64,
    /// Length, metres.
    pub depth_m: f64,
}

fn opened_deg() -> [f64; 2] {
    [50.0, 100.0]
}
fn setback_m() -> f64 {
    0.12
}
fn room_depth_m() -> f64 {
    4.2
}
fn sill_m() -> f64 {
    0.9
}
fn head_m() -> f64 {
    2.1
}
fn pane_depth_m() -> f64 {
    0.15
}

impl DoorConfig {
    pub(super) fn check(&self, place: &str) -> Result<()> {
        within(self.open, "open", 0.0..=1.0, place)?;
        within(self.setback_m, "setback_m", 0.0..=10.0, place)?;
        within(self.room_depth_m, "room_depth_m", 0.01..=1000.0, place)?;
        for (key, value) in [
            ("room_before_m", self.room_before_m),
            ("room_after_m", self.room_after_m),
        ] {
            within(value.unwrap_or(0.0), key, 0.0..=1000.0, place)?;
        }
        let [least, most] = self.opened_deg;
        if !(0.0 <= least && least <= most && most <= 180.0) {
            return Err(Error::usage(format!(
                "{place}: `opened_deg` is [{least}, {most}]; expected a range within 0 to 180"
            )));
        }
        Ok(())
    }
}
