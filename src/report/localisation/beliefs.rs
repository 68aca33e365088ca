//! What was kept of beliefs, on a page: the player, the map, and where errors are made.

use super::best_rival;
use crate::{
    error::{Error, Result},
    experiment::{
        belief_traces::{BeliefTraces, Plan},
        localisation::Record,
    },
    report::{Curve, Part, line_plot, player, scatter_plot},
};
use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};

/// Systems side by side at first.
const SHOWN: usize = 4;

/// The player, the map and the errors over the plan; nothing where no beliefs were kept.
///
/// # Errors
/// Where what was kept is damaged.
pub fn belief_parts(title: &str, record: &Record) -> Result<Vec<Part>> {
    let Some(traces) = &record.beliefs else {
        return Ok(Vec::new());
    };
    let shown = systems_at_first(record, traces);
    let mut parts = vec![Part::Heading("The belief, step by step".into())];
    parts.extend(player(traces, &shown)?);
    parts.push(Part::Heading("Where it fails".into()));
    parts.extend(errors(title, traces, &shown)?);
    if let Some(plan) = &traces.plan {
        parts.push(Part::Heading("The map".into()));
        parts.push(map(plan)?);
    }
    Ok(parts)
}

/// The systems that are seen at first: the first, its best rival, who works from the occupancy map, and the last, which is odometry alone
/// by default.
pub fn systems_at_first(record: &Record, traces: &BeliefTraces) -> Vec<usize> {
    let named = |name: &str| traces.systems.iter().position(|system| system[0] == name);
    let rival = best_rival::name(record).and_then(named);
    let last = traces.systems.len().checked_sub(1);
    let mut shown: Vec<usize> = Vec::new();
    for system in [Some(0), rival, named("likelihood_field"), last]
        .into_iter()
        .flatten()
    {
        if !shown.contains(&system) && shown.len() < SHOWN {
            shown.push(system);
        }
    }
    shown
}

/// Mean point error by place: along a route of all systems, in the plane a picture a system that is shown.
fn errors(title: &str, traces: &BeliefTraces, shown: &[usize]) -> Result<Vec<Part>> {
    let of = |system: usize| {
        let errors = traces.errors.iter();
        errors.map(move |here| here.point_error_m.get(system).copied().flatten())
    };
    let worst = |system: usize| {
        let all = of(system).zip(&traces.errors);
        let worst = all.filter_map(|(error_m, here)| Some((error_m?, &here.at)));
        let worst = worst.max_by(|a, b| a.0.total_cmp(&b.0));
        worst.map_or(String::new(), |(error_m, at)| {
            let at: Vec<String> = at.iter().map(|m| format!("{m:.0}")).collect();
            format!(
                "{} {error_m:.1} m at ({}) m",
                traces.systems[system][1],
                at.join(", ")
            )
        })
    };
    let caption = "Mean point error over all trials from a start anywhere, 10 m after the start or later, by square metre";
    if traces.is_route {
        let curves: Vec<Curve> = (0..traces.systems.len())
            .map(|system| Curve {
                name: traces.systems[system][1].clone(),
                x: traces.errors.iter().map(|here| here.at[0]).collect(),
                y: of(system)
                    .map(|error_m| error_m.unwrap_or(f64::NAN))
                    .collect(),
                band: None,
            })
            .collect();
        let plot = line_plot(
            &format!("{title}: error by place"),
            "along the route (m)",
            "mean point error (m)",
            &curves,
        )?;
        let alt: Vec<String> = shown.iter().map(|&system| worst(system)).collect();
        return Ok(vec![Part::picture(
            caption.replace("square metre", "metre of the route") + ".",
            format!("Mean point error by place; largest: {}", alt.join("; ")),
            plot,
        )]);
    }
    let (x, y): (Vec<f64>, Vec<f64>) = traces
        .errors
        .iter()
        .map(|here| (here.at[0], here.at[1]))
        .unzip();
    let largest = |&system: &usize| of(system).flatten().fold(0.0, f64::max);
    // One scale for all, up to where most of the last, odometry, would swamp the others.
    let most = shown
        .iter()
        .map(largest)
        .fold(0.0, f64::max)
        .clamp(1.0, 10.0);
    let mut parts = Vec::new();
    for &system in shown {
        let values: Vec<f64> = of(system)
            .map(|error_m| error_m.unwrap_or(f64::NAN))
            .collect();
        let name = &traces.systems[system][1];
        let plot = scatter_plot(
            &format!("{title}: {name}"),
            "error (m)",
            &x,
            &y,
            &values,
            Some((0.0, most)),
        )?;
        let caption = format!(
            "{name}: {}; {most:.0} m and more are of one colour.",
            lower_first(caption)
        );
        parts.push(Part::picture(
            caption,
            format!("Mean point error over the plan; largest: {}", worst(system)),
            plot,
        ));
    }
    Ok(parts)
}

fn lower_first(words: &str) -> String {
    let mut letters = words.chars();
    let first = letters.next().map(|c| c.to_lowercase().to_string());
    first.unwrap_or_default() + letters.as_str()
}

/// The map as a picture: a pixel a cell, y upwards.
fn map(plan: &Plan) -> Result<Part> {
    let [width, height] = plan.size;
    let bytes = plan.bytes()?;
    let shade = |byte: &u8| match byte {
        0 => 205u8,
        1 => 255,
        _ => 0,
    };
    let rows = bytes.chunks(width.max(1)).rev();
    let pixels: Vec<u8> = rows.flat_map(|row| row.iter().map(shade)).collect();
    let mut png = Vec::new();
    let drawn = PngEncoder::new(&mut png).write_image(
        &pixels,
        width as u32,
        height as u32,
        ExtendedColorType::L8,
    );
    drawn.map_err(|e| Error::work(format!("cannot draw the map: {e}")))?;
    let (wide_m, high_m) = (width as f64 * plan.cell_m, height as f64 * plan.cell_m);
    let occupied = bytes.iter().filter(|byte| **byte == 2).count();
    Ok(Part::Image {
        caption: format!(
            "The map that the likelihood field uses, {wide_m:.0} m by {high_m:.0} m in cells of {:.2} m: black occupied, \
             white free, grey unknown.",
            plan.cell_m
        ),
        alt: format!("Occupancy map of {width} by {height} cells, {occupied} of them occupied"),
        png,
    })
}
