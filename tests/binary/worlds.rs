//! Every building in `configs/worlds/` is driven by the real binary, and is still the one that `docs/worlds/` tells of:
//! length of a lap, snapshots, bins. The table there is this test's output,
//! `cargo test --release --test binary worlds -- --nocapture`.

use super::support::Workplace;
use ballmark::{
    recording::npz,
    score::Binning,
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
        ("duckett1998-a", stated(60.0, 0, 0, 2.0, 24)),
        ("duckett1998-b", stated(54.0, 0, 0, 2.0, 14)),
        ("duckett1998-c", stated(146.0, 0, 0, 2.0, 40)),
        ("duckett1998-d", stated(23.0, 0, 0, 2.0, 8)),
        ("duckett1998-e", stated(51.0, 0, 0, 2.0, 14)),
        ("duckett1998-f", stated(51.0, 0, 0, 2.0, 14)),
        ("duckett2000-a", stated(54.0, 0, 623, 6.0, 5)),
        ("duckett2000-b", stated(49.0, 0, 668, 6.0, 6)),
        ("duckett2000-c", stated(147.0, 0, 854, 6.0, 12)),
        ("duckett2000-d", stated(111.0, 0, 645, 6.0, 9)),
        ("ruizmayor2006-r1", stated(8.5, 18, 0, 2.0, 1)),
        ("ruizmayor2006-r2", stated(15.4, 62, 0, 2.0, 4)),
        ("ruizmayor2006-r3", stated(30.0, 61, 0, 2.0, 15)),
        ("thrun1998", stated(89.0, 808, 0, 2.0, 45)),
    ])
}

/// Number of the snapshot at which the first lap has ended, and of that at which the last whole one has; of all where the
/// way is driven once. The coordinate along the route begins anew somewhere on each lap.
fn laps(route_m: &[f64]) -> (usize, usize) {
    let round_m = route_m.iter().copied().fold(0.0, f64::max);
    let mut passed_m = 0.0;
    let mut ends = Vec::new();
    for (k, pair) in route_m.windows(2).enumerate() {
        let step_m = pair[1] - pair[0];
        passed_m += step_m - round_m * (step_m / round_m).round();
        if passed_m >= round_m * (ends.len() + 1) as f64 {
            ends.push(k + 1);
        }
    }
    let whole = route_m.len();
    (ends.first().copied().unwrap_or(whole), ends.last().copied().unwrap_or(whole))
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
    println!("| world | a lap, m | snapshots | after the first lap | bins | H(L), nats |\n|---|---|---|---|---|---|");
    for world in worlds {
        let name = world.file_stem().unwrap().to_str().unwrap().to_string();
        let stated = all.remove(name.as_str());
        let stated = stated.unwrap_or_else(|| panic!("{name}: no figures stated"));
        let place = Workplace::new();
        let mut call = vec!["simulate", world.to_str().unwrap(), "-o", "d.npz", "--runs", "1"];
        if name == "thrun1998" {
            call.extend(["--set", "d1"]);
        }
        place.ballmark(&call).done();
        let recording = npz::read(&place.path("d.npz")).unwrap();
        let travelled_m = recording.travelled_m();
        let route_m = recording.route_m().unwrap_or(&[]);
        // A lap that was broken off would weigh its part of the building more.
        let (first, whole) = laps(route_m);
        let lap_m = travelled_m[first.min(recording.len() - 1)];
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
        if ours != theirs || (lap_m - stated.lap_m).abs() > 0.051 {
            wrong.push(format!("{name}: {lap_m:.2} m, {ours:?}; stated {} m, {theirs:?}", stated.lap_m));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(all.is_empty(), "stated, but not there: {:?}", all.keys());
}
