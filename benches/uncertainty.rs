//! U(L|R) from 200,000 pairs of labels, 200 locations and 64 responses, beside scikit-learn's `homogeneity_score`, which is
//! the same figure.
//!
//! Both are given the labels as integers in an array and give U; both are held to the same value first. The peer
//! (`benches/peers/uncertainty.py`) runs in a Python of its own, named by `BALLMARK_PYTHON` (`python3` where it isn't set),
//! and is left out, with a line that says so, where that has no scikit-learn.
//!
//! Estimates on one core of a shared x86-64 machine, in one run: 1.85 ms, and 34 ms by scikit-learn 1.9.1 with numpy 2.4.6,
//! so an eighteenth. (With the standard library's hasher and counts that are sorted by location first, it was 9.0 ms.)

use ballmark::{
    score::{Contingency, Entropies},
    seed::Seed,
};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use rand::RngExt;
use std::{
    env, fs,
    hint::black_box,
    io::{BufRead, BufReader, Write},
    path::Path,
    process::{Child, Command, Stdio},
    time::Duration,
};

const PAIRS: usize = 200_000;
const LOCATIONS: usize = 200;
const RESPONSES: usize = 64;

/// Half of the answers are the response that belongs to the place, half are guessed.
fn labels() -> (Vec<usize>, Vec<usize>) {
    let mut random = Seed(0).stream("labels");
    let pair = |_| {
        let location = random.random_range(0..LOCATIONS);
        let knows = random.random_bool(0.5);
        let guess = random.random_range(0..RESPONSES);
        let response = if knows {
            location * RESPONSES / LOCATIONS
        } else {
            guess
        };
        (location, response)
    };
    (0..PAIRS).map(pair).unzip()
}

fn coefficient(location: &[usize], response: &[usize]) -> f64 {
    let mut table = Contingency::new();
    for (&location, &response) in location.iter().zip(response) {
        table.record(location, response);
    }
    let entropies = Entropies::of(&table.counts());
    entropies.uncertainty_coefficient().expect("200 locations")
}

/// The script, which computes as often as it is told to in a line and answers with the seconds and U.
struct Peer {
    child: Child,
    answers: BufReader<std::process::ChildStdout>,
}

impl Peer {
    /// `None` where the peer can't run here.
    fn start(location: &[usize], response: &[usize], folder: &Path) -> Option<Self> {
        let bytes = |labels: &[usize]| -> Vec<u8> {
            let wide = labels.iter().map(|&label| label as i64);
            wide.flat_map(i64::to_le_bytes).collect()
        };
        let files = [("location", location), ("response", response)].map(|(name, labels)| {
            let file = folder.join(name);
            fs::write(&file, bytes(labels)).expect("a file in a temporary folder");
            file
        });
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/peers/uncertainty.py");
        let python = env::var("BALLMARK_PYTHON").unwrap_or_else(|_| "python3".into());
        let mut child = Command::new(python)
            .arg(script)
            .args(files)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .ok()?;
        let mut answers = BufReader::new(child.stdout.take()?);
        let mut version = String::new();
        answers.read_line(&mut version).ok()?;
        if version.is_empty() {
            child.wait().ok()?;
            return None;
        }
        println!("beside {}", version.trim());
        Some(Self { child, answers })
    }

    /// Seconds for so many computations, and U.
    fn compute(&mut self, times: u64) -> (f64, f64) {
        let asked = self.child.stdin.as_mut().expect("a pipe");
        writeln!(asked, "{times}").expect("the peer listens");
        let mut answer = String::new();
        self.answers
            .read_line(&mut answer)
            .expect("the peer answers");
        let mut numbers = answer
            .split_whitespace()
            .map(|number| number.parse().expect("a number"));
        (numbers.next().expect("seconds"), numbers.next().expect("U"))
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        drop(self.child.stdin.take()); // the end of its input ends it
        let _ = self.child.wait();
    }
}

fn uncertainty(criterion: &mut Criterion) {
    let (location, response) = labels();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut group = criterion.benchmark_group("uncertainty");
    group
        .sample_size(20)
        .throughput(Throughput::Elements(PAIRS as u64));
    group.bench_function(BenchmarkId::new("ballmark", PAIRS), |b| {
        b.iter(|| coefficient(black_box(&location), black_box(&response)));
    });
    match Peer::start(&location, &response, folder.path()) {
        None => println!(
            "uncertainty: no peer; expected a Python with scikit-learn (BALLMARK_PYTHON names it)"
        ),
        Some(mut peer) => {
            let (ours, theirs) = (coefficient(&location, &response), peer.compute(3).1);
            assert!((ours - theirs).abs() < 1e-12, "{ours} {theirs}");
            group.bench_function(BenchmarkId::new("scikit-learn", PAIRS), |b| {
                b.iter_custom(|times| Duration::from_secs_f64(peer.compute(times).0));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, uncertainty);
criterion_main!(benches);
