//! Learn landmarks from a recording, localise with them on stretches that training never saw, and print how it went.
//!
//! `cargo run --release --example train_and_localise`

use ballmark::{
    Recipe, Result, Training,
    experiment::{
        localisation::{LocaliseConfig, localise},
        parts::Parts,
    },
    learning::trainer::Directive,
    recording::npz,
    report::localisation::table,
};
use std::path::Path;

pub fn main() -> Result<()> {
    // Three runs of a robot with 24 sonars along a corridor.
    let datasets = Path::new(env!("CARGO_MANIFEST_DIR")).join("datasets");
    let recording = npz::read(&datasets.join("corridor-small.npz"))?;

    // Four filters for a robot that knows its place to ±2 m. Every fourth stretch is kept for testing. Few steps (the
    // default is 4,000), so that this ends within seconds.
    let mut recipe = Recipe {
        features: 4,
        uncertainty: "2m".parse()?,
        ..Recipe::default()
    };
    recipe.split.test_fold = Some(3);
    recipe.descent.steps = 400;

    let learned = Training::new(&recipe, &recording)
        .on_progress(|progress| {
            if progress.judged {
                eprintln!("step {} of at most {}", progress.step, progress.most_steps);
            }
            Directive::Continue // or Directive::Stop, with the best so far
        })
        .run()?;
    for note in &learned.report.notes {
        eprintln!("note: {note}");
    }

    // Trials from starts anywhere on the stretches that were kept, beside baselines that learn nothing.
    let config = LocaliseConfig {
        trials: 10,
        resamples: 100,
        ..LocaliseConfig::default()
    };
    let parts = Parts::new(&learned.model, &recording, None)?;
    let record = localise(&[&learned.model], &parts, &config, &mut |_| ())?;
    println!("{}", table(&record).text());
    Ok(())
}
