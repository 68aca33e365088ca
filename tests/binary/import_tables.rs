//! `ballmark import` on tables as people have them, and on poses that come from elsewhere.

use crate::support::Workplace;

fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).expect("one JSON object and nothing else")
}

/// Thirty rows along a line at half a metre a second, two sonars.
fn rows(separator: &str, number: impl Fn(f64) -> String) -> String {
    let row = |k: usize| {
        let at = k as f64 / 2.0;
        let cells = [k as f64, at, 0.0, 0.0, 1.5 + at / 10.0, 2.25];
        cells.map(&number).join(separator) + "\n"
    };
    (0..30).map(row).collect()
}

fn plain(number: f64) -> String {
    number.to_string()
}

#[test]
fn every_program_s_tables_give_the_same_dataset() {
    let place = Workplace::new();
    let names = ["time_s", "x_m", "y_m", "heading_rad", "sonar_1", "sonar_2"];
    let table = |separator: &str, number: fn(f64) -> String| {
        names.join(separator) + "\n" + &rows(separator, number)
    };
    let comma = |number: f64| plain(number).replace('.', ",");
    place.write("plain.csv", table(",", plain));
    place.write(
        "excel.csv",
        "\u{feff}".to_string() + &table(";", comma).replace('\n', "\r\n"),
    );
    place.write("sep.csv", "sep=;\r\n".to_string() + &table(";", comma));
    place.write(
        "matlab.txt",
        table("\t", plain)
            .replace("sonar_1", "sonar(1)")
            .replace("sonar_2", "sonar(2)"),
    );
    let wide: Vec<u8> = table("\t", comma)
        .encode_utf16()
        .flat_map(u16::to_le_bytes)
        .collect();
    place.write("unicode.txt", [&[0xff, 0xfe][..], &wide].concat());
    let dataset = |log: &str| {
        let answer = place.ballmark(&["import", log, "-o", "d.npz"]);
        answer.done();
        let read = ballmark::recording::npz::read(&place.path("d.npz")).unwrap();
        (
            read.channels().to_vec(),
            read.values().to_owned(),
            read.poses().to_vec(),
        )
    };
    let expected = dataset("plain.csv");
    assert_eq!(
        (
            expected.0[0].name.as_str(),
            expected.0[0].width,
            expected.0[0].unit.as_str()
        ),
        ("sonar", 2, "m")
    );
    for log in ["excel.csv", "sep.csv", "matlab.txt", "unicode.txt"] {
        assert_eq!(dataset(log), expected, "{log}");
    }
}

#[test]
fn units_bearings_and_columns_are_said_in_the_header_or_by_options() {
    let place = Workplace::new();
    let header = "time_s,x_m,y_m,heading_rad,sonar.0[cm @ 90 + 0.2],sonar.1[cm @ -90 + 0.2]\n";
    place.write(
        "said.csv",
        header.to_string() + &rows(",", |n| (n * 1.0).to_string()),
    );
    place.write(
        "unsaid.csv",
        "time_s,x_m,y_m,heading_rad,range0,range1\n".to_string() + &rows(",", plain),
    );
    place
        .ballmark(&["import", "said.csv", "-o", "said.npz"])
        .done();
    place
        .ballmark(&[
            "import",
            "unsaid.csv",
            "-o",
            "unsaid.npz",
            "--unit",
            "range=cm",
            "--bearings",
            "range=90..-90",
            "--offset",
            "range=0.2",
        ])
        .done();
    let read = |name: &str| ballmark::recording::npz::read(&place.path(name)).unwrap();
    let (said, unsaid) = (read("said.npz"), read("unsaid.npz"));
    assert_eq!(said.values(), unsaid.values());
    assert!((said.values()[[0, 0]] - 0.015).abs() < 1e-6);
    let (a, b) = (&said.channels()[0], &unsaid.channels()[0]);
    assert_eq!(
        (&a.bearing_rad, &a.offset_m, a.unit.as_str()),
        (&b.bearing_rad, &b.offset_m, "m")
    );
    // Columns of a table, also those that hold no numbers, and values of any other log.
    let rooms = "time_s,x_m,y_m,heading_rad,a,room\n0,0,0,0,1,hall\n1,1,0,0,2,hall\n";
    place.write("rooms.csv", rooms);
    place
        .ballmark(&["import", "rooms.csv", "-o", "a.npz", "--drop", "room"])
        .done();
    place
        .ballmark(&["import", "said.npz", "-o", "b.npz", "--columns", "sonar.1"])
        .done();
    assert_eq!(read("b.npz").channels()[0].width, 1);
    for (options, parts) in [
        (
            ["--drop", "floor"],
            [
                "rooms.csv: no sensor is called `floor`",
                "there are a, room",
            ],
        ),
        (["--bearings", "a=1,2"], ["bearings of `a`", "which are 1"]),
        (
            ["--bearings", "b=1"],
            ["no channel is called `b`", "there are a"],
        ),
        (["--bearings", "a=x"], ["bearings `x`", "FIRST..LAST"]),
        (["--unit", "a"], ["--unit", "CHANNEL=VALUE"]),
        (["--gap", "0"], ["--gap 0", "metres above 0"]),
    ] {
        let mut call = vec!["import", "rooms.csv", "-o", "c.npz", "--columns", "a"];
        if options[0] == "--drop" {
            call.truncate(4);
        }
        call.extend(options);
        place.ballmark(&call).refused(2, &parts);
    }
    assert!(!place.path("c.npz").exists());
}

#[test]
fn what_looks_wrong_is_noted_and_what_is_lost_counted() {
    let place = Workplace::new();
    let header = "time_s,x_m,y_m,heading_rad,light.0,light.1\n";
    let far = rows(",", plain).replace("\n20,10,", "\n20,99,");
    place.write("gap.csv", header.to_string() + &far);
    let answer = place.ballmark(&[
        "import",
        "gap.csv",
        "-o",
        "d.npz",
        "--max-range",
        "5",
        "--topics",
        "/scan",
        "--json",
    ]);
    answer.done();
    let summary = json(&answer.stdout);
    assert_eq!(
        (&summary["runs"], &summary["snapshots"]),
        (&3.into(), &30.into())
    );
    for part in [
        "2 × gap of more than 5 m",
        "no channel is in metres",
        "topics have no effect: gap.csv is a CSV table",
        "same in every snapshot: 1 (2.25)",
        "no labels",
    ] {
        assert!(answer.stderr.contains(part), "{part}: {}", answer.stderr);
    }
    // Of a table the gap makes runs; a dataset's runs stand as they are.
    let taken_anew = |log, output| {
        let answer = place.ballmark(&["import", log, "-o", output, "--gap", "200"]);
        answer.done();
        answer.stderr.contains("the gap has no effect")
    };
    assert!(!taken_anew("gap.csv", "d.npz"));
    assert!(taken_anew("d.npz", "e.npz"));
    // Quiet: warnings alone; colours: where they are asked for.
    let answer = place.ballmark(&[
        "import", "gap.csv", "-o", "d.npz", "--quiet", "--color", "always",
    ]);
    answer.done();
    assert!(
        !answer.stderr.contains("note:") && answer.stderr.contains("\u{1b}[1m"),
        "{:?}",
        answer.stderr
    );
    // An open quote swallows the rest of the table: every line of it is counted.
    let open = rows(",", plain).replacen("2.25\n5,", "\"2.25\n5,", 1);
    place.write("open.csv", header.to_string() + &open);
    let answer = place.ballmark(&["import", "open.csv", "-o", "d.npz", "--json"]);
    assert_eq!(answer.status, 3, "{}", answer.stderr);
    let summary = json(&answer.stdout);
    assert_eq!(
        (&summary["snapshots"], &summary["dropped"]),
        (&4.into(), &26.into())
    );
    place.write("lacking.csv", "Zeit;x;y\n1;2;3\n");
    place
        .ballmark(&["import", "lacking.csv", "-o", "e.npz"])
        .refused(
            1,
            &[
                "lacking.csv: line 1",
                "no column `time_s`, `x_m`, `y_m`, `heading_rad` among Zeit, x, y",
            ],
        );
}

#[test]
fn poses_may_come_from_another_file() {
    let place = Workplace::new();
    let scan = |k: usize| format!("FLASER 3 1.{k} 2.5 2.25 {k} 0 0 {k} 0 0 {k} host {k}\n");
    place.write("raw.log", (0..6).map(scan).collect::<String>());
    place.write("est.tum", "# from SLAM\n0.5 0.5 1 0 0 0 0 1\n1.5 1.5 1 0 0 0 0 1\n3.9 3.9 1 0 0 0 0 1\n4.5 4.5 1 0 0 0 0 1\n");
    let answer = place.ballmark(&[
        "import", "raw.log", "-o", "d.npz", "--poses", "est.tum", "--json",
    ]);
    assert_eq!(answer.status, 3, "{}", answer.stderr);
    assert!(
        answer
            .stderr
            .contains("snapshot 3, at 3 s: the nearest pose of est.tum is 0.900 s away"),
        "{}",
        answer.stderr
    );
    let summary = json(&answer.stdout);
    assert_eq!(
        summary["passed_over"]["snapshot outside of the poses' time"],
        2
    );
    let read = |name: &str| ballmark::recording::npz::read(&place.path(name)).unwrap();
    let posed = read("d.npz");
    assert_eq!(posed.len(), 3); // at 1, 2 and 4 s; 2 s is half a second from a pose
    assert_eq!(
        (posed.poses()[0].y_m, posed.columns().odometry[0].y_m),
        (1.0, 0.0)
    );
    place
        .ballmark(&[
            "import",
            "raw.log",
            "-o",
            "d.npz",
            "--poses",
            "est.tum",
            "--pose-tolerance",
            "1.2",
        ])
        .done();
    // Without times: one each, or times beside them.
    let graph: String = (0..6)
        .map(|k| format!("VERTEX_SE2 {} {k} 2 0\n", 5 - k))
        .collect();
    place.write(
        "optimised.g2o",
        graph.clone() + "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n",
    );
    place
        .ballmark(&[
            "import",
            "raw.log",
            "-o",
            "g.npz",
            "--poses",
            "optimised.g2o",
        ])
        .done();
    assert_eq!(
        (read("g.npz").poses()[0].x_m, read("g.npz").poses()[0].y_m),
        (5.0, 2.0)
    );
    place.write(
        "kitti.txt",
        "1 0 0 7 0 1 0 8 0 0 1 0\n1 0 0 9 0 1 0 8 0 0 1 0\n",
    );
    place.write("times.txt", "0\n5\n");
    place
        .ballmark(&[
            "import",
            "raw.log",
            "-o",
            "k.npz",
            "--poses",
            "kitti.txt",
            "--pose-times",
            "times.txt",
            "--pose-tolerance",
            "3",
        ])
        .done();
    assert_eq!(read("k.npz").poses()[5].x_m, 9.0);
    place
        .ballmark(&["import", "raw.log", "-o", "f.npz", "--poses", "kitti.txt"])
        .refused(1, &["kitti.txt: 2 poses without times; expected 6"]);
    place.write("late.tum", "100 0 0 0 0 0 0 1\n200 0 0 0 0 0 0 1\n");
    place
        .ballmark(&["import", "raw.log", "-o", "f.npz", "--poses", "late.tum"])
        .refused(
            1,
            &[
                "late.tum: no snapshot has a pose",
                "100 to 200 s",
                "0 to 5 s",
            ],
        );
    place
        .ballmark(&["import", "raw.log", "-o", "f.npz", "--pose-tolerance", "1"])
        .refused(2, &["--poses"]);
    // Logs that have no poses at all: a scanner's without odometry, a table without a place.
    let scan = |k: usize| {
        format!("RAWLASER1 0 -1.57 3.14 1.57 20 0.1 0 3 1.{k} 2.5 2.25 0 {k} host {k}\n")
    };
    place.write("still.log", (0..6).map(scan).collect::<String>());
    place.write("light.csv", "time_s;light\n1;7\n2;8\n");
    place
        .ballmark(&["import", "still.log", "-o", "f.npz"])
        .refused(1, &["no pose"]);
    for log in ["still.log", "light.csv"] {
        let answer = place.ballmark(&[
            "import",
            log,
            "-o",
            "n.npz",
            "--poses",
            "est.tum",
            "--pose-tolerance",
            "1.2",
        ]);
        answer.done();
        assert!(!answer.stderr.contains("no labels"), "{}", answer.stderr);
        let posed = read("n.npz");
        assert_eq!(
            (posed.poses()[0].x_m, posed.poses()[0].y_m),
            (1.0, 1.0),
            "{log}"
        );
        assert_eq!(posed.columns().odometry, posed.poses());
    }
    // What holds poses alone is named as such.
    for (log, what) in [
        ("est.tum", "TUM format"),
        ("kitti.txt", "KITTI format"),
        ("optimised.g2o", "pose graph without scans"),
    ] {
        place
            .ballmark(&["import", log, "-o", "f.npz"])
            .refused(1, &[log, what, "`--poses`"]);
    }
    // A graph with its scans: the optimised vertices are the labels.
    let with_scans: String = (0..3)
        .map(|k| format!("VERTEX_SE2 {k} {k} 5 0\nROBOTLASER1 0 -1.57 3.14 1.57 20 0.1 0 3 1 2 3.{k} 0 {k} 0 0 {k} 0 0 0 0 0.5 0 0 {k} host {k}\n"))
        .collect();
    place.write("graph.g2o", with_scans);
    place
        .ballmark(&["import", "graph.g2o", "-o", "s.npz"])
        .done();
    assert_eq!(read("s.npz").poses()[2].y_m, 5.0);
    assert!(!place.path("f.npz").exists());
}
