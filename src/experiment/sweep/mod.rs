//! Sweeps: one command with many configurations, as cells that run anywhere and are collected into one table.
//!
//! A [sweep file](SweepConfig) names a command, what all cells share and what they differ in. [`make_plan`] reads every combination as the
//! command will, and names each cell by a digest of program version, configuration and data. Whoever runs it, in whatever order, on
//! whatever machine, leaves one file with the same bytes; a cell that has it is never run again, and a cell whose inputs changed has
//! another name. There is no scheduler here: [`run_missing`] starts the missing cells of one machine, Ray, Slurm and GNU parallel start
//! them elsewhere by the same `ballmark sweep run-cell`. `docs/sweeps.md` says how.

mod attempt;
mod cell;
mod collect;
mod command;
mod config;
mod figures;
mod folder;
mod inputs;
mod key;
mod lock;
mod memory;
mod plan;
mod record;
mod run;
mod scratch;
mod slurm;
mod status;

pub use attempt::{Attempt, ENDS_WITH_PARENT, Ended, Runner, Started};
pub use cell::{Base, Cell, VERSION};
pub use collect::{Collected, collect_results};
pub use command::Command;
pub use config::SweepConfig;
pub use figures::{at_path, headline_figures};
pub use folder::Sweep;
pub use inputs::{Input, InputFile};
pub use memory::{ASSUMED_BYTES, available_bytes, fits};
pub use plan::{Plan, Planned, described, make_plan, shown};
pub use record::{CellRow, Hole, SweepRecord, SweepRow};
pub use run::{Progress, Ran, Share, measured_bytes, of_a_cell, run_missing};
pub use slurm::{parallel_line, slurm_script};
pub use status::{FailedCell, RunningCell, Status};
