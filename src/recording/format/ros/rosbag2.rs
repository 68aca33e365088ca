//! rosbag2 in SQLite: the tables `topics` and `messages` of a `.db3` file.

use super::{
    collector::{Collector, Connection, Encoding},
    cursor::Serialisation,
    part::Budget,
    sqlite::{Database, Row, Visited},
};
use crate::recording::content::Content;
use std::collections::BTreeMap;

/// Reads all that a file holds.
///
/// # Errors
/// What the file is instead of a bag, in words.
pub(super) fn read(file: &Content, collector: &mut Collector) -> Result<(), String> {
    let database = Database::open(file)?;
    let (topics_root, topic_columns) = database
        .table("topics")
        .ok_or("an SQLite database without a table `topics`; expected a rosbag2 file")?;
    let (root, columns) = database
        .table("messages")
        .ok_or("an SQLite database without a table `messages`; expected a rosbag2 file")?;
    let column = |columns: &[String], name: &str| {
        let found = columns.iter().position(|column| column == name);
        found.ok_or_else(|| format!("a table without a column `{name}`; expected those of rosbag2"))
    };
    let [id, name, type_name, format] =
        ["id", "name", "type", "serialization_format"].map(|name| column(&topic_columns, name));
    let topic_at = [id?, name?, type_name?, format?];
    let [topic, timestamp, data] =
        ["topic_id", "timestamp", "data"].map(|name| column(&columns, name));
    let message_at = [topic?, timestamp?, data?];

    let mut visited = Visited::default();
    let mut topics = BTreeMap::new();
    let mut faults = Vec::new();
    database.rows(
        topics_root,
        &mut visited,
        &mut |row| {
            if let Some((number, connection)) = connection(&row, topic_at) {
                topics.insert(number, connection);
            }
        },
        &mut |fault| faults.push(format!("table `topics`: {fault}")),
    );
    let mut reader = Reader {
        topics,
        message_at,
        budget: Budget::for_file(file.len()),
        collector,
    };
    database.rows(
        root,
        &mut visited,
        &mut |row| reader.message(&row, true),
        &mut |fault| {
            faults.push(format!("table `messages`: {fault}"));
        },
    );
    let short = database.stated_pages.saturating_sub(database.pages());
    if !faults.is_empty() || short > 0 {
        database.stray_rows(&mut visited, &mut |row| reader.message(&row, false));
    }
    for fault in faults {
        collector.lost(&"the bag", &fault);
    }
    if short > 0 {
        let stated = database.stated_pages;
        collector.lost(
            &"the end",
            &format!("{short} of {stated} pages are cut off"),
        );
    }
    if database.write_ahead {
        let what = "bag whose last messages may stand in a file of the same name and -wal, which isn't read";
        collector.account.warning(what);
    }
    Ok(())
}

fn connection(row: &Row, [id, name, type_name, format]: [usize; 4]) -> Option<(i64, Connection)> {
    // A column that is the row's number holds nothing itself.
    let number = row.cells.get(id)?.integer().unwrap_or(row.id);
    let text = |at: usize| Some(row.cells.get(at)?.text()?.to_string());
    let connection = Connection {
        topic: text(name)?,
        type_name: text(type_name)?,
        encoding: match text(format)?.as_str() {
            "cdr" => Encoding::Known(Serialisation::Cdr),
            other => Encoding::Other(other.to_string()),
        },
    };
    Some((number, connection))
}

struct Reader<'c, 'o> {
    topics: BTreeMap<i64, Connection>,
    message_at: [usize; 3],
    budget: Budget,
    collector: &'c mut Collector<'o>,
}

impl Reader<'_, '_> {
    /// Takes a row in; one that isn't of the table for sure must look like a message.
    fn message(&mut self, row: &Row, of_table: bool) {
        let place = format!("message {}", row.id);
        let [topic, timestamp, data] = self.message_at.map(|at| row.cells.get(at));
        let numbers = topic
            .and_then(|t| t.integer())
            .zip(timestamp.and_then(|t| t.integer()));
        let content = match data {
            Some(super::sqlite::Value::Bytes(bytes)) => Some(bytes),
            _ => None,
        };
        let (Some((topic, logged_ns)), Some(content)) = (numbers, content) else {
            if of_table {
                self.collector
                    .lost(&place, "a row without topic, time or data");
            }
            return;
        };
        let Some(connection) = self.topics.get(&topic) else {
            if of_table {
                let fault = format!("of topic {topic}, which the bag doesn't declare");
                self.collector.lost(&place, &fault);
            }
            return;
        };
        let logged_s = logged_ns as f64 * 1e-9;
        self.collector
            .take_packed(connection, logged_s, content, &place, &mut self.budget);
    }
}
