//! Cross-talk: a sonar hears another's pulse and takes it for its own.
//!
//! Sonar j sends at t_j; its sound makes a way w over one or more surfaces to transducer i, which has listened since
//! t_i. Sonar i takes half of what sound travels from t_i until then for the range: (w + c (t_j − t_i)) / 2. Of all it
//! hears, the first counts. So two that fire at once hear each other's echoes in a corner or between close walls, and
//! one that fires soon after another hears the late echoes of that one.

use super::{
    SonarConfig,
    config::speed_of_sound_m_per_s,
    echo::{STEP_BACK_M, Transducer, cone, mirrored},
    loudness::{excess_db, heard_m, incidence_db, off_axis_db},
};
use crate::world::Surroundings;
use nalgebra::{Point2, Vector2};

/// Replaces each sonar's own echo by another's pulse where that is heard first. `times_s`: when each one sends.
pub(super) fn add(
    around: &Surroundings,
    sonar: &SonarConfig,
    ring: &[Transducer],
    times_s: &[f64],
    echoes_m: &mut [Option<f64>],
) {
    let speed_m_per_s = speed_of_sound_m_per_s(sonar.air_celsius);
    for (sender, transducer) in ring.iter().enumerate() {
        let mut hear = |listener: usize, way_m: f64| {
            let head_start_m = speed_m_per_s * (times_s[sender] - times_s[listener]);
            let range_m = (way_m + head_start_m) / 2.0;
            let listens = range_m >= sonar.minimum_m && range_m < sonar.maximum_m;
            if listens && echoes_m[listener].is_none_or(|metres| range_m < metres) {
                echoes_m[listener] = Some(range_m);
            }
        };
        for (direction, share) in cone(sonar, transducer) {
            let loss_db = off_axis_db(sonar, share);
            follow(around, sonar, ring, sender, (direction, loss_db), &mut hear);
        }
    }
}

/// Follows one ray of the sender's cone and tells every other sonar that hears it, with the way made until there. It leaves with a
/// loss against the cone's middle.
fn follow(
    around: &Surroundings,
    sonar: &SonarConfig,
    ring: &[Transducer],
    sender: usize,
    (mut direction, loss_db): (Vector2<f64>, f64),
    hear: &mut impl FnMut(usize, f64),
) {
    let mut origin = ring[sender].place;
    let mut way_m = 0.0;
    let mut heard_to_m = sonar.maximum_m;
    let others = || ring.iter().enumerate().filter(|(beam, _)| *beam != sender);
    let faces = |listener: &Transducer, coming: &Vector2<f64>| {
        -coming.dot(&listener.axis()) >= (sonar.opening_rad / 2.0).cos()
    };
    // The way that a listener reckons with, if what comes in from there is loud enough.
    let heard =
        |listener: &Transducer, coming: &Vector2<f64>, way_m: f64, limit_m, thrown_db: f64| {
            let aside_rad = (-coming.dot(&listener.axis())).clamp(-1.0, 1.0).acos();
            let half_rad = (sonar.opening_rad / 2.0).max(f64::MIN_POSITIVE);
            let all_db = loss_db + off_axis_db(sonar, aside_rad / half_rad) + thrown_db;
            let excess_db = excess_db(sonar, way_m / 2.0, limit_m) + listener.fade_db - all_db;
            heard_m(sonar, way_m / 2.0, excess_db).map(|range_m| 2.0 * range_m)
        };
    for reflected in 0..=sonar.reflections {
        let hit = around.cast(&origin, &direction, 2.0 * sonar.maximum_m, sonar.height_m);
        // A ray that mirrors have thrown past a transducer is heard, if it faces it.
        for (beam, listener) in others().filter(|_| reflected >= 1) {
            let to_listener = listener.place - origin;
            let listener_m = to_listener.dot(&direction);
            let near = (to_listener - direction * listener_m).norm() <= sonar.capture_radius_m;
            let free = hit.is_none_or(|hit| hit.distance_m >= listener_m);
            if listener_m > 0.0
                && near
                && free
                && faces(listener, &direction)
                && let Some(way_m) =
                    heard(listener, &direction, way_m + listener_m, heard_to_m, 0.0)
            {
                hear(beam, way_m);
            }
        }
        let Some(hit) = hit else { return };
        let material = around.wall(&hit).material;
        way_m += hit.distance_m;
        heard_to_m *= material.reflectivity;
        if way_m >= 2.0 * heard_to_m {
            return;
        }
        let critical_rad = material.critical_angle_rad;
        let spread_cos = critical_rad.cos();
        if hit.cos_incidence >= spread_cos {
            // A surface met within its critical angle throws sound back into that angle, on whoever listens there.
            let foot: Point2<f64> = origin + direction * (hit.distance_m - STEP_BACK_M);
            for (beam, listener) in others() {
                let to_listener = listener.place - foot;
                let listener_m = to_listener.norm();
                let coming = to_listener / listener_m;
                let leaving_cos = hit.normal.dot(&coming);
                if leaving_cos >= spread_cos && faces(listener, &coming) {
                    let angles = [hit.cos_incidence, leaving_cos];
                    let thrown_db = angles.map(|cos| incidence_db(sonar, cos, critical_rad) / 2.0);
                    let way_m = way_m + listener_m;
                    let thrown_db = thrown_db[0] + thrown_db[1];
                    if let Some(way_m) = heard(listener, &coming, way_m, heard_to_m, thrown_db)
                        && around
                            .cast(&foot, &coming, listener_m, sonar.height_m)
                            .is_none()
                    {
                        hear(beam, way_m);
                    }
                }
            }
            return;
        }
        (origin, direction) = mirrored(&origin, &direction, &hit);
    }
}

#[cfg(test)]
mod tests {
    use crate::world::{
        Material, SonarConfig, Wall,
        sonar::tests::{close, exact, scan, upright},
    };
    use nalgebra::Point2;

    fn dull() -> Material {
        Material {
            reflectivity: 0.01,
            ..Material::PLAIN
        }
    }

    /// Eight sonars, 0.3 m from the centre.
    fn wide_ring(opening_deg: f64) -> SonarConfig {
        exact(SonarConfig {
            beams: 8,
            ring_radius_m: 0.3,
            opening_rad: opening_deg.to_radians(),
            rays: 801,
            ..SonarConfig::default()
        })
    }

    #[test]
    fn a_later_sonar_takes_an_earlier_ones_echo_for_its_own() {
        let firing_after = |firing_interval_s| SonarConfig {
            firing: vec![vec![0, 2, 4, 6], vec![1, 3, 5, 7]],
            firing_interval_s,
            ..wide_ring(60.0)
        };
        let wall = || vec![upright(2.0, 0.8)];
        let quiet = scan(wide_ring(60.0), wall());
        // Sonar 1, at 0.3 m (cos 45°, sin 45°), meets the wall at the edge of its cone, 15° off the normal.
        let at_m = 0.3 * std::f64::consts::FRAC_1_SQRT_2;
        let own_m = (2.0 - at_m) / 15_f64.to_radians().cos();
        assert!(close(quiet[1], own_m, 1e-4), "{}", quiet[1]);
        // Sonar 0's sound is scattered there too: on its way from (0.3, 0) to that spot and on to sonar 1.
        let spot_m = at_m + (2.0 - at_m) * 15_f64.to_radians().tan();
        let way_m = 1.7_f64.hypot(spot_m) + own_m;
        let together = scan(firing_after(0.0), wall());
        assert!(close(together[1], way_m / 2.0, 1e-3), "{}", together[1]);
        // Fired 5 ms later, sonar 1 has listened for 5 ms less: 1.7162 m of sound at 343.2 m/s.
        let later = scan(firing_after(0.005), wall());
        let expected_m = (way_m - 0.005 * 343.2) / 2.0;
        assert!(close(later[1], expected_m, 1e-3), "{}", later[1]);
        assert_eq!(
            later[0], quiet[0],
            "the one that fires first hears nothing sooner"
        );
        assert!(later[3..6].iter().all(|metres| metres.is_nan()));
        // A dull board that hides all of the wall from sonar 1, and none of where sonar 0's sound arrives.
        let hiding = Wall::new(Point2::new(1.0, 0.3), Point2::new(1.0, 5.0), dull());
        let hidden = scan(firing_after(0.0), vec![upright(2.0, 0.8), hiding]);
        assert!(hidden[1].is_nan(), "{}", hidden[1]);
        // After 60 ms, 20.6 m of sound, the air is quiet.
        assert_eq!(scan(firing_after(0.06), wall())[..2], quiet[..2]);
    }

    #[test]
    fn mirrors_throw_a_pulse_at_another_sonar_unless_something_stands_between() {
        let firing = SonarConfig {
            firing: vec![(0..8).collect()],
            ..wide_ring(100.0)
        };
        // Sonar 1 seen in the mirror stands at 4 m − 0.2121, 0.2121 aside of sonar 0's height.
        let at_m = 0.3 * std::f64::consts::FRAC_1_SQRT_2;
        let way_m = (4.0 - at_m - 0.3).hypot(at_m);
        let heard = scan(firing.clone(), vec![upright(2.0, 0.02)]);
        assert!(close(heard[1], way_m / 2.0, 5e-3), "{}", heard[1]);
        let quiet = scan(wide_ring(100.0), vec![upright(2.0, 0.02)]);
        assert!(close(quiet[1], 2.0 - at_m, 1e-3), "{}", quiet[1]);
        // A board ahead of sonar 0, too dull to be heard itself, takes its sound away; sonar 1 is left with its own.
        let board = |y1_m, y2_m| Wall::new(Point2::new(1.0, y1_m), Point2::new(1.0, y2_m), dull());
        let hidden = scan(firing.clone(), vec![upright(2.0, 0.02), board(-0.9, 0.15)]);
        assert!(close(hidden[1], 2.0 - at_m, 1e-3), "{}", hidden[1]);
        // Sound on its way to the mirror passes at a height of 0.04 m, on its way back at 0.16 m: a board before sonar 1
        // takes all away.
        let narrow = SonarConfig {
            capture_radius_m: 0.05,
            ..firing
        };
        let hidden = scan(narrow, vec![upright(2.0, 0.02), board(0.06, 0.25)]);
        assert!(hidden[1].is_nan(), "{}", hidden[1]);
    }
}
