//! What every localiser must keep, built-in or not, as a check that anybody can run on one's own.

use super::{Estimate, Localiser, LocaliserConfig, Step};
use crate::{
    error::{Error, Result},
    geometry::Pose,
    recording::{Columns, Recording},
    seed::Seed,
};

/// Lets a localiser learn from the mapping part of a recording, plays a trial of the rest to it, and looks whether it keeps
/// the laws:
///
/// - the same constants, recording and seed give the same answers;
/// - there is a step for every snapshot of a trial, also of one without any; classes are below [`Localiser::places`], places
///   finite, probabilities in [0, 1] with a sum of 1;
/// - what is answered does not depend on snapshots that come later;
/// - it does not fail on readings that are 0, huge, infinite or NaN;
/// - it looks at neither poses nor route of what is played;
/// - unless it [is blind](Localiser::is_blind), another sensor than it learned from is refused, with its name.
///
/// ```
/// use ballmark::{localiser::{Kind, laws}, seed::Seed, world::corridor};
/// let config = corridor::CorridorConfig { runs: 2, spacing_m: 2.0, ..Default::default() };
/// let recording = corridor::thrun1998(Seed(1), &config)?;
/// let [mapping, trial] = [0, 1].map(|run| recording.runs()[run].clone().collect::<Vec<_>>());
/// laws::check(&Kind::DeadReckoning.default_config(), &recording, &mapping, &trial)?;
/// # Ok::<(), ballmark::Error>(())
/// ```
///
/// # Errors
/// Where the localiser can't learn, or breaks a law: the message says which.
pub fn check(
    config: &dyn LocaliserConfig,
    recording: &Recording,
    mapping: &[usize],
    trial: &[usize],
) -> Result<()> {
    let kind = config.kind().to_string();
    let broken = |law: String| Error::work(format!("{kind} breaks a law: {law}"));
    let learn = || config.learn(recording, mapping, Seed(3));
    // The start as it truly was, whatever the poses of the recording that is played.
    let start = trial.first().map(|&k| recording.poses()[k]);
    let play = |localiser: &dyn Localiser, recording: &Recording, trial: &[usize]| {
        let player = localiser.prepare(recording, trial)?;
        player.play(trial, start, &mut Seed(1).stream("a trial"))
    };

    let localiser = learn()?;
    localiser.check_channels(recording.channels())?;
    let steps = play(localiser.as_ref(), recording, trial)?;
    sound(localiser.as_ref(), trial.len(), &steps).map_err(broken)?;
    if play(learn()?.as_ref(), recording, trial)? != steps {
        return Err(broken("the same again gives other answers".into()));
    }
    for end in [0, trial.len() / 2] {
        if play(localiser.as_ref(), recording, &trial[..end])? != steps[..end] {
            return Err(broken(format!(
                "its first {end} answers depend on later snapshots"
            )));
        }
    }
    for (words, value) in [
        ("0", 0.0),
        ("1e30", 1e30),
        ("infinite", f32::INFINITY),
        ("NaN", f32::NAN),
    ] {
        let odd = changed(recording, |columns| columns.values.fill(value))?;
        let steps = play(localiser.as_ref(), &odd, trial)?;
        sound(localiser.as_ref(), trial.len(), &steps)
            .map_err(|law| broken(format!("readings that are {words}: {law}")))?;
    }
    let elsewhere = changed(recording, |columns| {
        for (k, pose) in columns.pose.iter_mut().enumerate() {
            *pose = Pose::new(-3.0 * k as f64, 7.0, 1.0);
        }
        columns.route_m = None;
    })?;
    if play(localiser.as_ref(), &elsewhere, trial)? != steps {
        return Err(broken("its answers depend on the true poses".into()));
    }
    if localiser.is_blind() {
        return Ok(());
    }
    let mut names: Vec<String> = Vec::new();
    let other = changed(recording, |columns| {
        for channel in &mut columns.channels {
            names.push(channel.name.clone());
            channel.name = format!("another {}", channel.name);
        }
    })?;
    match localiser.check_channels(other.channels()) {
        Ok(()) => Err(broken("check_channels passes other sensors".into())),
        Err(error) if names.iter().any(|name| error.to_string().contains(name)) => Ok(()),
        Err(error) => Err(broken(format!(
            "check_channels does not name the sensor that is missing: {error}"
        ))),
    }
}

/// The recording with some of its columns changed.
fn changed(recording: &Recording, change: impl FnOnce(&mut Columns)) -> Result<Recording> {
    let mut columns = recording.columns().clone();
    change(&mut columns);
    Recording::new(columns)
}

fn sound(
    localiser: &dyn Localiser,
    snapshots: usize,
    steps: &[Step],
) -> std::result::Result<(), String> {
    if steps.len() != snapshots {
        return Err(format!(
            "{} answers to a trial of {snapshots} snapshots; expected one each",
            steps.len()
        ));
    }
    let finite = |place: &[f64; 2]| place.iter().all(|c| c.is_finite());
    for step in steps {
        let is_place = match &step.estimate {
            Some(Estimate::Class(class)) => *class < localiser.places(),
            Some(Estimate::Place(place)) => finite(place),
            None => true,
        };
        if !is_place {
            return Err(format!(
                "{:?}; expected a class below {}, or a finite place",
                step.estimate,
                localiser.places()
            ));
        }
        if step.heading_rad.is_some_and(|heading| !heading.is_finite()) {
            return Err("a heading that is not finite; expected radians, or none".into());
        }
        let sum: f64 = step.posterior.iter().map(|(_, p)| p).sum();
        let mut probable = step.posterior.iter();
        let is_posterior = probable.all(|(place, p)| finite(place) && (0.0..=1.0).contains(p));
        let sums_to_1 = is_posterior && (sum - 1.0).abs() < 1e-6;
        if !step.posterior.is_empty() && !sums_to_1 {
            return Err(format!(
                "a posterior with sum {sum}; expected probabilities of finite places with sum 1"
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
