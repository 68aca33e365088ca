//! The real binary, called as a user calls it: one test binary for all commands.

mod help;
mod import;
mod limits;
mod score;
mod support;
