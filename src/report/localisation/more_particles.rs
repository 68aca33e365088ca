//! Whether more particles change a row, in a line below the table.

use crate::experiment::localisation::{MoreParticles, Record};

/// A line for everybody who played with more particles; a warning where they change the result.
pub fn more_particles(record: &Record) -> Vec<String> {
    record
        .more_particles
        .iter()
        .map(|check| in_words(record, check))
        .collect()
}

fn in_words(record: &Record, check: &MoreParticles) -> String {
    let result = |name: &str| record.results.iter().find(|result| result.name == name);
    let (own, more) = (result(&check.test.against), result(&check.test.name));
    let title = own.map_or(&*check.test.against, |result| &result.title);
    let found = [own, more].map(|result| {
        let share = result.map_or(f64::NAN, |result| result.global.converged_fraction);
        format!("{:.0}", 100.0 * share)
    });
    let of = |particles: usize, found: &str| format!("{found} % found with {particles} particles");
    let (few, many) = (of(check.particles, &found[0]), of(check.more, &found[1]));
    match (check.changes, check.test.is_too_few()) {
        (true, false) => {
            format!("warning: {title}: {few},\n  {many}: more of them change the result")
        }
        (true, true) => format!(
            "warning: {title}: {few},\n  {many}: more of them may change the result (too few stretches for a test)"
        ),
        (false, _) => format!("{title}: {few},\n  {many}: no change beyond chance"),
    }
}
