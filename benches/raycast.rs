//! How many rays a second: 4,096 rays from places along Thrun's corridor, answered with distance, wall and normal, by
//! `Raycaster` and by parry's `Polyline` (`parry2d-f64`, a bounding-volume hierarchy over the same segments), up to 10 m
//! and without an end. Both are held to the same distances first.

use ballmark::{
    seed::Seed,
    world::{
        FloorPlan, Material, Raycaster, Wall,
        corridor::{self, CorridorConfig},
        floor_plan::round,
    },
};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use nalgebra::{Point2, Vector2};
use parry2d_f64::{
    math::Vector,
    query::{Ray, RayCast},
    shape::Polyline,
};
use rand::RngExt;
use std::hint::black_box;

const RAYS: usize = 4096;

struct Scene {
    name: &'static str,
    plan: FloorPlan,
    rays: Vec<(Point2<f64>, Vector2<f64>)>,
}

fn ray(place: Point2<f64>, angle_rad: f64) -> (Point2<f64>, Vector2<f64>) {
    (place, Vector2::new(angle_rad.cos(), angle_rad.sin()))
}

/// The corridor, from places along the robot's way.
fn corridor() -> Scene {
    let mut random = Seed(1).stream("rays");
    let building = corridor::building(&CorridorConfig::default()).expect("the shipped world");
    let scene = building
        .plan_of_run(Seed(1), 0)
        .expect("the corridor's plan");
    let recording = corridor::thrun1998(
        Seed(1),
        &CorridorConfig {
            runs: 1,
            spacing_m: 0.1,
        },
    );
    let recording = recording.expect("the corridor can be driven");
    let places = &recording.columns().pose;
    let rays = (0..RAYS).map(|_| {
        let place = &places[random.random_range(0..places.len())];
        let place = Point2::new(place.x_m, place.y_m);
        ray(place, random.random_range(0.0..std::f64::consts::TAU))
    });
    Scene {
        name: "corridor",
        rays: rays.collect(),
        plan: scene.plan,
    }
}

/// A hall of 40 × 40 m with 400 pillars of 12 faces: many walls, all short, on every side.
fn pillars() -> Scene {
    let mut random = Seed(2).stream("rays");
    let corners = [
        [-1.0, -1.0],
        [41.0, -1.0],
        [41.0, 41.0],
        [-1.0, 41.0],
        [-1.0, -1.0],
    ];
    let mut walls: Vec<Wall> = corners
        .windows(2)
        .map(|pair| Wall::new(pair[0].into(), pair[1].into(), Material::PLAIN))
        .collect();
    for pillar in 0..400 {
        let centre = Point2::new(f64::from(pillar % 20), f64::from(pillar / 20)) * 2.0;
        walls.extend(round(centre, 0.3, 12, Material::PLAIN));
    }
    let rays = (0..RAYS).map(|_| {
        let lane =
            |random: &mut ballmark::seed::Stream| f64::from(random.random_range(0..19)) * 2.0 + 1.0;
        let place = Point2::new(lane(&mut random), lane(&mut random));
        ray(place, random.random_range(0.0..std::f64::consts::TAU))
    });
    Scene {
        name: "pillars",
        rays: rays.collect(),
        plan: FloorPlan::new(walls).expect("a sound plan"),
    }
}

fn polyline(plan: &FloorPlan) -> Polyline {
    let vertex = |point: Point2<f64>| Vector::new(point.x, point.y);
    let ends = plan
        .walls()
        .iter()
        .flat_map(|wall| [vertex(wall.from), vertex(wall.to)]);
    let pairs = (0..plan.walls().len() as u32).map(|wall| [2 * wall, 2 * wall + 1]);
    Polyline::new(ends.collect(), Some(pairs.collect()))
}

fn bench(criterion: &mut Criterion) {
    for scene in [corridor(), pillars()] {
        let caster = Raycaster::new(scene.plan.clone());
        let theirs = polyline(&scene.plan);
        let their_rays: Vec<Ray> = scene
            .rays
            .iter()
            .map(|(from, along)| {
                Ray::new(Vector::new(from.x, from.y), Vector::new(along.x, along.y))
            })
            .collect();
        for ((from, along), ray) in scene.rays.iter().zip(&their_rays) {
            let ours = caster.cast(from, along, 1e3).map(|hit| hit.distance_m);
            let theirs = theirs
                .cast_local_ray_and_get_normal(ray, 1e3, false)
                .map(|hit| hit.time_of_impact);
            let same = match (ours, theirs) {
                (Some(a), Some(b)) => (a - b).abs() < 1e-6,
                (a, b) => a == b,
            };
            assert!(same, "{ours:?} and {theirs:?} from {from} along {along}");
        }
        let mut group = criterion.benchmark_group(format!("raycast/{}", scene.name));
        group.throughput(Throughput::Elements(RAYS as u64));
        for (reach, reach_m) in [("10m", 10.0), ("endless", 1e3)] {
            group.bench_function(format!("ballmark/{reach}"), |bencher| {
                bencher.iter(|| {
                    for (from, along) in &scene.rays {
                        black_box(caster.cast(from, along, reach_m));
                    }
                });
            });
            group.bench_function(format!("parry2d/{reach}"), |bencher| {
                bencher.iter(|| {
                    for ray in &their_rays {
                        black_box(theirs.cast_local_ray_and_get_normal(ray, reach_m, false));
                    }
                });
            });
        }
        group.finish();
    }
}

criterion_group!(benches, bench);
criterion_main!(benches);
