//! The real binary, called as a user calls it: one test binary for all commands.

mod import;
mod score;
mod support;
