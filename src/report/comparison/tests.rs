//! Tables and pictures from a record that no experiment made.

use super::*;
use serde_json::{Value, json};

fn judgement(coefficient: f64) -> Value {
    json!({
        "n": 100, "locations": 5, "responses": 16, "entropy_of_location": 1.5,
        "entropy_of_location_given_response": 0.5, "uncertainty_coefficient": coefficient,
        "uncertainty_coefficient_corrected": coefficient - 0.05, "permutation_p": 0.001, "ci95": [0.3, 0.4],
    })
}

fn standard(mean: f64) -> Value {
    json!({ "done": {
        "places": 36, "bytes_per_place": 152, "trials": 263, "bins": 14, "units": 3, "responses": 15,
        "unanswered": 0.25, "outside": 0.0, "entropy_of_location": 2.5,
        "by_distance": [
            { "distance_m": 0.0, "entropy_of_location": 2.5, "entropy_of_location_given_response": 1.0,
              "uncertainty_coefficient": 0.6, "uncertainty_coefficient_corrected": null },
            { "distance_m": 0.1, "entropy_of_location": 2.5, "entropy_of_location_given_response": 0.5,
              "uncertainty_coefficient": 0.8, "uncertainty_coefficient_corrected": 0.7 },
        ],
        "mean_uncertainty_coefficient": mean, "mean_uncertainty_coefficient_corrected": 0.65,
        "mean_entropy_of_location_given_response": 0.75, "distance_at_coefficient_m": null,
        "distance_from_coefficient_on_m": 12.5, "mean_posterior_coefficient": -0.125, "at_end": judgement(0.8),
        "ci95_of_mean": [0.6, 0.7], "notes": ["all trials start in one lap"],
    }})
}

fn recognition(coefficient: f64) -> Value {
    json!({ "done": {
        "config": { "kind": "nearest" }, "patterns": 18, "responses": 16, "wanted": 16, "unanswered": 0.0, "bytes_per_place": 64, "matches": 18,
        "judgement": judgement(coefficient),
    }})
}

fn reduction(share: f64) -> Value {
    let score = json!({ "prior_error_m": 1.0, "posterior_error_m": 0.5, "error_reduction": share, "snapshots": 9 });
    json!({ "done": { "points": [{ "prior": "2m", "score": score }] } })
}

/// Two systems on two datasets; the second fails on B, and there are no ceiling lights.
fn comparison() -> Comparison {
    let failed = json!({ "failed": { "why": "gcs: no cells" } });
    let dataset = |name: &str, notes: Value| json!({ "name": name, "source": null, "sha256": null, "snapshots": 9, "mapping": 3, "testing": 6, "notes": notes });
    let system = |name: &str, kind: &str| json!({ "name": name, "kind": kind, "what": "…" });
    let found = json!({ "done": {
        "detector": "door", "snapshots": 9, "true_positives": 3, "false_positives": 1, "missed": 0,
        "precision": 0.75, "recall": 1.0,
    }});
    let section = |config: Value, systems: Value, cells: Value| json!({ "config": config, "systems": systems, "cells": cells });
    let both = json!([0, 1]);
    let json = json!({
        "version": "0.1.0", "seed": 7, "truth": "pose",
        "datasets": [dataset("A", json!(["no compass"])), dataset("B", json!(["no compass", "one lap"]))],
        "systems": [system("nearest", "nearest"), system("gcs", "growing_cells"), system("door", "door")],
        "standard": section(json!({}), both.clone(), json!([[standard(0.7), standard(0.5)], [standard(0.8), failed]])),
        "recognition": section(json!({}), both.clone(), json!([[recognition(0.65), recognition(0.55)], [recognition(0.7), failed]])),
        "recognition_tests": [{ "systems": [0, 1], "n": 1, "t": 2.5, "p": 0.0321, "p_holm": 0.0642 }],
        "error_reduction": section(json!({ "priors": ["2m", "global"] }), both, json!([[reduction(0.4), reduction(0.2)], [reduction(0.3), failed]])),
        "landmarks": section(json!({}), json!([2]), json!([[found, "not_asked"]])),
        "config": {},
        "timing": { "seconds": 3.0, "seconds_per_match": [[2e-6, 4e-6], [9e-6, null]] },
    });
    serde_json::from_value(json).unwrap()
}

fn sheet(name: &str) -> Sheet {
    let sheets = sheets(&comparison());
    let found = sheets.into_iter().find(|sheet| sheet.name == name);
    found.unwrap_or_else(|| panic!("no sheet {name}"))
}

#[test]
fn a_matrix_has_systems_down_datasets_across_and_their_mean() {
    assert_eq!(
        sheet("standard-matrix").table.text(),
        "system       A           B   mean\n\
         -------  -----  ----------  -----\n\
         nearest  0.700       0.500  0.600\n\
         gcs      0.800  failed [1]      –\n\
         [1] gcs: no cells\n"
    );
    let recognition = sheet("recognition-matrix").table.text();
    assert!(
        recognition.contains("nearest  0.650       0.550  0.600\n"),
        "{recognition}"
    );
}

#[test]
fn every_cell_of_the_standard_experiment_has_its_row() {
    let csv = sheet("standard").table.csv();
    let rows: Vec<&str> = csv.lines().collect();
    assert_eq!(
        rows[0],
        "dataset,system,trials,bins,mean U,corrected,low,high,H(L|R) nats,m to 0.9,for good m,end U,posterior U"
    );
    assert_eq!(
        rows[1],
        "A,nearest,263,14,0.7,0.65,0.6,0.7,0.75,,12.5,0.8,-0.125"
    );
    assert_eq!(rows[4], "B,gcs,failed,,,,,,,,,,");
    assert!(
        sheet("standard")
            .table
            .text()
            .contains("\nall trials start in one lap\n")
    );
    let answers = sheet("standard-answers").table.csv();
    assert!(
        answers.contains("\nA,nearest,15,25,0,,36,152\n"),
        "{answers}"
    );
    assert_eq!(
        sheet("standard-curves").table.csv().lines().count(),
        1 + 3 * 2
    );
    assert_eq!(sheet("standard-curves").reader, Reader::Programs);
}

#[test]
fn tests_stand_above_the_diagonal_and_corrected_below() {
    let text = sheet("recognition-tests").table.text();
    assert!(
        text.contains("nearest        –  0.032\ngcs        0.064      –\n"),
        "{text}"
    );
    let pairs = sheet("recognition-pairs").table.csv();
    assert!(
        pairs.ends_with("nearest,gcs,1,2.5,0.0321,0.0642\n"),
        "{pairs}"
    );
}

#[test]
fn costs_are_told_in_units_of_the_nearest_neighbour() {
    let text = sheet("cost").table.text();
    assert!(
        text.contains("nearest      18.0          64       3.000  1.00\n"),
        "{text}"
    );
    assert!(
        text.contains("gcs          18.0          64       9.000  3.00\n"),
        "{text}"
    );
    let mut without = comparison();
    without.record.systems[0].kind = "rce".into();
    let sheets = sheets(&without);
    let cost = sheets.iter().find(|sheet| sheet.name == "cost").unwrap();
    assert!(
        cost.table.text().contains("none takes part"),
        "{}",
        cost.table.text()
    );
}

#[test]
fn error_reductions_and_landmarks_have_a_column_a_figure() {
    let csv = sheet("error-reduction").table.csv();
    assert_eq!(
        csv,
        "dataset,system,2m %,global %\nA,nearest,40,\nA,gcs,30,\nB,nearest,20,\nB,gcs,failed,\n"
    );
    let landmarks = sheet("landmarks").table;
    assert!(
        landmarks
            .csv()
            .contains("A,door,9,3,1,0,0.75,1\nB,door,,,,,,\n"),
        "{}",
        landmarks.csv()
    );
    assert!(landmarks.text().contains("without a plan"));
}

#[test]
fn the_caption_tells_whose_notes_are_whose() {
    let caption = caption_lines(&comparison().record);
    assert_eq!(
        caption,
        [
            "truth: the recordings' poses",
            "no compass",
            "B: one lap",
            "seed 7, ballmark 0.1.0"
        ]
    );
}

#[test]
fn there_is_a_picture_a_dataset_and_one_of_costs() {
    let pictures = pictures(&comparison()).unwrap();
    let names: Vec<&str> = pictures.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(
        names,
        [
            "standard-A",
            "standard-B",
            "quality-against-cost",
            "error-reduction-A",
            "error-reduction-B"
        ]
    );
    assert!(pictures[2].1.contains("in units of the nearest neighbour"));
    assert!(pictures[3].1.contains("global"));
    // One curve a system that answered.
    let lines = |svg: &str| {
        svg.matches("stroke-width=\"4\" points").count() + svg.matches("<polyline").count()
    };
    assert!(lines(&pictures[0].1) > lines(&pictures[1].1));
}

#[test]
fn a_record_is_the_same_after_json() {
    let first = comparison();
    let json = serde_json::to_string(&first).unwrap();
    let again: Comparison = serde_json::from_str(&json).unwrap();
    assert_eq!(again, first);
    assert_eq!(serde_json::to_string(&again).unwrap(), json);
    let keys: Value = serde_json::from_str(&json).unwrap();
    assert!(keys["standard"]["cells"][1][1]["failed"]["why"] == "gcs: no cells");
}
