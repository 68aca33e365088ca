//! How long an estimate of 20,957 poses takes to be read and judged, both files in memory as TUM text: `trajectory/20957_poses`;
//! and without the reading: `trajectory/evaluate`. The peer is evo (1.38: `evo_ape tum` takes 1.0 s for as many).

use ballmark::{
    Result,
    score::trajectory::{Evaluation, EvaluationOptions, Format, Trajectory, evaluate},
};
use criterion::{Criterion, criterion_group, criterion_main};
use std::{fmt::Write, hint::black_box};

const POSES: usize = 20_957;

/// A walk in space, off by some centimetres and degrees; numbers have as many digits as a logger prints.
fn tum(off: f64) -> String {
    let mut text = String::from("# stamp x y z qx qy qz qw\n");
    for k in 0..POSES {
        let t = k as f64 * 0.01;
        let (half, tilt) = (0.05 * t + off, 0.02 * t.sin());
        let (x, y, z) = (
            5.0 * t.sin() + off * t.cos(),
            3.0 * (0.7 * t).cos(),
            0.1 * t + off,
        );
        let quaternion = [
            tilt.sin() * half.cos(),
            tilt.sin() * half.sin(),
            tilt.cos() * half.sin(),
            tilt.cos() * half.cos(),
        ];
        let [qx, qy, qz, qw] = quaternion;
        let stamp = 1_305_031_102.175_3 + t;
        let _ = writeln!(
            text,
            "{stamp:.4} {x:.6} {y:.6} {z:.6} {qx:.8} {qy:.8} {qz:.8} {qw:.8}"
        );
    }
    text
}

fn trajectory(criterion: &mut Criterion) {
    let (estimate, reference) = (tum(0.03), tum(0.0));
    let read = |text: &str| Format::Tum.read_bytes("bench.tum".as_ref(), text.as_bytes());
    let judged = |estimate: &Trajectory, reference: &Trajectory| -> Result<Evaluation> {
        evaluate(estimate, reference, None, &EvaluationOptions::default())
    };
    let mut group = criterion.benchmark_group("trajectory");
    group.bench_function("20957_poses", |bencher| {
        bencher.iter(|| {
            judged(
                &read(black_box(&estimate)).expect("poses"),
                &read(black_box(&reference)).expect("poses"),
            )
        });
    });
    let (estimate, reference) = (
        read(&estimate).expect("poses"),
        read(&reference).expect("poses"),
    );
    group.bench_function("evaluate", |bencher| {
        bencher.iter(|| judged(black_box(&estimate), black_box(&reference)));
    });
    group.finish();
}

criterion_group!(benches, trajectory);
criterion_main!(benches);
