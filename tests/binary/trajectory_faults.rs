//! `ballmark trajectory` on bad files and wrong calls: one clear line each.

use crate::{
    support::Workplace,
    trajectory::{json, tum},
};

const SOUND: &str = "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n2 2 0 0 0 0 0 1\n";

#[test]
fn damaged_files_are_refused_in_one_line() {
    let far = format!("0 {} 0 0 0 0 0 1\n", "1".repeat(100_000));
    let long = format!("0 0 0 0 0 0 0 1\n{}\n", "7 ".repeat(200_000));
    let bad: [(&[u8], &[&str]); 26] = [
        (b"", &["is empty", "TUM, KITTI, CSV or g2o"]),
        (b"# stamp x y z\n\n", &["is empty"]),
        (
            b"0 0 0 0 0 0 0 1\n1 0 0 0 0 0 1\n",
            &["line 2", "7 numbers; expected 8 a line (TUM"],
        ),
        (
            b"0 0 0 0 0 0 0 1\n\n1 0 0 0 0 0 0 1 9\n",
            &["line 3", "9 numbers; expected 8"],
        ),
        (
            b"1 2 3\n",
            &["line 1", "3 words", "8 numbers (TUM), 12 (KITTI)"],
        ),
        (
            b"0 0 0 0 0 0 0 1\n1 nan 0 0 0 0 0 1\n",
            &["line 2", "`x` holds `nan`", "finite"],
        ),
        (
            b"0 0 0 0 0 0 0 1\ninf 0 0 0 0 0 0 1\n",
            &["line 2", "`stamp` holds `inf`"],
        ),
        (
            b"0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 0\n",
            &["line 2", "quaternion of length zero"],
        ),
        (
            b"0 0 0 0 0 0 0 1\n1 0 0 0 0 0 5 1\n",
            &["line 2", "quaternion of length 5.099"],
        ),
        (
            b"0 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n",
            &["line 3", "stamp 2 stands at line 2 already"],
        ),
        (
            b"0 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n# a\n1 0 0 0 0 0 0 1\n",
            &["line 4", "stamp 1 goes back behind 2 at line 2"],
        ),
        (b"0 0 0 0 0 0 0 1\n", &["holds one pose", "at least two"]),
        (
            b"0 1e30 0 0 0 0 0 1\n",
            &["line 1", "1e30 m away", "within 1e9 m"],
        ),
        (
            b"0 0 0 0 0 0 0 1\n1 0 \xff 0 0 0 0 1\n",
            &["line 2", "UTF-8"],
        ),
        (
            b"0 0 0 0 0 0 0 1\n1 0 \0 0 0 0 0 1\n",
            &["line 2", "zero byte"],
        ),
        (b"\x1f\x8b\x08\0\0", &["compressed with gzip", "plain text"]),
        (b"\xff\xfe0\0 \0", &["UTF-16"]),
        (
            b"0 0 0 0 0 0 0 1\n1 \x1b[31m 0 0 0 0 0 1\n",
            &["line 2", "`\\u{1b}[31m`"],
        ),
        (
            b"stamp,x_m,y_m\n0,1,2\n",
            &["line 1", "no column `heading_rad`", "qx, qy, qz, qw"],
        ),
        (
            b"stamp,x_m,y_m,heading_rad\n0,1,2,0\n1,1,2\n",
            &["line 3", "3 cells; expected 4"],
        ),
        (
            b"stamp,x_m,y_m,heading_rad\n0,1,2,180\n",
            &["line 2", "`heading_rad` holds 180", "radians"],
        ),
        (
            b"stamp,x_m,y_m,yaw\n0,1,2,0\n1,1,2,20\n",
            &["line 3", "`yaw` holds 20", "heading_deg"],
        ),
        (
            b"stamp,x_m,y_m,qx,qy,qz,qw,qw\n0,1,2,0,0,0,1,1\n",
            &["line 1", "columns `qw` and `qw`"],
        ),
        (
            b"stamp,x,x_m,y_m,heading_rad\n0,1,1,2,0\n",
            &["line 1", "columns `x` and `x_m`"],
        ),
        (b"1 0 0 0 0 2 0 0 0 0 1 0\n", &["line 1", "no rotation"]),
        (b"stamp,x_m,y_m,heading_rad\n", &["holds no pose"]),
    ];
    let long = [
        (far.as_bytes(), &["line 1"][..]),
        (long.as_bytes(), &["line 2", "200000 numbers; expected 8"]),
    ];
    for (content, parts) in bad.into_iter().chain(long) {
        let place = Workplace::new();
        place.write("ref.tum", SOUND);
        place.write("bad.tum", content);
        for call in [["bad.tum", "ref.tum"], ["ref.tum", "bad.tum"]] {
            let answer = place.ballmark(&["trajectory", call[0], call[1], "--out", "out.csv"]);
            answer.refused(1, &[&["bad.tum"], parts].concat());
            assert_eq!(answer.stderr.lines().count(), 1, "{}", answer.stderr);
            assert!(answer.stderr.len() < 300, "{}", answer.stderr);
        }
        assert_eq!(place.files(), ["bad.tum", "ref.tum"]);
    }
}

#[test]
fn trajectories_that_do_not_go_together_are_refused() {
    let place = Workplace::new();
    place.write("ref.tum", SOUND);
    place.write(
        "later.tum",
        SOUND
            .replace("\n1 ", "\n11 ")
            .replace("\n2 ", "\n12 ")
            .replace("0 0 0 0 0 0 0 1", "10 0 0 0 0 0 0 1"),
    );
    place
        .ballmark(&["trajectory", "later.tum", "ref.tum"])
        .refused(
            1,
            &["no pose of later.tum", "stamps 10 to 12 s and 0 to 2 s"],
        );
    place
        .ballmark(&["trajectory", "later.tum", "ref.tum", "--offset", "-10"])
        .done();
    let in_nanoseconds = |plus: u64| {
        let at = |k: u64| 1_500_000_000_000_000_000 + k * 1_000_000_000 + plus;
        (0..3).fold(String::new(), |text, k| {
            text + &format!("{} {k} 0 0 0 0 0 1\n", at(k))
        })
    };
    place.write("ns.tum", in_nanoseconds(0));
    place.write("late.tum", in_nanoseconds(3_000));
    place
        .ballmark(&["trajectory", "ns.tum", "late.tum"])
        .refused(1, &["no pose of ns.tum", "in seconds?"]);
    let kitti = "1 0 0 0 0 1 0 0 0 0 1 0\n";
    place.write("three.kitti", kitti.repeat(3));
    place.write("four.kitti", kitti.repeat(4));
    place
        .ballmark(&["trajectory", "three.kitti", "four.kitti"])
        .refused(
            1,
            &[
                "three.kitti has 3 poses",
                "four.kitti has 4",
                "without time stamps",
            ],
        );
    place
        .ballmark(&["trajectory", "three.kitti", "ref.tum"])
        .refused(1, &["ref.tum has time stamps and three.kitti has none"]);
    place.write("times.txt", "0\n1\nx\n");
    let with_times =
        |file: &str| place.ballmark(&["trajectory", file, "ref.tum", "--times", "times.txt"]);
    with_times("three.kitti").refused(1, &["times.txt", "line 3", "`stamp` holds `x`"]);
    place.write("times.txt", "0\n1\n2\n");
    with_times("four.kitti").refused(1, &["four.kitti: 4 poses and 3 time stamps"]);
    with_times("later.tum").refused(2, &["--times", "time stamps of their own"]);
    with_times("three.kitti").done();
    // All on one line: no rotation about it is determined in space.
    place.write(
        "est.tum",
        tum((0..3).map(|k| [k as f64, k as f64, 0.1, 0.0])),
    );
    place
        .ballmark(&["trajectory", "est.tum", "ref.tum", "--align", "se3"])
        .refused(1, &["on one line", "se2"]);
    place
        .ballmark(&[
            "trajectory",
            "est.tum",
            "ref.tum",
            "--delta",
            "9",
            "--delta-unit",
            "m",
        ])
        .refused(1, &["no two poses are 9 m apart", "along 2.000 m"]);
    // A prior of another time, and one of part of the time.
    place
        .ballmark(&["trajectory", "est.tum", "ref.tum", "--prior", "later.tum"])
        .refused(1, &["no pose of later.tum", "est.tum"]);
    place.write(
        "part.tum",
        tum((0..2).map(|k| [k as f64, k as f64, 0.2, 0.0])),
    );
    let with_part = ["trajectory", "est.tum", "ref.tum", "--prior", "part.tum"];
    place.ballmark(&with_part).refused(
        1,
        &["part.tum has a prior for 2 of 3 matched poses of est.tum"],
    );
    let allowed =
        json(&place.ballmark(&[&with_part[..], &["--allow-incomplete", "--json"]].concat()));
    assert_eq!(allowed["prediction_correction"]["n"], 2);
}

#[test]
fn files_in_the_wrong_place_deserve_a_line() {
    let place = Workplace::new();
    place.write("ref.tum", SOUND);
    place.write("copy.tum", SOUND);
    let off = |y: f64| tum((0..3).map(|k| [k as f64, k as f64, y, 0.0]));
    place.write("near.tum", off(0.1));
    place.write("far.tum", off(0.5));
    let twice = |call: &[&str], parts: &[&str]| {
        place
            .ballmark(&[&["trajectory"], call].concat())
            .refused(2, parts)
    };
    twice(&["ref.tum", "ref.tum"], &["given as EST and as REF"]);
    twice(&["ref.tum", "./ref.tum"], &["given as EST and as REF"]);
    twice(
        &["near.tum", "ref.tum", "--prior", "near.tum"],
        &["given as EST and as --prior"],
    );
    twice(
        &["near.tum", "ref.tum", "--prior", "ref.tum"],
        &["given as REF and as --prior"],
    );
    twice(
        &["near.tum", "ref.tum", "--out", "ref.tum"],
        &["would replace REF"],
    );
    let noted = |call: &[&str], part: &str| {
        let answer = place.ballmark(&[&["trajectory"], call].concat());
        assert!(
            answer.done().stderr.contains(part),
            "{part} in {}",
            answer.stderr
        );
    };
    noted(&["copy.tum", "ref.tum"], "hold the same poses");
    noted(
        &["near.tum", "ref.tum", "--prior", "copy.tum"],
        "are --prior and REF swapped?",
    );
    noted(
        &["far.tum", "ref.tum", "--prior", "near.tum"],
        "prior and estimate swapped?",
    );
    std::fs::copy(place.path("near.tum"), place.path("again.tum")).unwrap();
    noted(
        &["near.tum", "ref.tum", "--prior", "again.tum"],
        "no correction changed an error",
    );
}

#[test]
fn what_is_no_file_and_what_is_no_call() {
    let place = Workplace::new();
    place.write("ref.tum", SOUND);
    place.write("est.tum", SOUND.replace(" 0 0 0 0 0 0 1", " 0 1 0 0 0 0 1"));
    place
        .ballmark(&["trajectory", "none.tum", "ref.tum"])
        .refused(1, &["none.tum", "cannot read"]);
    std::fs::create_dir(place.path("folder")).unwrap();
    place
        .ballmark(&["trajectory", "folder", "ref.tum"])
        .refused(1, &["folder", "expected a file"]);
    let refused = |more: &[&str], parts: &[&str]| {
        place
            .ballmark(&[&["trajectory", "est.tum", "ref.tum"], more].concat())
            .refused(2, parts);
    };
    refused(
        &["--out", "a.npz"],
        &["--out", "a.npz", ".tum, .txt or .csv"],
    );
    refused(&["--max-difference", "-1"], &["--max-difference"]);
    refused(&["--max-difference", "NaN"], &["--max-difference"]);
    refused(&["--offset", "inf"], &["--offset"]);
    refused(&["--delta", "0"], &["--delta", "above 0"]);
    refused(&["--delta", "1.5"], &["--delta", "whole number"]);
    refused(&["--delta", "200", "--delta-unit", "deg"], &["180"]);
    refused(&["--search-step", "10cm"], &["--search-step", "--prior"]);
    place.write(
        "prior.tum",
        SOUND.replace(" 0 0 0 0 0 0 1", " 0 2 0 0 0 0 1"),
    );
    let with_prior = |more: [&str; 2], parts: &[&str]| {
        refused(&["--prior", "prior.tum", more[0], more[1]], parts)
    };
    with_prior(["--truth-precision", "10"], &["--truth-precision", "`10`"]);
    refused(
        &["--prior", "prior.tum", "--truth-precision=-1m"],
        &["--truth-precision", "`-1m`"],
    );
    with_prior(
        ["--search-step", "1m,2m"],
        &["--search-step", "two lengths"],
    );
    with_prior(
        ["--prior-intervals", "2m,1m"],
        &["--prior-intervals", "rising"],
    );
    assert_eq!(place.ballmark(&["trajectory", "est.tum"]).status, 2);
    assert_eq!(
        place
            .ballmark(&["trajectory", "est.tum", "ref.tum", "--align", "best"])
            .status,
        2
    );
    // A folder that is not there is said before any work, and nothing is left behind.
    place
        .ballmark(&["trajectory", "est.tum", "ref.tum", "--out", "no/a.csv"])
        .refused(1, &["no/a.csv", "does not exist"]);
}
