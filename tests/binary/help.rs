//! Every command's help: fit for a terminal of 80 columns, and its example runs.
#![cfg(unix)]

use crate::support::{Workplace, answer, binary};
use std::{path::Path, process::Command};

/// Folders of the repository that examples may read from.
const REACHABLE: [&str; 3] = ["datasets", "models", "configs"];

/// What the calls of an example begin with.
const PROGRAMS: [&str; 2] = ["ballmark", "printf"];

fn help(arguments: &[&str]) -> String {
    let mut command = Command::new(binary());
    let told = answer(command.args(arguments).arg("--help").env("COLUMNS", "80"));
    told.done().stdout.clone()
}

/// The commands that `ballmark --help` lists, but for `help` itself.
fn commands() -> Vec<String> {
    let text = help(&[]);
    let list = text
        .split("\nCommands:\n")
        .nth(1)
        .expect("a list of commands");
    let lines = list.lines().take_while(|line| !line.is_empty());
    let starts = lines.filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    let names = starts.filter_map(|line| line.split_whitespace().next());
    names
        .filter(|&name| name != "help")
        .map(String::from)
        .collect()
}

/// What stands behind `Example:`, which is the end of the help.
#[track_caller]
fn example(help: &str) -> &str {
    let (_, example) = help
        .rsplit_once("\nExample:\n")
        .expect("a help ends with `Example:`");
    assert!(!example.trim().is_empty(), "an empty example:\n{help}");
    // A line begins a call or goes on behind a backslash; anything else was broken to fit, and can't be copied.
    let mut continued = false;
    for line in example.lines() {
        let begins = PROGRAMS
            .iter()
            .any(|p| line.starts_with(&format!("  {p} ")));
        assert!(
            begins || continued,
            "after `Example:` only calls, cut with \\ to fit 80 columns: {line}"
        );
        continued = line.ends_with('\\');
    }
    example
}

/// The first file of the repository that the example needs and that isn't there.
fn missing(example: &str) -> Option<&str> {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR"));
    let in_repository = |word: &&str| {
        let folder = word.split_once('/').map_or("", |(folder, _)| folder);
        REACHABLE.contains(&folder)
    };
    let mut needed = example.split_whitespace().filter(in_repository);
    needed.find(|word| !repository.join(word).exists())
}

/// Runs an example as a reader would who copies it, in a fresh folder beside copies of the repository's own.
#[track_caller]
fn run(name: &str, example: &str) {
    let place = Workplace::new();
    for folder in REACHABLE {
        let original = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
        if original.is_dir() {
            let copied = Command::new("cp")
                .arg("-R")
                .arg(original)
                .arg(place.path(""))
                .status();
            assert!(copied.expect("cp runs").success());
        }
    }
    let mut path = binary()
        .parent()
        .expect("a folder")
        .as_os_str()
        .to_os_string();
    path.push(":");
    path.push(std::env::var_os("PATH").unwrap_or_default());
    let mut command = Command::new("sh");
    command.args(["-e", "-c", example]).env("PATH", path);
    let ran = answer(command.current_dir(place.path("")));
    assert_eq!(
        ran.status, 0,
        "{name}:{example}\n{}{}",
        ran.stdout, ran.stderr
    );
    assert!(!ran.stdout.is_empty(), "{name}: says nothing:{example}");
    assert!(!ran.stderr.contains("panicked"), "{name}: {}", ran.stderr);
}

#[test]
fn every_help_fits_a_terminal_and_ends_with_an_example() {
    let commands = commands();
    for known in ["demo", "import", "train", "score"] {
        assert!(
            commands.iter().any(|c| c == known),
            "{known} in {commands:?}"
        );
    }
    let mut helps = vec![help(&[])];
    helps.extend(commands.iter().map(|name| help(&[name])));
    for help in helps {
        let widest = help.lines().max_by_key(|line| line.chars().count());
        let widest = widest.expect("a help has lines");
        assert!(widest.chars().count() <= 80, "over 80 columns: {widest}");
        example(&help);
    }
}

/// The steps of a sweep are commands of their own.
#[test]
fn the_steps_of_a_sweep_have_helps_and_examples() {
    for step in ["plan", "run", "run-cell", "status", "collect"] {
        let help = help(&["sweep", step]);
        let widest = help.lines().map(|line| line.chars().count()).max();
        assert!(widest.is_some_and(|widest| widest <= 80), "{help}");
        let example = example(&help);
        assert!(example.contains(&format!("ballmark sweep {step} ")));
        run(step, example);
    }
}

#[test]
fn every_example_runs() {
    let mut ran = Vec::new();
    let mut all = vec![("ballmark".to_string(), help(&[]))];
    all.extend(
        commands()
            .into_iter()
            .map(|name| (name.clone(), help(&[&name]))),
    );
    for (name, help) in &all {
        let example = example(help);
        let call = if name == "ballmark" {
            "ballmark "
        } else {
            &format!("ballmark {name} ")
        };
        assert!(
            example.contains(call),
            "the example of {name} calls it:\n{example}"
        );
        match missing(example) {
            Some(file) => {
                eprintln!("SKIPPED: the example of `{name}` needs {file}, which isn't there yet")
            }
            None if !ran.contains(&example) => {
                run(name, example);
                ran.push(example);
            }
            None => {} // the demo's stands in two places
        }
    }
    assert!(ran.len() >= 3, "only the examples of {ran:?} could run");
}
