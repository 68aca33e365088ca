//! What matching two places costs: `histograms/places` a scan's pair of histograms with those of 1,000 places, moved by up to five
//! elements, `…, every translation` by up to 63, beside a plain loop and beside two limits of the machine; `grids/…` a scan's grid with that of a place, by a plain hill climb from the middle,
//! by plain hill climbs from every fourth cell, by one on bit planes, and by the bounded search that agrees with the second;
//! `grids/best of all places` is the bounded search as a recogniser does it, where a place must beat those before it.
//!
//! Limits: `histograms/minima limit` takes as many minima of bytes and adds each to a sum, with registers that it never has
//! to fill; `histograms/memory limit` reads as many bytes as the places' histograms have, here and there from 64 MiB.

use ballmark::{
    recogniser::{
        alignment::{Alignment, SoughtGrid, hill_climb},
        histogram::{HistogramPair, PairMatch, Sought},
        local_scan::{LocalScans, ScanConfig},
        occupancy::{CELLS, State, States},
    },
    recording::npz,
};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::{hint::black_box, path::Path};

const PLACES: usize = 1000;
/// A pair of histograms: two directions, three kinds of cells.
const PLACE_BYTES: usize = 2 * 3 * CELLS;
const REACH: usize = 16;

/// Grids of the recording that comes with the crate, their walls along the axes.
fn scans() -> Vec<States> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("datasets/corridor-small.npz");
    let recording = npz::read(&path).expect("a recording in the repository");
    let config = ScanConfig::default();
    let scans = LocalScans::new(&config, recording.channels(), false).expect("sonars");
    let grid = |k| scans.grid(recording.channels(), &recording.observation(k));
    (0..recording.len()).filter_map(grid).collect()
}

fn histograms(criterion: &mut Criterion) {
    let of_scans: Vec<HistogramPair> = scans().iter().map(HistogramPair::of).collect();
    let places: Vec<HistogramPair> = of_scans.iter().cycle().take(PLACES).cloned().collect();
    let scan = &of_scans[of_scans.len() / 2];
    let mut group = criterion.benchmark_group("histograms");
    group.throughput(Throughput::Elements(PLACES as u64));
    let sought = Sought::new(scan, 5);
    let mut matches = vec![PairMatch { x: 0, y: 0 }; PLACES];
    group.bench_function("places", |bencher| {
        bencher.iter(|| sought.best_matches(black_box(&places), &mut matches));
    });
    let everywhere = Sought::new(scan, CELLS - 1);
    group.bench_function("places, every translation", |bencher| {
        bencher.iter(|| everywhere.best_matches(black_box(&places), &mut matches));
    });
    group.bench_function("minima limit", |bencher| {
        // 128 translations, 64 elements, three kinds, two directions.
        bencher.iter(|| minima(black_box(PLACES * 128 * 64 * 3 * 2 / 512)));
    });
    let bytes = vec![1u64; 64 << 17];
    let mut from = 0;
    group.bench_function("memory limit", |bencher| {
        bencher.iter(|| {
            let count = PLACES * PLACE_BYTES / 8;
            from = if from + 2 * count > bytes.len() {
                0
            } else {
                from + count
            };
            black_box(&bytes[from..from + count])
                .iter()
                .fold(0, |a, b| a | b)
        });
    });
    group.sample_size(10);
    group.bench_function("plain loop", |bencher| {
        let moved: Vec<HistogramPair> = (-64..64)
            .map(|by| HistogramPair {
                x: scan.x.moved(by),
                y: scan.y.moved(by),
            })
            .collect();
        let plain = |place: &HistogramPair| {
            let x = moved.iter().map(|scan| place.x.match_with(&scan.x)).max();
            let y = moved.iter().map(|scan| place.y.match_with(&scan.y)).max();
            x.unwrap_or(0) * y.unwrap_or(0)
        };
        bencher.iter(|| black_box(&places).iter().map(plain).max());
    });
    group.finish();
}

/// So many times 512 bytes' minima, each added to a sum of bytes.
fn minima(times: usize) -> u64 {
    struct Minima(usize);
    impl macerator::WithSimd for Minima {
        type Output = u64;

        #[inline(always)]
        fn with_simd<S: macerator::Simd>(self) -> u64 {
            let counts = black_box([3u8; 512]);
            let mut sums = [0u8; 512];
            for i in 0..self.0 {
                let count = i as u8;
                for t in 0..512 {
                    sums[t] = sums[t].wrapping_add(counts[t].min(count));
                }
            }
            sums.iter().map(|&s| u64::from(s)).sum()
        }
    }
    macerator::AutoArch::new().dispatch(Minima(times))
}

fn cells(states: &States) -> Vec<State> {
    let at = |i: usize| states.at(i % CELLS, i / CELLS);
    (0..CELLS * CELLS).map(at).collect()
}

fn better(a: Alignment, b: Alignment) -> Alignment {
    if b.agreement > a.agreement { b } else { a }
}

fn grids(criterion: &mut Criterion) {
    let scans: Vec<States> = scans().into_iter().step_by(17).collect();
    let sought: Vec<SoughtGrid> = scans.iter().map(|s| SoughtGrid::new(s, REACH)).collect();
    let plain: Vec<Vec<State>> = scans.iter().map(cells).collect();
    // Each scan with the next but some; the same pairs for all.
    let pairs: Vec<(usize, usize)> = (0..scans.len())
        .map(|i| (i, (i + 5) % scans.len()))
        .collect();
    let mut group = criterion.benchmark_group("grids");
    group.throughput(Throughput::Elements(pairs.len() as u64));
    group.bench_function("bounded search", |bencher| {
        bencher.iter(|| {
            let all = black_box(&pairs).iter();
            all.map(|&(a, b)| sought[a].align(&scans[b], 0))
                .max_by_key(|a| a.map(|a| a.agreement))
        });
    });
    group.bench_function("best of all places", |bencher| {
        bencher.iter(|| {
            let (mut best, scan) = (0, &sought[7]);
            for place in black_box(&scans[8..]) {
                best = scan.align(place, best).map_or(best, |a| a.agreement);
            }
            best
        });
    });
    group.bench_function("made ready", |bencher| {
        bencher.iter(|| {
            for scan in black_box(&scans) {
                black_box(SoughtGrid::new(scan, REACH));
            }
        });
    });
    group.bench_function("hill climb on bit planes", |bencher| {
        bencher.iter(|| {
            let all = black_box(&pairs).iter();
            all.map(|&(a, b)| sought[a].hill_climb(&scans[b], (0, 0)).agreement)
                .max()
        });
    });
    group.sample_size(10);
    let reach = REACH as i32;
    group.bench_function("plain hill climb", |bencher| {
        bencher.iter(|| {
            let all = black_box(&pairs).iter();
            all.map(|&(a, b)| hill_climb(&plain[b], &plain[a], (0, 0), reach).agreement)
                .max()
        });
    });
    group.throughput(Throughput::Elements(2));
    let starts: Vec<i32> = (-reach..=reach).step_by(4).collect();
    group.bench_function("plain hill climbs from every fourth cell", |bencher| {
        bencher.iter(|| {
            let all = black_box(&pairs[..2]).iter();
            let climb = |&(a, b): &(usize, usize)| {
                let from = starts
                    .iter()
                    .flat_map(|&up| starts.iter().map(move |&right| (right, up)));
                from.map(|start| hill_climb(&plain[b], &plain[a], start, reach))
                    .reduce(better)
            };
            all.map(climb).max_by_key(|a| a.map(|a| a.agreement))
        });
    });
    group.finish();
}

criterion_group!(benches, histograms, grids);
criterion_main!(benches);
