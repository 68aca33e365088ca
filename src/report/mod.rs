//! Results as tables, pictures and pages: values in, text out (plain, CSV, Markdown, LaTeX, SVG, HTML); the caller writes the files.

pub mod adaptation;
mod canvas;
pub mod comparison;
mod contingency;
mod latex;
mod legend;
pub mod lifelong;
pub mod localisation;
mod page;
mod paper;
mod plan;
mod plane;
mod plot;
mod price;
pub mod reproduction;
#[cfg(feature = "rerun")]
pub mod rerun;
pub mod ruizmayor2006;
mod scatter;
mod still;
pub mod sweep;
mod table;
pub mod thrun1998;
mod trajectory;
mod verdict;

pub use contingency::{answers_plot, contingency_plot};
pub use page::{Page, Part, page, player};
pub use plan::{Plan, PlanLine, plan_plot};
pub use plot::{Curve, Panel, Trace, category_plot, framed_plot, line_plot, stacked_plot};
pub use price::{Priced, price_plot};
pub use scatter::scatter_plot;
pub use table::{Cell, Table};
pub use trajectory::{conditions_text, runs_tables, traces_plot, trajectory_tables};
pub use verdict::{verdict_in_words, verdict_tables};
