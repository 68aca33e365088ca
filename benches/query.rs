//! What one query costs against a map of 10,000 places, on one thread: `kernel` sums the squared differences of 36 raw values
//! to those of every place (a scan of 360 beams as the baseline has it; its exponentials not counted), `codes` counts the bits
//! in which 64 rounded features differ.

use ballmark::{
    localiser::codes::{differing, packed},
    seed::Seed,
};
use criterion::{Criterion, criterion_group, criterion_main};
use ndarray::Array2;
use rand::RngExt;
use std::hint::black_box;

const PLACES: usize = 10_000;
const VALUES: usize = 36;

fn query(criterion: &mut Criterion) {
    let mut random = Seed(1).stream("query");
    let mut draw = |rows, columns| {
        Array2::from_shape_simple_fn((rows, columns), || random.random_range(0.0..1.0f32))
    };
    let (map, scan) = (draw(PLACES, VALUES), draw(1, VALUES));
    let (map, scan) = (
        map.into_raw_vec_and_offset().0,
        scan.into_raw_vec_and_offset().0,
    );
    let codes = packed(draw(PLACES, 64).view()).expect("64 features are not too many");
    let snapshot = packed(draw(1, 64).view()).expect("64 features are not too many")[0];
    let mut group = criterion.benchmark_group("query");
    group.bench_function("kernel", |bencher| {
        bencher.iter(|| {
            let scan = black_box(&scan[..]);
            // Twelve sums side by side, so that they go into vectors.
            let square = |place: &[f32]| {
                let mut sums = [0f32; 12];
                for (a, b) in place.chunks_exact(12).zip(scan.chunks_exact(12)) {
                    for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
                        *sum += (a - b) * (a - b);
                    }
                }
                sums.iter().sum::<f32>()
            };
            map.chunks_exact(VALUES).map(square).collect::<Vec<f32>>()
        });
    });
    group.bench_function("codes", |bencher| {
        bencher.iter(|| differing(black_box(snapshot), &codes));
    });
    group.finish();
}

criterion_group!(benches, query);
criterion_main!(benches);
