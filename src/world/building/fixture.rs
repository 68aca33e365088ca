//! What is in a wall, checked: doors, and boxes behind the wall's face or in front of it.

use super::{material::Materials, wall::WallConfig, within};
use crate::{
    error::{Error, Result},
    world::{Material, Room},
};

/// Something in a straight stretch of wall: where it begins along it, how wide it is (metres), and what it is.
#[derive(Debug, Clone)]
pub(super) struct Fixture {
    pub(super) at_m: f64,
    pub(super) width_m: f64,
    pub(super) what: What,
}

/// What is in a wall.
#[derive(Debug, Clone)]
pub(super) enum What {
    Door(Box<Door>),
    /// Between two heights; a window, a niche, something that stands out.
    Box {
        depth_m: f64,
        back: Material,
        side: Material,
        low_m: f64,
        high_m: f64,
    },
    Hallway {
        depth_m: f64,
    },
}

/// A door that each run draws anew.
#[derive(Debug, Clone)]
pub(super) struct Door {
    pub(super) open: f64,
    pub(super) opened_rad: [f64; 2],
    pub(super) setback_m: f64,
    pub(super) room: Room,
    pub(super) leaf: Material,
    pub(super) frame: Material,
    pub(super) shut_while_mapping: bool,
}

/// Everything that the file puts into the wall, with what it calls it.
pub(super) fn fixtures(
    config: &WallConfig,
    own: Material,
    materials: &Materials,
    place: &str,
) -> Result<Vec<(&'static str, Fixture)>> {
    let mut all = Vec::new();
    let mut add = |kind, at_m, width_m, what| {
        all.push((
            kind,
            Fixture {
                at_m,
                width_m,
                what,
            },
        ));
    };
    let wood = materials.named("wood", place)?;
    let steel = materials.named("steel", place)?;
    let glass = materials.named("glass", place)?;
    for entry in &config.door {
        let place = format!("{place}: door at {} m", entry.at_m);
        let door = Door {
            open: entry.open,
            opened_rad: entry.opened_deg.map(f64::to_radians),
            setback_m: entry.setback_m,
            room: Room {
                before_m: 0.0,
                after_m: 0.0,
                depth_m: entry.room_depth_m,
            },
            leaf: materials.named_or(entry.leaf.as_ref(), wood, &place)?,
            frame: materials.named_or(entry.frame.as_ref(), steel, &place)?,
            shut_while_mapping: entry.shut_while_mapping,
        };
        entry.check(&place)?;
        add(
            "door",
            entry.at_m,
            entry.width_m,
            What::Door(Box::new(door)),
        );
    }
    for entry in &config.window {
        let place = format!("{place}: window at {} m", entry.at_m);
        upwards(entry.sill_m, entry.head_m, ["sill_m", "head_m"], &place)?;
        within(entry.depth_m, "depth_m", 0.0..=100.0, &place)?;
        let what = What::Box {
            depth_m: entry.depth_m,
            back: materials.named_or(entry.pane.as_ref(), glass, &place)?,
            side: own,
            low_m: entry.sill_m,
            high_m: entry.head_m,
        };
        add("window", entry.at_m, entry.width_m, what);
    }
    for entry in &config.niche {
        let place = format!("{place}: niche at {} m", entry.at_m);
        let high_m = entry.high_m.unwrap_or(f64::INFINITY);
        upwards(entry.low_m, high_m, ["low_m", "high_m"], &place)?;
        within(entry.depth_m, "depth_m", -100.0..=100.0, &place)?;
        let back = materials.named_or(entry.back.as_ref(), own, &place)?;
        let what = What::Box {
            depth_m: entry.depth_m,
            back,
            side: if entry.depth_m < 0.0 { back } else { own },
            low_m: entry.low_m,
            high_m,
        };
        add("niche", entry.at_m, entry.width_m, what);
    }
    for entry in &config.hallway {
        let place = format!("{place}: hallway at {} m", entry.at_m);
        within(entry.depth_m, "depth_m", 0.01..=1000.0, &place)?;
        let depth_m = entry.depth_m;
        add(
            "hallway",
            entry.at_m,
            entry.width_m,
            What::Hallway { depth_m },
        );
    }
    Ok(all)
}

/// Makes sure that a stretch goes upwards.
fn upwards(low_m: f64, high_m: f64, keys: [&str; 2], place: &str) -> Result<()> {
    if low_m >= 0.0 && low_m < high_m {
        return Ok(());
    }
    Err(Error::usage(format!(
        "{place}: `{}` is {low_m} and `{}` {high_m}; expected a stretch upwards from 0 or more",
        keys[0], keys[1]
    )))
}
