use super::*;
use crate::{
    belief::{GridConfig, Places},
    seed::Seed,
};

/// Within 10 m of the origin.
fn grid() -> Grid {
    let config = GridConfig {
        margin_m: 10.0,
        headings: 1,
        ..GridConfig::default()
    };
    Grid::over(&Places::Plane(vec![Pose::default()]), &config).unwrap()
}

fn weighted(weights: &[f64]) -> Particles {
    let poses = (0..weights.len()).map(|k| Pose::new(k as f64, 0.0, 0.0));
    let mut particles = Particles::new(poses.collect());
    let log: Vec<f64> = weights.iter().map(|w| w.ln()).collect();
    particles.correct(&log);
    particles
}

#[test]
fn draws_are_in_proportion_however_many_there_are() {
    let particles = weighted(&[0.05, 0.5, 0.0, 0.15, 0.3]);
    for draws in [20, 137, 1000] {
        for first in [0.0, 0.3, 0.999_999] {
            let mut counts = [0.0; 5];
            for pose in particles.draws(first).take(draws) {
                counts[pose.x_m as usize] += 1.0;
            }
            for (count, weight) in counts.iter().zip([0.05, 0.5, 0.0, 0.15, 0.3]) {
                let off = (count - weight * draws as f64).abs();
                assert!(off < 3.0, "{counts:?}"); // independent draws scatter by 15 in a thousand
            }
        }
    }
}

#[test]
fn movements_scatter_as_the_motion_model_says() {
    let (motion, mut stream) = (OdometryMotion::default(), Seed(1).stream("noise"));
    let start = Pose::new(1.0, -1.0, 2.0);
    let step = Displacement {
        forward_m: 2.0,
        left_m: 0.5,
        turn_rad: 0.8,
    };
    let count = 20_000;
    let mut particles = Particles::new(vec![start; count]);
    particles.advance(&grid(), &motion, &step, &mut stream);
    let there = start.after(step);
    let (mut mean, mut variance) = ([0.0; 3], [0.0; 3]);
    for pose in particles.poses() {
        let off = [
            pose.x_m - there.x_m,
            pose.y_m - there.y_m,
            wrapped(pose.heading_rad - there.heading_rad),
        ];
        for axis in 0..3 {
            mean[axis] += off[axis] / count as f64;
            variance[axis] += off[axis] * off[axis] / count as f64;
        }
    }
    let m2 = motion.position_variance_m2(&step);
    let rad2 = motion.heading_variance_rad2(&step);
    for (axis, expected) in [m2, m2, rad2].into_iter().enumerate() {
        assert!(mean[axis].abs() < 0.005, "{mean:?}");
        assert!(
            (variance[axis] / expected - 1.0).abs() < 0.05,
            "{variance:?}"
        );
    }
}

#[test]
fn nobody_leaves_the_grid() {
    let motion = OdometryMotion {
        stall_probability: 0.01,
        ..OdometryMotion::default()
    };
    let mut stream = Seed(1).stream("noise");
    let step = Displacement {
        forward_m: 3.0,
        ..Displacement::default()
    };
    // One would drive off the grid, one has room.
    let mut particles = Particles::new(vec![Pose::new(9.0, 0.0, 0.0), Pose::new(0.0, 0.0, 0.0)]);
    particles.advance(&grid(), &motion, &step, &mut stream);
    assert!(
        particles
            .poses()
            .iter()
            .all(|pose| grid().cell_of(pose).is_some())
    );
    let posterior = particles.posterior();
    assert!(
        (posterior[0].1 - 0.01 / 1.01).abs() < 1e-12,
        "{posterior:?}"
    );
    // Where all would, odometry is wrong, and they stay as probable as they were.
    let mut particles = Particles::new(vec![Pose::new(9.0, 0.0, 0.0), Pose::new(9.5, 0.0, 0.0)]);
    particles.advance(&grid(), &motion, &step, &mut stream);
    assert!((particles.effective_number() - 2.0).abs() < 1e-12);
}

#[test]
fn a_correction_is_the_rule_of_bayes() {
    let mut particles = weighted(&[0.5, 0.3, 0.2]);
    let likelihood = [0.1_f64, 0.4, 0.0];
    let log: Vec<f64> = likelihood.iter().map(|l| l.ln() - 2000.0).collect();
    let predictive = 0.05 + 0.12;
    let said = particles.correct(&log);
    assert!((said + 2000.0 - f64::ln(predictive)).abs() < 1e-9, "{said}");
    let posterior = particles.posterior();
    assert_eq!(posterior.len(), 2); // what is impossible is left out
    assert!((posterior[0].1 - 0.05 / predictive).abs() < 1e-12);
    let effective = 0.17 * 0.17 / (0.05 * 0.05 + 0.12 * 0.12);
    assert!((particles.effective_number() - effective).abs() < 1e-9);
}

#[test]
fn the_heaviest_place_is_one_of_two_and_not_between_them() {
    let posterior = [
        ([0.1, 0.1], 0.3),
        ([0.6, 0.1], 0.1), // in the next bin
        ([5.1, 0.1], 0.35),
        ([9.0, 9.0], 0.25),
    ];
    let [x_m, y_m] = heaviest_place(&posterior, 0.5).unwrap();
    assert!((x_m - 0.09 / 0.4).abs() < 1e-12 && (y_m - 0.1).abs() < 1e-12);
    assert_eq!(heaviest_place(&[], 0.5), None);
}

#[test]
fn the_heading_is_of_the_heaviest_cluster_at_the_place() {
    let particle = |x_m: f64, heading_rad: f64| Pose::new(x_m, 0.0, heading_rad);
    let poses = vec![
        particle(0.0, 0.1),
        particle(0.2, -0.1), // on the other side of a border between bins
        particle(0.1, 3.0),
        particle(5.0, 1.0),
    ];
    let weights = vec![0.2, 0.2, 0.25, 0.35];
    let particles = Particles { poses, weights };
    let heading = |x_m: f64| particles.heading_about([x_m, 0.0], 0.75, 10_f64.to_radians());
    assert!(heading(0.1).unwrap().abs() < 1e-12, "{:?}", heading(0.1));
    assert!((heading(5.0).unwrap() - 1.0).abs() < 1e-12);
    assert_eq!(heading(2.5), None);
}
