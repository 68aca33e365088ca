//! How long it takes to draw a scan from elsewhere: `viewpoint/scan` one of 360 beams, `viewpoint/recording` 5,000 of them
//! on all cores.

use ballmark::{
    geometry::{Displacement, Pose},
    recording::{
        Channel, Columns, Recording,
        viewpoint::{Moves, Viewpoint, Views},
    },
    seed::Seed,
};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use ndarray::Array2;
use std::{f64::consts::TAU, hint::black_box};

const BEAMS: usize = 360;

/// Walls with a depth edge every few degrees and some readings without return.
fn scan(k: usize) -> Vec<f32> {
    (0..BEAMS)
        .map(|beam| match (beam + 3 * k) % 60 {
            0..5 => f32::NAN,
            5..20 => 1.5 + 0.01 * beam as f32,
            part => 4.0 + 0.02 * part as f32,
        })
        .collect()
}

fn bearing_rad() -> Vec<f64> {
    (0..BEAMS).map(|i| i as f64 * TAU / BEAMS as f64).collect()
}

fn recording(snapshots: usize) -> Recording {
    let laser = Channel {
        name: "laser".into(),
        width: BEAMS,
        unit: "m".into(),
        bearing_rad: Some(bearing_rad()),
        maximum: Some(30.0),
        offset_m: None,
    };
    let rows: Vec<f32> = (0..snapshots).flat_map(scan).collect();
    let pose: Vec<Pose> = (0..snapshots)
        .map(|k| Pose::new(k as f64 * 0.1, 0.0, 0.0))
        .collect();
    Recording::new(Columns {
        channels: vec![laser],
        values: Array2::from_shape_vec((snapshots, BEAMS), rows).expect("rows of the same width"),
        stamp_s: (0..snapshots).map(|k| k as f64).collect(),
        odometry: pose.clone(),
        pose,
        run: vec![0; snapshots],
        ..Columns::default()
    })
    .expect("a whole recording")
}

fn viewpoint(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("viewpoint");
    let step = Displacement {
        forward_m: 0.2,
        left_m: -0.1,
        turn_rad: 0.14,
    };
    let (viewpoint, scan) = (
        Viewpoint::new(&bearing_rad(), Some(30.0)).expect("finite bearings"),
        scan(0),
    );
    let mut drawn = vec![0.0; BEAMS];
    group.throughput(Throughput::Elements(1));
    group.bench_function("scan", |bencher| {
        bencher.iter(|| viewpoint.render(black_box(&scan), black_box(step), &mut drawn));
    });
    let recording = recording(5000);
    let views = Views::of(&recording)
        .expect("finite bearings")
        .expect("a range channel");
    let snapshots: Vec<usize> = (0..recording.len()).collect();
    group.throughput(Throughput::Elements(5000));
    group.sample_size(20);
    group.bench_function("recording", |bencher| {
        bencher.iter(|| {
            let mut random = Seed(1).stream("moved views");
            views.drawn(black_box(&snapshots), &Moves::default(), &mut random)
        });
    });
    group.finish();
}

criterion_group!(benches, viewpoint);
criterion_main!(benches);
