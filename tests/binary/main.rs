//! The real binary, called as a user calls it: one test binary for all commands.

mod bank;
mod camera_views;
mod compare;
mod compare_localisation;
mod configs;
mod degraded;
mod device;
mod given_map;
mod help;
mod import;
mod import_frames;
mod limits;
mod localise;
mod model;
mod pretrain;
mod remembered;
mod reproduce;
mod score;
mod simulate;
mod support;
mod train;
mod trajectory;
mod trajectory_faults;
mod unsteady_robots;
mod viewpoint;
mod worlds;
