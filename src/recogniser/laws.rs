//! What every recogniser must keep, built-in or not, as a check that anybody can run on one's own.

use super::{Recogniser, RecogniserConfig, Response};
use crate::{
    error::{Error, Result},
    geometry::Pose,
    recording::{Observation, Recording},
    seed::Seed,
};

/// Lets a recogniser learn from the mapping part of a recording, and looks whether it keeps the laws:
///
/// - the same constants, recording and seed give the same answers, for one thread or many;
/// - there is an answer, or none, for every snapshot asked for; a class is below [`Recogniser::responses`], a fit is finite;
/// - many snapshots together are answered as one by one;
/// - it answers, or doesn't, but does not fail on readings that are 0, huge, infinite or NaN, nor without any sensor;
/// - it looks at neither truth nor odometry;
/// - another sensor than it learned from is refused, with its name;
/// - it does not learn from nothing.
///
/// ```
/// use ballmark::{recogniser::{Kind, laws}, seed::Seed, world::corridor};
/// let config = corridor::CorridorConfig { runs: 2, spacing_m: 2.0, ..Default::default() };
/// let recording = corridor::thrun1998(Seed(1), &config)?;
/// let mapping: Vec<usize> = recording.runs()[0].clone().collect();
/// laws::check(&Kind::Nearest.default_config(), &recording, &mapping)?;
/// # Ok::<(), ballmark::Error>(())
/// ```
///
/// # Errors
/// Where the recogniser can't learn, or breaks a law: the message says which.
pub fn check(
    config: &dyn RecogniserConfig,
    recording: &Recording,
    mapping: &[usize],
) -> Result<()> {
    let kind = config.kind().to_string();
    let broken = |law: String| Error::work(format!("{kind} breaks a law: {law}"));
    let all: Vec<usize> = (0..recording.len()).collect();
    let learn = || config.learn(recording, mapping, Seed(3));

    let recogniser = learn()?;
    recogniser.check_channels(recording.channels())?;
    let answers = recogniser.respond_all(recording, &all);
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.map_err(|e| Error::work(format!("threads: {e}")))?;
        let again = pool.install(|| Ok::<_, Error>(learn()?.respond_all(recording, &all)))?;
        if !same(&again, &answers) {
            return Err(broken(format!("other answers on {threads} threads")));
        }
    }
    sound(recogniser.as_ref(), all.len(), &answers).map_err(broken)?;
    for &k in &all {
        let alone = recogniser.respond(recording.channels(), &recording.observation(k));
        if alone.map(|a| a.class) != answers[k].map(|a| a.class) {
            return Err(broken(format!(
                "snapshot {k} is answered {alone:?} alone, {:?} among others",
                answers[k]
            )));
        }
        let observation = recording.observation(k);
        let ready = recogniser.ready(recording.channels(), &observation)();
        if !same(&[ready], &[alone]) {
            return Err(broken(format!(
                "snapshot {k} is answered {ready:?} when made ready first, {alone:?} else"
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
        let answers = recogniser.respond_all(&odd, &all);
        sound(recogniser.as_ref(), all.len(), &answers)
            .map_err(|law| broken(format!("readings that are {words}: {law}")))?;
    }
    let nothing = ndarray::Array1::<f32>::zeros(0);
    let without_sensors = Observation {
        values: nothing.view(),
        ..recording.observation(0)
    };
    if recogniser.respond(&[], &without_sensors).is_some() {
        return Err(broken("an answer without any sensor".into()));
    }
    let elsewhere = changed(recording, |columns| {
        for k in 0..columns.pose.len() {
            columns.pose[k] = Pose::new(-3.0 * k as f64, 7.0, 1.0);
            columns.odometry[k] = Pose::new(5.0 * k as f64, 2.0, -1.0);
        }
        columns.route_m = None;
    })?;
    if !same(&recogniser.respond_all(&elsewhere, &all), &answers) {
        return Err(broken("its answers depend on truth or odometry".into()));
    }
    let mut names: Vec<String> = Vec::new();
    let other = changed(recording, |columns| {
        for channel in &mut columns.channels {
            names.push(channel.name.clone());
            channel.name = format!("another {}", channel.name);
        }
    })?;
    match recogniser.check_channels(other.channels()) {
        Ok(()) => return Err(broken("check_channels passes other sensors".into())),
        Err(error) if names.iter().any(|name| error.to_string().contains(name)) => (),
        Err(error) => {
            let law = format!("check_channels does not name the sensor that is missing: {error}");
            return Err(broken(law));
        }
    }
    match config.learn(recording, &[], Seed(1)) {
        Ok(_) => Err(broken("it learns from no snapshot at all".into())),
        Err(_) => Ok(()),
    }
}

/// The recording with some of its columns changed.
fn changed(
    recording: &Recording,
    change: impl FnOnce(&mut crate::recording::Columns),
) -> Result<Recording> {
    let mut columns = recording.columns().clone();
    change(&mut columns);
    Recording::new(columns)
}

fn same(a: &[Option<Response>], b: &[Option<Response>]) -> bool {
    let bits = |answer: &Option<Response>| answer.map(|a| (a.class, a.fit.to_bits()));
    a.iter().map(bits).eq(b.iter().map(bits))
}

fn sound(
    recogniser: &dyn Recogniser,
    snapshots: usize,
    answers: &[Option<Response>],
) -> std::result::Result<(), String> {
    if answers.len() != snapshots {
        return Err(format!(
            "{} answers; expected one for each of {snapshots} snapshots",
            answers.len()
        ));
    }
    let responses = recogniser.responses();
    let is_sound = |answer: &&Response| answer.class < responses && answer.fit.is_finite();
    match answers.iter().flatten().find(|answer| !is_sound(answer)) {
        None => Ok(()),
        Some(answer) => Err(format!(
            "{answer:?}; expected a class below {responses} and a finite fit"
        )),
    }
}

#[cfg(test)]
mod tests;
