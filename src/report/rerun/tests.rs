use super::*;
use crate::experiment::belief_traces::{Beam, SensedScan};
use base64::{Engine, prelude::BASE64_STANDARD};
use re_chunk::Chunk;
use re_log_encoding::DecoderApp;
use re_log_types::{LogMsg, StoreKind, TimelineName};
use re_sdk_types::{
    ComponentDescriptor,
    archetypes::{Arrows3D, BarChart, LineStrips3D, Points3D, Scalars, SeriesLines, Transform3D},
    blueprint::archetypes::{ContainerBlueprint, ViewBlueprint},
};
use std::io::Write;

fn packed(bytes: &[u8]) -> String {
    let mut packer = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    packer.write_all(bytes).unwrap();
    BASE64_STANDARD.encode(packer.finish().unwrap())
}

/// Two trials of two steps in the plane; the first system is a filter, the second says only where it is, and not always.
fn traces() -> BeliefTraces {
    let trial = |number: usize| {
        serde_json::json!({
            "number": number, "kept_as": ["the first"], "snapshots": [number, number + 1], "travelled_m": [0.0, 0.507],
            "truth": [[1.0, 2.0, 0.0], [1.5, 2.0, 1.5]],
            "systems": [{
                "answer": [[3.0, 1.0, 0.25], [1.5, 2.0, 1.5]], "expected_error_m": [2.5, 0.125 + number as f64],
                "point_error_m": [2.236, 0.0], "entropy_nats": [1.5, 0.5], "is_lost": [true, false],
                "mass": packed(&[128, 0, 64, 255, 0, 0]),
            }, {
                "answer": [null, [1.0, 1.0]], "expected_error_m": [4.0, 1.0], "point_error_m": [4.0, 1.0],
                "entropy_nats": [null, null], "is_lost": [null, null], "mass": "",
            }],
        })
    };
    serde_json::from_value(serde_json::json!({
        "is_route": false, "cell_m": 0.5, "cells": [[1.0, 2.0], [1.5, 2.0], [3.0, 1.0]],
        "plan": { "cell_m": 0.5, "origin_m": [-1.0, -2.0], "size": [3, 2], "cells": packed(&[2, 1, 1, 0, 0, 0]) },
        "systems": [["learned", "4 learned"], ["odd name/[1]", "<odd>"]], "errors": [], "trials": [trial(0), trial(6)],
    }))
    .unwrap()
}

fn sensed() -> Vec<SensedTrial> {
    let beam = |to: [f64; 2]| Beam {
        from: [0.25, 0.0],
        to,
    };
    let of_trial = |number| SensedTrial {
        number,
        scans: vec![SensedScan {
            channel: "laser".into(),
            beams: vec![vec![beam([2.0, 0.0]), beam([0.0, 3.0])], vec![]],
        }],
        features: vec![vec![0.25, 0.75], vec![1.0, 0.0]],
    };
    vec![of_trial(0), of_trial(6)]
}

/// Step and centimetres, where a value has a time, and what it is.
type Row<T> = (Option<[i64; 2]>, Vec<T>);

/// What stands in a file.
struct Read {
    chunks: Vec<(StoreKind, Chunk)>,
    others: Vec<LogMsg>,
}

impl Read {
    fn of(bytes: &[u8]) -> Self {
        let (mut chunks, mut others) = (Vec::new(), Vec::new());
        for message in DecoderApp::decode_lazy(bytes) {
            match message.unwrap() {
                LogMsg::ArrowMsg(store, message) => {
                    chunks.push((store.kind(), Chunk::from_arrow_msg(&message).unwrap()));
                }
                other => others.push(other),
            }
        }
        Self { chunks, others }
    }

    fn chunks(&self, path: &str) -> Vec<&Chunk> {
        let chunks = self.chunks.iter();
        let here = chunks.filter(|(_, chunk)| chunk.entity_path().to_string() == path);
        here.map(|(_, chunk)| chunk).collect()
    }

    /// A component's values with their steps and centimetres; those that always hold have neither.
    fn rows<T: Copy>(
        &self,
        path: &str,
        component: ComponentDescriptor,
        values: impl Fn(&Chunk, &ComponentDescriptor) -> Vec<Vec<T>>,
    ) -> Vec<Row<T>> {
        let mut rows = Vec::new();
        for chunk in self.chunks(path) {
            let times = |name: &'static str| {
                let column = chunk.timelines().get(&TimelineName::from(name));
                column.map(|column| column.times_raw().to_vec())
            };
            let (steps, centimetres) = (times("step"), times("travelled_cm"));
            for (row, values) in values(chunk, &component).into_iter().enumerate() {
                let when = steps
                    .as_ref()
                    .zip(centimetres.as_ref())
                    .map(|(s, cm)| [s[row], cm[row]]);
                rows.push((when, values));
            }
        }
        rows
    }

    fn numbers(&self, path: &str) -> Vec<Row<f64>> {
        self.rows(path, Scalars::descriptor_scalars(), |chunk, component| {
            let slices = chunk.iter_slices::<f64>(component.component);
            slices.map(<[f64]>::to_vec).collect()
        })
    }

    fn points(&self, path: &str, component: ComponentDescriptor) -> Vec<Row<[f32; 3]>> {
        self.rows(path, component, |chunk, component| {
            let slices = chunk.iter_slices::<[f32; 3]>(component.component);
            slices.map(<[[f32; 3]]>::to_vec).collect()
        })
    }
}

#[test]
fn a_recording_holds_the_records_numbers_and_the_scans_at_their_steps() {
    let bytes = recorded("a title", &traces(), &sensed(), &[0]).unwrap();
    let read = Read::of(&bytes);
    let (start, later) = (Some([0, 0]), Some([1, 51]));
    assert_eq!(
        read.numbers("/trials/7/expected_error_m/learned"),
        [(start, vec![2.5]), (later, vec![6.125])]
    );
    assert_eq!(
        read.numbers("/trials/1/says_lost/learned"),
        [(start, vec![1.0]), (later, vec![0.0])]
    );
    assert_eq!(
        read.numbers("/trials/1/features/over_time"),
        [(start, vec![0.25, 0.75]), (later, vec![1.0, 0.0])]
    );
    // What nobody said is not there.
    let odd = r"odd\ name\/\[1\]";
    assert!(
        read.chunks(&format!("/trials/1/entropy_nats/{odd}"))
            .is_empty()
    );
    assert_eq!(read.numbers("/trials/1/entropy_nats/learned").len(), 2);
    let bars = read.chunks("/trials/1/features/now");
    assert!(
        bars[0].num_rows() == 2
            && bars[0]
                .components()
                .contains_component(BarChart::descriptor_values().component)
    );

    // Where the robot is, and what it senses in its own frame.
    assert_eq!(
        read.points("/trials/1/robot", Transform3D::descriptor_translation()),
        [
            (start, vec![[1.0, 2.0, 0.0]]),
            (later, vec![[1.5, 2.0, 0.0]])
        ]
    );
    assert_eq!(
        read.points(
            "/trials/1/robot/scan/laser",
            Points3D::descriptor_positions()
        ),
        [
            (start, vec![[2.0, 0.0, 0.0], [0.0, 3.0, 0.0]]),
            (later, vec![])
        ]
    );
    // Squares that hold something, and answers: where there is none the one before ends.
    assert_eq!(
        read.points("/trials/1/belief/learned", Points3D::descriptor_positions()),
        [
            (start, vec![[1.0, 2.0, 0.0], [3.0, 1.0, 0.0]]),
            (later, vec![[1.0, 2.0, 0.0]])
        ]
    );
    assert!(
        read.chunks(&format!("/trials/1/belief/{odd}")).is_empty()
            || read
                .points(
                    &format!("/trials/1/belief/{odd}"),
                    Points3D::descriptor_positions()
                )
                .is_empty()
    );
    assert_eq!(
        read.points(
            &format!("/trials/1/answer/{odd}"),
            Points3D::descriptor_positions()
        ),
        [(start, vec![]), (later, vec![[1.0, 1.0, 0.0]])]
    );
    let heading = read.points(
        "/trials/1/answer/learned/heading",
        Arrows3D::descriptor_vectors(),
    );
    assert!(heading.len() == 2 && heading[0].1[0][1] > 0.0);
}

#[test]
fn systems_have_the_colours_of_the_pictures_and_no_clock_is_in_it() {
    let bytes = recorded("a title", &traces(), &sensed(), &[0, 1]).unwrap();
    let read = Read::of(&bytes);
    for (system, name) in ["learned", r"odd\ name\/\[1\]"].into_iter().enumerate() {
        let colour = read.rows(
            &format!("/trials/7/point_error_m/{name}"),
            SeriesLines::descriptor_colors(),
            |chunk, component| {
                let slices = chunk.iter_slices::<u32>(component.component);
                slices.map(<[u32]>::to_vec).collect()
            },
        );
        let plotters::style::RGBColor(r, g, b) = super::super::canvas::colour(system);
        let word = u32::from_be_bytes([r, g, b, 255]);
        assert_eq!(colour, [(None, vec![word])]);
    }
    for (store, chunk) in &read.chunks {
        let mut names: Vec<&str> = chunk.timelines().keys().map(|name| name.as_str()).collect();
        names.sort_unstable();
        let known: &[&[&str]] = match store {
            StoreKind::Recording => &[&[], &["step", "travelled_cm"]],
            StoreKind::Blueprint => &[&["blueprint"]],
        };
        assert!(known.contains(&&names[..]), "{names:?}");
    }
    // The layout is there, whole, and goes with the recording.
    let stores: Vec<_> = read.others.iter().map(|m| m.store_id().clone()).collect();
    assert_eq!(stores.len(), 3, "two stores and the layout's activation");
    assert!(matches!(
        read.others.last(),
        Some(LogMsg::BlueprintActivationCommand(_))
    ));
    assert_eq!(stores[0].recording_id(), stores[1].recording_id());
    let has = |component: ComponentDescriptor| {
        let chunks = read.chunks.iter();
        let with =
            chunks.filter(|(_, chunk)| chunk.components().contains_component(component.component));
        with.count()
    };
    // A trial: two systems, what the robot sees, features twice, four numbers.
    assert_eq!(has(ViewBlueprint::descriptor_class_identifier()), 2 * 9 + 1);
    assert_eq!(
        has(ContainerBlueprint::descriptor_container_kind()),
        2 * 5 + 1
    );
}

#[test]
fn the_same_trials_are_the_same_bytes_and_others_are_another_recording() {
    let once = recorded("a title", &traces(), &sensed(), &[0]).unwrap();
    assert!(
        once.ends_with(&[0; 16]),
        "the end of a stream, of no length"
    );
    for _ in 0..4 {
        assert!(recorded("a title", &traces(), &sensed(), &[0]).unwrap() == once);
    }
    let mut others = sensed();
    others[1].features[0][0] = 0.5;
    let other = recorded("a title", &traces(), &others, &[0]).unwrap();
    let name = |bytes: &[u8]| Read::of(bytes).others[0].store_id().clone();
    assert_ne!(name(&once), name(&other));
}

#[test]
fn a_route_is_a_line_and_beliefs_stand_above_it() {
    let mut traces = traces();
    traces.is_route = true;
    traces.plan = None;
    traces.cells = vec![vec![0.5], vec![1.0], vec![1.5]];
    for trial in &mut traces.trials {
        trial.truth = vec![vec![0.5], vec![1.5]];
        trial.systems[0].answer = vec![Some(vec![1.5]), None];
        trial.systems[1].answer = vec![None, None];
    }
    let read = Read::of(&recorded("a title", &traces, &[], &[0]).unwrap());
    let profile = read.rows(
        "/trials/1/belief/learned",
        LineStrips3D::descriptor_strips(),
        |chunk, component| {
            let strips = chunk.iter_slices::<&[[f32; 3]]>(component.component);
            let lines = strips.map(|row| row.iter().flat_map(|strip| strip.to_vec()).collect());
            lines.collect::<Vec<Vec<[f32; 3]>>>()
        },
    );
    assert_eq!(profile.len(), 2);
    // 255, 0, 0: up over the first piece, two pieces on the ground.
    let corners = [
        [0.25, 1.0, 0.0],
        [0.75, 1.0, 0.0],
        [0.75, 0.0, 0.0],
        [1.75, 0.0, 0.0],
    ];
    assert_eq!(profile[1].1, corners);
    let answers = read.points("/trials/1/answer/learned", Points3D::descriptor_positions());
    assert_eq!(answers[0].1, [[1.5, 0.0, 0.0]]);
    assert!(read.chunks("/map").is_empty() && read.chunks("/trials/1/features/now").is_empty());
}

#[test]
fn what_does_not_belong_together_is_refused() {
    let mut others = sensed();
    others[1].number = 5;
    let error = recorded("a title", &traces(), &others, &[0]).unwrap_err();
    assert!(error.to_string().contains("other trials"), "{error}");
    let mut damaged = traces();
    damaged.trials[0].systems.pop();
    let error = recorded("a title", &damaged, &[], &[0]).unwrap_err();
    assert!(error.to_string().contains("trial 0"), "{error}");
}
