use super::*;
use crate::{
    belief::Places,
    experiment::{
        localisation::{self, Record},
        localise_config::LocaliseConfig,
        mapped::Mapped,
        parts::{Parts, TrainingSource},
        trial_play::stream,
    },
    localiser::{Estimate, Localiser, LocaliserConfig, monte_carlo::MonteCarloConfig},
    recogniser::test_world::test_world,
    recording::Recording,
    seed::Seed,
};
use std::{borrow::Cow, fs, path::PathBuf};

/// Snapshots of a lap.
const LAP: usize = 104;

/// The first lap maps, the second is unseen.
fn in_context(recording: &Recording, test: impl FnOnce(&MethodContext)) {
    let parts = Parts {
        run: recording,
        places: Places::of(recording),
        unseen: (LAP..2 * LAP).collect(),
        unseen_is_validation: false,
        source: Some(TrainingSource {
            recording: Cow::Borrowed(recording),
            training: (0..LAP).collect(),
            validation: Vec::new(),
        }),
    };
    let config = LocaliseConfig {
        trials: 8,
        longest_m: 12.0,
        resamples: 20,
        ..LocaliseConfig::default()
    };
    let mapped = Mapped::of(parts.source.as_ref().unwrap());
    test(&MethodContext::over(mapped, &parts, &config).unwrap());
}

/// What a localiser of ours answers, as files of somebody else's would have it.
fn written(context: &MethodContext, localiser: &dyn Localiser, folder: &Path) {
    let run = context.parts.run;
    let trials = drawn(context).unwrap();
    let player = localiser.prepare(run, &context.parts.unseen).unwrap();
    for start in [Start::Unknown, Start::Known] {
        let names = names(start, trials.len(), context.seed());
        for (number, (trial, name)) in trials.iter().zip(&names).enumerate() {
            let pose = run.poses()[trial.snapshots[0]];
            let pose = (start == Start::Known && localiser.asks_for_the_start()).then_some(pose);
            let mut stream = stream(context, number);
            let steps = player.play(&trial.snapshots, pose, &mut stream).unwrap();
            let (mut tum, mut csv) = (String::new(), "time_s,x_m,y_m,weight\n".to_string());
            for (time_s, step) in times(run, &trial.snapshots).iter().zip(&steps) {
                let Some(Estimate::Place([x, y])) = step.estimate else {
                    panic!("{step:?}")
                };
                let half = step.heading_rad.unwrap() / 2.0;
                tum += &format!("{time_s} {x} {y} 0 0 0 {} {}\n", half.sin(), half.cos());
                for ([x, y], p) in &step.posterior {
                    csv += &format!("{time_s},{x},{y},{p}\n");
                }
            }
            fs::write(folder.join(format!("{name}.tum")), tum).unwrap();
            fs::write(folder.join(format!("{name}.csv")), csv).unwrap();
        }
    }
}

fn few_particles(recording: &Recording) -> Box<dyn Localiser> {
    let config = MonteCarloConfig {
        particles: 300,
        least_particles: 50,
        evidence_scale: Some(0.2),
        ..MonteCarloConfig::default()
    };
    let lap: Vec<usize> = (0..LAP).collect();
    config.learn(recording, &lap, Seed(1)).unwrap()
}

fn external(folder: &Path) -> ExternalConfig {
    ExternalConfig {
        answers: folder.into(),
        ..ExternalConfig::default()
    }
}

/// All numbers of a value with their keys, in order.
fn numbers(key: &str, value: &serde_json::Value, into: &mut Vec<(String, f64)>) {
    match value {
        serde_json::Value::Number(number) => {
            into.extend(number.as_f64().map(|number| (key.to_string(), number)));
        }
        serde_json::Value::Array(all) => all.iter().for_each(|value| numbers(key, value, into)),
        serde_json::Value::Object(all) => all
            .iter()
            .for_each(|(name, value)| numbers(&format!("{key}.{name}"), value, into)),
        _ => {}
    }
}

#[test]
fn one_of_ours_is_judged_alike_through_files() {
    let recording = test_world();
    in_context(&recording, |context| {
        let folder = tempfile::tempdir().unwrap();
        written(context, few_particles(&recording).as_ref(), folder.path());
        let own = context.localiser("own", "own", few_particles(&recording));
        let theirs = external(folder.path()).method(context, "theirs").unwrap();
        let record: Record = localisation::play(context, vec![own, theirs], &mut |_| ()).unwrap();
        assert!(record.left_out.is_empty(), "{:?}", record.left_out);
        let json = |at: usize| {
            let mut result = record.results[at].clone();
            // What a robot must hold of ours is known.
            (
                result.bytes_per_place,
                result.robot_bytes,
                result.evidence_scale,
            ) = (None, None, None);
            let mut all = Vec::new();
            numbers("", &serde_json::to_value(result).unwrap(), &mut all);
            all
        };
        let (own, theirs) = (json(0), json(1));
        assert!(
            own.len() > 200 && own.len() == theirs.len(),
            "{} {}",
            own.len(),
            theirs.len()
        );
        for ((key, a), (other, b)) in own.iter().zip(&theirs) {
            assert!(key == other && (a - b).abs() < 1e-9, "{key}: {a} {b}");
        }
        assert!(record.results[1].tracking.converged_fraction > 0.5);
        assert!(record.results[1].correction.is_some());
    });
}

#[test]
fn starts_that_nobody_asked_about_have_no_figures() {
    let recording = test_world();
    in_context(&recording, |context| {
        let folder = tempfile::tempdir().unwrap();
        written(context, few_particles(&recording).as_ref(), folder.path());
        for entry in fs::read_dir(folder.path()).unwrap() {
            let path = entry.unwrap().path();
            if path.to_string_lossy().contains("/known") {
                fs::remove_file(path).unwrap();
            }
        }
        let both = external(folder.path()).method(context, "x").err().unwrap();
        assert!(both.to_string().contains("no answer to known-"), "{both}");
        let alone = ExternalConfig {
            start: Starts::Unknown,
            ..external(folder.path())
        };
        let method = alone.method(context, "x").unwrap();
        let record = localisation::play(context, vec![method], &mut |_| ()).unwrap();
        let result = &record.results[0];
        assert!(result.global.units > 0 && result.risk_coverage_area_m.is_some());
        assert_eq!((result.tracking.units, result.tracked_error_m), (0, None));
        assert!(result.correction.is_none());
    });
}

#[test]
fn a_file_of_no_trial_is_named() {
    let recording = test_world();
    in_context(&recording, |context| {
        let folder = tempfile::tempdir().unwrap();
        written(context, few_particles(&recording).as_ref(), folder.path());
        fs::write(folder.path().join("README.md"), "mine").unwrap();
        external(folder.path()).method(context, "x").unwrap();
        fs::write(folder.path().join("unknown-009.tum"), "").unwrap();
        let error = external(folder.path()).method(context, "x").err().unwrap();
        let words = error.to_string();
        assert!(
            words
                .contains("unknown-009.tum: answers no trial; expected unknown-001 to unknown-008"),
            "{words}"
        );
        let nowhere = external(&folder.path().join("nowhere")).method(context, "x");
        assert!(
            nowhere
                .err()
                .unwrap()
                .to_string()
                .contains("nowhere: cannot read the folder")
        );
    });
}

/// A program for a shell, run once a trial.
#[cfg(unix)]
fn command(script: &str) -> ExternalConfig {
    let words = [
        "sh",
        "-c",
        script,
        "sh",
        "{trial_csv}",
        "{answer_tum}",
        "{start}",
        "{seed}",
    ];
    ExternalConfig {
        command: words.map(String::from).to_vec(),
        ..ExternalConfig::default()
    }
}

#[cfg(unix)]
#[test]
fn a_command_is_run_for_every_trial() {
    let recording = test_world();
    in_context(&recording, |context| {
        // Where it starts, or the origin, at all times of the table.
        let script = "IFS=, read x y h <<END\n$3\nEND\ncase $x in unknown) x=4.5 y=3;; esac\n\
            tail -n +2 \"$1\" | while IFS=, read t rest; do echo \"$t $x $y 0 0 0 0 1\"; done > \"$2\"";
        let answers = command(script).answers(context).unwrap();
        let trials = drawn(context).unwrap();
        assert_eq!((answers.anywhere.len(), answers.known.len()), (8, 8));
        for (trial, steps) in trials.iter().zip(&answers.known) {
            let pose = recording.poses()[trial.snapshots[0]];
            let place = Estimate::Place([pose.x_m, pose.y_m]);
            assert!(
                steps.len() == trial.snapshots.len()
                    && steps.iter().all(|s| s.estimate == Some(place))
            );
        }
        assert_eq!(
            answers.anywhere[0][0].estimate,
            Some(Estimate::Place([4.5, 3.0]))
        );
    });
}

#[cfg(unix)]
#[test]
fn a_command_that_fails_or_takes_too_long_is_named_with_its_last_words() {
    let recording = test_world();
    in_context(&recording, |context| {
        let fault = |config: ExternalConfig| config.answers(context).unwrap_err().to_string();
        // However much it printed before.
        let script = "yes | head -c 100000; echo one; echo 'no map' >&2; exit 3";
        let failed = fault(command(script));
        assert!(
            failed.contains("command `sh` failed (exit status: 3); it last printed `no map`"),
            "{failed}"
        );
        let nothing = fault(command("true"));
        assert!(nothing.starts_with("no answer to unknown-"), "{nothing}");
        let begun = std::time::Instant::now();
        let slow = fault(ExternalConfig {
            timeout_s: 0.2,
            ..command("sleep 30 & wait")
        });
        assert!(
            slow.contains("had not ended after timeout_s = 0.2 s"),
            "{slow}"
        );
        assert!(begun.elapsed().as_secs() < 20);
        let missing = fault(ExternalConfig {
            command: vec!["/no/such/program".into()],
            ..ExternalConfig::default()
        });
        assert!(
            missing.contains("command `/no/such/program`")
                && missing.contains("expected a program"),
            "{missing}"
        );
    });
}

/// A command whose answers hang on its seed, or on the time of the day.
#[cfg(unix)]
#[test]
fn what_is_chance_is_told_apart() {
    let recording = test_world();
    in_context(&recording, |context| {
        let repeats = |place: &str| {
            let script = format!(
                "tail -n +2 \"$1\" | while IFS=, read t rest; do echo \"$t {place} 3 0 0 0 0 1\"; done > \"$2\""
            );
            let config = ExternalConfig {
                repeats: 2,
                start: Starts::Unknown,
                ..command(&script)
            };
            let method = config.method(context, "x").unwrap();
            let record = localisation::play(context, vec![method], &mut |_| ()).unwrap();
            record.results[0].repeats.clone().unwrap()
        };
        let by_seed = repeats("$4");
        assert_eq!(
            (by_seed.seeds, by_seed.trials_that_differ_with_one_seed),
            (3, 0)
        );
        let error = by_seed.point_error_at_10m_m.unwrap();
        assert!(error.sd > 0.01 && error.least < error.most, "{error:?}");
        let by_chance = repeats("0.$(od -An -N4 -tu4 /dev/urandom | tr -d ' ')");
        assert!(by_chance.trials_that_differ_with_one_seed > 6);
    });
}

/// Answers of the run before, which lie there still, are none to what is asked now.
#[cfg(unix)]
#[test]
fn a_repeat_that_says_nothing_is_a_fault() {
    let recording = test_world();
    in_context(&recording, |context| {
        let seed = context.seed().0;
        let script = format!(
            "test $4 = {seed} || exit 0; tail -n +2 \"$1\" | while IFS=, read t rest; do echo \"$t 1 1 0 0 0 0 1\"; done > \"$2\""
        );
        let config = ExternalConfig {
            repeats: 1,
            ..command(&script)
        };
        let fault = config.answers(context).unwrap_err().to_string();
        assert!(fault.starts_with("no answer to unknown-"), "{fault}");
    });
}

#[test]
fn a_configuration_says_who_answers() {
    let check = |text: &str| {
        let config: ExternalConfig = toml::from_str(text).unwrap();
        crate::registry::Constants::check(&config)
            .err()
            .map(|e| e.to_string())
    };
    assert_eq!(check("answers = 'a'"), None);
    for (text, words) in [
        ("", "answers: expected the folder"),
        ("answers = 'a'\ncommand = ['x']", "command: expected either"),
        ("answers = 'a'\ntimeout_s = 0", "timeout_s"),
        ("answers = 'a'\ntolerance_s = nan", "tolerance_s"),
        (
            "command = ['x']\nrepeats = 3",
            "repeats: expected a `command` with `{seed}`",
        ),
        (
            "command = ['x', '{seed}']\nrepeats = 101",
            "repeats: expected at most 100",
        ),
    ] {
        let fault = check(text).unwrap();
        assert!(fault.starts_with(words), "{fault}");
    }
    let mut config = external(Path::new("mine"));
    for file in crate::registry::Constants::files(&mut config) {
        *file = Path::new("configs").join(&*file);
    }
    assert_eq!(
        (config.answers, config.folder),
        (PathBuf::from("configs/mine"), PathBuf::from("configs/."))
    );
}
