//! Every building in `configs/worlds/` is driven by the real binary, and is still the one that `docs/worlds/` tells of:
//! length of a lap, snapshots, bins. The table there is this test's output,
//! `cargo test --release --test binary worlds -- --nocapture`.

use super::support::Workplace;
use ballmark::{
    geometry::wrapped,
    recording::{Recording, npz},
    score::Binning,
    seed::Seed,
    world::{Building, WorldConfig, simulate},
};
use std::{collections::BTreeMap, path::Path};

/// What a building's page says of it.
struct Stated {
    /// Length of the first lap, or of the way where it is driven once, metres to a decimetre.
    lap_m: f64,
    /// Snapshots in all, and in the laps that are not for mapping.
    snapshots: usize,
    testing: usize,
    /// Bins of this size over the whole laps.
    bin_m: f64,
    bins: usize,
}

const fn stated(lap_m: f64, snapshots: usize, testing: usize, bin_m: f64, bins: usize) -> Stated {
    Stated {
        lap_m,
        snapshots,
        testing,
        bin_m,
        bins,
    }
}

/// By file name. Of T98's sets one run each is driven: sets, and so channels, differ, and images take their time.
fn stated_of_all() -> BTreeMap<&'static str, Stated> {
    BTreeMap::from([
        ("duckett1998-a", stated(60.3, 2160, 1666, 2.0, 24)),
        ("duckett1998-b", stated(54.1, 1953, 1509, 2.0, 14)),
        ("duckett1998-c", stated(146.6, 3794, 2592, 2.0, 40)),
        ("duckett1998-d", stated(23.1, 1506, 1317, 2.0, 8)),
        ("duckett1998-e", stated(50.7, 1842, 1426, 2.0, 14)),
        ("duckett1998-f", stated(50.9, 1844, 1427, 2.0, 14)),
        ("duckett2000-a", stated(53.9, 732, 624, 6.0, 5)),
        ("duckett2000-b", stated(49.4, 765, 666, 6.0, 6)),
        ("duckett2000-c", stated(146.3, 1149, 856, 6.0, 12)),
        ("duckett2000-d", stated(111.1, 867, 644, 6.0, 9)),
        ("ruizmayor2006-r1", stated(8.5, 18, 0, 2.0, 1)),
        ("ruizmayor2006-r2", stated(15.4, 62, 31, 2.0, 4)),
        ("ruizmayor2006-r3", stated(30.0, 61, 0, 2.0, 11)),
        ("thrun1998", stated(88.7, 808, 0, 2.0, 44)),
        ("thrun1998-twice", stated(178.7, 1616, 0, 2.0, 90)),
    ])
}

/// Metres of the first time round, number of the snapshot that follows it, and of the one that follows the last whole time
/// round; of a way that is driven once, all of it. The coordinate along the route begins anew somewhere on each lap.
fn laps(recording: &Recording, speed_m_per_s: f64) -> (f64, usize, usize) {
    let (route_m, stamp_s) = (recording.route_m().unwrap(), &recording.columns().stamp_s);
    let travelled_m: Vec<f64> = stamp_s
        .iter()
        .map(|s| (s - stamp_s[0]) * speed_m_per_s)
        .collect();
    let step_m = |of: &[f64], k: usize| of[k] - of[k - 1];
    let farthest_m = route_m.iter().copied().fold(0.0, f64::max);
    // Where the coordinate falls back, it does so by the way round, less what was travelled.
    let falls: Vec<f64> = (1..recording.len())
        .filter(|&k| step_m(route_m, k) < -farthest_m / 2.0)
        .map(|k| step_m(&travelled_m, k) - step_m(route_m, k))
        .collect();
    let whole = (recording.len(), travelled_m[recording.len() - 1]);
    let round_m = falls.iter().sum::<f64>() / falls.len() as f64;
    let mut passed_m = 0.0;
    let mut ends = Vec::new();
    for k in 1..recording.len() {
        let step_m = step_m(route_m, k);
        let step_m = if falls.is_empty() {
            0.0
        } else {
            step_m - round_m * (step_m / round_m).round()
        };
        let left_m = round_m * (ends.len() + 1) as f64 - passed_m;
        if left_m <= step_m {
            let share = left_m / step_m;
            ends.push((
                k,
                travelled_m[k - 1] + share * (travelled_m[k] - travelled_m[k - 1]),
            ));
        }
        passed_m += step_m;
    }
    let (first, first_m) = ends.first().copied().unwrap_or(whole);
    (first_m, first, ends.last().unwrap_or(&whole).0)
}

#[test]
fn every_world_is_the_one_its_page_tells_of() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/worlds");
    let mut worlds: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    worlds.sort();
    let mut all = stated_of_all();
    let mut wrong = Vec::new();
    println!(
        "| world | a lap, m | snapshots | after the first lap | bins | H(L), nats |\n|---|---|---|---|---|---|"
    );
    for world in worlds {
        let name = world.file_stem().unwrap().to_str().unwrap().to_string();
        let stated = all.remove(name.as_str());
        let stated = stated.unwrap_or_else(|| panic!("{name}: no figures stated"));
        let config = WorldConfig::parse(&std::fs::read_to_string(&world).unwrap()).unwrap();
        if let Some(people) = &config.people {
            let laps = config.path.laps;
            assert!(people.map_laps < laps, "{name}: nobody ever comes");
        }
        let place = Workplace::new();
        let mut call = vec![
            "simulate",
            world.to_str().unwrap(),
            "-o",
            "d.npz",
            "--runs",
            "1",
        ];
        if name.starts_with("thrun1998") {
            call.extend(["--set", "d1"]);
        }
        place.ballmark(&call).done();
        let recording = npz::read(&place.path("d.npz")).unwrap();
        // A lap that was broken off would weigh its part of the building more.
        let speed_m_per_s = Building::read(&world).unwrap().robot().speed_m_per_s;
        let (lap_m, first, whole) = laps(&recording, speed_m_per_s);
        let testing = recording.len() - first;
        let places: Vec<[f64; 2]> = recording.poses()[..whole]
            .iter()
            .map(|pose| [pose.x_m, pose.y_m])
            .collect();
        let binning = Binning::search(&places, stated.bin_m).unwrap();
        println!(
            "| {name} | {lap_m:.2} | {} | {testing} | {} of {} m | {:.3} |",
            recording.len(),
            binning.bins(),
            stated.bin_m,
            binning.entropy()
        );
        let ours = (recording.len(), testing, binning.bins());
        let theirs = (stated.snapshots, stated.testing, stated.bins);
        // A wall follower strays: its laps differ by some decimetres from seed to seed, and with them what is counted along them.
        let strays = name.starts_with("duckett");
        let near = |ours: usize, theirs: usize, within: f64| ours.abs_diff(theirs) as f64 <= within;
        let alike = match strays {
            true => {
                near(ours.0, theirs.0, 0.01 * theirs.0 as f64)
                    && near(ours.1, theirs.1, 0.01 * theirs.1 as f64)
                    && near(ours.2, theirs.2, 0.05 * theirs.2 as f64 + 1.0)
            }
            false => ours == theirs,
        };
        let within_m = if strays { 0.5 } else { 0.051 };
        if !alike || (lap_m - stated.lap_m).abs() > within_m {
            wrong.push(format!(
                "{name}: {lap_m:.2} m, {ours:?}; stated {} m, {theirs:?}",
                stated.lap_m
            ));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(all.is_empty(), "stated, but not there: {:?}", all.keys());
}

/// Duckett & Nehmzow 1998, 5.2 and Fig. 4: what the wheels count loses its heading; with north from the compass 2 to 5 % of the
/// way are left. Each environment draws its own.
#[test]
fn the_compass_makes_of_raw_odometry_one_that_does_not_turn_away() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/worlds");
    let (mut turns_rad, mut offs) = (Vec::new(), Vec::new());
    for letter in ["a", "b", "c", "d", "e", "f"] {
        let world = Building::read(&folder.join(format!("duckett1998-{letter}.toml"))).unwrap();
        let speed_m_per_s = world.robot().speed_m_per_s;
        let recording = simulate(&world, Seed(1), &Default::default()).unwrap();
        let (_, _, end) = laps(&recording, speed_m_per_s);
        let (poses, way_m) = (recording.poses(), recording.travelled_m()[end - 1]);
        let mut by_compass = [poses[0].x_m, poses[0].y_m];
        for k in 1..end {
            let (from, to) = (recording.observation(k - 1), recording.observation(k));
            let moved = from.north_displacement(&to).unwrap();
            by_compass = [by_compass[0] + moved[0], by_compass[1] + moved[1]];
        }
        let truth = &poses[end - 1];
        let off = (by_compass[0] - truth.x_m).hypot(by_compass[1] - truth.y_m) / way_m;
        let turned = |k: usize| {
            wrapped(recording.observation(k).odometry.heading_rad - poses[k].heading_rad)
        };
        let lap = (1..end)
            .find(|&k| recording.travelled_m()[k] > 50.0)
            .unwrap();
        let turned_rad = wrapped(turned(lap) - turned(0)).abs();
        println!(
            "{letter}: {:.1} % by the compass, {turned_rad:.2} rad in 50 m by the wheels",
            100.0 * off
        );
        // In a small room the field bends a lap the most.
        assert!((0.015..0.075).contains(&off), "{letter}: {off}");
        offs.push(off);
        turns_rad.push(turned_rad);
    }
    let off = offs.iter().sum::<f64>() / offs.len() as f64;
    assert!((0.02..0.05).contains(&off), "{offs:?}");
    // 0.01 rad a metre, standard deviation over runs: half a radian in 50 m.
    let squares: f64 = turns_rad.iter().map(|turned_rad| turned_rad.powi(2)).sum();
    let turned_rad = (squares / turns_rad.len() as f64).sqrt();
    assert!((0.2..1.0).contains(&turned_rad), "{turns_rad:?}");
}
