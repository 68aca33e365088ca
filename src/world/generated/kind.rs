//! Kinds of building, and how a plan of each is drawn.

use super::{
    bend::Bend, chance::Chance, corridor::corridor, glazing::glaze, hall::hall, office::office,
    plan::Plan, rooms::rooms,
};
use crate::{error::Result, world::bounds::Bounds};
use serde::{Deserialize, Serialize};

/// A kind of building.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PlanKind {
    /// Corridors that cross blocks of rooms.
    Office,
    /// Rooms cut from one another.
    Rooms,
    /// A long corridor, straight or a ring, with rooms behind its doors.
    Corridor,
    /// A hall with partitions and columns.
    Hall,
}

/// How often each kind is drawn, as weights: what counts is their share of the sum.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct KindShares {
    /// Offices.
    pub office: f64,
    /// Rooms.
    pub rooms: f64,
    /// Long corridors.
    pub corridor: f64,
    /// Halls.
    pub hall: f64,
}

impl Default for KindShares {
    fn default() -> Self {
        Self {
            office: 0.35,
            rooms: 0.2,
            corridor: 0.25,
            hall: 0.2,
        }
    }
}

impl KindShares {
    /// Checks that none is negative and one is more than 0.
    ///
    /// # Errors
    /// A usage error that names the first one out of bounds.
    pub fn check(&self) -> Result<()> {
        let bounds = Bounds("[pretrain.buildings]");
        bounds.not_negative(&[
            ("shares.office", self.office),
            ("shares.rooms", self.rooms),
            ("shares.corridor", self.corridor),
            ("shares.hall", self.hall),
        ])?;
        bounds.positive(&[("shares", self.sum())])
    }

    fn sum(&self) -> f64 {
        self.office + self.rooms + self.corridor + self.hall
    }

    /// Draws a kind.
    pub(super) fn draw(&self, chance: &mut Chance) -> PlanKind {
        let at = chance.between(0.0, self.sum());
        if at < self.office {
            PlanKind::Office
        } else if at < self.office + self.rooms {
            PlanKind::Rooms
        } else if at < self.office + self.rooms + self.corridor {
            PlanKind::Corridor
        } else {
            PlanKind::Hall
        }
    }
}

impl PlanKind {
    /// Draws a plan of this kind; this share of its walls get a pane, and it is bent where asked for.
    pub(super) fn plan(self, glazed: f64, bent: bool, chance: &mut Chance) -> Plan {
        let mut plan = match self {
            PlanKind::Office => office(chance),
            PlanKind::Rooms => rooms(chance),
            PlanKind::Corridor => corridor(chance),
            PlanKind::Hall => hall(chance),
        };
        glaze(&mut plan, glazed, chance);
        if bent {
            plan.bent(Bend::draw(chance))
        } else {
            plan
        }
    }
}
