//! Cross-talk: a sonar hears another's pulse and takes it for its own.
//!
//! Sonar j sends at t_j; its sound makes a way w over one or more surfaces to transducer i, which has listened since
//! t_i. Sonar i takes half of what sound travels from t_i until then for the range: (w + c (t_j − t_i)) / 2. Of all it
//! hears, the first counts. So two that fire at once hear each other's echoes in a corner or between close walls, and
//! one that fires soon after another hears the late echoes of that one.

use super::{SonarConfig, config::speed_of_sound_m_per_s};
use crate::world::{
    Surroundings,
    echo::{STEP_BACK_M, Transducer, cone, mirrored},
};
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
        for direction in cone(sonar, transducer) {
            follow(around, sonar, ring, sender, direction, &mut hear);
        }
    }
}

/// Follows one ray of the sender's cone and tells every other sonar that hears it, with the way made until there.
fn follow(
    around: &Surroundings,
    sonar: &SonarConfig,
    ring: &[Transducer],
    sender: usize,
    mut direction: Vector2<f64>,
    hear: &mut impl FnMut(usize, f64),
) {
    let mut origin = ring[sender].place;
    let mut way_m = 0.0;
    let mut heard_to_m = sonar.maximum_m;
    let others = || ring.iter().enumerate().filter(|(beam, _)| *beam != sender);
    let faces = |listener: &Transducer, coming: &Vector2<f64>| {
        -coming.dot(&listener.axis()) >= (sonar.opening_rad / 2.0).cos()
    };
    for reflected in 0..=sonar.reflections {
        let hit = around.cast(&origin, &direction, 2.0 * sonar.maximum_m, sonar.height_m);
        // A ray that mirrors have thrown past a transducer is heard, if it faces it.
        for (beam, listener) in others().filter(|_| reflected >= 1) {
            let there = listener.place - origin;
            let there_m = there.dot(&direction);
            let near = (there - direction * there_m).norm() <= sonar.capture_radius_m;
            let free = hit.is_none_or(|hit| hit.distance_m >= there_m);
            let strong = way_m + there_m < 2.0 * heard_to_m;
            if there_m > 0.0 && near && free && strong && faces(listener, &direction) {
                hear(beam, way_m + there_m);
            }
        }
        let Some(hit) = hit else { return };
        let material = around.wall(&hit).material;
        way_m += hit.distance_m;
        heard_to_m *= material.reflectivity;
        if way_m >= 2.0 * heard_to_m {
            return;
        }
        let spread_cos = material.critical_angle_rad.cos();
        if hit.cos_incidence >= spread_cos {
            // A surface met within its critical angle throws sound back into that angle, on whoever listens there.
            let foot: Point2<f64> = origin + direction * (hit.distance_m - STEP_BACK_M);
            for (beam, listener) in others() {
                let there = listener.place - foot;
                let there_m = there.norm();
                let coming = there / there_m;
                if hit.normal.dot(&coming) >= spread_cos
                    && faces(listener, &coming)
                    && way_m + there_m < 2.0 * heard_to_m
                    && around
                        .cast(&foot, &coming, there_m, sonar.height_m)
                        .is_none()
                {
                    hear(beam, way_m + there_m);
                }
            }
            return;
        }
        (origin, direction) = mirrored(&origin, &direction, &hit);
    }
}
