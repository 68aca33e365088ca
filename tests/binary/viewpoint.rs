//! Scans drawn from where other scans of the same recording were taken, beside these.

use crate::support::{Workplace, real_logs};
use ballmark::recording::{Recording, npz, viewpoint::Views};
use std::path::Path;

/// Readings beyond this, and missing ones, count as this: what is far away looks alike from everywhere.
const CLIP_M: f32 = 8.0;
/// Pairs of snapshots looked at, evenly over the log.
const PAIRS: usize = 400;

/// Pairs of snapshots taken 0.1 to 0.6 m apart that look the same way to 0.3 rad, one way or the other.
fn pairs(recording: &Recording) -> Vec<(usize, usize)> {
    let poses = recording.poses();
    let beside = |&(a, b): &(usize, usize)| {
        (0.1..0.6).contains(&poses[a].distance_m(&poses[b])) && poses[a].turn_rad(&poses[b]) < 0.3
    };
    let all: Vec<(usize, usize)> = (0..poses.len())
        .flat_map(|a| (0..poses.len()).map(move |b| (a, b)))
        .filter(beside)
        .collect();
    all.iter()
        .step_by((all.len() / PAIRS).max(1))
        .copied()
        .collect()
}

fn median(mut values: Vec<f32>) -> f32 {
    values.sort_by(f32::total_cmp);
    values[values.len() / 2]
}

/// Medians over the pairs: of the median and of the mean difference beam by beam, in metres.
fn difference_m(a: &Recording, b: &Recording) -> (f32, f32) {
    let clipped = |r: f32| if r < CLIP_M { r } else { CLIP_M }; // NaN isn't less
    let (mut medians, mut means) = (Vec::new(), Vec::new());
    for (a, b) in a.values().rows().into_iter().zip(b.values().rows()) {
        let beams = a.iter().zip(b);
        let apart: Vec<f32> = beams
            .map(|(&a, &b)| (clipped(a) - clipped(b)).abs())
            .collect();
        means.push(apart.iter().sum::<f32>() / apart.len() as f32);
        medians.push(median(apart));
    }
    (median(medians), median(means))
}

/// How different scans from a place beside are from those taken there, before and after they were drawn from there.
fn unmoved_and_moved_m(recording: &Recording) -> [(f32, f32); 2] {
    let views = Views::of(recording).unwrap().unwrap();
    let (from, to): (Vec<usize>, Vec<usize>) = pairs(recording).into_iter().unzip();
    assert!(from.len() >= PAIRS);
    let poses = recording.poses();
    let steps: Vec<_> = from
        .iter()
        .zip(&to)
        .map(|(&a, &b)| poses[a].displacement_to(&poses[b]))
        .collect();
    let there = recording.select(&to).unwrap();
    let unmoved = difference_m(&recording.select(&from).unwrap(), &there);
    [
        unmoved,
        difference_m(&views.moved(&from, &steps).unwrap(), &there),
    ]
}

#[test]
fn a_laser_scan_drawn_from_another_place_is_like_the_scan_taken_there() {
    let Some(logs) =
        real_logs("a_laser_scan_drawn_from_another_place_is_like_the_scan_taken_there")
    else {
        return;
    };
    let place = Workplace::new();
    for log in [
        "freiburg-079/freiburg-079-corrected.log.xz",
        "intel-lab/intel-corrected.log.xz",
        "infinite-corridor/infinite-corridor-corrected.log.xz",
    ] {
        let path = logs.join(log).display().to_string();
        place.ballmark(&["import", &path, "-o", "d.npz"]).done();
        let recording = npz::read(&place.path("d.npz")).unwrap();
        let [unmoved, moved] = unmoved_and_moved_m(&recording);
        println!("{log}: median and mean: unmoved {unmoved:.3?} m, moved {moved:.3?} m");
        assert!(
            moved.0 < 0.15 * unmoved.0 && moved.1 < 0.4 * unmoved.1,
            "{log}: unmoved {unmoved:?} m, moved {moved:?} m"
        );
    }
}

/// Sonars hear walls only head-on, so what a moved one would have missed is not to be known: the mean says nothing.
#[test]
fn sonars_drawn_from_another_place_are_mostly_like_those_heard_there() {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("datasets/corridor-small.npz");
    let [unmoved, moved] = unmoved_and_moved_m(&npz::read(&shipped).unwrap());
    println!("sonars: median and mean: unmoved {unmoved:.3?} m, moved {moved:.3?} m");
    assert!(
        moved.0 < 0.4 * unmoved.0,
        "unmoved {unmoved:?} m, moved {moved:?} m"
    );
}
