//! How fast CARMEN text is read, in bytes a second: `parse/carmen`.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::{fmt::Write, hint::black_box, path::Path};

/// 1,000 scans of 360 beams with an ODOM line each, about 2 MB.
fn synthetic_log() -> String {
    let mut log = String::new();
    for k in 0..1000 {
        let x_m = k as f64 / 10.0;
        log.push_str("FLASER 360");
        for beam in 0..360 {
            let _ = write!(
                log,
                " {:.2}",
                1.0 + ((k * 7 + beam * 13) % 1000) as f64 / 100.0
            );
        }
        let _ = writeln!(log, " {x_m} 0.5 0.01 {x_m} 0.5 0.01 {k}.25 host {k}.25");
        let _ = writeln!(log, "ODOM {x_m} 0.5 0.01 0.5 0 0 {k}.3 host {k}.3");
    }
    log
}

fn parse(criterion: &mut Criterion) {
    let log = synthetic_log();
    let mut group = criterion.benchmark_group("parse");
    group.throughput(Throughput::Bytes(log.len() as u64));
    group.bench_function("carmen", |bencher| {
        bencher.iter(|| {
            ballmark::recording::format::carmen::read(
                Path::new("bench.log"),
                black_box(log.as_bytes()),
                &Default::default(),
            )
        });
    });
    group.finish();
}

criterion_group!(benches, parse);
criterion_main!(benches);
