//! How the viewer lays the recording out at first: a tab a trial, views of a few systems from above, and their numbers beside them.

use super::{
    paths,
    scene::{Scene, trial_title},
    stream::Stream,
};
use crate::{
    error::Result,
    experiment::belief_traces::{SensedTrial, TracedTrial},
};
use re_log_types::{EntityPath, TimePoint, Timeline};
use re_sdk_types::{
    AsComponents,
    blueprint::{
        archetypes::{
            Background, ContainerBlueprint, EyeControls3D, LineGrid3D, PanelBlueprint,
            PlotBackground, PlotLegend, TimePanelBlueprint, ViewBlueprint, ViewContents,
            ViewportBlueprint,
        },
        components::{
            BackgroundKind, ContainerKind, Corner2D, Eye3DKind, PanelState, RootContainer,
        },
    },
    components::Color,
};

/// Systems whose views are side by side: of plans, and of routes, which are long and low. What a view is wider than high then.
const OF_PLANS: (u32, f64) = (2, 1.2);
const OF_ROUTES: (u32, f64) = (1, 2.5);

/// Height of the eye above what a view holds up and down, as a share of it: the viewer's eye opens 55°.
const EYE: f64 = 1.1;

/// How far the eye is above a robot, metres.
const ABOVE_ROBOT_M: f64 = 14.0;

/// Lays out a tab for each trial; views of systems that are not `shown` are there, hidden.
pub(super) fn lay_out(
    stream: &mut Stream,
    scene: &Scene<'_>,
    sensed: &[SensedTrial],
    shown: &[usize],
) -> Result<()> {
    stream.begin_blueprint();
    let mut layout = Layout { stream, scene };
    let mut tabs = Vec::new();
    for (index, trial) in scene.traces.trials.iter().enumerate() {
        tabs.push(layout.trial(trial, sensed.get(index), shown)?);
    }
    let about = View::new("TextDocument", "What is what", EntityPath::root())
        .with_contents(vec![format!("+ {}", paths::about())]);
    tabs.push(layout.view(about)?);
    let first = tabs.first().cloned().unwrap_or_default();
    let (_, root) = layout.container(
        ContainerBlueprint::new(ContainerKind::Tabs)
            .with_contents(tabs)
            .with_active_tab(first),
    )?;
    let viewport = ViewportBlueprint::new()
        .with_root_container(RootContainer(root))
        .with_auto_layout(false)
        .with_auto_views(false);
    layout.put("viewport", &viewport)?;
    layout.put(
        "time_panel",
        &TimePanelBlueprint::new().with_timeline("step"),
    )?;
    let hidden = PanelBlueprint::new().with_state(PanelState::Hidden);
    layout.put("selection_panel", &hidden)?;
    stream.end_blueprint();
    Ok(())
}

/// A view to be.
struct View {
    class: &'static str,
    name: String,
    origin: EntityPath,
    contents: Vec<String>,
    is_visible: bool,
    properties: Vec<(&'static str, Box<dyn AsComponents>)>,
}

impl View {
    fn new(class: &'static str, name: impl Into<String>, origin: EntityPath) -> Self {
        let white = Background::new(BackgroundKind::SolidColor).with_color(Color::WHITE);
        let properties: Vec<(&'static str, Box<dyn AsComponents>)> = match class {
            // On white, as all pictures are; the ground has no lines of its own.
            "3D" => vec![
                ("Background", Box::new(white)),
                (
                    "LineGrid3D",
                    Box::new(LineGrid3D::new().with_visible(false)),
                ),
            ],
            // Errors are largest at first, and their names stand where they are small.
            "TimeSeries" => vec![
                (
                    "PlotBackground",
                    Box::new(PlotBackground::new().with_color(Color::WHITE)),
                ),
                (
                    "PlotLegend",
                    Box::new(PlotLegend::new().with_corner(Corner2D::RightTop)),
                ),
            ],
            _ => Vec::new(),
        };
        Self {
            class,
            name: name.into(),
            origin,
            contents: vec!["$origin/**".into()],
            is_visible: true,
            properties,
        }
    }

    fn with_contents(mut self, contents: Vec<String>) -> Self {
        self.contents = contents;
        self
    }

    /// Looked at from straight above a place, y upwards.
    fn seen_from_above(mut self, [x, y]: [f64; 2], height_m: f64, up: [f64; 2]) -> Self {
        let eye = EyeControls3D::new()
            .with_kind(Eye3DKind::Orbital)
            .with_position([x, y, height_m])
            .with_look_target([x, y, 0.0])
            .with_eye_up([up[0], up[1], 0.0]);
        self.properties.push(("EyeControls3D", Box::new(eye)));
        self
    }
}

struct Layout<'a, 'b> {
    stream: &'a mut Stream,
    scene: &'a Scene<'b>,
}

impl Layout<'_, '_> {
    /// A trial's tab: its path.
    fn trial(
        &mut self,
        trial: &TracedTrial,
        sensed: Option<&SensedTrial>,
        shown: &[usize],
    ) -> Result<String> {
        let path = paths::trial(trial);
        // Those that are shown come first, in the order of the table.
        let systems = &self.scene.traces.systems;
        let mut order: Vec<usize> = shown.to_vec();
        order.extend((0..systems.len()).filter(|system| !shown.contains(system)));
        let mut views = Vec::new();
        for system in order {
            let view = self.system(&path, system);
            let is_visible = shown.contains(&system);
            views.push(self.view(View { is_visible, ..view })?);
        }
        let (left, _) = self.container(
            ContainerBlueprint::new(ContainerKind::Grid)
                .with_display_name("systems")
                .with_contents(views)
                .with_grid_columns(self.shape().0),
        )?;
        let right = self.beside(&path, sensed)?;
        let (tab, _) = self.container(
            ContainerBlueprint::new(ContainerKind::Horizontal)
                .with_display_name(trial_title(trial))
                .with_contents([left, right])
                .with_col_shares([3.0, 2.0]),
        )?;
        Ok(tab)
    }

    /// Columns of views, and how much wider than high a view is.
    fn shape(&self) -> (u32, f64) {
        match self.scene.traces.is_route {
            true => OF_ROUTES,
            false => OF_PLANS,
        }
    }

    /// What one system makes of the trial, from above.
    fn system(&self, path: &EntityPath, system: usize) -> View {
        let scene = self.scene;
        let [name, title] = &scene.traces.systems[system];
        let (robot, belief) = (paths::robot(path), paths::named(path, "belief", name));
        let answer = paths::named(path, "answer", name);
        let mut contents = vec![
            format!("+ {}", paths::map()),
            format!("+ {path}/way"),
            format!("+ {robot}/heading"),
            format!("+ {belief}"),
            format!("+ {answer}/**"),
        ];
        if !scene.traces.is_route {
            contents.push(format!("+ {robot}/scan/**"));
        }
        let size = [0, 1].map(|axis| scene.high_m[axis] - scene.low_m[axis]);
        let middle = [0, 1].map(|axis| 0.5 * (scene.high_m[axis] + scene.low_m[axis]));
        let seen_m = size[1].max(size[0] / self.shape().1).max(4.0);
        View::new("3D", title.clone(), EntityPath::root())
            .with_contents(contents)
            .seen_from_above(middle, EYE * seen_m, [0.0, 1.0])
    }

    /// What the robot sees, what its networks make of it, and the systems' numbers.
    fn beside(&mut self, path: &EntityPath, sensed: Option<&SensedTrial>) -> Result<String> {
        let mut parts = Vec::new();
        let mut shares: Vec<f32> = Vec::new();
        let mut tabs = Vec::new();
        if sensed.is_some_and(|sensed| !sensed.scans.is_empty()) {
            let robot = paths::robot(path);
            // Ahead is up.
            let view = View::new("3D", "what the robot sees", robot).seen_from_above(
                [0.0; 2],
                ABOVE_ROBOT_M,
                [1.0, 0.0],
            );
            tabs.push(self.view(view)?);
        }
        if sensed.is_some_and(|sensed| !sensed.features.is_empty()) {
            for (class, name, title) in [
                ("BarChart", "now", "features"),
                ("TimeSeries", "over_time", "features over time"),
            ] {
                let origin = paths::named(path, "features", name);
                tabs.push(self.view(View::new(class, title, origin))?);
            }
        }
        if !tabs.is_empty() {
            let (sensed, _) =
                self.container(ContainerBlueprint::new(ContainerKind::Tabs).with_contents(tabs))?;
            parts.push(sensed);
            shares.push(1.5);
        }
        for (kind, title) in [
            ("expected_error_m", "expected error (m)"),
            ("point_error_m", "distance of the answer from the truth (m)"),
        ] {
            parts.push(self.numbers(path, kind, title)?);
            shares.push(1.0);
        }
        let mut rest = Vec::new();
        for (kind, title) in [
            ("entropy_nats", "entropy (nats)"),
            ("says_lost", "says that it is lost"),
        ] {
            rest.push(self.numbers(path, kind, title)?);
        }
        let (rest, _) =
            self.container(ContainerBlueprint::new(ContainerKind::Tabs).with_contents(rest))?;
        parts.push(rest);
        shares.push(1.0);
        let (all, _) = self.container(
            ContainerBlueprint::new(ContainerKind::Vertical)
                .with_contents(parts)
                .with_row_shares(shares),
        )?;
        Ok(all)
    }

    fn numbers(&mut self, path: &EntityPath, kind: &'static str, title: &str) -> Result<String> {
        let origin = path.join(&re_log_types::entity_path!(kind));
        self.view(View::new("TimeSeries", title, origin))
    }

    /// Writes a view: its path.
    fn view(&mut self, view: View) -> Result<String> {
        let path = format!("/view/{}", self.stream.uuid());
        let blueprint = ViewBlueprint::new(view.class)
            .with_display_name(view.name)
            .with_space_origin(view.origin.to_string())
            .with_visible(view.is_visible);
        self.put(&path, &blueprint)?;
        self.put(
            &format!("{path}/ViewContents"),
            &ViewContents::new(view.contents),
        )?;
        for (name, property) in &view.properties {
            self.put(&format!("{path}/{name}"), property.as_ref())?;
        }
        Ok(path)
    }

    /// Writes a container: its path, and its identifier.
    fn container(
        &mut self,
        container: ContainerBlueprint,
    ) -> Result<(String, re_sdk_types::datatypes::Uuid)> {
        let id = self.stream.uuid();
        let path = format!("/container/{id}");
        self.put(&path, &container)?;
        Ok((path, id.into()))
    }

    fn put(&mut self, path: &str, content: &dyn AsComponents) -> Result<()> {
        let when = TimePoint::default().with(Timeline::new_sequence("blueprint"), 0);
        self.stream.rows(EntityPath::from(path), [(when, content)])
    }
}
