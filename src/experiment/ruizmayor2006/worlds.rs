//! The paper's worlds, and worlds that differ from them in one respect.

use serde::{Deserialize, Serialize};

/// How far pilasters stand out of a wall, in metres.
const PILASTER_M: f64 = 0.2;
/// They keep this far from the ends of the corridor, where the robot's way comes near its walls.
const FREE_END_M: f64 = 4.0;
/// The long walls of R3 (configs/worlds/ruizmayor2006-r3.toml), each from west to east, its other wall to the left or to the right.
const LONG_WALLS: [([f64; 2], [f64; 2], f64); 2] = [
    ([0.5, 5.0], [23.216, -16.183], 1.0),
    ([3.017, 7.699], [25.732, -13.484], -1.0),
];

/// In which worlds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Worlds {
    /// As they stand in the files.
    AsTheyAre,
    /// With sonars that read up to so many metres.
    LongestReadingM(f64),
    /// With pilasters so many metres apart in R3.
    PilastersEveryM(f64),
}

impl Worlds {
    /// What is added to the file of a run.
    pub(super) fn added(self, run: &str) -> String {
        match self {
            Worlds::AsTheyAre => String::new(),
            Worlds::LongestReadingM(m) => format!("\n[sonar]\nmaximum_m = {m:?}\n"),
            Worlds::PilastersEveryM(every_m) if run == "R3" => pilasters(every_m),
            Worlds::PilastersEveryM(_) => String::new(),
        }
    }
}

/// Walls that stand out of the long walls of R3, those of one wall midway between those of the other.
fn pilasters(every_m: f64) -> String {
    let mut walls = String::new();
    for (number, ([x_m, y_m], [to_x_m, to_y_m], side)) in LONG_WALLS.into_iter().enumerate() {
        let length_m = (to_x_m - x_m).hypot(to_y_m - y_m);
        let (along, across) = (
            [(to_x_m - x_m) / length_m, (to_y_m - y_m) / length_m],
            [
                -(to_y_m - y_m) / length_m * side,
                (to_x_m - x_m) / length_m * side,
            ],
        );
        let mut at_m = FREE_END_M + 0.5 * every_m * number as f64;
        while at_m < length_m - FREE_END_M {
            let [foot_x, foot_y] = [x_m + at_m * along[0], y_m + at_m * along[1]];
            let [tip_x, tip_y] = [
                foot_x + PILASTER_M * across[0],
                foot_y + PILASTER_M * across[1],
            ];
            walls += &format!("\n[[wall]]\npoints = [[{foot_x}, {foot_y}], [{tip_x}, {tip_y}]]\n");
            at_m += every_m;
        }
    }
    walls
}
