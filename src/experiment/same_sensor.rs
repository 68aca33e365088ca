//! Is a recording seen by the sensor that a model learned with? A net answers whatever has its width.

use crate::{
    error::{Error, Result},
    geometry::wrapped,
    model::Model,
    recording::{Channel, Recording},
};

/// Bearings apart by less than this are of the same beam, in radians: a fifth of the spacing of the finest laser scanners.
const SAME_BEARING_RAD: f64 = 0.001;

/// Reaches of two recordings apart by less than this share are the same: in logs that name none, it is found in the data.
const SAME_REACH: f64 = 0.1;
/// Those of one and the same recording may differ by rounding alone.
const EQUAL_REACH: f64 = 1e-6;

/// How a recording's sensor differs from the one that a model learned with, in words: of the channels that it works from, the
/// number of beams, their directions, or from which reading on there is no return. None where it is the same, or
/// lacks a channel, which the networks refuse.
pub fn other_sensor(model: &Model, recording: &Recording) -> Option<String> {
    differs(model, recording, SAME_REACH)
}

fn differs(model: &Model, recording: &Recording, same_reach: f64) -> Option<String> {
    let differs = |name: &str| {
        let named = |channel: &&Channel| channel.name == name;
        let own = model.header.channels.iter().find(named)?;
        let here = recording.channels().iter().find(named)?;
        let fault = difference(own, here, same_reach)?;
        Some(format!("channel `{name}`: {fault}"))
    };
    model.header.input.channel_names().find_map(differs)
}

/// A model's own recording must be seen by its own sensor: the checksum says that the file is the same, not what was made of it.
///
/// # Errors
/// Where it is another one; the message says how it differs.
pub fn refuse_other_sensor(model: &Model, own: &Recording) -> Result<()> {
    match differs(model, own, EQUAL_REACH) {
        None => Ok(()),
        Some(difference) => Err(Error::work(format!(
            "{difference}, though this is the model's own recording; expected the configuration's section [degraded] as it was \
             in training"
        ))),
    }
}

fn difference(own: &Channel, here: &Channel, same_reach: f64) -> Option<String> {
    if own.width != here.width {
        return Some(format!(
            "{} values; the model learned with {}",
            here.width, own.width
        ));
    }
    let same = |(a, b): (&f64, &f64)| wrapped(a - b).abs() < SAME_BEARING_RAD;
    if let (Some(own), Some(here)) = (&own.bearing_rad, &here.bearing_rad)
        && !own.iter().zip(here).all(same)
    {
        return Some("beams in other directions than the model learned with".into());
    }
    let reach = |maximum: Option<f64>| maximum.unwrap_or(f64::INFINITY);
    let (own_m, here_m) = (reach(own.maximum), reach(here.maximum));
    let is_same = own_m == here_m || (own_m - here_m).abs() <= same_reach * own_m.min(here_m);
    if is_same {
        return None;
    }
    let words = |maximum: Option<f64>| maximum.map_or("no limit".into(), |m| format!("{m} m"));
    Some(format!(
        "a reach of {}; the model learned with {}",
        words(here.maximum),
        words(own.maximum)
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        recording::degraded::Degraded,
        seed::Seed,
        world::corridor::{CorridorConfig, thrun1998},
    };
    use std::path::Path;

    /// A model of the repository, and the recording that it learned from.
    fn own() -> (Model, Recording) {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("models");
        let model = Model::read(&folder.join("corridor-2m.safetensors")).unwrap();
        (
            model,
            thrun1998(Seed(1), &CorridorConfig::default()).unwrap(),
        )
    }

    #[test]
    fn its_own_sensor_is_the_same_and_any_other_is_told() {
        let (model, recording) = own();
        assert_eq!(other_sensor(&model, &recording), None);
        refuse_other_sensor(&model, &recording).unwrap();
        let differs = |change: &dyn Fn(&mut Channel)| {
            let mut columns = recording.columns().clone();
            change(&mut columns.channels[0]);
            let other = Recording::new(columns).unwrap();
            let difference = other_sensor(&model, &other);
            assert_eq!(
                difference.is_some(),
                refuse_other_sensor(&model, &other).is_err()
            );
            difference.unwrap_or_default()
        };
        let turned = differs(&|c| c.bearing_rad.iter_mut().flatten().for_each(|b| *b += 0.1));
        assert!(
            turned.starts_with("channel `sonar`: beams in other directions"),
            "{turned}"
        );
        let round = differs(&|c| {
            let whole = std::f64::consts::TAU;
            c.bearing_rad.iter_mut().flatten().for_each(|b| *b += whole);
        });
        assert_eq!(round, "");
        let reach = differs(&|c| c.maximum = None);
        assert!(reach.contains("a reach of no limit; the model learned with"));
        let reach = differs(&|c| c.maximum = Some(1.25));
        assert!(reach.contains("a reach of 1.25 m"), "{reach}");
        let few = Degraded {
            beams: Some(12),
            ..Degraded::default()
        };
        let few = few.sensor(recording.clone()).unwrap();
        let width = other_sensor(&model, &few).unwrap();
        assert!(
            width.ends_with("12 values; the model learned with 24"),
            "{width}"
        );
    }

    #[test]
    fn reaches_of_two_logs_may_differ_a_little() {
        let (model, recording) = own();
        let mut columns = recording.into_columns();
        let maximum = columns.channels[0].maximum.as_mut().unwrap();
        *maximum *= 1.01;
        let little = Recording::new(columns).unwrap();
        assert_eq!(other_sensor(&model, &little), None);
        let error = refuse_other_sensor(&model, &little).unwrap_err();
        assert!(error.to_string().contains("section [degraded]"), "{error}");
    }
}
