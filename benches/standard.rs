//! What the standard experiment of Duckett & Nehmzow (1998) costs on a whole environment: `standard/binning` lays the grid over
//! the route of environment C, 146 m, three laps and a bit; `standard/trials` plays its 475 or so trials to dead reckoning and
//! judges all 201 tables, p-value and intervals included; `standard/judging alone` leaves these two out;
//! `standard/laps` finds laps in the odometry and takes out the drift.

use ballmark::{
    experiment::{
        protocol::{Protocol, ProtocolConfig, Truth},
        standard::{self, StandardConfig},
    },
    localiser::{self, Kind},
    seed::Seed,
    world::{
        Building,
        simulation::{Choice, simulate},
    },
};
use criterion::{Criterion, criterion_group, criterion_main};
use std::{hint::black_box, path::Path};

fn whole_environment(criterion: &mut Criterion) {
    let world = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/worlds/duckett1998-c.toml");
    let building = Building::read(&world).expect("a world in the repository");
    let recording = simulate(&building, Seed(1), &Choice::default()).expect("a simulation");
    let config = ProtocolConfig {
        truth: Truth::Odometry,
        ..ProtocolConfig::default()
    };
    let protocol = Protocol::new(&recording, &config).expect("laps");
    let mut group = criterion.benchmark_group("standard");
    group.sample_size(10);
    group.bench_function("laps", |bencher| {
        bencher.iter(|| Protocol::new(black_box(&recording), &config).expect("laps"));
    });
    let standard = StandardConfig::default();
    group.bench_function("binning", |bencher| {
        bencher.iter(|| black_box(&protocol).binning(standard.bin_m).expect("bins"));
    });
    let binning = protocol.binning(standard.bin_m).expect("bins");
    let dead_reckoning = Kind::DeadReckoning.default_config();
    let learned = localiser::learn(
        &dead_reckoning,
        &protocol.recording,
        &protocol.mapping,
        Seed(1),
    )
    .expect("it needn't learn");
    let play = |config: &StandardConfig| {
        standard::play(&protocol, &binning, learned.as_localiser(), config, Seed(1))
            .expect("trials")
    };
    group.bench_function("trials", |bencher| bencher.iter(|| play(&standard)));
    let alone = StandardConfig {
        permutations: 0,
        resamples: 0,
        ..standard.clone()
    };
    group.bench_function("judging alone", |bencher| bencher.iter(|| play(&alone)));
}

criterion_group!(benches, whole_environment);
criterion_main!(benches);
