//! One trial: the truth, what was sensed, and what each system made of it.

use super::{
    paths,
    scene::{Scene, ink, of_system},
    stream::{Stream, When},
};
use crate::{
    error::Result,
    experiment::belief_traces::{SensedScan, SensedTrial, TracedSystem, TracedTrial},
};
use re_log_types::{EntityPath, entity_path};
use re_sdk_types::{
    archetypes::{Arrows3D, BarChart, LineStrips3D, Points3D, Scalars, SeriesLines, Transform3D},
    components::{Color, Radius, RotationAxisAngle},
    datatypes::{Angle, TensorBuffer, TensorData},
};

/// Length of the arrow that points ahead, metres; along a route a share of the profile's height.
const ARROW_M: f64 = 0.8;

/// Radius of an answer, metres.
const ANSWER_M: f32 = 0.2;

/// The colours of beams and of what they meet.
const BEAM: [u8; 3] = [190, 190, 190];
const MET: [u8; 3] = [110, 110, 110];

pub(super) fn draw(
    stream: &mut Stream,
    scene: &Scene<'_>,
    trial: &TracedTrial,
    sensed: Option<&SensedTrial>,
) -> Result<()> {
    let path = paths::trial(trial);
    let when: Vec<When> = trial
        .travelled_m
        .iter()
        .enumerate()
        .map(|(step, &travelled_m)| When { step, travelled_m })
        .collect();
    draw_truth(stream, scene, trial, &path, &when)?;
    if let Some(sensed) = sensed {
        for scan in &sensed.scans {
            draw_scan(stream, &path, &when, scan)?;
        }
        draw_features(stream, &path, &when, &sensed.features)?;
    }
    let systems = scene.traces.systems.iter().zip(&trial.systems);
    for (index, (names, seen)) in systems.enumerate() {
        let drawn = System {
            names,
            colour: of_system(index),
            path: &path,
            when: &when,
        };
        drawn.draw_place(stream, scene, seen)?;
        drawn.draw_numbers(stream, seen)?;
    }
    Ok(())
}

fn draw_truth(
    stream: &mut Stream,
    scene: &Scene<'_>,
    trial: &TracedTrial,
    path: &EntityPath,
    when: &[When],
) -> Result<()> {
    let robot = paths::robot(path);
    let frames = trial.truth.iter().map(|truth| {
        let frame = Transform3D::from_translation(scene.point(truth));
        Some(match heading_rad(scene, truth) {
            Some(heading) => frame.with_rotation(about_up(heading)),
            None => frame,
        })
    });
    stream.steps(robot.clone(), when.iter().copied().zip(frames))?;
    let length_m = match scene.traces.is_route {
        true => 0.3 * scene.profile_m(),
        false => ARROW_M,
    };
    let arrow = Arrows3D::from_vectors([[length_m, 0.0, 0.0]])
        .with_origins([[0.0, 0.0, 0.0]])
        .with_radii([Radius::new_ui_points(2.5)])
        .with_colors([ink()]);
    stream.still(robot.join(&entity_path!("heading")), &arrow)?;
    let way: Vec<[f64; 3]> = trial.truth.iter().map(|t| scene.point(t)).collect();
    let way = LineStrips3D::new([way])
        .with_radii([Radius::new_ui_points(0.7)])
        .with_colors([ink()]);
    stream.still(path.join(&entity_path!("way")), &way)
}

/// Beams and what they met, in the robot's frame.
fn draw_scan(
    stream: &mut Stream,
    path: &EntityPath,
    when: &[When],
    scan: &SensedScan,
) -> Result<()> {
    let robot = paths::robot(path);
    let [met, beams] = ["scan", "beams"].map(|kind| paths::named(&robot, kind, &scan.channel));
    let flat = |[x, y]: [f64; 2]| [x, y, 0.0];
    let points = scan.beams.iter().map(|beams| {
        let ends = beams.iter().map(|beam| flat(beam.to));
        Some(Points3D::update_fields().with_positions(ends))
    });
    stream.steps(met.clone(), when.iter().copied().zip(points))?;
    let lines = scan.beams.iter().map(|beams| {
        let lines = beams.iter().map(|beam| [flat(beam.from), flat(beam.to)]);
        Some(LineStrips3D::update_fields().with_strips(lines))
    });
    stream.steps(beams.clone(), when.iter().copied().zip(lines))?;
    let style = Points3D::update_fields()
        .with_colors([MET])
        .with_radii([Radius::new_ui_points(2.0)]);
    stream.still(met, &style)?;
    let style = LineStrips3D::update_fields()
        .with_colors([BEAM])
        .with_radii([Radius::new_ui_points(0.5)]);
    stream.still(beams, &style)
}

fn draw_features(
    stream: &mut Stream,
    path: &EntityPath,
    when: &[When],
    features: &[Vec<f32>],
) -> Result<()> {
    let Some(first) = features.first() else {
        return Ok(());
    };
    let bars = features.iter().map(|values| {
        let buffer = TensorBuffer::F32(values.clone().into());
        let tensor = TensorData::new(vec![values.len() as u64], buffer);
        Some(BarChart::new(tensor).with_color(of_system(0)))
    });
    let [now, over_time] = ["now", "over_time"].map(|name| paths::named(path, "features", name));
    stream.steps(now, when.iter().copied().zip(bars))?;
    let lines = features
        .iter()
        .map(|values| Some(Scalars::new(values.iter().copied())));
    stream.steps(over_time.clone(), when.iter().copied().zip(lines))?;
    let names = (1..=first.len()).map(|number| format!("feature {number}"));
    stream.still(over_time, &SeriesLines::new().with_names(names))
}

/// A system along one trial.
struct System<'a> {
    /// Key and title.
    names: &'a [String; 2],
    colour: Color,
    path: &'a EntityPath,
    when: &'a [When],
}

impl System<'_> {
    fn at(&self, kind: &'static str) -> EntityPath {
        paths::named(self.path, kind, &self.names[0])
    }

    /// What it believed, and where it said to be.
    fn draw_place(
        &self,
        stream: &mut Stream,
        scene: &Scene<'_>,
        seen: &TracedSystem,
    ) -> Result<()> {
        let levels = scene.traces.levels(seen)?;
        let belief = self.at("belief");
        let steps = || self.when.iter().copied();
        if scene.traces.is_route {
            let profiles = levels.iter().map(|levels| Some(scene.profile(levels)));
            stream.steps(belief.clone(), steps().zip(profiles))?;
            let style = LineStrips3D::update_fields()
                .with_colors([self.colour])
                .with_radii([Radius::new_ui_points(1.5)]);
            stream.still(belief, &style)?;
        } else {
            let squares = levels.iter().map(|levels| Some(scene.squares(levels)));
            stream.steps(belief.clone(), steps().zip(squares))?;
            stream.still(
                belief,
                &Points3D::update_fields().with_colors([self.colour]),
            )?;
        }
        // Where there is none, none is drawn: an empty row ends the one before.
        let answer = self.at("answer");
        let places = seen.answer.iter().map(|answer| {
            let places = answer.iter().map(|place| scene.point(place));
            Some(Points3D::update_fields().with_positions(places))
        });
        stream.steps(answer.clone(), steps().zip(places))?;
        let radius_m = match scene.traces.is_route {
            true => 0.06 * scene.profile_m() as f32,
            false => ANSWER_M,
        };
        let style = Points3D::update_fields()
            .with_colors([self.colour])
            .with_radii([radius_m]);
        stream.still(answer.clone(), &style)?;
        let faces = |place: &Vec<f64>| heading_rad(scene, place);
        if !seen.answer.iter().flatten().any(|a| faces(a).is_some()) {
            return Ok(());
        }
        let heading = answer.join(&entity_path!("heading"));
        let arrows = seen.answer.iter().map(|answer| {
            let faced = answer
                .iter()
                .filter_map(|place| Some((scene.point(place), faces(place)?)));
            let (origins, vectors): (Vec<_>, Vec<_>) = faced
                .map(|(at, rad)| (at, [ARROW_M * rad.cos(), ARROW_M * rad.sin(), 0.0]))
                .unzip();
            Some(
                Arrows3D::update_fields()
                    .with_origins(origins)
                    .with_vectors(vectors),
            )
        });
        stream.steps(heading.clone(), steps().zip(arrows))?;
        let style = Arrows3D::update_fields()
            .with_colors([self.colour])
            .with_radii([Radius::new_ui_points(1.5)]);
        stream.still(heading, &style)
    }

    /// The record's numbers, a line each.
    fn draw_numbers(&self, stream: &mut Stream, seen: &TracedSystem) -> Result<()> {
        let all = |values: &[f64]| values.iter().copied().map(Some).collect::<Vec<_>>();
        let lost = |is_lost: &Option<bool>| is_lost.map(|is_lost| f64::from(u8::from(is_lost)));
        for (kind, values) in [
            ("expected_error_m", all(&seen.expected_error_m)),
            ("point_error_m", all(&seen.point_error_m)),
            ("entropy_nats", seen.entropy_nats.clone()),
            ("says_lost", seen.is_lost.iter().map(lost).collect()),
        ] {
            if values.iter().all(Option::is_none) {
                continue;
            }
            let path = self.at(kind);
            let rows = values.iter().map(|value| value.map(Scalars::single));
            stream.steps(path.clone(), self.when.iter().copied().zip(rows))?;
            let style = SeriesLines::new()
                .with_names([self.names[1].as_str()])
                .with_colors([self.colour])
                .with_widths([2.0]);
            stream.still(path, &style)?;
        }
        Ok(())
    }
}

/// The heading of a place that has one.
fn heading_rad(scene: &Scene<'_>, place: &[f64]) -> Option<f64> {
    match place {
        [_, _, heading, ..] if !scene.traces.is_route => Some(*heading),
        _ => None,
    }
}

fn about_up(heading_rad: f64) -> RotationAxisAngle {
    RotationAxisAngle::new([0.0, 0.0, 1.0], Angle::from_radians(heading_rad as f32))
}
