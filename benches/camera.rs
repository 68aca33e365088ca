//! How long a camera takes for a snapshot, on one thread, in a corridor with doors, windows and lamps: `camera/left` and
//! `camera/up` render an image and cut it into its 140 values, `camera/ahead` looks down the whole corridor.

use ballmark::{
    seed::Seed,
    world::{
        Building, Camera, CameraConfig, Raycaster,
        camera::Direction,
        corridor::{self, CorridorConfig},
    },
};
use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;

fn camera(criterion: &mut Criterion) {
    let building = Building::from_text(corridor::WORLD).expect("the shipped world");
    let scene = building
        .plan_of_run(Seed(1), 0)
        .expect("the corridor's plan");
    let recording = corridor::thrun1998(
        Seed(1),
        &CorridorConfig {
            runs: 1,
            spacing_m: 0.37,
        },
    );
    let poses = recording
        .expect("the corridor can be driven")
        .columns()
        .pose
        .clone();
    let caster = Raycaster::new(scene.plan.clone());
    let mut group = criterion.benchmark_group("camera");
    for (name, look) in [
        ("left", Direction::Left),
        ("up", Direction::Up),
        ("ahead", Direction::Ahead),
    ] {
        let config = CameraConfig {
            look,
            ..CameraConfig::default()
        };
        let camera = Camera::new(config).expect("the default camera");
        let mut noise = Seed(1).stream("camera");
        let mut poses = poses.iter().cycle();
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                let pose = poses.next().expect("a cycle");
                black_box(camera.read(&scene, &(&caster).into(), pose, &mut noise))
            });
        });
    }
    group.finish();
}

criterion_group!(benches, camera);
criterion_main!(benches);
