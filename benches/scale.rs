//! How time and memory grow: one evaluation of the objective with its gradient, one whole training step of small
//! networks, and one step of the default recipe, which draws its snapshots; for K = 2,400, 24,000 and 240,000 snapshots
//! along a route of the same density, four features, ±2 m.
//!
//! `cargo bench --bench scale`; sizes of one's own as arguments: `cargo bench --bench scale -- 2400 48000`. Every size
//! and job runs in a process of its own, whose greatest memory is read from `VmHWM` in /proc/self/status (Linux only).

use ballmark::{
    belief::{Places, Uncertainty},
    detector::device::cpu,
    learning::{
        Recipe,
        objective::{Objective, equal_weights},
        prior_operator::PriorOperator,
        trainer::Trainer,
        training_set::TrainingSet,
    },
    recording::split::Split,
    seed::Seed,
};
use ndarray::Array2;
use rand::RngExt;
use std::{
    env, fs,
    process::{Command, ExitCode},
    time::{Duration, Instant},
};

mod small_networks;

const SIZES: [usize; 3] = [2_400, 24_000, 240_000];
/// 2,400 snapshots on 89 m.
const SPACING_M: f64 = 89.0 / 2399.0;
const JOBS: [&str; 3] = ["objective", "small networks", "default recipe"];

fn main() -> ExitCode {
    let arguments: Vec<String> = env::args().skip(1).filter(|a| a != "--bench").collect();
    if let [flag, job, size] = &arguments[..]
        && flag == "--child"
    {
        let k = size.parse().expect("the parent passes a number");
        let time = match job.as_str() {
            "objective" => objective(k),
            "small networks" => training_step(k, &noisy_small_networks()),
            _ => training_step(k, &Recipe::default()),
        };
        println!("{} {}", time.as_secs_f64() * 1e3, peak_kib().unwrap_or(0));
        return ExitCode::SUCCESS;
    }
    let sizes: Option<Vec<usize>> = arguments.iter().map(|a| a.parse().ok()).collect();
    match sizes {
        None => {
            eprintln!("scale: expected numbers of snapshots, such as `2400 24000`");
            ExitCode::from(2)
        }
        Some(sizes) if sizes.is_empty() => table(&SIZES),
        Some(sizes) => table(&sizes),
    }
}

fn table(sizes: &[usize]) -> ExitCode {
    println!(
        "{:<14} {:>8} {:>12} {:>8} {:>11} {:>8}",
        "", "K", "median ms", "factor", "peak MiB", "factor"
    );
    for job in JOBS {
        let mut before: Option<(usize, f64, f64)> = None;
        for &k in sizes {
            let Some((ms, kib)) = child(job, k) else {
                eprintln!("scale: {job} with K = {k} failed");
                return ExitCode::FAILURE;
            };
            let grown = |value: f64, of: fn(&(usize, f64, f64)) -> f64| {
                before
                    .as_ref()
                    .map_or(String::new(), |b| format!("×{:.1}", value / of(b)))
            };
            let growth = before.map_or(String::new(), |b| {
                format!("K ×{:.0}", k as f64 / b.0 as f64)
            });
            let memory = if kib > 0.0 {
                format!("{:.0}", kib / 1024.0)
            } else {
                "no /proc".into()
            };
            println!(
                "{job:<14} {k:>8} {ms:>12.3} {:>8} {memory:>11} {:>8}  {growth}",
                grown(ms, |b| b.1),
                grown(kib, |b| b.2),
            );
            before = Some((k, ms, kib));
        }
    }
    ExitCode::SUCCESS
}

/// Median time of a job in milliseconds and greatest memory in KiB, from a fresh process.
fn child(job: &str, k: usize) -> Option<(f64, f64)> {
    let own = env::current_exe().ok()?;
    let output = Command::new(own)
        .args(["--child", job, &k.to_string()])
        .output()
        .ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    let (ms, kib) = text.trim().split_once(' ')?;
    Some((ms.parse().ok()?, kib.parse().ok()?))
}

/// The greatest memory this process has held; known on Linux only.
fn peak_kib() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse().ok()
}

/// The median over about two seconds, after three rounds to fill the buffers.
fn median(mut work: impl FnMut()) -> Duration {
    for _ in 0..3 {
        work();
    }
    let (start, mut times) = (Instant::now(), Vec::new());
    while times.len() < 5 || (start.elapsed() < Duration::from_secs(2) && times.len() < 2000) {
        let now = Instant::now();
        work();
        times.push(now.elapsed());
    }
    times.sort();
    times[times.len() / 2]
}

fn objective(k: usize) -> Duration {
    let mut random = Seed(1).stream("bench");
    let places = Places::Route((0..k).map(|i| i as f64 * SPACING_M).collect());
    let window: Uncertainty = "2m".parse().expect("an uncertainty as users write it");
    let prior = PriorOperator::new(window, &places, &places);
    let g = Array2::from_shape_simple_fn((k, 4), || random.random_range(0.0..1.0f32));
    let weight = equal_weights(k);
    let mut objective = Objective::<f32>::new();
    median(|| {
        let e = objective.evaluate(&prior, g.view(), g.view(), weight.view());
        assert!(e.expect("four features are not too many").posterior_error_m > 0.0);
    })
}

/// Small networks, with noise on the inputs and the map in the objective.
fn noisy_small_networks() -> Recipe {
    let mut recipe = small_networks::recipe();
    recipe.descent.map_in_objective = true;
    recipe.augmentation.input_noise = 0.3;
    recipe
}

fn training_step(k: usize, recipe: &Recipe) -> Duration {
    let recording = small_networks::recording(k, (k - 1) as f64 * SPACING_M);
    let everything = Split {
        train: (0..k).collect(),
        validation: Vec::new(),
        test: Vec::new(),
    };
    let recipe = Recipe {
        uncertainty: "2m".parse().expect("an uncertainty as users write it"),
        ..recipe.clone()
    };
    let training_set =
        TrainingSet::prepare(&recipe, &recording, &everything).expect("enough snapshots");
    let mut trainer = Trainer::new(&recipe, &training_set, &cpu());
    median(|| {
        trainer.step().expect("a finite objective");
    })
}
