//! The nearest of 10,000 prototypes: one snapshot after another in a plain loop, and many together as a blocked product.
//!
//! Both on one thread, over the same 1,024 snapshots, with the same answers; the blocked product on all threads besides.
//! Medians on one x86-64 core with AVX2, while other programs kept the rest busy: 16 beams 45 ms and 6.5 ms, 7 times as
//! fast; 180 beams 297 ms and 35 ms, 8 times. The plain loop has the vectors every x86-64 has, the product the widest.

use ballmark::{
    geometry::Pose,
    recogniser::{
        Learn, Recogniser,
        nearest::{Nearest, NearestConfig},
    },
    recording::{Channel, Columns, Recording},
    seed::Seed,
};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use ndarray::Array2;
use rand::RngExt;
use std::hint::black_box;

const PROTOTYPES: usize = 10_000;
const SNAPSHOTS: usize = 1_024;

/// Scans of random ranges, each 2 m from the last, so that every one of the first 10,000 becomes a prototype.
fn scans(beams: usize) -> Recording {
    let mut random = Seed(0).stream("ranges");
    let k = PROTOTYPES + SNAPSHOTS;
    let pose: Vec<Pose> = (0..k)
        .map(|k| Pose::new(2.0 * k as f64, 0.0, 0.0))
        .collect();
    Recording::new(Columns {
        channels: vec![Channel {
            name: "range".into(),
            width: beams,
            unit: "m".into(),
            bearing_rad: None,
            maximum: Some(8.0),
            offset_m: None,
        }],
        values: Array2::from_shape_simple_fn((k, beams), || random.random_range(0.3..8.0)),
        stamp_s: vec![0.0; k],
        odometry: pose.clone(),
        pose,
        run: vec![0; k],
        ..Columns::default()
    })
    .expect("columns of one length")
}

fn nearest_of_10_000(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("nearest_of_10_000");
    group
        .sample_size(10)
        .throughput(Throughput::Elements(SNAPSHOTS as u64));
    for beams in [16, 180] {
        let recording = scans(beams);
        let mapping: Vec<usize> = (0..PROTOTYPES).collect();
        let config = NearestConfig::default();
        let nearest =
            Nearest::learn(&config, &recording, &mapping, Seed(0)).expect("a mapping part");
        assert_eq!(nearest.responses(), PROTOTYPES);
        let asked: Vec<usize> = (PROTOTYPES..PROTOTYPES + SNAPSHOTS).collect();
        let plain = || -> Vec<_> {
            asked
                .iter()
                .map(|&k| nearest.respond(recording.channels(), &recording.observation(k)))
                .collect()
        };
        assert_eq!(plain(), nearest.respond_all(&recording, &asked));

        let one_thread = rayon::ThreadPoolBuilder::new()
            .num_threads(1)
            .build()
            .expect("a pool of one thread");
        group.bench_function(BenchmarkId::new("plain_loop", beams), |b| {
            b.iter(|| black_box(plain()));
        });
        group.bench_function(BenchmarkId::new("blocked_product", beams), |b| {
            b.iter(|| one_thread.install(|| black_box(nearest.respond_all(&recording, &asked))));
        });
        group.bench_function(
            BenchmarkId::new("blocked_product_all_threads", beams),
            |b| {
                b.iter(|| black_box(nearest.respond_all(&recording, &asked)));
            },
        );
    }
    group.finish();
}

criterion_group!(benches, nearest_of_10_000);
criterion_main!(benches);
