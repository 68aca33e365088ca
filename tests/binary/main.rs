//! The real binary, called as a user calls it: one test binary for all commands.

mod score;
mod support;
