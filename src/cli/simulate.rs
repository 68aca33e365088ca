//! `ballmark simulate`: a simulated building and robot become a dataset.

use super::{Outcome, print, progress::PatientProgress};
use crate::{
    error::{Error, Result},
    recording::{Recording, npz},
    report::{Plan, PlanLine, plan_plot},
    seed::Seed,
    storage,
    world::{
        Building, RunScene, Wall,
        simulation::{Choice, first_run, simulate_watched},
    },
};
use nalgebra::{Rotation2, Vector2};
use serde_json::{Value, json};
use std::{fmt::Write, path::PathBuf};

/// Simulate a robot in a building and record what its sensors say.
///
/// A world is one TOML: walls, doors, windows, lamps, a robot, its sensors, its way, and who walks about.
#[derive(Debug, clap::Args)]
#[command(after_long_help = HELP)]
pub struct Arguments {
    /// The world.
    #[arg(value_name = "WORLD.toml")]
    world: PathBuf,

    /// Dataset to write.
    #[arg(short, long, value_name = "D.npz")]
    output: PathBuf,

    /// Seed of everything that differs from run to run.
    #[arg(long, default_value_t = 1)]
    seed: u64,

    /// Only this set of the world's runs; without it all of them, one after another.
    #[arg(long, value_name = "NAME")]
    set: Option<String>,

    /// This number of runs of each set, instead of the world's.
    #[arg(long, value_name = "N")]
    runs: Option<usize>,

    /// Also draw the plan as the first run finds it, its lamps, and the way of that run.
    #[arg(long, value_name = "P.svg")]
    plan: Option<PathBuf>,

    /// Print the summary as one JSON object.
    #[arg(long)]
    json: bool,
}

const HELP: &str = "\
A world has tables [materials.NAME], [building], [[wall]] with [[wall.door]], [[wall.window]], [[wall.niche]], \
[[wall.hallway]] and [[wall.paint]], [[thing]], [[light]], [[fire_door]], [robot], [sonar], [infrared], [laser], [camera], \
[compass], [path], [record], [[set]], [days] and [people]. Lengths are metres; an unknown key is an error.

Exit status: 0 done, 1 the robot can't drive so (it gets out, hits a wall), 2 the world or the call is wrong.

Example:
  printf 'name = \"hall\"\\nsonar = {}\\n' > hall.toml
  printf 'record = {every_m = 0.5}\\n' >> hall.toml
  printf 'path = {corners = [[1,2],[8,2]]}\\n' >> hall.toml
  printf '[[wall]]\\nclosed = true\\n' >> hall.toml
  printf 'points = [[0,0],[9,0],[9,4],[0,4]]\\n' >> hall.toml
  ballmark simulate hall.toml -o hall.npz";

pub fn run(arguments: Arguments) -> Result<Outcome> {
    for target in [Some(&arguments.output), arguments.plan.as_ref()]
        .into_iter()
        .flatten()
    {
        storage::check_target(target)?; // a wrong name fails now, not after the driving
    }
    let world = Building::read(&arguments.world)?;
    let choice = Choice {
        set: arguments.set.clone(),
        runs: arguments.runs,
    };
    let in_world = |fault: Error| fault.in_file(&arguments.world);
    let seed = Seed(arguments.seed);
    let progress = PatientProgress::new("simulating");
    let recording = simulate_watched(&world, seed, &choice, &|done, of| {
        progress.at(done, of, "snapshots");
    });
    progress.done();
    let recording = recording.map_err(in_world)?;
    let picture = match &arguments.plan {
        Some(_) => {
            let first = first_run(&world, &choice)?;
            let scene = world.plan_of_run(seed, first)?;
            Some(plan_plot(
                &format!("{}, run {first}", world.name()),
                &plan(&scene, &recording),
            )?)
        }
        None => None,
    };
    npz::write(&arguments.output, &recording)?;
    if let (Some(file), Some(svg)) = (&arguments.plan, picture) {
        storage::write_file(file, |out| out.write_all(svg.as_bytes()))?;
    }
    if arguments.json {
        print(&format!("{}\n", summary(&world, &recording, &arguments)))?;
    } else {
        print(&table(&world, &recording, &arguments))?;
    }
    Ok(Outcome::Done)
}

/// What the picture of a plan shows: all that stands in the way of light, and the way of the first run.
fn plan(scene: &RunScene, recording: &Recording) -> Plan {
    let line = |wall: &Wall, thin: bool| PlanLine {
        from: [wall.from.x, wall.from.y],
        to: [wall.to.x, wall.to.y],
        colour: wall.material.look.colour,
        window: wall.material.look.daylight.iter().any(|light| *light > 0.0),
        thin,
    };
    let walls = scene.plan.walls().iter();
    let daylit = |wall: &Wall| wall.material.look.daylight.iter().any(|light| *light > 0.0);
    let walls = walls.map(|wall| line(wall, wall.low_m > 0.0 && !daylit(wall)));
    let fire_doors = scene.fire_doors.iter().map(|door| line(door, false));
    let lamps = scene.lights.iter().map(|lamp| {
        let turn = Rotation2::new(lamp.heading_rad);
        let [length_m, width_m] = lamp.size_m;
        let corners = [[0.5, 0.5], [-0.5, 0.5], [-0.5, -0.5], [0.5, -0.5]].map(|[ahead, aside]| {
            let corner = lamp.at + turn * Vector2::new(ahead * length_m, aside * width_m);
            [corner.x, corner.y]
        });
        (corners, lamp.lit)
    });
    let first = recording.runs().first().cloned().unwrap_or(0..0);
    Plan {
        lines: walls.chain(fire_doors).collect(),
        lamps: lamps.collect(),
        path: recording.poses()[first]
            .iter()
            .map(|pose| [pose.x_m, pose.y_m])
            .collect(),
    }
}

fn summary(world: &Building, recording: &Recording, arguments: &Arguments) -> Value {
    let channels = recording.channels().iter();
    let channels = channels.map(
        |c| json!({ "name": c.name, "values": c.width, "unit": c.unit, "maximum": c.maximum }),
    );
    json!({
        "output": arguments.output.display().to_string(),
        "world": world.name(),
        "seed": arguments.seed,
        "set": arguments.set,
        "snapshots": recording.len(),
        "runs": recording.runs().len(),
        "path_m": recording.path_m(),
        "channels": channels.collect::<Vec<_>>(),
    })
}

fn table(world: &Building, recording: &Recording, arguments: &Arguments) -> String {
    let mut out = String::new();
    let mut row = |name: &str, value: String| {
        let _ = writeln!(out, "{name:<12} {value}"); // writing to a String can't fail
    };
    row("dataset", arguments.output.display().to_string());
    row("world", world.name().to_string());
    row("snapshots", recording.len().to_string());
    row("runs", recording.runs().len().to_string());
    row("path", format!("{:.1} m", recording.path_m()));
    for channel in recording.channels() {
        row(
            "channel",
            format!(
                "{}: {} values in {}",
                channel.name, channel.width, channel.unit
            ),
        );
    }
    out
}
