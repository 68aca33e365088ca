//! Sectors of one range sensor filled by the beams of another: which beams stand in each, by their bearings.

use crate::geometry::wrapped;

/// How far past half the angle between two beams a sector may still take the nearer one, as a share of that angle.
const SLACK: f64 = 0.05;

/// Beams of each of `sectors` sectors of a sensor with beams at `own_rad`, out of beams at `bearing_rad`: those within it, and where
/// there is none the nearest, unless that is farther off than beams are from one another. A sector that nothing looks into has
/// none. Both are radians in the robot's frame; `own_rad` ascend or descend, the others come in any order.
pub(super) fn beams_of_sectors(
    own_rad: &[f64],
    sectors: usize,
    bearing_rad: &[f64],
) -> Vec<Vec<usize>> {
    let apart_rad = |bearings: &[f64]| {
        let mut gaps: Vec<f64> = bearings
            .windows(2)
            .map(|pair| wrapped(pair[1] - pair[0]).abs())
            .collect();
        gaps.sort_by(f64::total_cmp);
        gaps.get(gaps.len() / 2).copied().unwrap_or(0.0)
    };
    let half_own_rad = apart_rad(own_rad) / 2.0;
    let mut sorted = bearing_rad.to_vec();
    sorted.sort_by(f64::total_cmp);
    let reach_rad = (0.5 + SLACK) * apart_rad(&sorted);
    (0..sectors)
        .map(|sector| {
            let own =
                &own_rad[sector * own_rad.len() / sectors..(sector + 1) * own_rad.len() / sectors];
            let (Some(&first), Some(&last)) = (own.first(), own.last()) else {
                return Vec::new();
            };
            let half_rad = wrapped(last - first).abs() / 2.0 + half_own_rad;
            let middle_rad = first + wrapped(last - first) / 2.0;
            let off_rad = |beam: usize| wrapped(bearing_rad[beam] - middle_rad).abs();
            // Half a sector's edge belongs to it: the lower beam of two that stand on edges.
            let within: Vec<usize> = (0..bearing_rad.len())
                .filter(|&beam| off_rad(beam) <= half_rad * (1.0 - 1e-6))
                .collect();
            if !within.is_empty() {
                return within;
            }
            (0..bearing_rad.len())
                .min_by(|&a, &b| off_rad(a).total_cmp(&off_rad(b)))
                .filter(|&beam| off_rad(beam) <= reach_rad.max(half_rad))
                .into_iter()
                .collect()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fan(beams: usize, view_deg: f64) -> Vec<f64> {
        let step = view_deg / (beams - 1) as f64;
        (0..beams)
            .map(|beam| (beam as f64 * step - view_deg / 2.0).to_radians())
            .collect()
    }

    #[test]
    fn the_same_beams_fill_their_own_sectors() {
        let own = fan(180, 179.0);
        let filled = beams_of_sectors(&own, 36, &own);
        let expected: Vec<Vec<usize>> = (0..36).map(|s| (5 * s..5 * s + 5).collect()).collect();
        assert_eq!(filled, expected);
    }

    #[test]
    fn twice_as_many_beams_fill_twice_and_in_the_other_order() {
        let own = fan(180, 179.0);
        let twice = beams_of_sectors(&own, 36, &fan(360, 179.5));
        assert!(twice.iter().all(|beams| (9..=11).contains(&beams.len())));
        let mut backwards = fan(180, 179.0);
        backwards.reverse();
        let filled = beams_of_sectors(&own, 36, &backwards);
        assert_eq!(filled[0], [175, 176, 177, 178, 179]);
    }

    #[test]
    fn twelve_beams_stand_in_three_sectors_each() {
        let bearings: Vec<f64> = (0..12)
            .map(|b| (-90.0 + 15.0 * (b as f64 + 0.5)).to_radians())
            .collect();
        let filled = beams_of_sectors(&fan(180, 179.0), 36, &bearings);
        for (sector, beams) in filled.iter().enumerate() {
            assert_eq!(beams, &[sector / 3], "{sector}");
        }
    }

    #[test]
    fn what_is_blocked_is_left_empty() {
        let own = fan(180, 179.0);
        let open: Vec<f64> = own
            .iter()
            .copied()
            .filter(|b| !(-0.5..0.0).contains(b))
            .collect();
        let filled = beams_of_sectors(&own, 36, &open);
        let empty = filled.iter().filter(|beams| beams.is_empty()).count();
        assert!((4..=6).contains(&empty), "{empty}"); // 29° of sectors of 5°
        assert!(beams_of_sectors(&own, 36, &[]).iter().all(Vec::is_empty));
    }
}
