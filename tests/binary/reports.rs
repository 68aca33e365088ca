//! What every command that evaluates leaves in the folder of its report, on the real binary.

use super::{
    page::{stands_alone, workplace},
    support::Workplace,
};
use serde_json::Value;
use std::fs;

/// Runs a command and looks for its record, tables, pictures, configuration and page in a folder.
#[track_caller]
fn leaves(place: &Workplace, call: &str, [record, table, picture, config]: [&str; 4]) -> Value {
    place.ballmark(&Vec::from_iter(call.split(' '))).done();
    let read = |name: String| {
        let path = place.path("out").join(&name);
        fs::read(&path).unwrap_or_else(|e| panic!("{call}: {name}: {e}"))
    };
    for ending in ["txt", "csv", "md", "tex"] {
        assert!(read(format!("{table}.{ending}")).len() > 10, "{table}");
    }
    let svg = String::from_utf8(read(format!("{picture}.svg"))).unwrap();
    assert!(svg.trim_end().ends_with("</svg>"));
    assert!(read(format!("{picture}.png")).starts_with(b"\x89PNG"));
    let json = |name: &str| -> Value { serde_json::from_slice(&read(name.into())).expect(name) };
    assert!(json(config).is_object(), "{config}");
    // That of a comparison is the same when it is drawn again, by another call.
    let is_named = !call.starts_with("compare");
    let page = stands_alone(&place.path("out/index.html"), &[]);
    assert_eq!(page.contains(call), is_named, "{call}");
    let record = json(record);
    fs::remove_dir_all(place.path("out")).unwrap();
    record
}

#[test]
fn every_report_has_record_tables_pictures_configuration_and_page() {
    let place = workplace();
    let localised = leaves(
        &place,
        "localise m.safetensors way.npz --trials 4 --out out",
        [
            "localisation.json",
            "localisation",
            "found_by_distance",
            "config-2m.json",
        ],
    );
    assert!(localised["systems"].as_array().unwrap().len() > 3);
    assert!(localised.get("timing").is_none());
    let seen = leaves(
        &place,
        "features m.safetensors way.npz -o f.csv --report out",
        ["features.json", "features", "features", "config.json"],
    );
    let last = seen["sets"][0]["features"].as_array().unwrap().last();
    let mean = last.unwrap()["mean_probability"].as_f64().unwrap();
    let table = fs::read_to_string(place.path("f.csv")).unwrap();
    let column = table
        .lines()
        .skip(1)
        .map(|row| row.rsplit(',').next().unwrap());
    let column = Vec::from_iter(column.map(|p| p.parse::<f64>().unwrap()));
    assert!((mean - column.iter().sum::<f64>() / column.len() as f64).abs() < 1e-6);
    assert_eq!(seen["snapshots"], column.len());

    place.write(
        "r.csv",
        "location,response\nhall,1\nhall,1\ndoor,2\ndoor,1\n",
    );
    let scored = leaves(
        &place,
        "score r.csv --out out --permutations 50",
        ["score.json", "score", "contingency", "config.json"],
    );
    place.write(
        "ref.tum",
        "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n2 2 0 0 0 0 0 1\n",
    );
    place.write(
        "est.tum",
        "0 0 .1 0 0 0 0 1\n1 1 .1 0 0 0 0 1\n2 2 .2 0 0 0 0 1\n",
    );
    let judged = leaves(
        &place,
        "trajectory est.tum ref.tum --report out",
        ["trajectory.json", "errors", "traces-est", "config.json"],
    );
    let config = "[[dataset]]\nname = \"way\"\nfile = \"way.npz\"\n[[system]]\nkind = \"nearest\"\n\
                  [protocol]\nmapping = \"split\"\n[recognition]\nbin_m = 5.0\npermutations = 49\nresamples = 49\n";
    place.write("c.toml", config);
    let compared = leaves(
        &place,
        "compare c.toml --out out",
        [
            "comparison.json",
            "recognition",
            "contingency-recognition-way-nearest",
            "config.json",
        ],
    );
    let of_dataset = &compared["datasets"][0];
    for record in [&localised, &seen, &scored, &judged, of_dataset] {
        assert_eq!(
            record["protocol"]["hash"].as_str().map(str::len),
            Some(16),
            "{record}"
        );
    }
}
