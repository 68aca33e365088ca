//! How seconds and memory of the commands grow with the length of a log: a robot with 24 sonars that drives a ring of corridors again and
//! again (`benches/long_logs.toml`) is simulated, its log written as a table, imported, learned from, and localised in.
//!
//! `cargo bench --bench long_logs` takes 10,000 and 100,000 snapshots; sizes of one's own as arguments: `cargo bench --bench long_logs
//! -- 10000 100000 1000000` (a million takes half an hour on two cores). Every command runs in a process of its own, whose
//! greatest memory is watched in /proc (Linux only).

use ballmark::recording::{
    npz,
    write::{Format, write},
};
use std::{
    env, fs,
    path::Path,
    process::{Child, Command, ExitCode, Stdio},
    thread,
    time::{Duration, Instant},
};

const SIZES: [usize; 2] = [10_000, 100_000];
/// Snapshots of a run of the world.
const OF_A_RUN: f64 = 866.0;
const WORLD: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/long_logs.toml");
const WATCHED_EVERY: Duration = Duration::from_millis(20);

/// What a command took.
struct Taken {
    seconds: f64,
    peak_mb: f64,
}

fn main() -> ExitCode {
    let arguments = env::args().skip(1).filter(|a| a != "--bench");
    let sizes: Option<Vec<usize>> = arguments.map(|a| a.parse().ok()).collect();
    let sizes = match sizes {
        Some(sizes) if sizes.is_empty() => SIZES.to_vec(),
        Some(sizes) => sizes,
        None => {
            eprintln!("long_logs: expected numbers of snapshots, such as `10000 100000`");
            return ExitCode::from(2);
        }
    };
    println!(
        "{:<10} {:>10} {:>10} {:>16} {:>9}",
        "", "snapshots", "seconds", "µs a snapshot", "peak MB"
    );
    for size in sizes {
        if let Err(fault) = all_commands(size) {
            eprintln!("long_logs: {fault}");
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

fn all_commands(size: usize) -> Result<(), String> {
    let folder = tempfile::tempdir().map_err(|e| e.to_string())?;
    let folder = folder.path();
    let runs = (size as f64 / OF_A_RUN).round().max(3.0).to_string();
    let shown = |name: &str, snapshots: usize, taken: &Taken| {
        let of_each = taken.seconds / snapshots as f64 * 1e6;
        println!(
            "{name:<10} {snapshots:>10} {:>10.1} {of_each:>16.1} {:>9.0}",
            taken.seconds, taken.peak_mb
        );
    };
    let simulated = run(
        folder,
        &["simulate", WORLD, "-o", "simulated.npz", "--runs", &runs],
    )?;
    let snapshots = as_table(folder).map_err(|e| e.to_string())?;
    shown("simulate", snapshots, &simulated);
    let commands: [(&str, &[&str]); 3] = [
        ("import", &["import", "log.csv", "-o", "d.npz"]),
        (
            "train",
            &[
                "train",
                "d.npz",
                "-o",
                "m.safetensors",
                "--uncertainty",
                "2m",
                "--features",
                "16",
                "--test-fold",
                "3",
                "--steps",
                "300",
            ],
        ),
        ("localise", &["localise", "m.safetensors", "d.npz"]),
    ];
    for (name, arguments) in commands {
        shown(name, snapshots, &run(folder, arguments)?);
    }
    Ok(())
}

/// The simulated recording as the table that somebody would bring; returns its length.
fn as_table(folder: &Path) -> ballmark::Result<usize> {
    let recording = npz::read(&folder.join("simulated.npz"))?;
    write(
        Format::Csv,
        &folder.join("log.csv"),
        &recording,
        Some(recording.poses()),
    )?;
    Ok(recording.len())
}

fn run(folder: &Path, arguments: &[&str]) -> Result<Taken, String> {
    let start = Instant::now();
    let mut command = Command::new(env!("CARGO_BIN_EXE_ballmark"));
    command.args(arguments).current_dir(folder);
    let said = folder.join("said.txt");
    let stderr = fs::File::create(&said).map_err(|e| e.to_string())?;
    let child = command.stdout(Stdio::null()).stderr(stderr).spawn();
    let mut child = child.map_err(|e| e.to_string())?;
    let mut peak_kib = 0.0;
    loop {
        peak_kib = f64::max(peak_kib, greatest_kib(&child).unwrap_or(0.0));
        match child.try_wait().map_err(|e| e.to_string())? {
            Some(status) if status.success() => break,
            Some(status) => {
                let said = fs::read_to_string(&said).unwrap_or_default();
                let last = said.lines().last().unwrap_or_default();
                let called = arguments.join(" ");
                return Err(format!("`ballmark {called}`: {status}: {last}"));
            }
            None => thread::sleep(WATCHED_EVERY),
        }
    }
    Ok(Taken {
        seconds: start.elapsed().as_secs_f64(),
        peak_mb: peak_kib / 1000.0 * 1.024,
    })
}

/// The greatest memory that a process has held so far; known on Linux only.
fn greatest_kib(child: &Child) -> Option<f64> {
    let status = fs::read_to_string(format!("/proc/{}/status", child.id())).ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse().ok()
}
