//! Results as tables and pictures: text in, text out; whoever calls writes the files.

mod table;

pub use table::{Cell, Table};
