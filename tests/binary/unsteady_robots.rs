//! How far a Nomad 200 of the worlds of Duckett & Nehmzow repeats itself from lap to lap: the turret's heading, its way along
//! the wall, and what its readings say; and how far its odometry drifts. The figures of `docs/worlds/nomad200.md` are printed by
//! `cargo test --release --test binary unsteady -- --nocapture`.

use ballmark::{
    geometry::{Pose, wrapped},
    recording::Recording,
    seed::Seed,
    world::{Building, simulate, simulation::Choice},
};
use std::path::Path;

const WORLDS: [&str; 4] = [
    "duckett2000-a",
    "duckett2000-b",
    "duckett2000-c",
    "duckett2000-d",
];

fn world(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/worlds");
    std::fs::read_to_string(folder.join(format!("{name}.toml"))).unwrap()
}

fn recorded(text: &str, seed: u64) -> Recording {
    let building = Building::from_text(text).unwrap();
    simulate(&building, Seed(seed), &Choice::default()).unwrap()
}

/// Where each lap passes places a metre apart along the route, `[place][lap]`: the true pose and the odometry's.
fn passings(recording: &Recording) -> Vec<Vec<(Pose, Pose)>> {
    let route_m = recording.route_m().unwrap();
    let columns = recording.columns();
    let farthest_m = route_m.iter().copied().fold(0.0, f64::max);
    let mut passings = vec![Vec::new(); farthest_m as usize];
    for k in 1..recording.len() {
        let step_m = route_m[k] - route_m[k - 1];
        if !(0.0..2.0).contains(&step_m) {
            continue; // it comes round, or dwells in a corner
        }
        for (place, passing) in passings.iter_mut().enumerate() {
            let share = (place as f64 - route_m[k - 1]) / step_m;
            if share > 0.0 && share <= 1.0 {
                let between = |poses: &[Pose]| {
                    let (from, to) = (poses[k - 1], poses[k]);
                    let heading_rad =
                        from.heading_rad + share * wrapped(to.heading_rad - from.heading_rad);
                    Pose::new(
                        from.x_m + share * (to.x_m - from.x_m),
                        from.y_m + share * (to.y_m - from.y_m),
                        heading_rad,
                    )
                };
                passing.push((between(&columns.pose), between(&columns.odometry)));
            }
        }
    }
    passings
}

/// Root mean square of the standard deviations of a value over the laps, over all places that were passed three times or more.
fn repeats(passings: &[Vec<(Pose, Pose)>], value: impl Fn(usize, &Pose) -> f64) -> f64 {
    let (mut squares, mut n) = (0.0, 0.0);
    for (place, passing) in passings.iter().enumerate() {
        if passing.len() < 3 {
            continue;
        }
        let values: Vec<f64> = passing.iter().map(|(pose, _)| value(place, pose)).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        if !mean.is_finite() {
            continue; // a place whose neighbour no lap passed
        }
        squares += values.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
        n += values.len() as f64 - 1.0;
    }
    (squares / n).sqrt()
}

fn turret_sd_deg(recording: &Recording) -> f64 {
    let north_rad = std::f64::consts::FRAC_PI_2;
    let off = |_, pose: &Pose| wrapped(pose.heading_rad - north_rad).to_degrees();
    repeats(&passings(recording), off)
}

/// To the side of the way, which goes from where the laps pass one place on average to where they pass the next.
fn way_sd_m(recording: &Recording) -> f64 {
    let passings = passings(recording);
    let middle = |place: usize| {
        let here = &passings[place.min(passings.len() - 1)];
        let sum = here
            .iter()
            .fold((0.0, 0.0), |s, (p, _)| (s.0 + p.x_m, s.1 + p.y_m));
        (sum.0 / here.len() as f64, sum.1 / here.len() as f64)
    };
    repeats(&passings, |place, pose| {
        let (from, to) = (middle(place.saturating_sub(1)), middle(place + 1));
        let (along_x, along_y) = (to.0 - from.0, to.1 - from.1);
        (along_x * pose.y_m - along_y * pose.x_m) / along_x.hypot(along_y)
    })
}

/// How far the odometry drifts in each lap, as a share of it: where the same place is passed again.
fn drifts(recording: &Recording, lap_m: f64) -> Vec<f64> {
    let drift = |pair: &[(Pose, Pose)]| {
        let moved = |of: fn(&(Pose, Pose)) -> Pose| {
            let (from, to) = (of(&pair[0]), of(&pair[1]));
            (to.x_m - from.x_m, to.y_m - from.y_m)
        };
        let (truth, odometry) = (moved(|both| both.0), moved(|both| both.1));
        (odometry.0 - truth.0).hypot(odometry.1 - truth.1) / lap_m
    };
    let passings = passings(recording);
    // One place will do: a lap's drift is the same from wherever it is counted.
    let most = passings.iter().map(Vec::len).max().unwrap_or(0);
    let place = passings.iter().find(|passing| passing.len() == most);
    place.unwrap().windows(2).map(drift).collect()
}

#[test]
fn the_turret_repeats_its_heading_as_compasses_of_its_time_do_and_the_way_is_a_wall_followers() {
    println!(
        "| world | turret, ° | the same, held by a steady compass | way, cm |\n|---|---|---|---|"
    );
    for name in WORLDS {
        let text = world(name);
        let steady =
            format!("{text}\n[compass]\nnoise_rad = 0\ntilt_sd_rad = 0\ndrift_sd_rad = 0\n");
        let (ours, held) = (recorded(&text, 1), recorded(&steady, 1));
        let (turret, still, way) = (turret_sd_deg(&ours), turret_sd_deg(&held), way_sd_m(&ours));
        println!("| {name} | {turret:.2} | {still:.2} | {:.1} |", 100.0 * way);
        // Between a flux-gate's at rest (KVH C-100: ±0.5°) and that of a plain two-axis compass held level (PNI Vector: ±2°).
        assert!((0.5..2.0).contains(&turret), "{name}: {turret}°");
        // The place alone, passed a little to the side, does not make it.
        assert!(still < 0.7 * turret, "{name}: {still}° of {turret}°");
        assert!((0.015..0.06).contains(&way), "{name}: {way} m");
    }
}

#[test]
fn compass_based_odometry_drifts_by_two_to_five_per_cent_and_anew_in_each_environment() {
    let laps_m = [53.9, 49.4, 146.5, 111.0];
    let mut all = Vec::new();
    let mut means = Vec::new();
    for seed in 1..=10 {
        for (name, lap_m) in WORLDS.into_iter().zip(laps_m) {
            // Only the way matters here.
            let text = world(name).replace("detailed = 9", "rays = 1");
            let drifts = drifts(&recorded(&text, seed), lap_m);
            means.push(drifts.iter().sum::<f64>() / drifts.len() as f64);
            all.extend(drifts);
        }
    }
    all.sort_by(f64::total_cmp);
    let at = |share: f64| all[(share * (all.len() - 1) as f64) as usize];
    let mean = all.iter().sum::<f64>() / all.len() as f64;
    println!(
        "drift of a lap: mean {:.1} %, 5 to 95 % of the laps {:.1} to {:.1} %",
        100.0 * mean,
        100.0 * at(0.05),
        100.0 * at(0.95)
    );
    // "A translational drift of approximately 2-5% of distance travelled" (Duckett & Nehmzow 1998, 5.2).
    assert!((0.02..0.05).contains(&mean), "{mean}");
    assert!(
        at(0.05) > 0.012 && at(0.95) < 0.065,
        "{} {}",
        at(0.05),
        at(0.95)
    );
    // With one seed each environment has its own.
    for of_seed in means.chunks(4) {
        let spread = of_seed.iter().copied().fold(f64::MIN, f64::max)
            - of_seed.iter().copied().fold(f64::MAX, f64::min);
        assert!(spread > 0.002, "{of_seed:?}");
    }
}
