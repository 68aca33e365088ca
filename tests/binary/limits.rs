//! When the system refuses: limits, full disks, closed pipes, files that can't be read, folders in the way.
#![cfg(unix)]

use crate::support::{Answer, Workplace, answer, binary};
use std::{
    fs,
    process::{Command, Stdio},
};

/// A dataset's worth of text: far more than a block of output.
fn walk() -> String {
    let row = |k: usize| {
        let x_m = k as f64 / 10.0;
        format!("{k},{x_m},{},0,{},{x_m}\n", (x_m / 7.0).sin(), (k * k) % 97)
    };
    let header = "time_s,x_m,y_m,heading_rad,light,route_m\n".to_string();
    header + &(0..400).map(row).collect::<String>()
}

const TRAIN: &str = "train walk.npz -o walk.safetensors --features 1 --steps 5";

/// A place with a dataset and a model.
fn furnished() -> Workplace {
    let place = Workplace::new();
    place.write("walk.csv", walk());
    place
        .ballmark(&["import", "walk.csv", "-o", "walk.npz"])
        .done();
    place.ballmark(&TRAIN.split(' ').collect::<Vec<_>>()).done();
    place
}

/// Runs a line of shell in which `$ballmark` is the binary.
fn shell(place: &Workplace, line: &str) -> Answer {
    let mut command = Command::new("sh");
    command.args(["-c", line]).env("ballmark", binary());
    answer(command.current_dir(place.path("")))
}

#[track_caller]
fn one_line(answer: &Answer) {
    let errors = answer.stderr.lines().filter(|l| l.starts_with("error: "));
    assert_eq!(errors.count(), 1, "{}", answer.stderr);
}

#[test]
fn a_file_size_limit_is_told_and_the_old_file_kept() {
    let place = furnished();
    let files = place.files();
    for (arguments, output) in [
        ("import walk.csv -o walk.npz", "walk.npz"),
        (TRAIN, "walk.safetensors"),
        (
            "export walk.safetensors -o new.safetensors",
            "new.safetensors",
        ),
        ("features walk.safetensors walk.npz -o new.csv", "new.csv"),
    ] {
        let old = fs::read(place.path(output)).ok();
        let limited = format!("ulimit -f 1; exec \"$ballmark\" {arguments}");
        let refused = shell(&place, &limited);
        refused.refused(1, &[output, "cannot write", "too large"]);
        one_line(&refused);
        assert_eq!(fs::read(place.path(output)).ok(), old, "{arguments}");
        assert_eq!(place.files(), files, "{arguments} leaves nothing behind");
    }
    // The demo's first file is its dataset; the folder was asked for, but nothing half-written lies in it.
    let refused = shell(
        &place,
        "ulimit -f 1; exec \"$ballmark\" demo --toy --out demo",
    );
    refused.refused(1, &["corridor.npz", "cannot write", "too large"]);
    assert_eq!(fs::read_dir(place.path("demo")).unwrap().count(), 0);
    // Standard output into a file is limited as well.
    let refused = shell(
        &place,
        "ulimit -f 0; exec \"$ballmark\" score walk.csv > table",
    );
    assert_eq!(refused.status, 1, "{}", refused.stderr);
    one_line(&refused);
}

#[test]
fn a_limit_that_is_not_met_changes_nothing() {
    let place = furnished();
    shell(
        &place,
        "ulimit -f 10000; exec \"$ballmark\" export walk.safetensors -o new.safetensors",
    )
    .done();
}

const RESPONSES: &str = "response,location\n1,a\n1,a\n2,b\n2,b\n";

#[test]
fn a_reader_that_stops_early_is_no_fault() {
    let place = furnished();
    place.write("damaged.csv", walk() + "nonsense\n");
    place.write("responses.csv", RESPONSES);
    for (arguments, status) in [
        ("score responses.csv", 0),
        ("score responses.csv --json", 0),
        ("import walk.csv -o again.npz", 0),
        ("import damaged.csv -o damaged.npz", 3), // what was lost stays lost, whether anybody reads it or not
        ("export walk.safetensors -o again.safetensors", 0),
        ("--help", 0),
    ] {
        let (reader, writer) = std::io::pipe().expect("a pipe");
        drop(reader);
        let mut command = Command::new(binary());
        command
            .args(arguments.split(' '))
            .current_dir(place.path(""));
        let output = command.stdout(writer).stderr(Stdio::piped()).spawn();
        let output = output.and_then(|child| child.wait_with_output()).unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(status), "{arguments}: {stderr}");
        assert!(!stderr.contains("error:"), "{arguments}: {stderr}");
        assert!(!stderr.contains("panicked"), "{arguments}: {stderr}");
    }
    for written in ["again.npz", "damaged.npz", "again.safetensors"] {
        assert!(place.path(written).is_file(), "{written}");
    }
}

#[test]
fn closed_streams_never_panic() {
    let place = Workplace::new();
    place.write("responses.csv", RESPONSES);
    place.write("damaged.csv", walk() + "nonsense\n");
    for (line, status) in [
        ("\"$ballmark\" score responses.csv >&-", 0),
        ("\"$ballmark\" score responses.csv >&- 2>&-", 0),
        ("\"$ballmark\" score missing.csv 2>&-", 1),
        ("\"$ballmark\" score <&- >&- 2>&-", 2),
        ("\"$ballmark\" import damaged.csv -o d.npz >&- 2>&-", 3),
    ] {
        assert_eq!(shell(&place, line).status, status, "{line}");
    }
    // Streams that were closed at the start must not be mistaken for the files opened next.
    assert_eq!(
        fs::read_to_string(place.path("responses.csv")).unwrap(),
        RESPONSES
    );
}

#[test]
fn a_full_device_is_told() {
    if !std::path::Path::new("/dev/full").exists() {
        eprintln!("skipped: a_full_device_is_told needs /dev/full");
        return;
    }
    let place = Workplace::new();
    place.write("responses.csv", RESPONSES);
    let refused = shell(&place, "\"$ballmark\" score responses.csv > /dev/full");
    refused.refused(1, &["standard output", "cannot write", "No space left"]);
    one_line(&refused);
}

#[test]
fn files_that_cannot_be_read_are_told() {
    use std::os::unix::fs::PermissionsExt;
    let place = Workplace::new();
    let locked = place.write("locked.csv", RESPONSES);
    fs::set_permissions(&locked, fs::Permissions::from_mode(0o000)).unwrap();
    if fs::read(&locked).is_ok() {
        eprintln!("skipped: no file is closed to this user; a memory image stands in for it");
    } else {
        let refused = place.ballmark(&["score", "locked.csv"]);
        refused.refused(1, &["locked.csv", "cannot read", "ermission"]);
    }
    if cfg!(target_os = "linux") {
        for arguments in ["score /proc/self/mem", "import /proc/self/mem -o d.npz"] {
            let refused = place.ballmark(&arguments.split(' ').collect::<Vec<_>>());
            refused.refused(1, &["/proc/self/mem", "cannot read"]);
        }
    }
    assert_eq!(place.files(), ["locked.csv"]);
}

#[test]
fn outputs_without_a_folder_or_upon_one_are_told() {
    let place = furnished();
    fs::create_dir(place.path("folder.npz")).unwrap();
    fs::create_dir(place.path("folder.safetensors")).unwrap();
    fs::create_dir(place.path("folder.csv")).unwrap();
    place.ballmark(&["demo", "--toy", "--out", "demo"]).done();
    let files = place.files();
    for (call, ending) in [
        ("import walk.csv -o ", "npz"),
        ("train walk.npz --features 1 --steps 5 -o ", "safetensors"),
        ("export walk.safetensors -o ", "safetensors"),
        ("features walk.safetensors walk.npz -o ", "csv"),
    ] {
        for (output, fault) in [
            (format!("folder.{ending}"), "a folder of that name exists"),
            (format!("missing/new.{ending}"), "does not exist"),
            (format!("walk.csv/new.{ending}"), "is a file, not a folder"),
        ] {
            let call = call.to_string() + &output;
            let refused = place.ballmark(&call.split(' ').collect::<Vec<_>>());
            refused.refused(1, &[&output, "cannot write", fault]);
            one_line(&refused);
        }
    }
    for call in [
        "demo --toy --out walk.csv",
        "localise demo/corridor-2m.safetensors demo/corridor.npz --trials 2 --out walk.csv",
    ] {
        let refused = place.ballmark(&call.split(' ').collect::<Vec<_>>());
        refused.refused(1, &["walk.csv", "cannot make the folder"]);
        one_line(&refused);
    }
    assert_eq!(place.files(), files);
}
