//! How loud an echo is against the threshold of the circuit that waits for it.
//!
//! An echo off a large surface falls with its way, by spreading as 1 / way and by absorption, and with the angles at which it leaves,
//! is thrown back and comes in. How far a surface is heard head-on, along the axis, is its material's; from there it is reckoned in
//! decibels. The circuit answers once the rising envelope crosses its threshold, so that what is hardly heard is also late (Kuc,
//! *Forward model for sonar maps produced with the Polaroid ranging module*, 2003).

use super::SonarConfig;

/// What an echo has above the threshold, dB, if it comes in after `range_m` along the axis and is still heard up to `heard_to_m`.
pub(super) fn excess_db(sonar: &SonarConfig, range_m: f64, heard_to_m: f64) -> f64 {
    20.0 * (heard_to_m / range_m).log10() + 2.0 * sonar.absorption_db_per_m * (heard_to_m - range_m)
}

/// What it loses where it leaves or comes in at a share of half the cone's opening from the axis, one way.
pub(super) fn off_axis_db(sonar: &SonarConfig, share: f64) -> f64 {
    sonar.edge_loss_db / 2.0 * share * share
}

/// What it loses where a surface throws it back within its critical angle.
pub(super) fn incidence_db(sonar: &SonarConfig, cos_incidence: f64, critical_rad: f64) -> f64 {
    if sonar.incidence_loss_db == 0.0 {
        return 0.0; // also where the critical angle is 0
    }
    let share = cos_incidence.clamp(-1.0, 1.0).acos() / critical_rad.max(f64::MIN_POSITIVE);
    sonar.incidence_loss_db * share * share
}

/// The range that is reported of an echo with so much above the threshold; none where it stays below.
pub(super) fn heard_m(sonar: &SonarConfig, range_m: f64, excess_db: f64) -> Option<f64> {
    (excess_db > 0.0).then(|| range_m + sonar.late_m * 10_f64.powf(-excess_db / 20.0))
}

#[cfg(test)]
mod tests {
    use crate::{
        geometry::Pose,
        seed::Seed,
        world::{
            FloorPlan, Material, Raycaster, Sonar, SonarConfig, Wall,
            sonar::tests::{exact, upright},
        },
    };
    use nalgebra::Point2;

    /// One sonar that looks along x, with the fading of a Nomad's.
    fn sonar(change: impl Fn(&mut SonarConfig)) -> Sonar {
        let mut config = SonarConfig {
            beams: 1,
            firing: Vec::new(),
            ring_radius_m: 0.0,
            rays: 101,
            maximum_m: 10.0,
            ..exact(SonarConfig::nomad200())
        };
        change(&mut config);
        Sonar::new(config).unwrap()
    }

    /// The share of readings with an echo of the wall, and their mean.
    fn heard(sonar: &Sonar, wall: Wall, pose: Pose) -> (f64, f64) {
        let caster = Raycaster::new(FloorPlan::new(vec![wall]).unwrap());
        let (around, mut random) = ((&caster).into(), Seed(3).stream("sonar"));
        let readings: Vec<f32> = (0..2000)
            .flat_map(|_| sonar.read(&around, &pose, &mut random))
            .filter(|metres| !metres.is_nan())
            .collect();
        let sum: f64 = readings.iter().map(|&metres| f64::from(metres)).sum();
        (readings.len() as f64 / 2000.0, sum / readings.len() as f64)
    }

    /// A mirror whose echo ends at 5 m.
    fn mirror(x_m: f64) -> Wall {
        let material = Material {
            reflectivity: 0.5,
            critical_angle_rad: 0.001,
            ..Material::PLAIN
        };
        Wall::new(Point2::new(x_m, -9.0), Point2::new(x_m, 9.0), material)
    }

    #[test]
    fn echoes_come_and_go_around_the_range_at_which_they_end() {
        let sonar = sonar(|_| {});
        let share = |x_m| heard(&sonar, mirror(x_m), Pose::default()).0;
        // 20 log10(5 / 4) + 3.28 dB for the metre: 5.2 dB above the threshold, 1.74 standard deviations.
        assert!((share(4.0) - 0.959).abs() < 0.02, "{}", share(4.0));
        assert!((share(5.0) - 0.5).abs() < 0.045, "{}", share(5.0));
        // −0.83 and −1.64 dB: 0.82 below.
        assert!((share(5.5) - 0.206).abs() < 0.035, "{}", share(5.5));
        assert_eq!((share(1.0), share(9.0)), (1.0, 0.0));
    }

    #[test]
    fn a_mirror_is_heard_the_less_aside_the_farther_it_is() {
        let sonar = sonar(|c| c.fading_db = 0.0);
        let within_deg = |x_m: f64| {
            let seen = |deg: &i32| {
                let pose = Pose::new(0.0, 0.0, f64::from(*deg).to_radians() / 4.0);
                heard(&sonar, mirror(x_m), pose).0 == 1.0
            };
            f64::from((0..60).take_while(seen).count() as i32 - 1) / 4.0
        };
        // 33 dB (θ / 12.5°)² against 1.9 + 3.3 · 1, and 14 + 13 dB above the threshold, to a ray's quarter of a degree.
        assert!((within_deg(4.0) - 4.97).abs() <= 0.3, "{}", within_deg(4.0));
        assert!((within_deg(1.0) - 11.3).abs() <= 0.3, "{}", within_deg(1.0));
    }

    #[test]
    fn a_rough_wall_is_softer_at_a_slant_and_late_where_it_is_hardly_heard() {
        let sonar = sonar(|c| (c.fading_db, c.edge_loss_db, c.rays) = (0.0, 0.0, 1));
        let wall = |critical_rad| upright(2.0, critical_rad);
        let slanting = Pose::new(0.0, 0.0, 0.2);
        let ahead = heard(&sonar, wall(0.4), Pose::default()).1;
        // Reflectivity 1: heard to 10 m. 13.98 + 26.24 dB above: a hundredth of the pulse late.
        assert!(
            (ahead - 2.0 - 0.056 * 10_f64.powf(-40.22 / 20.0)).abs() < 1e-5,
            "{ahead}"
        );
        let (share, slant) = heard(&sonar, wall(0.4), slanting);
        // (0.2 / 0.4)² of 12 dB less, and 2 m / cos 0.2 away.
        let away: f64 = 2.0 / 0.2_f64.cos();
        let excess = 20.0 * (10.0 / away).log10() + 3.28 * (10.0 - away) - 3.0;
        let expected = away + 0.056 * 10_f64.powf(-excess / 20.0);
        assert!(
            share == 1.0 && (slant - expected).abs() < 1e-5,
            "{slant} {expected}"
        );
        assert!(heard(&sonar, wall(0.19), slanting).0 == 0.0);
    }

    #[test]
    fn without_fading_nothing_but_the_range_counts_and_no_number_is_drawn() {
        let drawn = |fading_db| {
            let sonar = sonar(|c| c.fading_db = fading_db);
            let caster = Raycaster::new(FloorPlan::new(vec![upright(2.0, 0.4)]).unwrap());
            let mut random = Seed(4).stream("sonar");
            sonar.read(&(&caster).into(), &Pose::default(), &mut random);
            rand::RngExt::random::<u64>(&mut random)
        };
        let mut random = Seed(4).stream("sonar");
        super::super::Chance::draw(&mut random);
        assert_eq!(drawn(0.0), rand::RngExt::random::<u64>(&mut random));
        assert_ne!(drawn(0.0), drawn(3.0));
    }
}
