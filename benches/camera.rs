//! How long a camera takes for a snapshot, on one thread, in a corridor with doors, windows and lamps: `camera/left` and
//! `camera/up` render an image and cut it into its 140 values, `camera/ahead` looks down the whole corridor.

use ballmark::{
    geometry::Pose,
    seed::Seed,
    world::{Camera, CameraConfig, Light, Raycaster, RunScene, camera::Direction, corridor},
};
use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;

fn camera(criterion: &mut Criterion) {
    let plan = corridor::plan_of_run(Seed(1), 0).expect("the corridor's plan");
    let route = corridor::route().expect("the corridor's route");
    let lights = (0..18).map(|index| Light {
        at: route.at(2.5 + 5.0 * f64::from(index)).0,
        ..Light::default()
    });
    let scene = RunScene {
        lights: lights.collect(),
        ..RunScene::of(plan)
    };
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
        let mut along_m = 0.0;
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                along_m = (along_m + 0.37) % 85.0;
                let (at, heading_rad, _) = route.at(along_m);
                let pose = Pose::new(at.x, at.y, heading_rad);
                black_box(camera.read(&scene, &(&caster).into(), &pose, &mut noise))
            });
        });
    }
    group.finish();
}

criterion_group!(benches, camera);
criterion_main!(benches);
