//! A map that answers at every pose: how long it takes to fill 240,000 poses (rendered scans of 180 beams through convolutions),
//! and to hold one snapshot against it, with 64 features as probabilities and as bits.
//!
//!     cargo bench --bench every_pose

use ballmark::{
    belief::{CodeMap, Grid, GridConfig, Places},
    detector::{
        input::{Input, InputConfig},
        net::{NetConfig, NetDetector, Weights},
        rendered::{RenderedInputs, SensedMap},
    },
    mapping::{OccupancyMap, OccupancyMapConfig, RangeSensors},
    seed::Seed,
    world::generated::{GeneratedBuilding, GeneratedConfig},
};
use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;

const POSES: usize = 240_000;
const FEATURES: usize = 64;

fn every_pose(criterion: &mut Criterion) {
    let config = GeneratedConfig::default();
    let building = (0..9).find_map(|number| {
        GeneratedBuilding::draw(&config, number, Seed(1)).expect("sound constants")
    });
    let recording = building.expect("a building of nine").first;
    let all: Vec<usize> = (0..recording.len()).collect();
    let input = Input::fit(&InputConfig::far(), &recording, &all).expect("a laser");
    let weights = Weights::random(
        &NetConfig::default(),
        input.shape(),
        FEATURES,
        &mut Seed(1).stream("weights"),
    );
    let map = OccupancyMap::from_scans(&recording, &all, &OccupancyMapConfig::default());
    let sensed = SensedMap {
        map: map.expect("walls"),
        sensors: RangeSensors::default(),
    };
    let rendered = RenderedInputs::new(&sensed, recording.channels(), &input).expect("a laser");
    let detector = NetDetector::new(input, &weights, &ballmark::detector::device::cpu());
    let places = Places::Plane(recording.poses().to_vec());
    let mut config = GridConfig::default();
    let grid = loop {
        let grid = Grid::over(&places, &config).expect("a grid");
        if grid.len() >= POSES {
            break grid;
        }
        config.cell_m *= 0.98;
    };
    let Places::Plane(cells) = &**grid.places() else {
        return;
    };
    let cells = &cells[..POSES];
    let fill = || {
        rendered
            .at_as(cells, FEATURES, |inputs| detector.respond(inputs))
            .expect("answers")
    };
    let mut group = criterion.benchmark_group("every_pose");
    group.sample_size(10);
    group.bench_function("fill", |b| b.iter(|| black_box(fill())));

    let at = fill();
    let soft = CodeMap::probabilities(at.values.view(), &at.seen).expect("a map");
    let examples = (at.values.view(), at.values.view());
    let bits = CodeMap::bits(at.values.view(), &at.seen, examples).expect("a map");
    let g = at.values.row(POSES / 2).to_vec();
    for (id, map) in [("step_soft", soft), ("step_bits", bits)] {
        group.bench_function(id, |b| b.iter(|| black_box(map.log_likelihood(&g))));
    }
}

criterion_group!(benches, every_pose);
criterion_main!(benches);
