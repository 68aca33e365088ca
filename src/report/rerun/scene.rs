//! What all trials share: the map, colours, and how places, beliefs and answers are drawn.

use super::{paths, stream::Stream};
use crate::{
    error::Result,
    experiment::belief_traces::{BeliefTraces, Plan, TracedTrial},
    report::canvas::{INK, colour},
};
use plotters::style::RGBColor;
use re_sdk_types::{
    archetypes::{GridMap, LineStrips3D, Points3D, TextDocument, ViewCoordinates},
    components::{Color, Colormap, ImageFormat, MediaType, Radius},
    datatypes::{ChannelDatatype, ColorModel},
};

/// The map lies a little below all that moves on it, metres.
const BELOW_M: f64 = 0.05;

/// Height of a profile along a route, as a share of the route's length.
const PROFILE: f64 = 0.15;

/// Kept trials, with what drawing them needs again and again.
pub(super) struct Scene<'a> {
    pub traces: &'a BeliefTraces,
    /// Least and greatest x and y of all places, metres.
    pub low_m: [f64; 2],
    pub high_m: [f64; 2],
}

impl<'a> Scene<'a> {
    pub fn new(traces: &'a BeliefTraces) -> Self {
        let truths = traces.trials.iter().flat_map(|trial| &trial.truth);
        let places = traces.cells.iter().chain(truths);
        let (mut low_m, mut high_m) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for place in places {
            let [x, y, _] = point(traces.is_route, place);
            for (axis, m) in [x, y].into_iter().enumerate() {
                low_m[axis] = low_m[axis].min(m);
                high_m[axis] = high_m[axis].max(m);
            }
        }
        Self {
            traces,
            low_m,
            high_m,
        }
    }

    /// The map, and what is what.
    ///
    /// # Errors
    /// Where the map is damaged.
    pub fn draw(&self, stream: &mut Stream) -> Result<()> {
        let above = ViewCoordinates::RIGHT_HAND_Z_UP();
        stream.still(re_log_types::EntityPath::root(), &above)?;
        if let Some(plan) = &self.traces.plan {
            stream.still(paths::map(), &map(plan)?)?;
        }
        let about = TextDocument::new(self.about()).with_media_type(MediaType::markdown());
        stream.still(paths::about(), &about)
    }

    /// A place as a point.
    pub fn point(&self, place: &[f64]) -> [f64; 3] {
        point(self.traces.is_route, place)
    }

    /// How high a profile may rise, metres.
    pub fn profile_m(&self) -> f64 {
        (PROFILE * (self.high_m[0] - self.low_m[0])).max(1.0)
    }

    /// Squares that hold something, as points: the area grows with the root of the mass, and a peak stands out.
    pub fn squares(&self, levels: &[u8]) -> Points3D {
        let held = levels.iter().zip(&self.traces.cells);
        let held = held.filter(|(level, _)| **level > 0);
        let (places, radii): (Vec<[f64; 3]>, Vec<Radius>) = held
            .map(|(level, place)| {
                let share = f64::from(*level) / 255.0;
                let radius_m = 0.5 * self.traces.cell_m * (share.sqrt() + share);
                let radius = Radius::new_scene_units(radius_m as f32);
                (self.point(place), radius)
            })
            .unzip();
        Points3D::update_fields()
            .with_positions(places)
            .with_radii(radii)
    }

    /// What pieces of a route hold, as a line above it; within a level stretch it has two corners.
    pub fn profile(&self, levels: &[u8]) -> LineStrips3D {
        let half_m = 0.5 * self.traces.cell_m;
        let mut line: Vec<[f64; 3]> = Vec::new();
        for (level, place) in levels.iter().zip(&self.traces.cells) {
            let [x, y, z] = self.point(place);
            let y = y + f64::from(*level) / 255.0 * self.profile_m();
            match &mut line[..] {
                [.., last] if last[1] == y => last[0] = x + half_m,
                _ => line.extend([[x - half_m, y, z], [x + half_m, y, z]]),
            }
        }
        LineStrips3D::update_fields().with_strips([line])
    }

    fn about(&self) -> String {
        let mut lines = vec![
            "Trials of `ballmark localise` from a start anywhere: what each system believed, step by step.".to_string(),
            String::new(),
        ];
        for trial in &self.traces.trials {
            lines.push(format!("- {}", trial_title(trial)));
        }
        lines.push(String::new());
        lines.push("| system | entity | colour |\n|---|---|---|".to_string());
        for (system, [name, title]) in self.traces.systems.iter().enumerate() {
            let RGBColor(r, g, b) = colour(system);
            let cell = |text: &str| text.replace('|', "\\|");
            lines.push(format!(
                "| {} | `{}` | #{r:02X}{g:02X}{b:02X} |",
                cell(title),
                cell(name)
            ));
        }
        lines.push(String::new());
        lines.push(if self.traces.is_route {
            "x is the way along the route in metres. Lines above it are beliefs, as high as the root of the mass; the arrow is the truth, points \
             are answers. What the robot sees is in its own frame."
        } else {
            "x and y are metres, seen from above. Points are squares that a belief holds, their area as the root of the mass; the dark arrow is the \
             truth, larger points are answers. Grey ground is unknown to the map."
        }.to_string());
        lines.push("Time is the step of a trial, or centimetres from its start (`travelled_cm`): choose it in the time panel.".to_string());
        lines.join("\n")
    }
}

/// A trial in words, as the page's player has it.
pub(super) fn trial_title(trial: &TracedTrial) -> String {
    let length_m = trial.travelled_m.last().copied().unwrap_or(0.0);
    let why = trial.kept_as.join(", ");
    format!("{why} (number {}, {length_m:.1} m)", trial.number + 1)
}

fn point(is_route: bool, place: &[f64]) -> [f64; 3] {
    match place {
        [x, y, ..] if !is_route => [*x, *y, 0.0],
        [x, ..] => [*x, 0.0, 0.0],
        [] => [0.0; 3], // no place has no number: the traces were checked
    }
}

/// The colour of a system in every picture.
pub(super) fn of_system(system: usize) -> Color {
    let RGBColor(r, g, b) = colour(system);
    Color::from_rgb(r, g, b)
}

/// The colour of the truth.
pub(super) fn ink() -> Color {
    Color::from_rgb(INK.0, INK.1, INK.2)
}

/// The map in the shades of the page.
fn map(plan: &Plan) -> Result<GridMap> {
    let [width, height] = plan.size;
    let shade = |byte: &u8| match byte {
        0 => 205u8,
        1 => 255,
        _ => 0,
    };
    // A picture begins at its top, a plan at its least y.
    let bytes = plan.bytes()?;
    let rows = bytes.chunks(width.max(1)).rev();
    let pixels: Vec<u8> = rows.flat_map(|row| row.iter().map(shade)).collect();
    let size = [width as u32, height as u32];
    let format = ImageFormat::from_color_model(size, ColorModel::L, ChannelDatatype::U8);
    let [x, y] = plan.origin_m;
    Ok(GridMap::new(pixels, format, plan.cell_m as f32)
        .with_translation([x, y, -BELOW_M])
        .with_colormap(Colormap::Grayscale))
}
