//! Judge anybody's responses: how much do they tell about the place?
//!
//! `cargo run --release --example score_csv [answers.csv]`

use ballmark::{
    Result, Seed,
    report::{Table, verdict_tables},
    score::{Effort, Responses, Verdict},
};

/// Ten visits to three places, from a robot that takes the door for the hall now and then.
const ANSWERS: &str = "\
location,response,trial
hall,1,a
hall,1,a
door,2,a
door,1,a
office,3,a
hall,1,b
door,2,b
door,2,b
office,3,b
office,3,b
";

pub fn main() -> Result<()> {
    let responses = match std::env::args().nth(1).filter(|a| a.ends_with(".csv")) {
        Some(file) => Responses::read(file)?,
        None => Responses::from_reader("the built-in answers", ANSWERS.as_bytes())?,
    };
    let verdict = Verdict::new(&responses, Effort::default(), Seed(1));
    for note in &verdict.notes {
        eprintln!("note: {note}");
    }
    for table in verdict_tables(&verdict) {
        println!("{}", Table::text(&table));
    }
    Ok(())
}
