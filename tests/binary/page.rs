//! The page of a report, and `ballmark view`, on the real binary.

use super::support::{Workplace, answer, binary};
use serde_json::Value;
use std::{fs, path::Path, process::Command};

/// Most bytes of a page.
const MOST: usize = 5_000_000;

/// A page is whole, stands alone, is no larger than it may be, and says all these words.
#[track_caller]
pub fn stands_alone(file: &Path, words: &[&str]) -> String {
    let html = fs::read_to_string(file).expect("a page");
    assert!(html.starts_with("<!doctype html>") && html.trim_end().ends_with("</html>"));
    assert!(html.len() < MOST, "{} bytes", html.len());
    for outside in [
        "src=\"http",
        "href=\"http",
        "src=\"//",
        "@import",
        "url(",
        "href=\"/",
    ] {
        assert!(!html.contains(outside), "{outside}");
    }
    for word in words {
        assert!(html.contains(word), "no `{word}` in the page");
    }
    html
}

/// What a page's player reads.
#[track_caller]
pub fn played(html: &str) -> Value {
    let start = "<script type=\"application/json\">";
    let data = html.split(start).nth(1).expect("a player");
    serde_json::from_str(data.split("</script>").next().unwrap()).expect("JSON")
}

/// A light that tells places apart along 30 m, in eight runs, and a model of it.
pub fn workplace() -> Workplace {
    let place = Workplace::new();
    let mut text = String::from("time_s,x_m,y_m,heading_rad,route_m,run,light.0,light.1\n");
    for k in 0..480 {
        let (run, x) = (k / 60, f64::from(k % 60) * 0.5 + 0.001 * f64::from(k / 60));
        let (a, b) = ((x * 0.4).sin(), (x * 0.13).cos());
        text += &format!("{k},{x},0,0,{x},{run},{a},{b}\n");
    }
    place.write("way.csv", text);
    place
        .ballmark(&["import", "way.csv", "-o", "way.npz"])
        .done();
    let train = [
        "train",
        "way.npz",
        "-o",
        "m.safetensors",
        "--steps",
        "20",
        "--test-fold",
        "3",
    ];
    place.ballmark(&train).done();
    place
}

#[test]
fn the_page_has_every_system_and_a_player_and_is_the_same_with_any_number_of_threads() {
    let place = workplace();
    let page = |threads: &str| {
        let mut command = Command::new(binary());
        let call = [
            "localise",
            "m.safetensors",
            "way.npz",
            "--trials",
            "5",
            "--out",
            "report",
        ];
        let call = command.args(call).env("RAYON_NUM_THREADS", threads);
        answer(call.current_dir(place.path(""))).done();
        let html = stands_alone(&place.path("report/index.html"), &[]);
        (
            html,
            fs::read_to_string(place.path("report/player.json")).unwrap(),
        )
    };
    let (html, player) = page("1");
    assert!(
        page("3") == (html.clone(), player.clone()),
        "threads change the page"
    );
    let words = [
        "localise m.safetensors way.npz --trials 5 --out report",
        "95 % interval",
        "<noscript>",
        "odometry alone",
    ];
    stands_alone(&place.path("report/index.html"), &words);

    let player: Value = serde_json::from_str(&player).unwrap();
    assert_eq!(played(&html)["traces"], player);
    let systems = player["systems"].as_array().unwrap();
    for system in systems {
        assert!(
            html.matches(system[1].as_str().unwrap()).count() >= 4,
            "{system}"
        );
    }
    // All systems play the same trials, step by step, and the answers are those that were judged.
    let trials = player["trials"].as_array().unwrap();
    assert!((1..=3).contains(&trials.len()) && trials[0]["number"] == 0);
    for trial in trials {
        let steps = trial["travelled_m"].as_array().unwrap().len();
        assert_eq!(trial["systems"].as_array().unwrap().len(), systems.len());
        for system in trial["systems"].as_array().unwrap() {
            for k in 0..steps {
                let truth = trial["truth"][k][0].as_f64().unwrap();
                let error_m = system["point_error_m"][k].as_f64().unwrap();
                if let Some(at) = system["answer"][k][0].as_f64() {
                    assert!(((at - truth).abs() - error_m).abs() < 0.003, "{trial}");
                }
            }
        }
    }
    // Where nothing is to be written nothing is kept.
    place
        .ballmark(&[
            "localise",
            "m.safetensors",
            "way.npz",
            "--trials",
            "2",
            "--json",
        ])
        .done();
    assert!(!place.path("player.json").exists());
}

#[test]
fn a_page_is_found_and_a_browser_that_is_not_there_is_one_line() {
    let place = Workplace::new();
    place.write(
        "r.csv",
        "location,response\nhall,1\nhall,1\ndoor,<b>2\ndoor,1\n",
    );
    let scored = place.ballmark(&["score", "r.csv", "--out", "scored", "--permutations", "100"]);
    scored.done();
    let html = stands_alone(
        &place.path("scored/index.html"),
        &["Contingency table", "&lt;b&gt;2", "uncertainty_coefficient"],
    );
    assert!(!html.contains("<b>2") && !html.contains("<script"));
    for ending in ["json", "txt", "csv", "md", "tex"] {
        assert!(
            place.path(&format!("scored/score.{ending}")).is_file(),
            "{ending}"
        );
    }
    for folder in ["scored", "scored/index.html"] {
        let said = place.ballmark(&["view", folder]);
        let page = said.done().stdout.trim_end();
        assert!(
            Path::new(page).is_absolute() && Path::new(page).is_file(),
            "{page}"
        );
        assert!(page.ends_with("index.html") && said.stderr.is_empty());
    }
    for wrong in [".", "nowhere", "r.csv"] {
        place
            .ballmark(&["view", wrong])
            .refused(1, &[wrong, "no index.html here", "--out"]);
    }
    let mut command = Command::new(binary());
    let call = command.args(["view", "scored", "--open"]).env("PATH", "");
    let said = answer(call.current_dir(place.path("")));
    assert_eq!(said.status, 1, "{}", said.stderr);
    assert_eq!(said.stderr.lines().count(), 1);
    for words in ["error: cannot show ", "index.html", "by hand"] {
        assert!(said.stderr.contains(words), "{}", said.stderr);
    }
}
