//! Days of a world that changes.

use crate::support::Workplace;

const SMALL: &str = "
[lifelong]
set = 'd3'
[train]
features = 2
uncertainty = 'global'
[adapt.update]
steps = 2
";

#[test]
fn robots_live_some_days_and_what_came_of_it_is_written_down() {
    let place = Workplace::new();
    place.write("small.toml", SMALL);
    let call = [
        "lifelong",
        "small.toml",
        "--toy",
        "--seeds",
        "1",
        "--out",
        "out",
    ];
    let told = place.ballmark(&call);
    let table = &told.done().stdout;
    for words in [
        "the world changes",
        "nothing changes",
        "no gate, filter's labels",
        "true labels",
    ] {
        assert!(table.contains(words), "{words} is missing in {table}");
    }
    assert!(
        table.lines().all(|line| line.chars().count() <= 110),
        "{table}"
    );
    for name in ["lifelong.json", "days.csv", "days.svg"] {
        assert!(place.path("out").join(name).exists(), "{name}");
    }
    let text = std::fs::read_to_string(place.path("out/lifelong.json")).unwrap();
    let record: serde_json::Value = serde_json::from_str(&text).unwrap();
    let worlds = record["worlds"].as_array().unwrap();
    assert_eq!(worlds.len(), 2);
    assert_eq!(worlds[0]["robots"][0]["kind"], "frozen");
    assert_eq!(record["config"]["set"], "d3");
}

#[test]
fn what_makes_no_sense_is_refused_with_its_line() {
    let place = Workplace::new();
    place.write("few.toml", "[lifelong]\ndays = 1\n");
    let few = place.ballmark(&["lifelong", "few.toml"]);
    few.refused(2, &["few.toml: line 2", "lifelong.days"]);
    place.write("set.toml", "[lifelong]\nset = 'd7'\n");
    place
        .ballmark(&["lifelong", "set.toml"])
        .refused(2, &["d1, d2 or d3"]);
    place
        .ballmark(&["lifelong", "none.toml"])
        .refused(1, &["none.toml"]);
}
