//! Scans of real logs, drawn from where other scans of the same log were taken.

use crate::support::{Workplace, real_logs};
use ballmark::recording::{Recording, npz, viewpoint::Views};

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

#[test]
fn a_scan_drawn_from_another_place_is_like_the_scan_taken_there() {
    let Some(logs) = real_logs("a_scan_drawn_from_another_place_is_like_the_scan_taken_there")
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
        let views = Views::of(&recording).unwrap().unwrap();
        let (from, to): (Vec<usize>, Vec<usize>) = pairs(&recording).into_iter().unzip();
        let poses = recording.poses();
        let steps: Vec<_> = from
            .iter()
            .zip(&to)
            .map(|(&a, &b)| poses[a].displacement_to(&poses[b]))
            .collect();
        let (taken, there) = (
            recording.select(&from).unwrap(),
            recording.select(&to).unwrap(),
        );
        let unmoved = difference_m(&taken, &there);
        let moved = difference_m(&views.moved(&from, &steps).unwrap(), &there);
        println!(
            "{log}: {} pairs, unmoved {unmoved:.3?} m, moved {moved:.3?} m",
            from.len()
        );
        assert!(
            from.len() >= 100 && moved.0 < 0.5 * unmoved.0 && moved.1 < 0.7 * unmoved.1,
            "{log}: {} pairs, unmoved {unmoved:?}, moved {moved:?}",
            from.len()
        );
    }
}
